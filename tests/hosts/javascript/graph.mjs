// From the description of a frame, a package's `graph`, to resources and steps with all numbers known.
//
// Nothing here knows a pass, an axis or a resource by name. The generator has checked the description.

const bits = (a) => (a === 0 ? 0 : a.toString(2).length);
const OPERATIONS = {
  '==': (a, b) => a === b, '!=': (a, b) => a !== b, '<': (a, b) => a < b, '<=': (a, b) => a <= b,
  '>': (a, b) => a > b, '>=': (a, b) => a >= b, '+': (a, b) => a + b, '-': (a, b) => a - b, '*': (a, b) => a * b,
  '/': (a, b) => (a - (a % b)) / b, '%': (a, b) => a % b, '<<': (a, b) => a * 2 ** b,
  '>>': (a, b) => Math.floor(a / 2 ** b), '!': (a) => a === 0, min: Math.min, max: Math.max,
  div_ceil: (a, b) => (a - (a % b)) / b + (a % b > 0), log2: (a) => bits(a) - 1, bits,
  pow2_ceil: (a) => 2 ** bits(Math.max(a - 1, 0)),
};
const FORMULAS = new Set(['name', 'is', 'select', '&&', '||', ...Object.keys(OPERATIONS)]);
const isTable = (value) => typeof value === 'object' && value !== null && !Array.isArray(value);
const mapped = (table, each) => Object.fromEntries(Object.entries(table).map(([name, one]) => [name, each(one)]));

/// What is wrong with a configuration, or missing in what a host has.
export class Problem extends Error {}

/// The entry of a table, or an error that names it.
export function entry(table, kind, name) {
  if (Object.hasOwn(table, name)) return table[name];
  throw new Problem(`no ${kind} \`${name}\`; there are: ${Object.keys(table).sort().join(', ')}`);
}

/// Some parts of the frame of an input with these facts: by defaults of its class, a preset, and `own` values.
export class Frame {
  rounds = {};
  resources = [];
  steps = [];
  known = {}; // by name: the index among the resources, or null

  constructor(graph, parts, facts = [], preset = null, own = {}) {
    Object.assign(this, { graph, facts, rules: graph.exclusion ?? [] });
    this.axes = mapped(graph.axes, (one) => one.default);
    this.parameters = mapped(graph.parameter, (one) => one.default);
    this.parts = new Set([undefined, ...parts]); // what is of no part always runs
    const later = { ...(preset && entry(graph.preset, 'preset', preset).set), ...own };
    const given = {};
    for (const rule of [{ set: later }, ...(graph.default ?? [])]) { // each rule sees what is set before it
      if (!this.holds(rule) || rule.unless?.some((name) => Object.hasOwn(own, name))) continue;
      for (const [name, value] of Object.entries(Object.assign(given, rule.set, later))) this.set(name, value);
    }
    const broken = this.rules.find((rule) => !rule.passes && this.holds(rule));
    if (broken) throw new Problem(broken.reason);
    for (const [name, one] of Object.entries(graph.resource)) {
      const exists = this.holds(one);
      this.known[name] = exists ? this.resources.length : null;
      const external = one.external === true || !this.parts.has(one.part);
      if (exists) this.resources.push({ ...this.resolve(one), name, external });
    }
    this.run(graph.step);
  }

  set(name, value) {
    const isNumber = Object.hasOwn(this.graph.parameter, name);
    const one = isNumber ? this.graph.parameter[name] : entry(this.graph.axes, 'axis', name);
    const { minimum = 0, above = -1, maximum = value, values } = one;
    const allowed = isNumber ? value >= minimum && value > above && value <= maximum : values.includes(value);
    if (!allowed) throw new Problem(`${name} is ${value}: ${JSON.stringify(one)}`);
    (isNumber ? this.parameters : this.axes)[name] = value;
  }

  named(name) {
    const { graph, facts, rounds } = this;
    if (Object.hasOwn(rounds, name)) return rounds[name];
    if (Object.hasOwn(graph.let, name)) return this.number(graph.let[name]);
    return graph.facts.includes(name) ? Number(facts.includes(name)) : entry(this.parameters, 'number', name);
  }

  /// A whole number, or the real parameter that is the whole formula. Numbers above 2^53 would want BigInt.
  number(formula) {
    if (!isTable(formula)) return formula;
    const [[symbol, parts]] = Object.entries(formula);
    if (symbol === 'name') return this.named(parts);
    if (symbol === 'is') return Number(entry(this.axes, 'axis', parts[0]) === parts[1]);
    const first = this.number(parts[0]);
    if (symbol === 'select') return this.number(parts[first ? 1 : 2]);
    if (symbol === '&&') return Number(first !== 0 && this.number(parts[1]) !== 0);
    if (symbol === '||') return Number(first !== 0 || this.number(parts[1]) !== 0);
    const numbers = [first, ...parts.slice(1).map((part) => this.number(part))];
    const result = Number(OPERATIONS[symbol](...numbers));
    if ([...numbers, result].every(Number.isSafeInteger) && result >= 0) return result;
    throw new Problem(`${symbol} of ${numbers} is no whole number below 2^53`);
  }

  /// Whether the condition of a rule, a case, a resource or a step is met, if it has one.
  holds({ when = 1 }) {
    return this.number(when) !== 0;
  }

  /// A part of the description with numbers for formulas, and { index, level } or null for references.
  resolve(value) {
    if (Array.isArray(value)) {
      const isCase = (one) => isTable(one) && Object.hasOwn(one, 'value');
      if (!value.some(isCase)) return value.map((one) => this.resolve(one));
      return this.resolve(value.find((one) => this.holds(one))?.value ?? null);
    }
    if (!isTable(value)) return value;
    const [first, ...others] = Object.keys(value);
    if (others.length === 0 && FORMULAS.has(first)) return this.number(value);
    if (!Object.hasOwn(value, 'resource')) return mapped(value, (one) => this.resolve(one));
    const index = entry(this.known, 'resource', value.resource);
    return index === null ? null : { index, level: this.resolve(value.level ?? null) };
  }

  /// Does something in each round of a group or for each call of a draw, in which its number is known.
  repeated({ repeat = 1, index }, each) {
    return Array.from({ length: this.number(repeat) }, (_, number) => {
      this.rounds[index] = number;
      return each();
    });
  }

  run(steps) {
    for (const step of steps.filter((one) => this.holds(one))) {
      if (step.steps) this.repeated(step, () => this.run(step.steps));
      else if (this.parts.has(step.part)) this.steps.push(step.pass ? this.work(step) : this.resolve(step));
    }
  }

  /// A dispatch or a render pass: what is the same for all its calls, what it runs, and the calls.
  work({ pass, axes = {}, draw, uniforms = {}, bind = {}, constants = {}, ...others }) {
    const value = (axis) => this.resolve(axes[axis]) ?? this.axes[axis];
    const chosen = entry(this.graph.passes, 'pass', pass).map((axis) => [axis, value(axis)]);
    // An identifier leaves out the default of an axis that is implied.
    const isNamed = ([axis, of]) => !this.graph.axes[axis].implied || of !== this.graph.axes[axis].default;
    const variant = [pass, ...chosen.filter(isNamed).map(([, of]) => of)].join('-');
    const ofVariant = Object.assign(Object.create(this), { axes: Object.fromEntries(chosen) });
    const excludes = (rule) => rule.passes?.includes(pass) && ofVariant.holds(rule);
    const rule = draw?.list ? undefined : this.rules.find(excludes);
    if (rule) throw new Problem(`${variant} is excluded by ${rule.name}: ${rule.reason}`);
    const call = { ...others, draw, bind, constants, uniforms: mapped(uniforms, (name) => this.graph.uniform[name]) };
    const calls = this.repeated(draw ?? {}, () => this.resolve(call));
    // What is the same for all calls is there without any as well.
    this.rounds[draw?.index] = 0;
    return { ...this.resolve(call), variant, calls };
  }
}
