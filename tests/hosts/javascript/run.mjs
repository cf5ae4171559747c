// Runs frames of indirect light from a package's folder alone, manifest.json and WGSL files.
//
//   node run.mjs PACKAGE OUT [--facts NAME,…] [--preset NAME] [--set NAME=VALUE,…] [--size 33x17] [--map 48]
//     [--frames 1] [--graph FILE] [--modules DIR]
//
// Of the frame it runs what reflects light and what makes virtual lights visible; the surfaces are those of scene.mjs.
// --modules: the folder with node_modules/webgpu, which stands for what a browser has.

import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { parseArgs } from 'node:util';
import { Frame, Problem, configured, entry, read } from './graph.mjs';
import { Host, generate, resolved } from './host.mjs';
import * as scene from './scene.mjs';

const PARTS = new Set(['lights', 'visibility', 'shading']);
const OUTPUTS = ['diffuse', 'specular', 'vsgls'];

/// A device with what the variants of a frame require.
async function request(modules, variants, { graph, steps }) {
  const used = [...new Set(steps.filter(({ clear }) => !clear).map(({ variant }) => variant))];
  const missing = used.filter((id) => !variants.has(id)).sort();
  if (missing.length > 0) throw new Problem(`the package lacks ${missing.join(', ')}; type: ${generate(graph, used)}`);
  if (modules) {
    const { create, globals } = await import(pathToFileURL(resolve(modules, 'node_modules/webgpu/index.js')).href);
    Object.assign(globalThis, globals);
    // Dawn's instance has to outlive what is made of it.
    globalThis.gpu = create(['backend=vulkan']);
  }
  const requiredFeatures = [...new Set(used.flatMap((id) => variants.get(id).requires.features))];
  const adapter = await (globalThis.gpu ?? navigator.gpu).requestAdapter();
  if (!adapter) throw new Problem('no adapter; VK_ICD_FILENAMES may name a driver that Dawn accepts');
  const device = await adapter.requestDevice({ requiredFeatures });
  device.onuncapturederror = ({ error }) => fail(error);
  return device;
}

/// 32 bits for each half of some bytes.
function floats(data) {
  const halves = new Uint16Array(data.buffer, data.byteOffset, data.length / 2);
  return Float32Array.from(halves, (half) => {
    const [exponent, fraction] = [(half >> 10) & 0x1f, half & 0x3ff];
    const size = exponent > 0 ? (1024 + fraction) * 2 ** (exponent - 25) : fraction * 2 ** -24;
    return (half & 0x8000 ? -1 : 1) * (exponent < 31 ? size : fraction ? NaN : Infinity);
  });
}

async function main() {
  const flags = ['facts', 'preset', 'set', 'size', 'map', 'frames', 'graph', 'modules'];
  const options = Object.fromEntries(flags.map((name) => [name, { type: 'string' }]));
  const { values, positionals: [folder, out] } = parseArgs({ options, allowPositionals: true });
  const { facts = '', preset, set = '', size = '33x17', map = '48', frames = '1', modules } = values;
  const manifest = read(readFileSync(join(folder, 'manifest.json'), 'utf8'));
  const graph = values.graph ? read(readFileSync(values.graph, 'utf8')) : entry(manifest, 'key', 'graph');
  const [width, height] = size.split('x');
  const given = set.split(',').filter(Boolean).map((one) => one.split('='));
  const own = { width, height, map, ...Object.fromEntries(given), ...scene.counts() };
  const number = ([name, value]) => [name, Object.hasOwn(graph.parameter, name) ? Number(value) : value];
  const numbers = Object.fromEntries(Object.entries(own).map(number));
  const [axes, parameters] = configured(graph, facts.split(','), preset, numbers);
  const frame = new Frame(graph, axes, parameters, PARTS);
  const variants = resolved(manifest);
  const [inputs, supplied] = [scene.inputs(frame), scene.supplied(frame)];
  const host = new Host(await request(modules, variants, frame), folder, variants, frame, supplied);
  for (let age = 0; age < Number(frames); age++) host.run(inputs, age);
  mkdirSync(out, { recursive: true });
  for (const [index, { name, texture }] of frame.resources.entries()) {
    if (!OUTPUTS.includes(name)) continue;
    const data = await host.read(index);
    writeFileSync(join(out, name), texture?.format.includes('16float') ? floats(data) : data);
  }
  for (const [name, data] of Object.entries(supplied)) writeFileSync(join(out, name), data);
  const steps = frame.steps.map(({ variant = 'clear' }) => variant);
  const configuration = { axes, parameters, inputs, frames: Number(frames), steps };
  writeFileSync(join(out, 'configuration.json'), JSON.stringify(configuration, null, 1));
}

function fail(error) {
  console.error(`error: ${error instanceof Problem ? error.message : error.stack ?? error.message}`);
  process.exit(1);
}

main().then(() => process.exit(0), fail);
