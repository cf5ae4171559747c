"""From the description of a frame, a package's `graph`, to resources and steps with all numbers known.

Nothing here knows a pass, an axis or a resource by name. The generator has checked the description.
"""

import json
import operator
from copy import copy

OPERATIONS = {
    "==": operator.eq, "!=": operator.ne, "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge,
    "+": operator.add, "-": operator.sub, "*": operator.mul, "<<": operator.lshift, ">>": operator.rshift,
    "/": lambda a, b: a // b if b else -1, "%": lambda a, b: a % b if b else -1, "!": operator.not_,
    "div_ceil": lambda a, b: -(-a // b) if b else -1, "min": min, "max": max, "bits": int.bit_length,
    "log2": lambda a: a.bit_length() - 1, "pow2_ceil": lambda a: 1 << max(a - 1, 0).bit_length(),
}  # fmt: skip
FORMULAS = {"name", "is", "select", "&&", "||", *OPERATIONS}


class Problem(Exception):
    """What is wrong with a configuration, or missing in what a host has."""


def entry(table, kind, name):
    """The entry of a table, or an error that names it."""
    if name not in table:
        raise Problem(f"no {kind} `{name}`; there are: {', '.join(sorted(table))}")
    return table[name]


class Frame:
    """Some parts of the frame of an input with these facts: by defaults of its class, a preset, and `own` values."""

    def __init__(self, graph, parts, facts=(), preset=None, own=()):
        self.graph, self.facts, self.rounds, self.known = graph, facts, {}, {}  # known: an index of resources, or None
        self.resources, self.steps, self.parts = [], [], {None, *parts}  # what is of no part always runs
        defaults = lambda table: {name: one["default"] for name, one in graph[table].items()}
        self.axes, self.parameters, given = defaults("axes"), defaults("parameter"), {}
        later = (entry(graph["preset"], "preset", preset)["set"] if preset else {}) | dict(own)
        for rule in [{"set": later}, *graph.get("default", [])]:  # each rule sees what is set before it
            if self.holds(rule) and not set(own) & set(rule.get("unless", [])):
                given |= rule["set"] | later
                for name, value in given.items():
                    self.set(name, value)
        for rule in graph.get("exclusion", []):
            if "passes" not in rule and self.holds(rule):
                raise Problem(rule["reason"])
        for name, one in graph["resource"].items():
            exists = self.holds(one)
            self.known[name] = len(self.resources) if exists else None
            external = one.get("external", False) or one.get("part") not in self.parts
            self.resources += [self.resolve(one) | {"name": name, "external": external}] if exists else []
        self.run(graph["step"])

    def set(self, name, value):
        if of := self.graph["parameter"].get(name):
            self.parameters[name] = value
            allowed = of.get("minimum", 0) <= value <= of.get("maximum", value) and value > of.get("above", -1)
        else:
            self.axes[name] = value
            allowed = value in entry(self.graph["axes"], "axis", name)["values"]
        if not allowed:
            raise Problem(f"{name} is {value}: {json.dumps(of or self.graph['axes'][name])}")

    def named(self, name):
        if name in self.rounds:
            return self.rounds[name]
        if name in self.graph["let"]:
            return self.number(self.graph["let"][name])
        return int(name in self.facts) if name in self.graph["facts"] else entry(self.parameters, "number", name)

    def number(self, formula):
        """A whole number of 64 bits, or the real parameter that is the whole formula."""
        if not isinstance(formula, dict):
            return formula
        [(symbol, arguments)] = formula.items()
        if symbol == "name":
            return self.named(arguments)
        if symbol == "is":
            return int(entry(self.axes, "axis", arguments[0]) == arguments[1])
        first = self.number(arguments[0])
        if symbol == "select":
            return self.number(arguments[1 if first else 2])
        if symbol in ("&&", "||"):
            decided = (first != 0) == (symbol == "||")
            return int((first if decided else self.number(arguments[1])) != 0)
        numbers = [first, *map(self.number, arguments[1:])]
        result = int(OPERATIONS[symbol](*numbers))
        if not all(isinstance(number, int) for number in numbers) or not 0 <= result < 1 << 64:
            raise Problem(f"{symbol} of {numbers} is no whole number of 64 bits")
        return result

    def holds(self, one):
        """Whether the condition of a rule, a case, a resource or a step is met, if it has one."""
        return self.number(one.get("when", 1)) != 0

    def resolve(self, value):
        """A part of the description with numbers for formulas, and (index, level) or None for references."""
        if isinstance(value, list) and any(isinstance(one, dict) and "value" in one for one in value):
            return self.resolve(next((case["value"] for case in value if self.holds(case)), None))
        if isinstance(value, list):
            return [self.resolve(one) for one in value]
        if not isinstance(value, dict):
            return value
        if len(value) == 1 and value.keys() <= FORMULAS:
            return self.number(value)
        if "resource" in value:
            index, level = entry(self.known, "resource", value["resource"]), value.get("level")
            return None if index is None else (index, self.resolve(level))
        return {name: self.resolve(one) for name, one in value.items()}

    def repeated(self, of):
        """The rounds of a group or the calls of a draw; in each its number is known."""
        for number in range(self.number(of.get("repeat", 1))):
            self.rounds[of.get("index")] = number
            yield

    def run(self, steps):
        for step in filter(self.holds, steps):
            for _ in self.repeated(step):
                self.run(step.get("steps", []))
            if "steps" not in step and step.get("part") in self.parts:
                self.steps.append(self.work(step) if "pass" in step else self.resolve(step))

    def work(self, step):
        """A dispatch or a render pass: what is the same for all its calls, what it runs, and the calls."""
        draw, axes = step.get("draw", {}), entry(self.graph["passes"], "pass", step["pass"])
        chosen = {axis: self.resolve(step.get("axes", {}).get(axis)) or self.axes[axis] for axis in axes}
        # An identifier leaves out the default of an axis that is implied.
        implied = {axis: one["default"] for axis, one in self.graph["axes"].items() if "implied" in one}
        variant = "-".join([step["pass"], *(value for axis, value in chosen.items() if implied.get(axis) != value)])
        of_variant = copy(self)
        of_variant.axes = chosen
        for rule in [] if "list" in draw else self.graph.get("exclusion", []):
            if step["pass"] in rule.get("passes", []) and of_variant.holds(rule):
                raise Problem(f"{variant} is excluded by {rule['name']}: {rule['reason']}")
        uniforms = {binding: self.graph["uniform"][name] for binding, name in step.get("uniforms", {}).items()}
        step = {"bind": {}, "constants": {}} | step | {"uniforms": uniforms}
        calls = [self.resolve(step) for _ in self.repeated(draw)]
        # What is the same for all calls is there without any as well.
        self.rounds[draw.get("index")] = 0
        return self.resolve(step) | {"variant": variant, "calls": calls}
