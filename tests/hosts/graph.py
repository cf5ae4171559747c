"""Evaluates the frame of a package's manifest: from `graph` and a configuration to resources and steps.

The language is described in graph/src/lib.rs. Errors are Python's own: the generator has checked the description.
"""

OPERATIONS = {
    "==": lambda a, b: a == b, "!=": lambda a, b: a != b, "<": lambda a, b: a < b, ">": lambda a, b: a > b,
    "<=": lambda a, b: a <= b, ">=": lambda a, b: a >= b, "<<": lambda a, b: a << b, ">>": lambda a, b: a >> b,
    "+": lambda a, b: a + b, "-": lambda a, b: a - b, "*": lambda a, b: a * b, "/": lambda a, b: a // b,
    "%": lambda a, b: a % b, "!": lambda a: not a, "min": min, "max": max, "div_ceil": lambda a, b: -(-a // b),
    "log2": lambda a: a.bit_length() - 1, "pow2_ceil": lambda a: 1 << max(a - 1, 0).bit_length(),
    "bits": lambda a: a.bit_length(),
}
TEXEL = {"r32float": 4, "depth32float": 4, "rgba16float": 8, "rgba32float": 16, "rgba8unorm": 4, "r8unorm": 1}


class Scope:
    """The frame, or one use of a template; or one round of a repetition within it."""

    def __init__(self, evaluation, template, prefix="", caller=None, step=None, numbers=None, outer=None):
        self.of, self.template, self.prefix, self.caller, self.step = evaluation, template, prefix, caller, step
        self.numbers, self.outer = numbers or {}, outer

    def round(self, numbers, lets):
        scope = Scope(self.of, self.template, self.prefix, self.caller, self.step, numbers, self)
        scope.lets = lets
        return scope

    def number(self, name):
        scope = self
        while scope.outer:
            if name in scope.numbers:
                return scope.numbers[name]
            if name in scope.lets:
                return scope.formula(scope.lets[name])
            scope = scope.outer
        if scope.caller and name in scope.step.get("let", {}):
            return scope.caller.formula(scope.step["let"][name])
        if name in scope.template.get("let", {}):
            return scope.formula(scope.template["let"][name])
        if scope.caller:
            return self.of.root.number(name)
        known = self.of.graph.get("parameter", {})
        if name in known:
            return self.of.parameters.get(name, known[name]["default"])
        return int(self.of.facts.get(name, False))

    def formula(self, formula):
        return self.tree(formula["tree"])

    def tree(self, tree):
        if isinstance(tree, int):
            return tree
        if isinstance(tree, str):
            return self.number(tree)
        (operation, arguments), = tree.items()
        if operation == "is":
            return int(self.axis(arguments[0]) == arguments[1])
        first = self.tree(arguments[0])
        if operation in ("&&", "||"):
            return int(bool(self.tree(arguments[1]))) if bool(first) == (operation == "&&") else int(bool(first))
        if operation == "select":
            return self.tree(arguments[1 if first else 2])
        return int(OPERATIONS[operation](first, *(self.tree(argument) for argument in arguments[1:])))

    def holds(self, item):
        return "when" not in item or self.formula(item["when"]) != 0

    def choose(self, choice):
        if not isinstance(choice, list):
            return choice
        return next((case["value"] for case in choice if self.holds(case)), None)

    def axis(self, name):
        scope = self
        while scope.caller:
            value = scope.caller.choose(scope.step.get("axes", {}).get(name))
            if value is not None:
                return value
            scope = scope.caller
        value = self.choose(self.of.graph.get("choose", {}).get(name))
        return value or self.of.axes.get(name) or self.of.graph["axes"][name]["default"]

    def view(self, reference):
        """(resource, level), or None where the resource does not exist."""
        name, side = reference["resource"], reference.get("side")
        level = self.formula(reference["level"]) if "level" in reference else None
        if self.caller and name in self.step.get("names", {}):
            found = self.caller.view({**self.step["names"][name], **({"side": side} if side else {})})
            return found and (found[0], found[1] if level is None else level)
        known = self.of.known.get(self.prefix + name, "nothing")
        if known == "nothing":
            return self.of.root.view(reference) if self.caller else self.of.known[name]
        if isinstance(known, tuple):
            scope, choice = known
            found = scope.view({**scope.choose(choice), **({"side": side} if side else {})})
            return found and (found[0], found[1] if level is None else level)
        if isinstance(known, list):
            return known[0 if side == "front" else 1], level
        return known and (known, level)

    def input(self, name):
        if not self.caller:
            return name
        return self.caller.input(self.step.get("names", {}).get(name, {"resource": name})["resource"])

    def field(self, field):
        if isinstance(field, list):
            return [self.field(item) for item in field]
        if not isinstance(field, dict):
            return field
        if "age" in field:
            return {"age": self.view(field["age"])[0]}
        if "input" in field:
            element = self.formula(field["element"]) if "element" in field else None
            return {"input": self.input(field["input"]), "element": element}
        return self.formula(field)


class Evaluation:
    def __init__(self, graph, axes=(), parameters=(), facts=(), parts=None):
        self.graph, self.axes, self.parameters = graph, dict(axes), dict(parameters)
        self.facts, self.parts = dict(facts), parts
        self.known, self.resources, self.steps = {}, {}, []
        self.root = Scope(self, graph["template"]["frame"])
        self.run(self.root, "", "", True)

    def run(self, scope, label, part, runs):
        for name, choice in scope.template.get("alias", {}).items():
            self.known[scope.prefix + name] = (scope, choice)
        for name, resource in scope.template.get("resource", {}).items():
            name = scope.prefix + name
            self.known[name] = None
            if runs and scope.holds(resource):
                pair = [name + ".0", name + ".1"]
                self.known[name] = pair if resource.get("flip") else name
                for one in pair if resource.get("flip") else [name]:
                    self.resources[one] = self.resource(scope, resource, part)
        for step in scope.template.get("step", []):
            self.step(scope, step, label, part, runs)

    def resource(self, scope, resource, part):
        part = resource.get("part", part)
        external = bool(resource.get("external")) or not self.has(part)
        result = {"part": part, "external": external, "kept": bool(resource.get("kept")), "bytes": 0}
        if "buffer" in resource:
            length, stride = (scope.formula(resource["buffer"][key]) for key in ("length", "stride"))
            return {**result, "length": length, "stride": stride, "bytes": length * stride,
                    "initial": resource["buffer"].get("initial", [])}
        if "sampler" in resource:
            return {**result, "filter": resource["sampler"]}
        texture = resource["texture"]
        size = [scope.formula(side) for side in texture["size"]]
        layers, levels = (scope.formula(texture[key]) for key in ("layers", "levels"))
        format = scope.choose(texture["format"])
        texels = sum(max(size[0] >> level, 1) * max(size[1] >> level, 1) for level in range(levels))
        return {**result, "format": format, "size": size, "layers": layers, "levels": levels,
                "bytes": texels * layers * TEXEL[format]}

    def has(self, part):
        return self.parts is None or part in self.parts

    def step(self, scope, step, label, part, runs):
        runs = runs and scope.holds(step)
        part = step.get("part", part)
        label = scope.prefix.replace("_", " ") + step["label"] if "label" in step else label
        if "use" in step:
            template = self.graph["template"][step["use"]]
            return self.run(Scope(self, template, scope.prefix + step.get("prefix", ""), scope, step), label, part, runs)
        if "steps" in step:
            rounds = scope.formula(step["repeat"]) if runs and "repeat" in step else 1
            for number in range(rounds):
                inner = scope
                if runs and "repeat" in step:
                    inner = scope.round({step.get("index"): number}, step.get("let", {}))
                for one in step["steps"]:
                    self.step(inner, one, label, part, runs)
                for name in step.get("flip", []) if runs else []:
                    self.known[scope.prefix + name].reverse()
            return None
        if not runs or not self.has(part):
            return None
        new = scope.view(step["new"])[0] if "new" in step else None
        result = {"label": label, "part": part, "new": new}
        if "clear" in step:
            bytes = scope.formula(step["bytes"]) if "bytes" in step else None
            return self.steps.append({**result, "clear": scope.view(step["clear"])[0], "bytes": bytes})
        result["pass"] = step["pass"]
        if "draw" in step:
            return self.steps.append({**result, **self.draw(scope, step, step["draw"])})
        result.update({
            "axes": self.variant(scope, step), "entry": step.get("entry"),
            "constants": {name: scope.formula(of) for name, of in step.get("constants", {}).items()},
        })
        size = self.indirect(scope, step) or [scope.formula(size) for size in step["dispatch"]]
        return self.steps.append({**result, "size": size, **self.bindings(scope, step)})

    def indirect(self, scope, step):
        if "indirect" in step:
            return scope.view(step["indirect"]["buffer"])[0], scope.formula(step["indirect"]["offset"])

    def draw(self, scope, step, draw):
        """One render pass. What its clears, comparison and attributes are stands in the description."""
        calls = []
        for number in range(scope.formula(draw["repeat"]) if "repeat" in draw else 1):
            inner = scope.round({draw.get("index"): number}, {})
            indirect = self.indirect(inner, step)
            count = None if indirect or "list" in draw else inner.formula(draw["count"])
            calls.append({
                "viewport": [inner.formula(side) for side in draw["viewport"]] if "viewport" in draw else None,
                "geometry": indirect or (count and [count, [inner.formula(of) for of in draw.get("instances", [])]]),
                **self.bindings(inner, step),
            })
        return {
            "draw": draw, "axes": None if "list" in draw else self.variant(scope, step), "calls": calls,
            "color": [scope.view(target["target"]) for target in draw.get("color", [])],
            "depth": scope.view(draw["depth"]["target"]) if "depth" in draw else None,
            "vertices": [scope.view(of["buffer"]) if "buffer" in of else None for of in draw.get("vertices", [])],
            "indices": scope.view(draw["indices"]) if "indices" in draw else None,
        }

    def variant(self, scope, step):
        own = step.get("axes", {})
        axes = self.graph["passes"].get(step["pass"], [])
        return {axis: scope.choose(own.get(axis)) or scope.axis(axis) for axis in axes}

    def bindings(self, scope, step):
        views = {name: scope.choose(choice) for name, choice in step.get("bind", {}).items()}
        views = {name: scope.view(reference) for name, reference in views.items() if reference}
        uniforms = {}
        for binding, name in step.get("uniforms", {}).items():
            fields = scope.template.get("uniform", {}).get(name) or self.root.template["uniform"][name]
            uniforms[binding] = {member: scope.field(field) for member, field in fields.items()}
        return {"bind": {name: view for name, view in views.items() if view}, "uniforms": uniforms}
