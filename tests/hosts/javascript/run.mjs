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
import { Frame, Problem, entry } from './graph.mjs';
import { Host } from './host.mjs';
import * as scene from './scene.mjs';

const PARTS = ['lights', 'visibility', 'shading'];
const SCHEMA_VERSION = 7;
const OUTPUTS = ['diffuse', 'specular', 'vsgls'];

/// The command that generates variants.
function generate({ passes }, ids) {
  const axes = ([pass, ...values]) => values.map((value, i) => `${passes[pass][i]}=${value}`);
  const values = ids.flatMap((id) => axes(id.split('-')));
  return `cargo xtask gen-shaders --set ${[...new Set(values)].sort()} --out DIR`;
}

/// A device with what the variants of a frame require.
async function request(modules, { shared, variants }, { graph, steps }) {
  const requires = new Map(variants.map((one) => [one.id, shared.requires[one.requires]]));
  const used = [...new Set(steps.flatMap(({ variant }) => variant ?? []))];
  const missing = used.filter((id) => !requires.has(id)).sort();
  if (missing.length > 0) throw new Problem(`the package lacks ${missing.join(', ')}; type: ${generate(graph, used)}`);
  if (modules) {
    const { create, globals } = await import(pathToFileURL(resolve(modules, 'node_modules/webgpu/index.js')).href);
    Object.assign(globalThis, globals);
    // Dawn's instance has to outlive what is made of it.
    globalThis.gpu = create(['backend=vulkan']);
  }
  const requiredFeatures = [...new Set(used.flatMap((id) => requires.get(id).features ?? []))];
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

/// The bytes of a buffer, or of a texture of four floats or halves; these as floats.
async function read({ device, resources, frame }, index) {
  const { texture, buffer } = frame.resources[index];
  const [width, height] = texture?.size ?? [buffer.length * buffer.stride, 1];
  const isHalf = texture?.format.includes('16float') === true;
  const row = texture ? width * (isHalf ? 8 : 16) : width;
  const padded = Math.ceil(row / 256) * 256;
  const usage = GPUBufferUsage.COPY_DST | GPUBufferUsage.MAP_READ;
  const copy = device.createBuffer({ size: padded * height, usage });
  const encoder = device.createCommandEncoder();
  const target = { buffer: copy, bytesPerRow: padded };
  if (texture) encoder.copyTextureToBuffer({ texture: resources[index] }, target, [width, height]);
  else encoder.copyBufferToBuffer(resources[index], 0, copy, 0, row);
  device.queue.submit([encoder.finish()]);
  await copy.mapAsync(GPUMapMode.READ);
  const bytes = Buffer.from(copy.getMappedRange());
  const data = Buffer.concat(Array.from({ length: height }, (_, y) => bytes.subarray(y * padded, y * padded + row)));
  return isHalf ? floats(data) : data;
}

async function main() {
  const flags = ['facts', 'preset', 'set', 'size', 'map', 'frames', 'graph', 'modules'];
  const options = Object.fromEntries(flags.map((name) => [name, { type: 'string' }]));
  const { values, positionals: [folder, out] } = parseArgs({ options, allowPositionals: true });
  const { facts = '', preset, set = '', size = '33x17', map = '48', frames = '1', modules } = values;
  const manifest = JSON.parse(readFileSync(join(folder, 'manifest.json'), 'utf8'));
  const version = manifest.schema_version;
  if (version !== SCHEMA_VERSION) {
    const command = 'cargo xtask gen-shaders --out DIR';
    throw new Problem(`the package is of format ${version}, not ${SCHEMA_VERSION}; type: ${command}`);
  }
  const graph = values.graph ? JSON.parse(readFileSync(values.graph, 'utf8')) : entry(manifest, 'key', 'graph');
  const [width, height] = size.split('x');
  const given = set.split(',').filter(Boolean).map((one) => one.split('='));
  const own = { width, height, map, ...Object.fromEntries(given), ...scene.counts() };
  const number = ([name, value]) => [name, Object.hasOwn(graph.parameter, name) ? Number(value) : value];
  const numbers = Object.fromEntries(Object.entries(own).map(number));
  const frame = new Frame(graph, PARTS, facts.split(','), preset, numbers);
  const [inputs, supplied] = [scene.inputs(frame), scene.supplied(frame)];
  const device = await request(modules, manifest, frame);
  const host = new Host(device, folder, manifest, frame, scene.contents(frame, supplied));
  for (let age = 0; age < Number(frames); age++) host.run(inputs, age);
  mkdirSync(out, { recursive: true });
  for (const [index, { name }] of frame.resources.entries()) {
    if (OUTPUTS.includes(name)) writeFileSync(join(out, name), await read(host, index));
  }
  for (const [name, data] of Object.entries(supplied)) writeFileSync(join(out, name), data);
  const steps = frame.steps.map(({ variant = 'clear' }) => variant);
  const { axes, parameters } = frame;
  const configuration = { axes, parameters, inputs, frames: Number(frames), steps };
  writeFileSync(join(out, 'configuration.json'), JSON.stringify(configuration, null, 1));
}

function fail(error) {
  console.error(`error: ${error instanceof Problem ? error.message : error.stack ?? error.message}`);
  process.exit(1);
}

main().then(() => process.exit(0), fail);
