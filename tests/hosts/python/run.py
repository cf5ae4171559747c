"""Runs frames of indirect light from a package's folder alone, manifest.json and WGSL files.

    python run.py PACKAGE OUT [--facts NAME,…] [--preset NAME] [--set NAME=VALUE,…] [--size 33x17] [--map 48]
        [--frames 1] [--graph FILE]

Of the frame it runs what reflects light and what makes virtual lights visible; the surfaces are those of scene.py.
"""

import argparse
import json
import struct
import sys
from pathlib import Path

import scene
import wgpu
from graph import Frame, Problem, entry
from host import Host

PARTS = {"lights", "visibility", "shading"}
SCHEMA_VERSION = 7
OUTPUTS = ("diffuse", "specular", "vsgls")


def generate(frame, variants):
    """The command that generates variants."""
    values = set()
    for own, *of in (name.split("-") for name in variants):
        values |= {f"{axis}={value}" for axis, value in zip(frame.graph["passes"][own], of)}
    return f"cargo xtask gen-shaders --set {','.join(sorted(values))} --out DIR"


def request(frame, manifest):
    """A device with what the variants of a frame require."""
    variants = {one["id"]: manifest["shared"]["requires"][one["requires"]] for one in manifest["variants"]}
    used = {step["variant"] for step in frame.steps if "variant" in step}
    if missing := used - variants.keys():
        raise Problem(f"the package lacks {', '.join(sorted(missing))}; type: {generate(frame, used)}")
    features = {feature for name in used for feature in variants[name].get("features", [])}
    return wgpu.gpu.request_adapter_sync().request_device_sync(required_features=sorted(features))


def read(host, index):
    """The bytes of a buffer, or of a texture of four floats or halves; these as floats."""
    made, queue = host.resources[index], host.device.queue
    if not (texture := host.frame.resources[index].get("texture")):
        return queue.read_buffer(made)
    width, height = texture["size"]
    is_half = "16float" in texture["format"]
    layout = {"bytes_per_row": width * (8 if is_half else 16), "rows_per_image": height}
    data = queue.read_texture({"texture": made}, layout, (width, height, 1))
    return scene.packed(struct.unpack(f"<{len(data) // 2}e", data)) if is_half else data


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("package", type=Path)
    parser.add_argument("out", type=Path)
    options = {"facts": "", "preset": None, "set": "", "size": "33x17", "map": "48", "frames": "1", "graph": None}
    for name, default in options.items():
        parser.add_argument(f"--{name}", default=default)
    given = parser.parse_args()
    manifest = json.loads((given.package / "manifest.json").read_text())
    if (version := manifest["schema_version"]) != SCHEMA_VERSION:
        text = f"the package is of format {version}, not {SCHEMA_VERSION}"
        raise Problem(f"{text}; type: cargo xtask gen-shaders --out DIR")
    graph = json.loads(Path(given.graph).read_text()) if given.graph else entry(manifest, "key", "graph")
    own = dict(zip(("width", "height"), given.size.split("x"))) | {"map": given.map}
    own |= dict(one.split("=") for one in given.set.split(",") if one)
    number = lambda kind, text: int(text) if kind == "whole" else float(text)
    numbers = {name: number(one["type"], own[name]) for name, one in graph["parameter"].items() if name in own}
    frame = Frame(graph, PARTS, given.facts.split(","), given.preset, own | numbers | scene.counts())
    supplied, inputs = scene.supplied(frame), scene.inputs(frame)
    contents = scene.contents(frame, supplied)
    host = Host(request(frame, manifest), given.package, manifest, frame, contents)
    for age in range(int(given.frames)):
        host.run(inputs, age)
    given.out.mkdir(parents=True, exist_ok=True)
    for index, resource in enumerate(frame.resources):
        if resource["name"] in OUTPUTS:
            (given.out / resource["name"]).write_bytes(read(host, index))
    for name, numbers in supplied.items():
        (given.out / name).write_bytes(scene.packed(numbers))
    configuration = {"axes": frame.axes, "parameters": frame.parameters, "inputs": inputs, "frames": int(given.frames)}
    configuration["steps"] = [step.get("variant", "clear") for step in frame.steps]
    (given.out / "configuration.json").write_text(json.dumps(configuration, indent=1))


if __name__ == "__main__":
    try:
        main()
    except Problem as problem:
        sys.exit(f"error: {problem}")
