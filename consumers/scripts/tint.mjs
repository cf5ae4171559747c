// Lets Tint, the WGSL compiler of Dawn and Chromium, read WGSL files. It shares no code with naga.
//
//   node tint.mjs MODULES LIST.json RESULT.json
//
// MODULES is the folder that holds node_modules/webgpu. LIST.json is an array of
// { name, file, features: [..], entry_points: [{ name, stage }] }. RESULT.json receives
// { adapter, driver, versions, results: [{ name, state: "valid" | "invalid" | "skipped", pipelines, messages: [..] }] }.
// A module is skipped if the adapter lacks one of its features. Limits are WebGPU's defaults on purpose.

import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';

const [modules, list, result] = process.argv.slice(2);
const webgpu = join(modules, 'node_modules', 'webgpu');
const { create, globals } = await import(pathToFileURL(join(webgpu, 'index.js')).href);
const { version } = JSON.parse(readFileSync(join(webgpu, 'package.json'), 'utf8'));
Object.assign(globalThis, globals);

// Dawn's instance has to outlive what is made of it, and nothing else here keeps it alive.
globalThis.gpu = create(['backend=vulkan']);
const adapter = await globalThis.gpu.requestAdapter();
if (!adapter) {
  console.error('Dawn finds no adapter; VK_ICD_FILENAMES has to name a driver that it accepts');
  process.exit(2);
}
const device = await adapter.requestDevice({ requiredFeatures: [...adapter.features] });

const results = [];
for (const { name, file, features = [], entry_points: entryPoints } of JSON.parse(readFileSync(list, 'utf8'))) {
  const lacking = features.filter((feature) => !adapter.features.has(feature));
  if (lacking.length > 0) {
    results.push({ name, state: 'skipped', pipelines: 0, messages: [`the adapter lacks ${lacking.join(', ')}`] });
    continue;
  }
  const messages = [];
  let pipelines = 0;
  device.pushErrorScope('validation');
  const module = device.createShaderModule({ label: name, code: readFileSync(file, 'utf8') });
  const { messages: compilation } = await module.getCompilationInfo();
  let valid = true;
  for (const message of compilation) {
    valid &&= message.type !== 'error';
    messages.push(`${message.lineNum}:${message.linePos}: ${message.type}: ${message.message}`);
  }
  const error = await device.popErrorScope();
  if (error && valid) {
    valid = false;
    messages.push(error.message);
  }
  for (const { name: entryPoint, stage } of valid ? entryPoints : []) {
    if (stage !== 'compute') continue;
    device.pushErrorScope('validation');
    device.createComputePipeline({ label: name, layout: 'auto', compute: { module, entryPoint } });
    const failure = await device.popErrorScope();
    if (failure) {
      valid = false;
      messages.push(`${entryPoint}: ${failure.message}`);
    } else {
      pipelines += 1;
    }
  }
  results.push({ name, state: valid ? 'valid' : 'invalid', pipelines, messages });
}

const { vendor, architecture, description } = adapter.info;
const versions = { webgpu: version, node: process.version };
const report = { adapter: `${vendor} ${architecture}`, driver: description, versions, results };
writeFileSync(result, JSON.stringify(report, null, 2));
// Dawn keeps threads alive.
process.exit(0);
