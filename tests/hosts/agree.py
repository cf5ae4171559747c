"""Holds the frames that both hosts evaluate against those that the crate graph evaluated. No device needed.

    python3 agree.py FILE                              {"graph", "cases": [{"configuration", "frame"}]}
    python3 agree.py [--graph FILE] [--number 200]     random configurations, by the crate's example `evaluate`,
                     [--evaluate COMMAND]              which that runs

The second also compares the numbers that hosts compute with the package's inputs.json.
--graph: the description as JSON, if not that of the committed package.
"""

import argparse
import json
import random
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE / "python"))
from check import CASES, COMMITTED, SHORT, wrong  # noqa: E402
from graph import Frame, Problem  # noqa: E402
from inputs import INPUTS as python_inputs  # noqa: E402

PARTS = ["surfaces", "lights", "visibility", "shading", "picture"]
INPUTS = """
const { INPUTS } = await import(process.argv[1]);
const list = JSON.parse((await import('node:fs')).readFileSync(0, 'utf8'));
console.log(JSON.stringify(list.map(({ name, given }) => INPUTS[name](given))));
"""
NODE = """
const { Frame, Problem } = await import(process.argv[1]);
const [graph, list] = JSON.parse((await import('node:fs')).readFileSync(0, 'utf8'));
const frames = list.map(({ axes, parameters, parts, facts, preset, set }) => {
  try {
    // What is no change of the defaults of a class has those of none.
    const of = set ? graph : { ...graph, default: [] };
    const { resources, steps } = new Frame(of, parts, facts, preset, set ?? { ...axes, ...parameters });
    return { resources, steps };
  } catch (error) {
    if (error instanceof Problem) return null;
    throw error;
  }
});
const isView = (one) => one && typeof one === 'object' && Object.hasOwn(one, 'level');
console.log(JSON.stringify(frames, (_, one) => (isView(one) ? [one.index, one.level] : one)));
"""


def configurations(graph, number, seed):
    """Random values on some axes and of some parameters, and some parts of the frame."""
    chance = random.Random(seed)
    for _ in range(number):
        axes = {name: chance.choice(one["values"]) for name, one in graph["axes"].items() if chance.random() < 0.5}
        axes |= {"light": "spot"} if axes.get("light") == "camera" else {}
        parameters = {"occluder_index_count": 3 * chance.randrange(3)}
        for name, most in {"width": 80, "height": 60, "map": 70, "lights": 90, "camera_lights": 50}.items():
            parameters[name] = chance.randrange(1, most)
        parameters |= {"tile": 2 ** chance.randrange(3, 7), "iterations": chance.randrange(1, 25)}
        parts = chance.choice([["lights", "visibility", "shading"], PARTS, None])
        facts = {name: chance.random() < 0.5 for name in graph["facts"]}
        given = {"parts": parts, "facts": facts}
        if chance.random() < 0.5:
            preset = chance.choice([None, *graph["preset"]])
            few = dict(chance.sample([*axes.items()], min(len(axes), chance.randrange(4))))
            yield given | {"preset": preset, "set": few | parameters}
        else:
            yield given | {"axes": axes, "parameters": parameters}


def of_crate(frame):
    """The crate's frame in the form of the hosts', as far as both have it; None for errors."""
    if "errors" in frame:
        return None
    view = lambda of: of and [of["resource"], of["level"]]
    name = lambda index: None if index is None else frame["resources"][index]["name"]

    def value(member):
        [(kind, of)] = member.items()
        if kind == "list":
            return [value(one) for one in of]
        if kind == "input":
            return {"input": of[0], "element": of[1]}
        return {"age": name(of)} if kind == "age" else of

    def call(index, size):
        group = frame["groups"][index].items()
        uniforms = {name: frame["uniforms"][of["uniform"]] for name, of in group if "uniform" in of}
        return {
            "bind": {name: view(of["view"]) for name, of in group if "view" in of},
            "uniforms": {name: {key: value(of) for key, of in one.items()} for name, one in uniforms.items()},
            "size": size,
        }

    def size(of):
        """Workgroups; vertices, first instance and instances; a buffer's arguments; or nothing for a list of draws."""
        return None if of == "list" else next(iter(of.values()))

    steps = []
    for step in frame["steps"]:
        [(kind, of)] = step["action"].items()
        found = {"new": name(step["new"]), "clear": of if kind == "clear" else None}
        variant = of["variant"] if kind == "dispatch" else None
        if kind == "draw" and not of["description"].get("list"):
            [[variant, _]] = of["variants"]
        if variant:
            found["variant"] = variant["id"]
        if kind == "dispatch":
            found |= {"constants": of["constants"], "calls": [call(of["group"], size(of["size"]))]}
        if kind == "draw":
            found["calls"] = [call(one["group"], [size(one["geometry"]), one["viewport"]]) for one in of["calls"]]
            targets = [view(one) for one in [*of["color"], of["depth"], of["indices"]]]
            found["draw"] = [of["description"]["vertex"], targets, [view(one) for one in of["vertices"]]]
        steps.append(found)
    resources = []
    for one in frame["resources"]:
        [(kind, of)] = one["kind"].items()
        resources.append([one["name"], one["external"], one["kept"], kind, of])
    return [resources, steps]


def of_host(frame):
    """The same of a host's frame."""
    if frame is None:
        return None

    def member(of):
        if isinstance(of, dict) and "input" in of:
            return {"input": of["input"], "element": of.get("element")}
        return [member(one) for one in of] if isinstance(of, list) else of

    def call(one, draw):
        bind = {name: view for name, view in one["bind"].items() if view}
        uniforms = {name: {key: member(of) for key, of in of.items()} for name, of in one["uniforms"].items()}
        size = one.get("dispatch") or (one.get("indirect") and [one["indirect"][0], one.get("offset", 0)])
        if draw:
            direct = size or [one["draw"].get("count"), one["draw"].get("instances", [0, 1])]
            size = [None if "list" in draw else direct, one["draw"].get("viewport")]
        return {"bind": bind, "uniforms": uniforms, "size": size}

    steps = []
    for step in frame["steps"]:
        draw, clear = step.get("draw"), step.get("clear")
        found = {"new": step.get("new"), "clear": clear and [clear[0], step.get("bytes")]}
        if not clear:
            found |= {"variant": step["variant"]} if not (draw and "list" in draw) else {}
            found["calls"] = [call(one, draw) for one in step["calls"]]
        if draw:
            targets = [*(one["target"] for one in draw.get("color", [])), draw.get("depth", {}).get("target")]
            vertices = [one.get("buffer") for one in draw.get("vertices", [])]
            found["draw"] = [draw["vertex"], [*targets, draw.get("indices")], vertices]
        elif not clear:
            found["constants"] = step["constants"]
        steps.append(found)
    resources = []
    for one in frame["resources"]:
        [kind] = [kind for kind in ("buffer", "texture", "sampler") if kind in one]
        of = one[kind] if kind == "sampler" else dict(one[kind])
        if kind == "buffer":
            of["initial"] = one[kind].get("initial", [])
        resources.append([one["name"], one["external"], one.get("kept", False), kind, of])
    return [resources, steps]


def evaluated(graph, case):
    """The Python host's frame, or None for what it refuses."""
    try:
        # What is no change of the defaults of a class has those of none.
        of = graph if "set" in case else graph | {"default": []}
        own = case.get("set", case.get("axes", {}) | case.get("parameters", {}))
        frame = Frame(of, case["parts"], case["facts"], case.get("preset"), own)
    except Problem:
        return None
    return json.loads(json.dumps({"resources": frame.resources, "steps": frame.steps}))


def node(script, module, data):
    """What a script in JavaScript says of data, with a module of the host; None without Node."""
    if not shutil.which("node"):
        return None
    command = ["node", "--input-type=module", "-e", script, (HERE / "javascript" / module).as_uri()]
    text = subprocess.run(command, input=json.dumps(data), stdout=-1, text=True, check=True).stdout
    return json.loads(text)


def inputs():
    """How many numbers that hosts compute are not what the package says."""
    examples = json.loads((COMMITTED / "inputs.json").read_text())["inputs"]
    cases = [{"name": name, **one} for name, list in examples.items() for one in list]
    hosts = {"python": [python_inputs[one["name"]](one["given"]) for one in cases]}
    if (script := node(INPUTS, "inputs.mjs", cases)) is not None:
        hosts["javascript"] = script
    near = lambda one, other: abs(one - other) <= 1e-6 * abs(other)
    apart = 0
    for name, results in hosts.items():
        for one, result in zip(cases, results):
            if not near(result, one["result"]) or (result and near(1.0001 * result, one["result"])):
                apart += 1
                print(f"{name}: {result} for {json.dumps(one)}")
    print(f"{' and '.join(hosts)}: {len(cases)} numbers that a host computes; {apart} apart")
    return apart


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path, nargs="?")
    parser.add_argument("--graph", type=Path)
    parser.add_argument("--number", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--evaluate", default="cargo run -q -p sglow-graph --example evaluate")
    given = parser.parse_args()
    if given.file:
        document = json.loads(given.file.read_text())
        graph, cases = document["graph"], [case["configuration"] for case in document["cases"]]
        crate = [case["frame"] for case in document["cases"]]
    else:
        graph = json.loads((given.graph or COMMITTED / "manifest.json").read_text())
        graph = graph if given.graph else graph["graph"]
        cases = list(configurations(graph, given.number, given.seed))
        lines = "\n".join(map(json.dumps, [graph, *cases]))
        ran = subprocess.run(given.evaluate.split(), cwd=HERE, input=lines, stdout=-1, text=True, check=True)
        crate = [json.loads(line) for line in ran.stdout.splitlines()]
    facts = lambda case: {"facts": [name for name, holds in case["facts"].items() if holds]}
    cases = [case | facts(case) | {"parts": case.get("parts") or PARTS} for case in cases]
    hosts = {"python": [evaluated(graph, case) for case in cases]}
    if (script := node(NODE, "graph.mjs", [graph, cases])) is not None:
        hosts["javascript"] = script
    errors = steps = apart = 0
    for case, frame, *of in zip(cases, crate, *hosts.values()):
        expected = of_crate(frame)
        errors += expected is None
        steps += len(expected[1]) if expected else 0
        for name, host in zip(hosts, of):
            found = of_host(host)
            if found != expected:
                apart += 1
                print(f"{name}: another frame for {json.dumps(case)}")
                pairs = zip(sum(expected or [[json.dumps(frame)]], []), sum(found or [["no frame"]], []))
                one, other = next((pair for pair in pairs if pair[0] != pair[1]), ("fewer or more", "than the other"))
                print(f"  crate {one}\n  host  {other}")
    names = " and ".join(hosts)
    print(f"{names}: {len(cases)} configurations, {errors} refused by all, {steps} steps; {apart} frames apart")
    for *_, of_frame in CASES.values():
        wrong(graph, *of_frame)  # names something that the description has
    control = wrong(graph, "step.mip moments.repeat", SHORT)
    seen = sum(of_host(evaluated(control, case)) != of_host(host) for case, host in zip(cases, hosts["python"]))
    print(f"control, mips of moments one round short: {seen} frames apart")
    apart += 0 if given.file else inputs()
    sys.exit(apart > 0 or seen == 0)


if __name__ == "__main__":
    main()
