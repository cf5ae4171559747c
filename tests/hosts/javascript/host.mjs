// Runs a frame on a device: resources, pipelines, bind groups, uniforms, steps.
//
// Nothing here knows a pass, an axis or a resource by name. What it does not do, for what reflects light does not need
// it: color targets, the host's own draws, indirect dispatches and draws, bind groups beside group 0.

import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { Problem, entry } from './graph.mjs';

// Usages by the numbers of WebGPU, which a browser has as GPUBufferUsage and GPUTextureUsage.
const BUFFER = 0x4 | 0x8 | 0x10 | 0x20 | 0x80; // COPY_SRC, COPY_DST, INDEX, VERTEX, STORAGE
const TEXTURE = 0x1 | 0x2 | 0x4; // COPY_SRC, COPY_DST, TEXTURE_BINDING
const [STORAGE_BINDING, RENDER_ATTACHMENT] = [0x8, 0x10];

/// What of 32 bits 16 bits hold, exactly.
function half(number) {
  const [word] = new Uint32Array(new Float32Array([number]).buffer);
  const exponent = (word >>> 23) & 0xff;
  if (number === 0) return 0;
  if (word & 0x1fff || exponent < 113 || exponent > 142) throw new Problem(`${number} is no number of 16 bits`);
  return ((word >>> 16) & 0x8000) | ((exponent - 112) << 10) | ((word >>> 13) & 0x3ff);
}

/// The resources of a frame on a device, and its steps with pipelines and bind groups.
export class Host {
  pipelines = new Map();
  groups = new Map();
  uniforms = [];

  constructor(device, folder, variants, frame, supplied) {
    Object.assign(this, { device, folder, variants, frame, supplied });
    this.resources = frame.resources.map((resource) => this.make(resource));
    this.steps = frame.steps.map((step) => ({ step, ...this.prepare(step) }));
  }

  /// A resource, with its contents if the host supplies it; null if it should and does not.
  make({ name, external, buffer, texture, sampler }) {
    const { device, supplied } = this;
    if (sampler) return device.createSampler({ magFilter: sampler, minFilter: sampler, mipmapFilter: sampler });
    const contents = Object.hasOwn(supplied, name) ? supplied[name] : null;
    if (external && contents === null) return null;
    if (buffer) {
      const made = device.createBuffer({ size: buffer.length * buffer.stride, usage: BUFFER });
      device.queue.writeBuffer(made, 0, contents ?? new Uint32Array(buffer.initial));
      return made;
    }
    const { format, size: [width, height], layers, levels: mipLevelCount } = texture;
    const size = [width, height, layers];
    const target = format.startsWith('depth') ? RENDER_ATTACHMENT : STORAGE_BINDING;
    const made = device.createTexture({ size, format, mipLevelCount, usage: TEXTURE | target });
    if (contents) {
      const data = format.includes('16float') ? Uint16Array.from(contents, half) : contents;
      const layout = { bytesPerRow: data.byteLength / height, rowsPerImage: height };
      device.queue.writeTexture({ texture: made }, data, layout, size);
    }
    return made;
  }

  /// The pipeline of a step and the bind groups of its calls; the same ones for the same.
  prepare(step) {
    if (step.clear) return {};
    const { device, folder, pipelines } = this;
    const { id, files, entry_points: points, overrides = [] } = this.variants.get(step.variant);
    const named = overrides.filter(({ name }) => Object.hasOwn(step.constants, name));
    const constants = Object.fromEntries(named.map(({ name }) => [name, step.constants[name]]));
    const key = JSON.stringify([id, step.entry, constants, step.draw]);
    if (!pipelines.has(key)) {
      const { path } = files.find(({ target }) => target === 'wgsl');
      const module = device.createShaderModule({ code: readFileSync(join(folder, path), 'utf8') });
      const compute = { module, constants, entryPoint: step.entry ?? points[0].name };
      pipelines.set(key, step.draw
        ? device.createRenderPipeline({ layout: 'auto', ...this.raster(step.draw, { module, constants }) })
        : device.createComputePipeline({ layout: 'auto', compute }));
    }
    return { pipeline: pipelines.get(key), groups: step.calls.map((call) => this.group(key, id, call)) };
  }

  /// The state of a render pipeline. What is drawn has indices and goes into a depth texture.
  raster({ vertex, fragment, vertices, depth, indices, color, list }, stage) {
    if (color.length > 0 || list || !depth || !indices) {
      throw new Problem(`this host draws indexed triangles into depth textures alone, not \`${vertex}\``);
    }
    const attribute = ({ location, format, offset }) => ({ shaderLocation: location, format, offset });
    const buffer = ({ stride, attributes }) => ({ arrayStride: stride, attributes: attributes.map(attribute) });
    const { format } = this.frame.resources[depth.target.index].texture;
    const depthStencil = { format, depthCompare: depth.compare, depthWriteEnabled: depth.write === true };
    const state = { vertex: { ...stage, entryPoint: vertex, buffers: vertices.map(buffer) }, depthStencil };
    return fragment ? { ...state, fragment: { ...stage, entryPoint: fragment, targets: [] } } : state;
  }

  group(pipeline, id, { bind, uniforms }) {
    const { device, groups, resources } = this;
    const key = JSON.stringify([pipeline, bind, uniforms]);
    if (groups.has(key)) return groups.get(key);
    const { bindings, structs } = this.variants.get(id);
    const layouts = Object.fromEntries(structs.map((one) => [one.name, one]));
    const entries = bindings.map(({ binding, name, kind, type, dimension }) => {
      if (Object.hasOwn(uniforms, name)) {
        const usage = GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST;
        const buffer = device.createBuffer({ size: layouts[type].size, usage });
        this.uniforms.push({ buffer, type, members: uniforms[name], layouts });
        return { binding, resource: { buffer } };
      }
      const made = bind[name] ? resources[bind[name].index] : null;
      if (!made) throw new Problem(`nothing is bound to \`${name}\` of ${id}`);
      if (kind === 'storage') return { binding, resource: { buffer: made } };
      return { binding, resource: kind === 'sampler' ? made : this.view(bind[name], dimension) };
    });
    const layout = this.pipelines.get(pipeline).getBindGroupLayout(0);
    groups.set(key, device.createBindGroup({ layout, entries }));
    return groups.get(key);
  }

  view({ index, level }, dimension) {
    const levels = level === null ? {} : { baseMipLevel: level, mipLevelCount: 1 };
    return this.resources[index].createView({ dimension, ...levels });
  }

  /// One frame. `age`: how many were before it.
  run(inputs, age) {
    const { device, resources } = this;
    for (const { buffer, type, members, layouts } of this.uniforms) {
      const data = new DataView(new ArrayBuffer(buffer.size));
      pack(data, 0, type, members, { layouts, inputs, age });
      device.queue.writeBuffer(buffer, 0, data.buffer);
    }
    const encoder = device.createCommandEncoder();
    for (const { step, pipeline, groups } of this.steps) {
      if (step.new !== null && age > 0) continue;
      if (step.clear) {
        encoder.clearBuffer(resources[step.clear.index], 0, step.bytes ?? undefined);
        continue;
      }
      const work = step.draw ? this.begin(encoder, step.draw) : encoder.beginComputePass();
      work.setPipeline(pipeline);
      step.calls.forEach(({ viewport, count, instances, dispatch }, index) => {
        work.setBindGroup(0, groups[index]);
        if (viewport) work.setViewport(...viewport, 0, 1);
        const [first, number] = instances ?? [0, 1];
        if (step.draw) work.drawIndexed(count, number, 0, 0, first);
        else work.dispatchWorkgroups(...dispatch);
      });
      work.end();
    }
    device.queue.submit([encoder.finish()]);
  }

  /// A render pass with its target and vertices.
  begin(encoder, { depth, vertices, indices }) {
    const depthStencilAttachment = { view: this.view(depth.target, '2d'), depthStoreOp: 'store', depthLoadOp: 'load' };
    const clear = { depthLoadOp: 'clear', depthClearValue: depth.clear };
    if (depth.clear !== null) Object.assign(depthStencilAttachment, clear);
    const work = encoder.beginRenderPass({ colorAttachments: [], depthStencilAttachment });
    vertices.forEach(({ buffer }, slot) => work.setVertexBuffer(slot, this.resources[buffer.index]));
    work.setIndexBuffer(this.resources[indices.index], 'uint32');
    return work;
  }

  /// The bytes of a buffer, or of a texture of four floats or halves.
  async read(index) {
    const { device, resources } = this;
    const { texture, buffer } = this.frame.resources[index];
    const [width, height] = texture?.size ?? [buffer.length * buffer.stride, 1];
    const row = texture ? width * (texture.format.includes('16float') ? 8 : 16) : width;
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
    return Buffer.concat(Array.from({ length: height }, (_, y) => bytes.subarray(y * padded, y * padded + row)));
  }
}

/// Writes a value of a type of WGSL where the manifest's layout has it.
function pack(data, offset, type, member, given) {
  const { layouts, inputs, age } = given;
  let value = member?.age ? age : member;
  if (member?.input) {
    value = entry(inputs, 'input', member.input);
    if (member.element !== null) value = value[member.element];
  }
  if (Object.hasOwn(layouts, type)) {
    for (const field of layouts[type].fields) {
      pack(data, offset + field.offset, field.type, entry(value, `member of ${type}`, field.name), given);
    }
    return;
  }
  const write = { f32: data.setFloat32, u32: data.setUint32, i32: data.setInt32 };
  const scalar = entry(write, 'scalar type', type.replace('>', '').split('<').at(-1));
  [value].flat().forEach((number, index) => scalar.call(data, offset + 4 * index, number, true));
}

/// The variants by identifier, with what they share in place of its keys.
export function resolved({ shared, variants }) {
  const tables = ['entry_points', 'bindings', 'structs'];
  const whole = (one) => tables.map((table) => [table, one[table].map((key) => shared[table][key])]);
  const requires = (one) => ['requires', shared.requires[one.requires]];
  const all = (one) => ({ ...one, ...Object.fromEntries([...whole(one), requires(one)]) });
  return new Map(variants.map((one) => [one.id, all(one)]));
}

/// The command that generates variants.
export function generate({ passes }, ids) {
  const axes = ([pass, ...values]) => values.map((value, i) => `${passes[pass][i]}=${value}`);
  const values = ids.flatMap((id) => axes(id.split('-')));
  return `cargo xtask gen-shaders --set ${[...new Set(values)].sort()} --out DIR`;
}
