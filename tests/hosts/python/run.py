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
from graph import Frame, Problem, Table, configured, entry
from host import Host

PARTS = {"lights", "visibility", "shading"}
OUTPUTS = ("diffuse", "specular", "vsgls")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("package", type=Path)
    parser.add_argument("out", type=Path)
    options = {"facts": "", "preset": None, "set": "", "size": "33x17", "map": "48", "frames": "1", "graph": None}
    for name, default in options.items():
        parser.add_argument(f"--{name}", default=default)
    given = parser.parse_args()
    read = lambda path: json.loads(path.read_text(), object_hook=Table)
    manifest = read(given.package / "manifest.json")
    graph = read(Path(given.graph)) if given.graph else entry(manifest, "key", "graph")
    own = dict(zip(("width", "height"), given.size.split("x"))) | {"map": given.map}
    own |= dict(one.split("=") for one in given.set.split(",") if one)
    number = lambda kind, text: int(text) if kind == "whole" else float(text)
    numbers = {name: number(one["type"], own[name]) for name, one in graph["parameter"].items() if name in own}
    axes, parameters = configured(graph, given.facts.split(","), given.preset, own | numbers | scene.counts())
    frame = Frame(graph, axes, parameters, PARTS)
    supplied, inputs = scene.supplied(frame), scene.inputs(frame)
    host = Host(given.package, manifest, frame, supplied)
    for age in range(int(given.frames)):
        host.run(inputs, age)
    given.out.mkdir(parents=True, exist_ok=True)
    for index, resource in enumerate(frame.resources):
        if resource["name"] in OUTPUTS:
            data = host.read(index)
            if "16float" in (resource["texture"] or {"format": ""})["format"]:
                data = struct.pack(f"<{len(data) // 2}f", *struct.unpack(f"<{len(data) // 2}e", data))
            (given.out / resource["name"]).write_bytes(data)
    for name, numbers in supplied.items():
        letter = "I" if isinstance(numbers[0], int) else "f"
        (given.out / name).write_bytes(struct.pack(f"<{len(numbers)}{letter}", *numbers))
    configuration = {"axes": axes, "parameters": parameters, "inputs": inputs, "frames": int(given.frames)}
    configuration["steps"] = [step["variant"] or "clear" for step in frame.steps]
    (given.out / "configuration.json").write_text(json.dumps(configuration, indent=1))


if __name__ == "__main__":
    try:
        main()
    except Problem as problem:
        sys.exit(f"error: {problem}")
