"""Runs a frame on a device: resources, pipelines, bind groups, uniforms, steps.

Nothing here knows a pass, an axis or a resource by name. What it does not do, for what reflects light does not need it:
color targets, the host's own draws, indirect dispatches and draws, bind groups beside group 0.
"""

import json
import struct

import wgpu
from graph import Problem, Table, entry
from wgpu import BufferUsage, TextureUsage

BUFFER = BufferUsage.STORAGE | BufferUsage.VERTEX | BufferUsage.INDEX | BufferUsage.COPY_SRC | BufferUsage.COPY_DST
TEXTURE = TextureUsage.TEXTURE_BINDING | TextureUsage.COPY_SRC | TextureUsage.COPY_DST
LETTERS = {"f32": "f", "u32": "I", "i32": "i"}


def generate(frame, variants):
    """The command that generates variants."""
    values = set()
    for own, *of in (name.split("-") for name in variants):
        values |= {f"{axis}={value}" for axis, value in zip(frame.graph["passes"][own], of)}
    return f"cargo xtask gen-shaders --set {','.join(sorted(values))} --out DIR"


def resolved(manifest):
    """The variants by identifier, with what they share in place of its keys."""
    shared, tables = manifest["shared"], ("entry_points", "bindings", "structs")
    whole = lambda one: {table: [shared[table][key] for key in one[table]] for table in tables}
    requires = lambda one: {"requires": shared["requires"][one["requires"]]}
    return {one["id"]: Table(one | whole(one) | requires(one)) for one in manifest["variants"]}


class Host:
    """The resources of a frame on a device, and its steps with pipelines and bind groups."""

    def __init__(self, package, manifest, frame, supplied):
        self.package, self.frame, self.supplied = package, frame, supplied
        self.variants = resolved(manifest)
        used = {step["variant"] for step in frame.steps if not step["clear"]}
        if missing := used - self.variants.keys():
            raise Problem(f"the package lacks {', '.join(sorted(missing))}; type: {generate(frame, used)}")
        features = {feature for name in used for feature in self.variants[name]["requires"]["features"]}
        self.device = wgpu.gpu.request_adapter_sync().request_device_sync(required_features=sorted(features))
        self.pipelines, self.groups, self.uniforms = {}, {}, []
        self.resources = [self.make(one) for one in frame.resources]
        self.steps = [(step, *self.prepare(step)) for step in frame.steps]

    def make(self, resource):
        """A resource, with its contents if the host supplies it; none if it should and does not."""
        if filtering := resource["sampler"]:
            return self.device.create_sampler(mag_filter=filtering, min_filter=filtering, mipmap_filter=filtering)
        numbers = self.supplied.get(resource["name"])
        if resource["external"] and numbers is None:
            return None
        if buffer := resource["buffer"]:
            made = self.device.create_buffer(size=buffer["length"] * buffer["stride"], usage=BUFFER)
            if numbers := numbers or buffer["initial"]:
                letter = "I" if isinstance(numbers[0], int) else "f"
                self.device.queue.write_buffer(made, 0, struct.pack(f"<{len(numbers)}{letter}", *numbers))
            return made
        texture = resource["texture"]
        size, levels, form = (*texture["size"], texture["layers"]), texture["levels"], texture["format"]
        target = TextureUsage.RENDER_ATTACHMENT if form.startswith("depth") else TextureUsage.STORAGE_BINDING
        made = self.device.create_texture(size=size, mip_level_count=levels, format=form, usage=TEXTURE | target)
        if numbers:
            data = struct.pack(f"<{len(numbers)}{'e' if '16float' in form else 'f'}", *numbers)
            layout = {"bytes_per_row": len(data) // size[1], "rows_per_image": size[1]}
            self.device.queue.write_texture({"texture": made}, data, layout, size)
        return made

    def prepare(self, step):
        """The pipeline of a step and the bind groups of its calls; the same ones for the same."""
        if step["clear"]:
            return None, []
        variant, draw = self.variants[step["variant"]], step["draw"]
        overrides = {override["name"] for override in variant["overrides"] or []}
        constants = {name: value for name, value in step["constants"].items() if name in overrides}
        key = json.dumps([step["variant"], step["entry"], constants, draw])
        if key not in self.pipelines:
            [path] = [file["path"] for file in variant["files"] if file["target"] == "wgsl"]
            module = self.device.create_shader_module(code=(self.package / path).read_text())
            stage = {"module": module, "constants": constants}
            make = self.device.create_render_pipeline if draw else self.device.create_compute_pipeline
            name = step["entry"] or variant["entry_points"][0]["name"]
            state = self.raster(draw, stage) if draw else {"compute": stage | {"entry_point": name}}
            self.pipelines[key] = make(layout="auto", **state)
        return self.pipelines[key], [self.group(key, variant, call) for call in step["calls"]]

    def raster(self, draw, stage):
        """The state of a render pipeline. What is drawn has indices and goes into a depth texture."""
        if draw["color"] or draw["list"] or not (draw["depth"] and draw["indices"]):
            raise Problem(f"this host draws indexed triangles into depth textures alone, not `{draw['vertex']}`")
        attribute = lambda one: {"shader_location": one["location"], "format": one["format"], "offset": one["offset"]}
        buffer = lambda one: {"array_stride": one["stride"], "attributes": [*map(attribute, one["attributes"])]}
        state = {"vertex": stage | {"entry_point": draw["vertex"], "buffers": [*map(buffer, draw["vertices"])]}}
        if draw["fragment"]:
            state["fragment"] = stage | {"entry_point": draw["fragment"], "targets": []}
        depth = draw["depth"]
        form = self.frame.resources[depth["target"][0]]["texture"]["format"]
        compare = {"depth_compare": depth["compare"], "depth_write_enabled": bool(depth["write"])}
        return state | {"depth_stencil": {"format": form} | compare}

    def group(self, pipeline, variant, call):
        key = json.dumps([pipeline, call["bind"], call["uniforms"]])
        if key not in self.groups:
            entries, structs = [], {one["name"]: one for one in variant["structs"]}
            for binding in variant["bindings"]:
                name, view = binding["name"], call["bind"].get(binding["name"])
                if name in call["uniforms"]:
                    size, usage = structs[binding["type"]]["size"], BufferUsage.UNIFORM | BufferUsage.COPY_DST
                    bound = {"buffer": self.device.create_buffer(size=size, usage=usage)}
                    self.uniforms.append((bound["buffer"], binding["type"], call["uniforms"][name], structs))
                elif view is None or self.resources[view[0]] is None:
                    raise Problem(f"nothing is bound to `{name}` of {variant['id']}")
                elif binding["kind"] in ("texture", "storage_texture"):
                    bound = self.view(view, binding["dimension"])
                else:
                    bound = self.resources[view[0]]
                    bound = {"buffer": bound} if binding["kind"] == "storage" else bound
                entries.append({"binding": binding["binding"], "resource": bound})
            layout = self.pipelines[pipeline].get_bind_group_layout(0)
            self.groups[key] = self.device.create_bind_group(layout=layout, entries=entries)
        return self.groups[key]

    def view(self, view, dimension):
        levels = {} if view[1] is None else {"base_mip_level": view[1], "mip_level_count": 1}
        return self.resources[view[0]].create_view(dimension=dimension, **levels)

    def run(self, inputs, age):
        """One frame. `age`: how many were before it."""

        def pack(data, offset, kind, value, structs):
            """Writes a value of a type of WGSL where the manifest's layout has it."""
            if isinstance(value, dict) and "age" in value:
                value = age
            elif isinstance(value, dict) and "input" in value:
                given = entry(inputs, "input", value["input"])
                value = given if value["element"] is None else given[value["element"]]
            if kind in structs:
                for field in structs[kind]["fields"]:
                    member = entry(value, f"member of {kind}", field["name"])
                    pack(data, offset + field["offset"], field["type"], member, structs)
            else:
                numbers = value if isinstance(value, list) else [value]
                letter = entry(LETTERS, "scalar type", kind.rstrip(">").split("<")[-1])
                struct.pack_into(f"<{len(numbers)}{letter}", data, offset, *numbers)

        for buffer, kind, members, structs in self.uniforms:
            data = bytearray(buffer.size)
            pack(data, 0, kind, members, structs)
            self.device.queue.write_buffer(buffer, 0, data)
        encoder = self.device.create_command_encoder()
        for step, pipeline, groups in self.steps:
            if step["new"] is not None and age > 0:
                continue
            if step["clear"]:
                encoder.clear_buffer(self.resources[step["clear"][0]], 0, step["bytes"])
                continue
            work = self.begin(encoder, step["draw"]) if step["draw"] else encoder.begin_compute_pass()
            work.set_pipeline(pipeline)
            for call, group in zip(step["calls"], groups):
                work.set_bind_group(0, group)
                if call["viewport"]:
                    work.set_viewport(*call["viewport"], 0, 1)
                if step["draw"]:
                    first, instances = call["instances"] or (0, 1)
                    work.draw_indexed(call["count"], instances, 0, 0, first)
                else:
                    work.dispatch_workgroups(*call["dispatch"])
            work.end()
        self.device.queue.submit([encoder.finish()])

    def begin(self, encoder, draw):
        """A render pass with its target and vertices."""
        depth = {"view": self.view(draw["depth"]["target"], "2d"), "depth_store_op": "store", "depth_load_op": "load"}
        if (clear := draw["depth"]["clear"]) is not None:
            depth |= {"depth_load_op": "clear", "depth_clear_value": clear}
        work = encoder.begin_render_pass(color_attachments=[], depth_stencil_attachment=depth)
        for slot, one in enumerate(draw["vertices"]):
            work.set_vertex_buffer(slot, self.resources[one["buffer"][0]])
        work.set_index_buffer(self.resources[draw["indices"][0]], "uint32")
        return work

    def read(self, index):
        """The bytes of a buffer, or of a texture of four floats or halves."""
        made, texture = self.resources[index], self.frame.resources[index]["texture"]
        if not texture:
            return self.device.queue.read_buffer(made)
        width, height = texture["size"]
        texel = 8 if "16float" in texture["format"] else 16
        layout = {"bytes_per_row": width * texel, "rows_per_image": height}
        return self.device.queue.read_texture({"texture": made}, layout, (width, height, 1))
