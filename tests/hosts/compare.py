"""Compares this evaluator with frames that the library evaluated: `compare.py FILE`, a file of `graph` and `cases`."""

import json
import sys

from graph import Evaluation


def evaluated(frame):
    """A frame of the library in the form of this evaluator's."""
    names = [resource["name"] for resource in frame["resources"]]

    def value(of):
        (kind, content), = of.items()
        if kind == "input":
            return {"input": content[0], "element": content[1]}
        return {"number": lambda: content, "age": lambda: {"age": names[content]},
                "list": lambda: [value(item) for item in content]}[kind]()

    def view(of):
        return of and (names[of["resource"]], of["level"])

    def group(index):
        group = frame["groups"][index].items()
        uniforms = {name: frame["uniforms"][of["uniform"]] for name, of in group if "uniform" in of}
        return {
            "bind": {name: view(of["view"]) for name, of in group if "view" in of},
            "uniforms": {name: {key: value(of) for key, of in members.items()} for name, members in uniforms.items()},
        }

    def size(of):
        (kind, content), = of.items() if isinstance(of, dict) else ((of, None),)
        return (names[content[0]], content[1]) if kind == "indirect" else content

    def action(of):
        (kind, content), = of.items()
        if kind == "clear":
            return {"clear": names[content[0]], "bytes": content[1]}
        if kind == "dispatch":
            return {
                "pass": content["variant"]["pass"], "axes": dict(content["variant"]["axes"]), "entry": content["entry"],
                "constants": content["constants"], "size": size(content["size"]), **group(content["group"]),
            }
        calls = [{"viewport": call["viewport"], "geometry": size(call["geometry"]), **group(call["group"])}
                 for call in content["calls"]]
        return {
            "calls": calls, "color": [view(of) for of in content["color"]], "depth": view(content["depth"]),
            "vertices": [view(of) for of in content["vertices"]], "indices": view(content["indices"]),
        }

    steps = [{"label": step["label"], "part": step["part"], "new": None if step["new"] is None else names[step["new"]],
              **action(step["action"])} for step in frame["steps"]]
    return {resource["name"]: resource["bytes"] for resource in frame["resources"]}, steps


def main():
    document = json.load(open(sys.argv[1], encoding="utf-8"))
    different = 0
    for case in document["cases"]:
        configuration = case["configuration"]
        own = Evaluation(document["graph"], configuration["axes"], configuration["parameters"], configuration["facts"])
        resources = {name: resource["bytes"] for name, resource in own.resources.items()}
        # Of a draw, the library repeats what the description says, and the variants of the host's lists.
        hidden = ("draw", "axes", "pass")
        steps = [{key: of for key, of in step.items() if "draw" not in step or key not in hidden} for step in own.steps]
        if (resources, steps) != evaluated(case["frame"]):
            different += 1
            print("different:", configuration)
    print(f"{different} of {len(document['cases'])} frames differ")
    return different > 0 or not document["cases"]


if __name__ == "__main__":
    sys.exit(main())
