"""Holds the frames that both hosts evaluate against those of the crate graph, for random configurations. No device needed.

    python3 agree.py --graph FILE [--number 200] [--seed 1]
"""

import argparse
import json
import random
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE / "python"))
from check import SHORT, wrong  # noqa: E402
from graph import Frame, Problem, Table  # noqa: E402

PARTS = ["indirect", "visibility"]
NODE = """
const { Frame, Problem, read } = await import(process.argv[1]);
const [graph, list] = read((await import('node:fs')).readFileSync(0, 'utf8'));
const frames = list.map(({ axes, parameters, parts }) => {
  try {
    const { resources, steps } = new Frame(graph, axes, parameters, new Set(parts));
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
    """Random values on some axes and of some parameters."""
    chance = random.Random(seed)
    for _ in range(number):
        axes = {name: chance.choice(one["values"]) for name, one in graph["axes"].items() if chance.random() < 0.5}
        axes |= {"light": "spot"} if axes.get("light") == "camera" else {}
        parameters = {"occluder_index_count": 3 * chance.randrange(3)}
        for name, most in {"width": 80, "height": 60, "map": 70, "lights": 90, "camera_lights": 50}.items():
            parameters[name] = chance.randrange(1, most)
        parameters |= {"tile": 2 ** chance.randrange(3, 7), "iterations": chance.randrange(1, 25)}
        yield {"axes": axes, "parameters": parameters, "parts": PARTS}


def of_crate(frame):
    """The crate's frame in the form of the hosts', as far as both have it; None for errors."""
    if "errors" in frame:
        return None

    def value(member):
        [(kind, of)] = member.items()
        if kind == "list":
            return [value(one) for one in of]
        if kind == "input":
            return {"input": of[0], "element": of[1]}
        return {"age": of} if kind == "age" else of

    def group(index):
        bind, uniforms = {}, {}
        for name, binding in frame["groups"][index].items():
            if "view" in binding:
                bind[name] = [binding["view"]["resource"], binding["view"]["level"]]
            else:
                uniforms[name] = {name: value(of) for name, of in frame["uniforms"][binding["uniform"]].items()}
        return {"bind": bind, "uniforms": uniforms}

    steps = []
    for step in frame["steps"]:
        [(kind, of)] = step["action"].items()
        if kind == "clear":
            steps.append([step["new"], of])
        elif kind == "dispatch":
            variant = "-".join([of["variant"]["pass"], *(value for _, value in of["variant"]["axes"])])
            calls = [dict(group(of["group"]), size=of["size"]["groups"])]
            steps.append([step["new"], variant, of["constants"], calls, None])
        else:
            [[variant, fragment]] = of["variants"]
            variant = "-".join([variant["pass"], *(value for _, value in variant["axes"])])
            size = lambda call: [*call["geometry"]["direct"], call["viewport"]]
            calls = [dict(group(call["group"]), size=size(call)) for call in of["calls"]]
            targets = [of["depth"]["resource"], of["indices"]["resource"], [one["resource"] for one in of["vertices"]]]
            steps.append([step["new"], variant, {}, calls, [fragment, *targets]])
    resources = []
    for one in frame["resources"]:
        [(kind, of)] = one["kind"].items()
        resources.append([one["name"].removesuffix(".0").removesuffix(".1"), one["external"], one["kept"], kind, of])
    return [resources, steps]


def is_age(member):
    return isinstance(member, dict) and "age" in member


def of_host(frame):
    """The same of a host's frame."""
    if frame is None:
        return None
    steps = []
    for step in frame["steps"]:
        new = step["new"]
        if step["clear"]:
            steps.append([new, [step["clear"][0], step["bytes"]]])
            continue
        calls, draw = [], step["draw"]
        for call in step["calls"]:
            bind = {name: view for name, view in call["bind"].items() if view}
            uniforms = {
                binding: {name: {"age": of["age"][0]} if is_age(of) else of for name, of in members.items()}
                for binding, members in call["uniforms"].items()
            }
            size = [call["count"], call["instances"] or [0, 1], call["viewport"]] if draw else call["dispatch"]
            calls.append({"bind": bind, "uniforms": uniforms, "size": size})
        shown = None
        if draw:
            vertices = [one["buffer"][0] for one in draw["vertices"]]
            shown = [draw["fragment"], draw["depth"]["target"][0], draw["indices"][0], vertices]
        steps.append([new, step["variant"], step["constants"], calls, shown])
    resources = []
    for one in frame["resources"]:
        [kind] = [kind for kind in ("buffer", "texture", "sampler") if one[kind]]
        of = {"filter": one[kind]} if kind == "sampler" else dict(one[kind])
        if kind == "buffer":
            of["initial"] = one[kind]["initial"]
        resources.append([one["name"], one["external"], bool(one["kept"]), kind, of])
    return [resources, steps]


def evaluated(graph, case):
    """The Python host's frame, or None for what it refuses."""
    try:
        frame = Frame(graph, case["axes"], case["parameters"], set(case["parts"]))
    except Problem:
        return None
    return json.loads(json.dumps({"resources": frame.resources, "steps": frame.steps}), object_hook=Table)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--graph", type=Path, required=True)
    parser.add_argument("--number", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    graph = json.loads(given.graph.read_text(), object_hook=Table)
    cases = list(configurations(graph, given.number, given.seed))
    cargo = ["cargo", "run", "-q", "-p", "sglow-graph", "--example", "evaluate", given.graph.resolve()]
    lines = "\n".join(map(json.dumps, cases))
    crate = subprocess.run(cargo, cwd=HERE, input=lines, capture_output=True, text=True, check=True).stdout.splitlines()
    node = ["node", "--input-type=module", "-e", NODE, (HERE / "javascript/graph.mjs").as_uri()]
    script = subprocess.run(node, input=json.dumps([graph, cases]), capture_output=True, text=True, check=True).stdout
    python = [evaluated(graph, case) for case in cases]
    errors = steps = apart = 0
    for case, line, *hosts in zip(cases, crate, python, json.loads(script, object_hook=Table)):
        expected = of_crate(json.loads(line))
        errors += expected is None
        steps += len(expected[1]) if expected else 0
        for name, host in zip(("python", "javascript"), hosts):
            if of_host(host) != expected:
                apart += 1
                print(f"{name}: another frame for {json.dumps(case)}")
                found = of_host(host)
                if found is None or expected is None:
                    print(f"  crate: {line[:300]}\n  host: {json.dumps(host)[:300]}")
                    continue
                for one, other in zip(expected[0] + expected[1], found[0] + found[1]):
                    if one != other:
                        print(f"  crate {json.dumps(one)}\n  host  {json.dumps(other)}")
                        break
    print(f"{len(cases)} configurations, {errors} refused by all, {steps} steps; {apart} frames apart")
    control = wrong(graph, "mips.step.0.repeat", SHORT)
    seen = sum(of_host(evaluated(control, case)) != of_host(host) for case, host in zip(cases, python))
    print(f"control, mips one round short: {seen} frames apart")
    sys.exit(apart > 0 or seen == 0)


if __name__ == "__main__":
    main()
