"""From the description of a frame, a package's `graph`, to resources and steps with all numbers known.

Nothing here knows a pass, an axis or a resource by name. The generator has checked the description.
"""

import operator
from dataclasses import dataclass, replace

OPERATIONS = {
    "==": operator.eq, "!=": operator.ne, "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge,
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.floordiv, "%": operator.mod,
    "<<": operator.lshift, ">>": operator.rshift, "!": operator.not_, "min": min, "max": max,
    "div_ceil": lambda a, b: -(-a // b), "log2": lambda a: a.bit_length() - 1, "bits": int.bit_length,
    "pow2_ceil": lambda a: 1 << max(a - 1, 0).bit_length(),
}  # fmt: skip


EMPTY = dict.fromkeys(("let", "alias", "uniform", "resource", "axes", "bind", "uniforms", "constants", "names"), {})
EMPTY |= dict.fromkeys(("step", "steps", "flip", "color", "vertices", "initial", "require", "exclusion"), [])
EMPTY |= {"preset": {}, "prefix": ""}


class Table(dict):
    """A table of the description; what is not written in it is empty or None."""

    def __missing__(self, key):
        return EMPTY.get(key)


class Problem(Exception):
    """What is wrong with a configuration, or missing in what a host has."""


def entry(table, kind, name):
    """The entry of a table, or an error that names it."""
    if name not in table:
        raise Problem(f"no {kind} `{name}`; there are: {', '.join(sorted(table))}")
    return table[name]


def configured(graph, facts, preset, own):
    """Axes and parameters for an input with these facts: defaults of its class, changed by a preset, then by `own`."""
    made = {}
    for rule in graph["default"]:
        if all((fact in facts) == holds for fact, holds in rule["when"].items()) and not own.keys() & rule["unless"]:
            made |= rule["set"]
    made |= (entry(graph["preset"], "preset", preset)["set"] if preset else {}) | own
    axes = {name: value for name, value in made.items() if name not in graph["parameter"]}
    return axes, {name: value for name, value in made.items() if name in graph["parameter"]}


class Frame:
    """The frame for values of axes and parameters by name and facts that hold, as far as it belongs to these parts."""

    def __init__(self, graph, axes, parameters, parts, facts=()):
        self.graph, self.axes, self.parts, self.facts = graph, axes, parts, facts
        self.parameters = {name: one["default"] for name, one in graph["parameter"].items()} | parameters
        self.resources = []  # {name, external, kept, and one of buffer, texture, sampler}
        self.steps = []  # {new, clear, bytes, and variant, entry, constants, calls, draw}
        self.known = {}  # by name: an index, a pair [first, front], an alias (scope, reference), or None
        for name, value in axes.items():
            if value not in entry(graph["axes"], "axis", name)["values"]:
                raise Problem(f"axis {name} is {value}: one of {', '.join(graph['axes'][name]['values'])}")
        for name, value in parameters.items():
            one = entry(graph["parameter"], "parameter", name)
            low, above, high = (one[key] for key in ("minimum", "above", "maximum"))
            if value < (low or 0) or (above is not None and value <= above) or (high is not None and value > high):
                raise Problem(f"parameter {name} is {value}: minimum {low}, above {above}, maximum {high}")
        self.root = Scope(self, graph["template"]["frame"])
        for one in graph["require"]:
            if not self.root.resolve(one["that"]):
                raise Problem(one["reason"])
        self.root.enter("", True, None)


@dataclass(frozen=True)
class Scope:
    """What names mean in the frame or in the use of a template, and in rounds of repetitions, the innermost last."""

    frame: Frame
    template: dict
    prefix: str = ""
    caller: "Scope | None" = None
    use: dict | None = None  # the caller's step that uses the template
    rounds: tuple = ()  # (name of the round's number, the number, lets of the round)

    def number(self, name):
        for depth in range(len(self.rounds), 0, -1):
            index, number, lets = self.rounds[depth - 1]
            if name == index:
                return number
            if name in lets:
                return replace(self, rounds=self.rounds[:depth]).resolve(lets[name])
        if self.caller and name in self.use["let"]:
            return self.caller.resolve(self.use["let"][name])
        if name in self.template["let"]:
            return replace(self, rounds=()).resolve(self.template["let"][name])
        if self.caller:
            return self.frame.root.number(name)
        if name in self.frame.graph["facts"]:
            return int(name in self.frame.facts)
        return entry(self.frame.parameters, "number", name)

    def formula(self, tree, text):
        """A whole number of 64 bits, or the real parameter that is the whole formula."""
        if not isinstance(tree, dict):
            return self.number(tree) if isinstance(tree, str) else tree
        [(symbol, arguments)] = tree.items()
        if symbol == "is":
            return int(self.axis(arguments[0]) == arguments[1])
        first = self.formula(arguments[0], text)
        if symbol == "select":
            return self.formula(arguments[1 if first else 2], text)
        if symbol in ("&&", "||"):
            return int((self.formula(arguments[1], text) if (first != 0) == (symbol == "&&") else first) != 0)
        numbers = [first, *(self.formula(argument, text) for argument in arguments[1:])]
        by_zero = symbol in ("/", "%", "div_ceil") and numbers[1] == 0
        result = -1 if by_zero else int(entry(OPERATIONS, "operation", symbol)(*numbers))
        if not all(isinstance(number, int) for number in numbers) or not 0 <= result < 1 << 64:
            raise Problem(f"`{text}`: {symbol} of {numbers} is no whole number of 64 bits")
        return result

    def axis(self, name):
        """Of the innermost use that has a value; else what follows from others, is configured, or is the default."""
        scope, graph = self, self.frame.graph
        while scope.caller:
            if value := scope.caller.resolve(scope.use["axes"].get(name)):
                return value
            scope = scope.caller
        value = replace(self, rounds=()).resolve(graph["choose"].get(name)) or self.frame.axes.get(name)
        return value or entry(graph["axes"], "axis", name)["default"]

    def target(self, reference):
        """What a reference stands for, and which side of a pair."""
        name, side, known = reference["resource"], None, self.frame.known
        if self.caller and name in self.use["names"]:
            found, side = self.caller.target(self.use["names"][name])
        elif self.caller and self.prefix + name not in known:
            found, side = self.frame.root.target(reference)
        else:
            found = entry(known, "resource", self.prefix + name)
            if isinstance(found, tuple):
                found, side = found[0].target(found[0].case(found[1]))
        return found, reference["side"] or side

    def input(self, name):
        return self.caller.input(self.use["names"].get(name, {"resource": name})["resource"]) if self.caller else name

    def case(self, value):
        """A value, or that of the first case that applies; None if there is none."""
        if not (isinstance(value, list) and value and isinstance(value[0], dict) and "value" in value[0]):
            return value
        return next((one["value"] for one in value if one["when"] is None or self.resolve(one["when"])), None)

    def resolve(self, value):
        """A part of the description with numbers for formulas, (index, level) for references, None if it is absent."""
        value = self.case(value)
        if isinstance(value, list):
            return [self.resolve(one) for one in value]
        if not isinstance(value, dict):
            return value
        if "tree" in value:
            return self.formula(value["tree"], value["text"])
        if "resource" in value:
            found, side = self.target(value)
            if isinstance(found, list):
                found = found[0] + (found[1] if side == "front" else 1 - found[1])
            return None if found is None else (found, self.resolve(value["level"]))
        if "input" in value:
            return Table(input=self.input(value["input"]), element=self.resolve(value["element"]))
        return Table((name, self.resolve(one)) for name, one in value.items())

    def enter(self, part, run, new):
        """Makes known what the template has, and runs its steps."""
        known, resources = self.frame.known, self.frame.resources
        known |= {self.prefix + name: (self, choice) for name, choice in self.template["alias"].items()}
        for name, one in self.template["resource"].items():
            name, found = self.prefix + name, None
            if run and (one["when"] is None or self.resolve(one["when"])):
                external = bool(one["external"]) or (one["part"] or part or None) not in {None, *self.frame.parts}
                made = Table(self.resolve(one), name=name, external=external)
                found = [len(resources), 0] if one["flip"] else len(resources)
                resources += [made, made] if one["flip"] else [made]
            known[name] = found
        self.run(self.template["step"], part, run, new)

    def run(self, steps, part, run, new):
        frame = self.frame
        for step in steps:
            own, runs = step["part"] or part, bool(run and (step["when"] is None or self.resolve(step["when"])))
            active, rounds = runs and (not own or own in frame.parts), self.resolve(step["repeat"]) if runs else None
            own_new = self.resolve(step["new"])[0] if active and step["new"] else new
            if step["use"]:
                template = entry(frame.graph["template"], "template", step["use"])
                Scope(frame, template, self.prefix + step["prefix"], self, step).enter(own, runs, own_new)
            elif step["steps"] and rounds is None:
                self.run(step["steps"], own, runs, own_new)
            elif step["steps"]:
                for number in range(rounds):
                    inner = replace(self, rounds=(*self.rounds, (step["index"], number, step["let"])))
                    inner.run(step["steps"], own, True, own_new)
                    for name in step["flip"]:
                        pair, _ = self.target({"resource": name, "side": None})
                        pair[1] = 1 - pair[1]
            elif active:
                frame.steps.append(Table(self.work(step), new=own_new))

    def work(self, step):
        """A clear, or a dispatch or a render pass: what it runs, and its calls with bindings of their own."""
        work = {key: self.resolve(step[key]) for key in ("clear", "bytes", "constants", "entry")}
        if step["clear"]:
            return work
        draw, axes = step["draw"] or Table(), entry(self.frame.graph["passes"], "pass", step["pass"])
        values = [self.resolve(step["axes"].get(axis)) or self.axis(axis) for axis in axes]
        chosen = dict(zip(axes, values))
        # An identifier leaves out the default of an axis that is implied.
        known = ((value, self.frame.graph["axes"][axis]) for axis, value in chosen.items())
        named = [value for value, of in known if not of["implied"] or value != of["default"]]
        variant = "-".join([step["pass"], *named])
        for rule in [] if draw["list"] else self.frame.graph["exclusion"]:
            illegal = all(chosen.get(axis) in of for axis, of in rule["when"].items())
            if illegal and rule["pass"] in (None, step["pass"]):
                raise Problem(f"{variant} is excluded by {rule['name']}: {rule['reason']}")
        known = self.frame.root.template["uniform"] | self.template["uniform"]
        call = {key: step[key] for key in ("bind", "dispatch", "indirect")}
        call["uniforms"] = {name: entry(known, "uniform", uniform) for name, uniform in step["uniforms"].items()}
        call |= {key: draw[key] for key in ("count", "instances", "viewport")}
        shared = Table((key, one) for key, one in draw.items() if key not in call and key != "repeat")
        times = 1 if draw["repeat"] is None else self.resolve(draw["repeat"])
        rounds = [(*self.rounds, (draw["index"], number, {})) for number in range(times)]
        calls = [replace(self, rounds=one).resolve(call) for one in rounds]
        return work | {"variant": variant, "calls": calls, "draw": self.resolve(shared)}
