// From the description of a frame, a package's `graph`, to resources and steps with all numbers known.
//
// Nothing here knows a pass, an axis or a resource by name. The generator has checked the description.

const OPERATIONS = {
  '==': (a, b) => a === b, '!=': (a, b) => a !== b, '<': (a, b) => a < b, '<=': (a, b) => a <= b,
  '>': (a, b) => a > b, '>=': (a, b) => a >= b, '+': (a, b) => a + b, '-': (a, b) => a - b, '*': (a, b) => a * b,
  '/': (a, b) => (a - (a % b)) / b, '%': (a, b) => a % b, '<<': (a, b) => a * 2 ** b,
  '>>': (a, b) => Math.floor(a / 2 ** b), '!': (a) => a === 0, min: Math.min, max: Math.max,
  div_ceil: (a, b) => (a - (a % b)) / b + (a % b > 0), log2: (a) => bits(a) - 1, bits: (a) => bits(a),
  pow2_ceil: (a) => 2 ** bits(Math.max(a - 1, 0)),
};
const bits = (a) => (a === 0 ? 0 : a.toString(2).length);
// What is not written in a table of the description.
const ABSENT = {
  let: {}, alias: {}, uniform: {}, resource: {}, axes: {}, bind: {}, uniforms: {}, constants: {}, names: {},
  step: [], steps: [], color: [], vertices: [], initial: [], require: [], exclusion: [], preset: {}, prefix: '',
  when: null, repeat: null, element: null, level: null, clear: null, bytes: null,
};
const isTable = (value) => typeof value === 'object' && value !== null && !Array.isArray(value);
const table = (value) => Object.setPrototypeOf(value, ABSENT);
const mapped = (of, each) => table(Object.fromEntries(Object.entries(of).map(([name, value]) => [name, each(value)])));

/// What a text in JSON holds; tables of it have what is not written in them.
export const read = (text) => JSON.parse(text, (_, value) => (isTable(value) ? table(value) : value));

/// What is wrong with a configuration, or missing in what a host has.
export class Problem extends Error {}

/// The entry of a table, or an error that names it.
export function entry(table, kind, name) {
  if (Object.hasOwn(table, name)) return table[name];
  throw new Problem(`no ${kind} \`${name}\`; there are: ${Object.keys(table).sort().join(', ')}`);
}

/// Axes and parameters for an input with these facts: defaults of its class, changed by a preset and by one's own.
export function configured(graph, facts, preset, own) {
  const given = (name) => Object.hasOwn(own, name);
  const holds = ({ when, unless }) =>
    Object.entries(when).every(([fact, value]) => facts.includes(fact) === value) && !unless.some(given);
  const sets = graph.default.filter(holds).map(({ set }) => set);
  if (preset) sets.push(entry(graph.preset, 'preset', preset).set);
  const made = Object.entries(Object.assign({}, ...sets, own));
  const isNumber = ([name]) => Object.hasOwn(graph.parameter, name);
  return [made.filter((one) => !isNumber(one)), made.filter(isNumber)].map(Object.fromEntries);
}

/// The frame for values of axes and parameters by name and facts that hold, as far as it belongs to these parts.
export class Frame {
  resources = []; // { name, external, kept, and one of buffer, texture, sampler }
  steps = []; // { new, clear, bytes, and variant, entry, constants, calls, draw }
  known = {}; // by name: an index, a pair { first, front }, an alias { scope, choice }, or null

  // What is of no part always runs.
  runs(part) {
    return !part || this.parts.has(part);
  }

  constructor(graph, axes, parameters, parts, facts = new Set()) {
    const defaults = mapped(graph.parameter, (one) => one.default);
    Object.assign(this, { graph, axes, parts, facts, parameters: { ...defaults, ...parameters } });
    for (const [name, value] of Object.entries(axes)) {
      const { values } = entry(graph.axes, 'axis', name);
      if (!values.includes(value)) throw new Problem(`axis ${name} is ${value}: one of ${values.join(', ')}`);
    }
    for (const [name, value] of Object.entries(parameters)) {
      const { minimum, above, maximum } = entry(graph.parameter, 'parameter', name);
      if (!(value >= (minimum ?? 0) && value > (above ?? -1) && value <= (maximum ?? value))) {
        throw new Problem(`parameter ${name} is ${value}: minimum ${minimum}, above ${above}, maximum ${maximum}`);
      }
    }
    this.root = new Scope({ frame: this, template: graph.template.frame, prefix: '', rounds: [] });
    for (const { that, reason } of graph.require) {
      if (!this.root.resolve(that)) throw new Problem(reason);
    }
    this.root.enter('', true, null);
  }
}

/// What names mean in the frame or in the use of a template, and in rounds of repetitions, the innermost last.
class Scope {
  // { frame, template, prefix, caller, use: the caller's step that uses the template, rounds: { index, number, lets } }
  constructor(parts) {
    Object.assign(this, parts);
  }

  within(rounds) {
    return new Scope({ ...this, rounds });
  }

  number(name) {
    const { frame, template, caller, use, rounds } = this;
    for (let depth = rounds.length; depth > 0; depth--) {
      const { index, number, lets } = rounds[depth - 1];
      if (name === index) return number;
      if (Object.hasOwn(lets, name)) return this.within(rounds.slice(0, depth)).resolve(lets[name]);
    }
    if (caller && Object.hasOwn(use.let, name)) return caller.resolve(use.let[name]);
    if (Object.hasOwn(template.let, name)) return this.within([]).resolve(template.let[name]);
    if (caller) return frame.root.number(name);
    return frame.graph.facts.includes(name) ? Number(frame.facts.has(name)) : entry(frame.parameters, 'number', name);
  }

  /// A whole number, or the real parameter that is the whole formula. Numbers above 2^53 would want BigInt.
  formula(tree, text) {
    if (!isTable(tree)) return typeof tree === 'string' ? this.number(tree) : tree;
    const [[symbol, parts]] = Object.entries(tree);
    if (symbol === 'is') return Number(this.axis(parts[0]) === parts[1]);
    const first = this.formula(parts[0], text);
    if (symbol === 'select') return this.formula(parts[first ? 1 : 2], text);
    if (symbol === '&&') return Number(first !== 0 && this.formula(parts[1], text) !== 0);
    if (symbol === '||') return Number(first !== 0 || this.formula(parts[1], text) !== 0);
    const numbers = [first, ...parts.slice(1).map((part) => this.formula(part, text))];
    const result = Number(entry(OPERATIONS, 'operation', symbol)(...numbers));
    if (![...numbers, result].every(Number.isSafeInteger) || result < 0) {
      throw new Problem(`\`${text}\`: ${symbol} of ${numbers} is no whole number below 2^53`);
    }
    return result;
  }

  /// Of the innermost use that has a value; else what follows from others, is configured, or is the default.
  axis(name) {
    const { graph, axes } = this.frame;
    for (let scope = this; scope.caller; scope = scope.caller) {
      const value = scope.caller.resolve(scope.use.axes[name] ?? null);
      if (value !== null) return value;
    }
    const value = this.within([]).resolve(graph.choose[name] ?? null) ?? axes[name];
    return value ?? entry(graph.axes, 'axis', name).default;
  }

  /// What a reference stands for, and which side of a pair.
  target({ resource, side }) {
    const { frame, prefix, caller, use } = this;
    if (caller && Object.hasOwn(use.names, resource)) {
      const inner = caller.target(use.names[resource]);
      return { found: inner.found, side: side ?? inner.side };
    }
    if (caller && !Object.hasOwn(frame.known, prefix + resource)) return frame.root.target({ resource, side });
    const found = entry(frame.known, 'resource', prefix + resource);
    if (!found?.scope) return { found, side };
    const inner = found.scope.target(found.scope.case(found.choice));
    return { found: inner.found, side: side ?? inner.side };
  }

  input(name) {
    return this.caller ? this.caller.input(this.use.names[name]?.resource ?? name) : name;
  }

  /// A value, or that of the first case that applies; null if there is none.
  case(value) {
    if (!(Array.isArray(value) && isTable(value[0]) && Object.hasOwn(value[0], 'value'))) return value;
    return value.find(({ when }) => when === null || this.resolve(when))?.value ?? null;
  }

  /// A part of the description with numbers for formulas, { index, level } for references, null for what is absent.
  resolve(choice) {
    const value = this.case(choice);
    if (Array.isArray(value)) return value.map((one) => this.resolve(one));
    if (!isTable(value)) return value;
    if (Object.hasOwn(value, 'tree')) return this.formula(value.tree, value.text);
    if (Object.hasOwn(value, 'resource')) {
      const { found, side } = this.target(value);
      if (found === null) return null;
      const { first = found, front = 0 } = found;
      const index = side === 'back' ? first + 1 - front : first + front;
      return table({ index, level: this.resolve(value.level) });
    }
    if (Object.hasOwn(value, 'input')) return { input: this.input(value.input), element: this.resolve(value.element) };
    return mapped(value, (one) => this.resolve(one));
  }

  /// Makes known what the template has, and runs its steps.
  enter(part, run, fresh) {
    const { template, prefix, frame } = this;
    for (const [name, choice] of Object.entries(template.alias)) frame.known[prefix + name] = { scope: this, choice };
    for (const [own, one] of Object.entries(template.resource)) {
      const name = prefix + own;
      frame.known[name] = null;
      if (!(run && (one.when === null || this.resolve(one.when)))) continue;
      const external = one.external === true || !frame.runs(one.part ?? part);
      const made = table({ ...this.resolve(one), name, external });
      const first = frame.resources.length;
      frame.known[name] = one.flip === true ? { first, front: 0 } : first;
      frame.resources.push(...(one.flip === true ? [made, made] : [made]));
    }
    this.run(template.step, part, run, fresh);
  }

  run(steps, part, run, fresh) {
    const { frame, prefix, rounds } = this;
    for (const step of steps) {
      const own = step.part ?? part;
      const runs = Boolean(run && (step.when === null || this.resolve(step.when)));
      const active = runs && frame.runs(own);
      const times = runs ? this.resolve(step.repeat) : null;
      const ownFresh = active && step.new ? this.resolve(step.new).index : fresh;
      if (step.use) {
        const template = entry(frame.graph.template, 'template', step.use);
        const inner = { frame, template, prefix: prefix + step.prefix, caller: this, use: step, rounds: [] };
        new Scope(inner).enter(own, runs, ownFresh);
      } else if (step.steps.length > 0 && times === null) {
        this.run(step.steps, own, runs, ownFresh);
      } else if (step.steps.length > 0) {
        for (let number = 0; number < times; number++) {
          const inner = this.within([...rounds, { index: step.index, number, lets: step.let }]);
          inner.run(step.steps, own, true, ownFresh);
          for (const resource of step.flip ?? []) this.target({ resource, side: null }).found.front ^= 1;
        }
      } else if (active) {
        frame.steps.push(table({ ...this.work(step), new: ownFresh }));
      }
    }
  }

  /// A clear, or a dispatch or a render pass: what it runs, and its calls with bindings of their own.
  work(step) {
    const { clear, bytes, constants, entry: point } = step;
    const work = this.resolve({ clear, bytes, constants, entry: point });
    if (clear) return work;
    const axes = entry(this.frame.graph.passes, 'pass', step.pass);
    const values = axes.map((axis) => this.resolve(step.axes[axis] ?? null) ?? this.axis(axis));
    // An identifier leaves out the default of an axis that is implied.
    const of = (index) => this.frame.graph.axes[axes[index]];
    const named = values.filter((value, index) => !of(index).implied || value !== of(index).default);
    const variant = [step.pass, ...named].join('-');
    for (const { name, pass, when, reason } of step.draw?.list ? [] : this.frame.graph.exclusion) {
      const holds = ([axis, illegal]) => illegal.includes(values[axes.indexOf(axis)]);
      if ((pass ?? step.pass) === step.pass && Object.entries(when).every(holds)) {
        throw new Problem(`${variant} is excluded by ${name}: ${reason}`);
      }
    }
    const known = { ...this.frame.root.template.uniform, ...this.template.uniform };
    const { count = null, instances = null, viewport = null, repeat = null, index = null, ...shared } = step.draw ?? {};
    const { bind, dispatch, indirect } = step;
    const uniforms = mapped(step.uniforms, (name) => entry(known, 'uniform', name));
    const call = { bind, dispatch, indirect, uniforms, count, instances, viewport };
    const times = repeat === null ? 1 : this.resolve(repeat);
    const rounds = Array.from({ length: times }, (_, number) => ({ index, number, lets: {} }));
    const calls = rounds.map((round) => this.within([...this.rounds, round]).resolve(call));
    return { ...work, variant, calls, draw: step.draw && this.resolve(shared) };
  }
}
