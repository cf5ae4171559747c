"""Runs a frame on a device: resources, pipelines, bind groups, uniforms, steps.

Nothing here knows a pass, an axis or a resource by name. What it does not do, for what reflects light does not need it:
color targets, the host's own draws, indirect dispatches and draws, bind groups beside group 0.
"""

import json
import struct
from functools import cache

from graph import Problem, entry
from wgpu import BufferUsage, TextureUsage

BUFFER = BufferUsage.STORAGE | BufferUsage.VERTEX | BufferUsage.INDEX | BufferUsage.COPY_SRC | BufferUsage.COPY_DST
UNIFORM = BufferUsage.UNIFORM | BufferUsage.COPY_DST
TEXTURE = TextureUsage.TEXTURE_BINDING | TextureUsage.COPY_SRC | TextureUsage.COPY_DST


class Host:
    """A frame on a device. `package` is the folder of `manifest`; what the host supplies is given as bytes by name."""

    def __init__(self, device, package, manifest, frame, supplied):
        self.device, self.package, self.frame, self.shared = device, package, frame, manifest["shared"]
        self.variants = {variant["id"]: variant for variant in manifest["variants"]}
        self.uniforms = []
        self.resources = [self.resource(one, supplied.get(one["name"])) for one in frame.resources]
        self.steps = [(step, *self.prepare(step)) for step in frame.steps]

    def resource(self, resource, data):
        """A resource with its contents; none if the host should supply it and does not."""
        if resource["external"] and data is None:
            return None
        if filtering := resource.get("sampler"):
            return self.device.create_sampler(mag_filter=filtering, min_filter=filtering, mipmap_filter=filtering)
        if buffer := resource.get("buffer"):
            made = self.device.create_buffer(size=buffer["length"] * buffer["stride"], usage=BUFFER)
            if contents := data or b"".join(word.to_bytes(4, "little") for word in buffer.get("initial", [])):
                self.device.queue.write_buffer(made, 0, contents)
            return made
        texture = resource["texture"]
        form, size, levels = texture["format"], (*texture["size"], texture["layers"]), texture["levels"]
        target = TextureUsage.RENDER_ATTACHMENT if form.startswith("depth") else TextureUsage.STORAGE_BINDING
        made = self.device.create_texture(size=size, mip_level_count=levels, format=form, usage=TEXTURE | target)
        if data:
            layout = {"bytes_per_row": len(data) // size[1], "rows_per_image": size[1]}
            self.device.queue.write_texture({"texture": made}, data, layout, size)
        return made

    def prepare(self, step):
        if "clear" in step:
            return None, []
        overrides = {override["name"] for override in self.variants[step["variant"]].get("overrides", [])}
        constants = {name: value for name, value in step["constants"].items() if name in overrides}
        pipeline = json.dumps([step["variant"], step.get("entry"), constants, step.get("draw")])
        bound = [json.dumps([call["bind"], call["uniforms"]]) for call in step["calls"]]
        return self.pipeline(pipeline), [self.group(pipeline, one) for one in bound]

    @cache
    def pipeline(self, of):
        """The pipeline of a variant, an entry point, constants and a draw, as JSON."""
        name, point, constants, draw = json.loads(of)
        variant = self.variants[name]
        [path] = [file["path"] for file in variant["files"] if file["target"] == "wgsl"]
        stage = {"module": self.device.create_shader_module(code=(self.package / path).read_text())}
        [first, *_] = [self.shared["entry_points"][key]["name"] for key in variant["entry_points"]]
        stage |= {"constants": constants, "entry_point": point or first}
        if not draw:
            return self.device.create_compute_pipeline(layout="auto", compute=stage)
        if "color" in draw or "list" in draw or not {"depth", "indices"} <= draw.keys():
            raise Problem(f"this host draws indexed triangles into depth textures alone, not `{draw['vertex']}`")
        attribute = lambda one: {"shader_location": one["location"], "format": one["format"], "offset": one["offset"]}
        buffer = lambda one: {"array_stride": one["stride"], "attributes": [*map(attribute, one["attributes"])]}
        depth, vertices = draw["depth"], [*map(buffer, draw["vertices"])]
        form = self.frame.resources[depth["target"][0]]["texture"]["format"]
        return self.device.create_render_pipeline(
            layout="auto",
            vertex=stage | {"entry_point": draw["vertex"], "buffers": vertices},
            fragment=stage | {"entry_point": draw["fragment"], "targets": []} if draw.get("fragment") else None,
            depth_stencil={"format": form, "depth_compare": depth["compare"], "depth_write_enabled": "write" in depth},
        )

    @cache
    def group(self, pipeline, of):
        """A bind group for a pipeline, of resources and uniforms, as JSON."""
        variant, entries, (bind, uniforms) = self.variants[json.loads(pipeline)[0]], [], json.loads(of)
        structs = {one["name"]: one for one in map(self.shared["structs"].get, variant["structs"])}
        for binding in map(self.shared["bindings"].get, variant["bindings"]):
            name, view = binding["name"], bind.get(binding["name"])
            bound = None if view is None else self.resources[view[0]]
            if name in uniforms:
                bound = self.device.create_buffer(size=structs[binding["type"]]["size"], usage=UNIFORM)
                self.uniforms.append((bound, binding["type"], uniforms[name], structs))
            elif bound is None:
                raise Problem(f"nothing is bound to `{name}` of {variant['id']}")
            if "dimension" in binding:
                bound = self.view(view, binding["dimension"])
            bound = {"buffer": bound} if binding["kind"] in ("uniform", "storage") else bound
            entries.append({"binding": binding["binding"], "resource": bound})
        layout = self.pipeline(pipeline).get_bind_group_layout(0)
        return self.device.create_bind_group(layout=layout, entries=entries)

    def view(self, view, dimension):
        levels = {} if view[1] is None else {"base_mip_level": view[1], "mip_level_count": 1}
        return self.resources[view[0]].create_view(dimension=dimension, **levels)

    def run(self, inputs, age):
        """One frame. `age`: how many were before it."""
        for buffer, kind, members, structs in self.uniforms:
            data = bytearray(buffer.size)
            pack(data, 0, kind, members, structs, inputs | {"age": age})
            self.device.queue.write_buffer(buffer, 0, data)
        encoder = self.device.create_command_encoder()
        for step, pipeline, groups in [one for one in self.steps if age == 0 or "new" not in one[0]]:
            if "clear" in step:
                encoder.clear_buffer(self.resources[step["clear"][0]], 0, step.get("bytes"))
                continue
            work = self.begin(encoder, step["draw"]) if "draw" in step else encoder.begin_compute_pass()
            work.set_pipeline(pipeline)
            for call, group in zip(step["calls"], groups):
                work.set_bind_group(0, group)
                if "dispatch" in call:
                    work.dispatch_workgroups(*call["dispatch"])
                    continue
                if "viewport" in call["draw"]:
                    work.set_viewport(*call["draw"]["viewport"], 0, 1)
                first, instances = call["draw"].get("instances", (0, 1))
                work.draw_indexed(call["draw"]["count"], instances, 0, 0, first)
            work.end()
        self.device.queue.submit([encoder.finish()])

    def begin(self, encoder, draw):
        """A render pass with its target and vertices."""
        clear, view = draw["depth"].get("clear"), self.view(draw["depth"]["target"], "2d")
        load = {"depth_load_op": "load"} if clear is None else {"depth_load_op": "clear", "depth_clear_value": clear}
        depth = {"view": view, "depth_store_op": "store"} | load
        work = encoder.begin_render_pass(color_attachments=[], depth_stencil_attachment=depth)
        for slot, one in enumerate(draw["vertices"]):
            work.set_vertex_buffer(slot, self.resources[one["buffer"][0]])
        work.set_index_buffer(self.resources[draw["indices"][0]], "uint32")
        return work


def pack(data, offset, kind, value, structs, inputs):
    """Writes a value of a type of WGSL where the manifest's layout has it."""
    if isinstance(value, dict) and "age" in value:
        value = inputs["age"]
    elif isinstance(value, dict) and "input" in value:
        given = entry(inputs, "input", value["input"])
        value = given[value["element"]] if "element" in value else given
    if kind in structs:
        for field in structs[kind]["fields"]:
            member = entry(value, f"member of {kind}", field["name"])
            pack(data, offset + field["offset"], field["type"], member, structs, inputs)
    else:
        numbers = value if isinstance(value, list) else [value]
        letter = entry({"f32": "f", "u32": "I", "i32": "i"}, "scalar type", kind.rstrip(">").split("<")[-1])
        struct.pack_into(f"<{len(numbers)}{letter}", data, offset, *numbers)
