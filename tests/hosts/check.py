"""Runs both hosts on the same frames, repeats these with the runtime in Rust, and compares the results.

    python3 check.py [--graph FILE] [--runtime COMMAND] [--xtask COMMAND] [--case NAME] [--work DIR] [--json FILE]
    python3 check.py --install [--work DIR]

--graph: the description as JSON, if not that of the committed package. --runtime: tests/examples/host_frame.rs
[default: by cargo]. --xtask: what generates variants that the package lacks [default: cargo xtask]. --work: for
libraries and results [default: target/hosts]. --json: receives the differences. --install: fetches the libraries alone,
once, at fixed versions. All run on the same driver: SwiftShader where a browser brought it, for Dawn takes few others;
else the system's.

Two controls for each frame have to differ: the Python host with one number of the description wrong, and the runtime
with the light a thousandth brighter.
"""

import argparse
import array
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
COMMITTED = ROOT / "shaders/packages/sglow"
WGPU, WEBGPU = "0.32.0", "0.6.2"
SWIFTSHADER = "/usr/lib/chromium/vk_swiftshader_icd.json"
OUTPUTS = ("diffuse", "specular", "vsgls")
# Numbers that differ by the tolerance have halves that differ by one step, up to 2^-10 of a normal one.
TOLERANCE, HALF = 1e-5, 2**-10
SIZES = (("33x17", "48"), ("57x31", "37"))
VARIANTS = "light=spot,lobes=both,precision=f32,variance=trace,sharpness=exact,specular_power=f0,function=none"
VARIANTS += ",output=rgba32float"
CLUSTERS, CHAINS = "space=world,emitter=disc", "draw=metropolis"
# Axes; parameters; frames; whether the package lacks a variant; and a number of the description that is wrong in the
# control, with the formula that takes its place ("it" is the one that was there).
SHORT = {"-": ["it", 1]}
CASES = {
    "default": ("", "lights=256", 1, False, ("uniform.chain_sample.count", SHORT)),
    "one-light": ("", "lights=1", 1, False, ("step.shade.dispatch.0", SHORT)),
    "f16": ("precision=f16", "lights=256", 1, False, ("step.moments.dispatch.1", SHORT)),
    "rgba16float": ("output=rgba16float", "lights=256", 1, False, ("step.shade.dispatch.0", SHORT)),
    "hardware-filter": (
        "filter=hardware,kernel=previous,lobes=diffuse,specular=none,ndf=none", "lights=256,size_factor=0.25", 1, False,
        ("uniform.chain_sample.count", SHORT)),
    "bidirectional": (
        "density=bidirectional", "lights=64,camera_lights=40", 1, False, ("uniform.chain_density.count", SHORT)),
    "visibility": (
        "visibility=shadow_map", "lights=64,tile=32", 1, False,
        ("step.light shadow maps.draw.instances.1", SHORT)),
    "occluders": ("", "lights=64", 1, False, ("step.cluster sort.repeat", SHORT)),
    "points": (
        "visibility=imperfect", "lights=64,tile=16,shadow_points=50,fill_levels=2", 1, False,
        ("uniform.light_maps.levels", SHORT)),
    "clusters": (CLUSTERS, "lights=64", 1, True, ("step.cluster sort.repeat", SHORT)),
    "chains": (CHAINS, "lights=64,mutations=4", 3, True, ("uniform.chains_move.frame", 0)),
    "clusters-of-chains": (f"{CLUSTERS},{CHAINS}", "lights=64", 3, True, ("uniform.clusters_count.count", SHORT)),
}  # fmt: skip

FACTS = {"occluders": "occluders"}
BRIGHTER = "light.intensity=1.001"


def install(folder):
    """The two libraries; the Python that has the first, and the folder that has the second."""
    python, node = folder / "python", folder / "node"
    venv = [[sys.executable, "-m", "venv", python], [python / "bin/pip", "install", "-q", f"wgpu=={WGPU}"]]
    npm = [["npm", "install", "--no-audit", "--no-fund", "--ignore-scripts", f"webgpu@{WEBGPU}"]]
    for made, stamp, commands in ((python, WGPU, venv), (node, WEBGPU, npm)):
        made.mkdir(parents=True, exist_ok=True)
        if not (made / stamp).exists():
            if made == node:
                (node / "package.json").write_text('{"private": true}')
            for command in commands:
                subprocess.run(command, cwd=made, check=True, stdout=subprocess.DEVNULL)
            (made / stamp).touch()
    return python / "bin/python", node


def steps_of(steps):
    """All steps, those in groups behind their group."""
    for step in steps:
        yield step
        yield from steps_of(step.get("steps", []))


def wrong(graph, path, formula):
    """The description with one number made wrong: of a uniform, of a label's step, or how often that is repeated."""
    graph = json.loads(json.dumps(graph))
    table, name, *way = path.split(".")
    if table == "uniform":
        place = graph["uniform"][name]
    else:
        repeated = lambda step: "repeat" in step and any(one.get("label") == name for one in step["steps"])
        has_name = repeated if way == ["repeat"] else lambda step: step.get("label") == name
        place = next(step for step in steps_of(graph["step"]) if has_name(step))
    for key in way[:-1]:
        place = place[key]
    last = int(way[-1]) if way[-1].isdigit() else way[-1]
    put = lambda part: place[last] if part == "it" else part
    is_operation = isinstance(formula, dict)
    place[last] = {key: [*map(put, parts)] for key, parts in formula.items()} if is_operation else formula
    return graph


def layout(package, step, name):
    """The members of an element of a result: (first word, words, scalar type), and the words of an element."""
    manifest = json.loads((package / "manifest.json").read_text())
    variant = next(one for one in manifest["variants"] if one["id"] == step)
    shared = manifest["shared"]
    structs = {one["name"]: one for one in (shared["structs"][key] for key in variant["structs"])}
    bindings = (shared["bindings"][key] for key in variant["bindings"])
    kind = next((one.get("type") for one in bindings if one["name"] == name), None)
    if kind is None or "<" not in kind:
        return [(0, 3, "f32"), (3, 1, "f32")], 4
    members = []

    def walk(struct, offset):
        for field in structs[struct]["fields"]:
            if field["type"] in structs:
                walk(field["type"], offset + field["offset"])
            else:
                scalar = field["type"].rstrip(">").split("<")[-1]
                members.append(((offset + field["offset"]) // 4, field["size"] // 4, scalar))

    element = kind.removeprefix("array<").removesuffix(">")
    walk(element, 0)
    return members, structs[element]["size"] // 4


def difference(one, other, members, stride):
    """The largest difference of two results, relative to the largest component of the vector that a number stands in.

    Vectors below 1e-6 of the largest of their member are compared relative to that. Whole numbers have to be the same,
    and so has what is not finite.
    """
    results = []
    for path in (one, other):
        results.append((array.array("f"), array.array("I")))
        for words in results[-1]:
            words.frombytes(path.read_bytes())
    ((a, a_words), (b, b_words)), largest = results, 0.0
    if len(a) != len(b) or not any(a_words):
        return float("inf")
    for first, count, scalar in members:
        places = range(first, len(a), stride)
        sizes = [max(map(abs, a[i : i + count])) for i in places]
        least = 1e-6 * max(sizes)
        for i, size in zip(places, sizes):
            if a_words[i : i + count] == b_words[i : i + count]:
                continue
            if scalar != "f32":
                return float("inf")
            parts = [abs(x - y) / max(size, least, 1e-38) for x, y in zip(a[i : i + count], b[i : i + count])]
            largest = max([largest, *(part if part == part else float("inf") for part in parts)])
    return largest


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--graph", type=Path)
    parser.add_argument("--runtime", default="cargo run -q --workspace --example host_frame --")
    parser.add_argument("--xtask", default="cargo xtask")
    parser.add_argument("--case", choices=CASES, action="append")
    parser.add_argument("--work", type=Path, default=ROOT / "target/hosts")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--install", action="store_true")
    given = parser.parse_args()
    work = given.work.resolve()
    python, node = install(work)
    if given.install:
        return
    environment = dict(os.environ)
    if Path(SWIFTSHADER).exists():
        environment |= {"VK_ICD_FILENAMES": SWIFTSHADER, "VK_DRIVER_FILES": SWIFTSHADER}
    hosts = {
        "python": [python, HERE / "python/run.py"],
        "javascript": ["node", HERE / "javascript/run.mjs", "--modules", node],
    }
    graph = json.loads((given.graph or COMMITTED / "manifest.json").read_text())
    graph = graph if given.graph else graph["graph"]

    def run(command, out, description, arguments):
        """The results of a program, in a folder."""
        file = out.with_suffix(".graph.json")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(description))
        command = [*command, out, "--graph", file, *arguments]
        ran = subprocess.run(command, env=environment, capture_output=True, text=True)
        if ran.returncode != 0:
            sys.exit(f"{out}: {ran.stderr[-2000:]}")
        return out

    found = []
    print(f"{'frame':20}{'size':>8}{'map':>5}  {'results':24}{'apart':>10}{'control':>10}")
    for case in given.case or CASES:
        axes, parameters, frames, generate, control = CASES[case]
        package = work / "packages" / case if generate else COMMITTED
        if generate:
            command = [*given.xtask.split(), "gen-shaders", "--set", ",".join((VARIANTS, axes)), "--out", package]
            subprocess.run(command, check=True, capture_output=True)
        for size, side in SIZES:
            arguments = ["--set", ",".join(filter(None, (axes, parameters))), "--size", size, "--map", side]
            arguments += ["--frames", str(frames), "--facts", FACTS.get(case, "")]
            out = work / "frames" / f"{case}-{size}"
            shutil.rmtree(out, ignore_errors=True)
            host = lambda name, description, to: run([*hosts[name], package], out / to, description, arguments)
            results = {name: host(name, graph, name) for name in hosts}
            repeat = lambda to, *more: run([*given.runtime.split(), package, out / "python"], out / to, graph, more)
            results |= {"runtime": repeat("runtime"), "brighter": repeat("brighter", "--scale", BRIGHTER)}
            results["wrong"] = host("python", wrong(graph, *control), "wrong")
            shade = json.loads((results["python"] / "configuration.json").read_text())["steps"][-1]
            outputs = [name for name in OUTPUTS if (results["python"] / name).exists()]
            forms = {name: layout(package, shade, f"sglow_{name}") for name in outputs}
            of = lambda a, b, name: min(difference(results[a] / name, results[b] / name, *forms[name]), 1e30)
            # Of halves what is beyond one step.
            half = lambda name: HALF if "rgba16float" in axes and name != "vsgls" else 0.0
            apart = lambda a, b: max(0.0, *(of(a, b, name) - half(name) for name in outputs))
            for a, b, off in (
                ("python", "javascript", "wrong"),
                ("python", "runtime", "brighter"),
                ("javascript", "runtime", "brighter"),
            ):
                one = {"case": case, "size": size, "map": side, "results": [a, b]}
                one |= {"apart": apart(a, b), "control": apart(a, off)}
                one["same"] = one["apart"] <= TOLERANCE < one["control"]
                found.append(one)
                pair = f"{a}, {b}"
                print(f"{case:20}{size:>8}{side:>5}  {pair:24}{one['apart']:>10.1e}{one['control']:>10.1e}", flush=True)
    if given.json:
        given.json.write_text(json.dumps(found, indent=1))
    if failures := sum(not one["same"] for one in found):
        sys.exit(f"{failures} frames are more than {TOLERANCE} apart, or their control is not")


if __name__ == "__main__":
    main()
