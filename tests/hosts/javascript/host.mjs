// Runs a frame on a device: resources, pipelines, bind groups, uniforms, steps.
//
// Nothing here knows a pass, an axis or a resource by name. What it does not do, for what reflects light does not need
// it: color targets, the host's own draws, indirect dispatches and draws, bind groups beside group 0.

import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { Problem, entry } from './graph.mjs';

// Usages by the numbers of WebGPU, which a browser has as GPUBufferUsage and GPUTextureUsage.
const BUFFER = 0x4 | 0x8 | 0x10 | 0x20 | 0x80; // COPY_SRC, COPY_DST, INDEX, VERTEX, STORAGE
const UNIFORM = 0x8 | 0x40; // COPY_DST, UNIFORM
const TEXTURE = 0x1 | 0x2 | 0x4; // COPY_SRC, COPY_DST, TEXTURE_BINDING
const [STORAGE_BINDING, RENDER_ATTACHMENT] = [0x8, 0x10];

/// A frame on a device. `folder` is that of `manifest`; what the host supplies is given as typed arrays by name.
export class Host {
  constructor(device, folder, { shared, variants }, frame, supplied) {
    Object.assign(this, { device, folder, shared, frame, made: new Map(), uniforms: [] });
    this.variants = new Map(variants.map((variant) => [variant.id, variant]));
    this.resources = frame.resources.map((one) => this.resource(one, supplied[one.name]));
    this.steps = frame.steps.map((step) => ({ step, ...this.prepare(step) }));
  }

  /// A resource with its contents; null if the host should supply it and does not.
  resource({ external, buffer, texture, sampler }, data) {
    const { device } = this;
    if (sampler) return device.createSampler({ magFilter: sampler, minFilter: sampler, mipmapFilter: sampler });
    if (external && !data) return null;
    if (buffer) {
      const made = device.createBuffer({ size: buffer.length * buffer.stride, usage: BUFFER });
      device.queue.writeBuffer(made, 0, data ?? new Uint32Array(buffer.initial ?? []));
      return made;
    }
    const { format, size: [width, height], layers, levels: mipLevelCount } = texture;
    const usage = TEXTURE | (format.startsWith('depth') ? RENDER_ATTACHMENT : STORAGE_BINDING);
    const size = [width, height, layers];
    const made = device.createTexture({ size, format, mipLevelCount, usage });
    const layout = { bytesPerRow: data?.byteLength / height, rowsPerImage: height };
    if (data) device.queue.writeTexture({ texture: made }, data, layout, size);
    return made;
  }

  /// What a method makes of these; the same for the same.
  once(make, ...key) {
    const name = JSON.stringify([make, ...key]);
    if (!this.made.has(name)) this.made.set(name, this[make](...key));
    return this.made.get(name);
  }

  prepare({ variant, entry: point, constants, draw, calls }) {
    if (!variant) return {};
    const known = new Set(this.variants.get(variant).overrides?.map(({ name }) => name));
    const own = Object.fromEntries(Object.entries(constants).filter(([name]) => known.has(name)));
    const of = [variant, point, own, draw];
    const groups = calls.map(({ bind, uniforms }) => this.once('group', of, bind, uniforms));
    return { pipeline: this.once('pipeline', ...of), groups };
  }

  pipeline(variant, point, constants, draw) {
    const { device, variants, shared } = this;
    const { files, entry_points: [first] } = variants.get(variant);
    const code = readFileSync(join(this.folder, files.find(({ target }) => target === 'wgsl').path), 'utf8');
    const module = device.createShaderModule({ code });
    const stage = (entryPoint) => ({ module, constants, entryPoint });
    const compute = stage(point ?? shared.entry_points[first].name);
    if (!draw) return device.createComputePipeline({ layout: 'auto', compute });
    const { vertex, fragment, vertices, depth, indices, color, list } = draw;
    if (color || list || !depth || !indices) {
      throw new Problem(`this host draws indexed triangles into depth textures alone, not \`${vertex}\``);
    }
    const attribute = ({ location, format, offset }) => ({ shaderLocation: location, format, offset });
    const buffer = ({ stride, attributes }) => ({ arrayStride: stride, attributes: attributes.map(attribute) });
    const { format } = this.frame.resources[depth.target.index].texture;
    return device.createRenderPipeline({
      layout: 'auto',
      vertex: { ...stage(vertex), buffers: vertices.map(buffer) },
      fragment: fragment ? { ...stage(fragment), targets: [] } : undefined,
      depthStencil: { format, depthCompare: depth.compare, depthWriteEnabled: depth.write === true },
    });
  }

  group([variant, ...of], bind, uniforms) {
    const { device, resources, shared } = this;
    const { bindings, structs: keys } = this.variants.get(variant);
    const structs = Object.fromEntries(keys.map((key) => [shared.structs[key].name, shared.structs[key]]));
    const entries = bindings.map((key) => {
      const { binding, name, kind, type, dimension } = shared.bindings[key];
      if (Object.hasOwn(uniforms, name)) {
        const buffer = device.createBuffer({ size: structs[type].size, usage: UNIFORM });
        this.uniforms.push({ buffer, type, members: uniforms[name], structs });
        return { binding, resource: { buffer } };
      }
      const made = resources[bind[name]?.index];
      if (!made) throw new Problem(`nothing is bound to \`${name}\` of ${variant}`);
      if (dimension) return { binding, resource: this.view(bind[name], dimension) };
      return { binding, resource: kind === 'sampler' ? made : { buffer: made } };
    });
    const layout = this.once('pipeline', variant, ...of).getBindGroupLayout(0);
    return device.createBindGroup({ layout, entries });
  }

  view({ index, level }, dimension) {
    const levels = { baseMipLevel: level ?? 0, mipLevelCount: level === null ? undefined : 1 };
    return this.resources[index].createView({ dimension, ...levels });
  }

  /// One frame. `age`: how many were before it.
  run(inputs, age) {
    const { device, resources } = this;
    for (const { buffer, type, members, structs } of this.uniforms) {
      const data = new DataView(new ArrayBuffer(buffer.size));
      pack(data, 0, type, members, { structs, inputs, age });
      device.queue.writeBuffer(buffer, 0, data.buffer);
    }
    const encoder = device.createCommandEncoder();
    for (const { step, pipeline, groups } of this.steps.filter((one) => age === 0 || !one.step.new)) {
      if (step.clear) {
        encoder.clearBuffer(resources[step.clear.index], 0, step.bytes);
        continue;
      }
      const work = step.draw ? this.begin(encoder, step.draw) : encoder.beginComputePass();
      work.setPipeline(pipeline);
      for (const [index, { draw, dispatch }] of step.calls.entries()) {
        work.setBindGroup(0, groups[index]);
        if (draw?.viewport) work.setViewport(...draw.viewport, 0, 1);
        const [first, number] = draw?.instances ?? [0, 1];
        if (draw) work.drawIndexed(draw.count, number, 0, 0, first);
        else work.dispatchWorkgroups(...dispatch);
      }
      work.end();
    }
    device.queue.submit([encoder.finish()]);
  }

  /// A render pass with its target and vertices.
  begin(encoder, { depth, vertices, indices }) {
    const load = { depthLoadOp: depth.clear === undefined ? 'load' : 'clear', depthClearValue: depth.clear };
    const depthStencilAttachment = { view: this.view(depth.target, '2d'), depthStoreOp: 'store', ...load };
    const work = encoder.beginRenderPass({ colorAttachments: [], depthStencilAttachment });
    vertices.forEach(({ buffer }, slot) => work.setVertexBuffer(slot, this.resources[buffer.index]));
    work.setIndexBuffer(this.resources[indices.index], 'uint32');
    return work;
  }
}

/// Writes a value of a type of WGSL where the manifest's layout has it.
function pack(data, offset, type, member, given) {
  const { structs, inputs, age } = given;
  let value = member?.age ? age : member;
  if (member?.input) value = entry(inputs, 'input', member.input);
  if (member?.element !== undefined) value = value[member.element];
  for (const field of structs[type]?.fields ?? []) {
    pack(data, offset + field.offset, field.type, entry(value, `member of ${type}`, field.name), given);
  }
  if (Object.hasOwn(structs, type)) return;
  const write = { f32: data.setFloat32, u32: data.setUint32, i32: data.setInt32 };
  const scalar = entry(write, 'scalar type', type.replace('>', '').split('<').at(-1));
  [value].flat().forEach((number, index) => scalar.call(data, offset + 4 * index, number, true));
}
