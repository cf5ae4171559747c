// A floor, a wall and a ball as a light and a camera see them, and what a host computes for them.
//
// Surfaces take + - * / and square roots of 64 bits alone, in this order, so that every language has the same numbers.

import { Problem } from './graph.mjs';
import { INPUTS } from './inputs.mjs';

// Position; unit axes to the right, up and into the scene; half the image's height at unit distance.
const LIGHT = [[0.5, 3.5, 1.0], [1.0, 0.0, 0.0], [0.0, 0.6, -0.8], [0.0, -0.8, -0.6], 0.75];
const CAMERA = [[-0.25, 1.5, 4.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0], 0.625];
// W/sr; angles of the cone.
const [INTENSITY, INNER, OUTER] = [[20.0, 18.0, 15.0], 0.5, 0.8];
const [LOW, HIGH, CENTRE, BALL] = [[-2.0, 0.0, -2.0], [2.0, 3.0, 2.0], [0.25, 0.625, -0.5], 0.625];
// Axis of the normal; base colour and metallic; roughness alpha.
const FLOOR = [1, [0.75, 0.5, 0.25, 0.0], 0.25];
const WALL = [2, [0.25, 0.625, 0.75, 0.0], 0.5];
const [BALL_COLOR, BALL_ALPHA, DIELECTRIC, NOTHING] = [[0.875, 0.75, 0.5, 0.75], 0.125, 0.04, [0.0, 0.0, 0.0, 0.0]];
const XYZ = [0, 1, 2];

/// Position, normal and base colour of what a ray meets first, with what stands in their fourth components.
function surface(eye, ray) {
  const along = (t) => XYZ.map((i) => eye[i] + t * ray[i]);
  const dot = (p, q) => p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
  let [nearest, found] = [Infinity, [[0.0, 0.0, 0.0, -1.0], NOTHING, NOTHING]];
  for (const [axis, color, alpha] of [FLOOR, WALL]) {
    const t = ray[axis] < 0.0 ? (LOW[axis] - eye[axis]) / ray[axis] : nearest;
    if (t < nearest && along(t).every((p, i) => i === axis || (LOW[i] <= p && p <= HIGH[i]))) {
      nearest = t;
      found = [[...along(t), DIELECTRIC], [...XYZ.map((i) => Number(i === axis)), alpha], color];
    }
  }
  const offset = XYZ.map((i) => eye[i] - CENTRE[i]);
  const [a, b, c] = [dot(ray, ray), dot(ray, offset), dot(offset, offset) - BALL * BALL];
  const t = b * b > a * c ? (-b - Math.sqrt(b * b - a * c)) / a : nearest;
  if (t < nearest) {
    // Rounded so that 16 bits hold it.
    const normal = along(t).map((p, i) => Math.floor(((p - CENTRE[i]) / BALL) * 1024.0 + 0.5) / 1024.0);
    found = [[...along(t), DIELECTRIC], [...normal, BALL_ALPHA], BALL_COLOR];
  }
  return found;
}

/// The three surface textures of a view, row by row from the top.
function image(prefix, [eye, right, up, forward, tangent], width, height) {
  const texels = [];
  for (let row = 0; row < height; row++) {
    for (let column = 0; column < width; column++) {
      const u = ((2.0 * (column + 0.5)) / width - 1.0) * tangent * (width / height);
      const v = (1.0 - (2.0 * (row + 0.5)) / height) * tangent;
      texels.push(surface(eye, XYZ.map((i) => forward[i] + u * right[i] + v * up[i])));
    }
  }
  const names = ['position', 'normal', 'base_color'];
  const parts = (i) => new Float32Array(texels.flatMap((texel) => texel[i]));
  return Object.fromEntries(names.map((name, i) => [prefix + name, parts(i)]));
}

/// Positions and indices of the floor, the wall, and an octahedron in the ball.
function triangles() {
  const [[x, y, z], [right, top, front]] = [LOW, HIGH];
  const positions = [[x, y, front], [right, y, front], [right, y, z], [x, y, z], [right, top, z], [x, top, z]];
  for (const axis of XYZ) {
    for (const side of [-1, 1]) positions.push(CENTRE.map((c, i) => c + (i === axis ? BALL * side : 0.0)));
  }
  const indices = [0, 1, 2, 0, 2, 3, 3, 2, 4, 3, 4, 5];
  for (const i of [0, 1]) for (const j of [2, 3]) for (const k of [4, 5]) indices.push(6 + i, 6 + j, 6 + k);
  return { positions, indices };
}

/// What the description calls the numbers of the triangles.
export function counts() {
  const { positions, indices } = triangles();
  return { occluder_vertex_count: positions.length, occluder_index_count: indices.length };
}

/// Points on the triangles, evenly over their area, as discs that cover it; each subset is such by itself.
function points(count, subsets) {
  const { positions, indices } = triangles();
  const ends = [0.0];
  const all = [];
  for (let at = 0; at < indices.length; at += 3) {
    const [a, b, c] = indices.slice(at, at + 3).map((index) => positions[index]);
    const [p, q] = [b, c].map((corner) => XYZ.map((i) => corner[i] - a[i]));
    const n = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
    const length = Math.sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    ends.push(ends.at(-1) + length);
    all.push({ a, p, q, length, end: ends.at(-1), normal: n.map((part) => part / length) });
  }
  const total = ends.at(-1);
  const found = [];
  for (let place = 0; place < count * subsets; place++) {
    const [subset, turn] = [Math.floor(place / count), place % count];
    const along = ((turn * subsets + subset + 0.5) / (count * subsets)) * total;
    const { a, p, q, length, end, normal } = all.find((one) => along < one.end);
    // [Turk 1990, Graphics Gems, Generating random points in triangles]
    const [root, across] = [Math.sqrt((along - end + length) / length), (0.618 * turn + 0.755 * subset) % 1.0];
    found.push(...XYZ.map((i) => a[i] + root * (1.0 - across) * p[i] + root * across * q[i]));
    found.push(Math.sqrt(total / count / 4.0), ...normal, 0.0);
  }
  return found;
}

/// What of 32 bits 16 bits hold, exactly.
function half(number) {
  const [word] = new Uint32Array(new Float32Array([number]).buffer);
  const exponent = (word >>> 23) & 0xff;
  if (number === 0) return 0;
  if (word & 0x1fff || exponent < 113 || exponent > 142) throw new Problem(`${number} is no number of 16 bits`);
  return ((word >>> 16) & 0x8000) | ((exponent - 112) << 10) | ((word >>> 13) & 0x3ff);
}

/// Textures and buffers by name.
export function supplied(frame) {
  const { map, width, height, shadow_points: count } = frame.parameters;
  const { positions, indices } = triangles();
  const made = { ...image('rsm_', LIGHT, map, map), ...image('gbuffer_', CAMERA, width, height) };
  made.occluder_positions = new Float32Array(positions.flat());
  made.occluder_indices = new Uint32Array(indices);
  if (frame.axes.visibility !== 'imperfect') return made;
  made.points = new Float32Array(points(count, frame.named('point_subsets')));
  return made;
}

/// The same in the formats of the frame's resources.
export function contents({ resources }, made) {
  const halves = resources.filter(({ texture }) => texture?.format.includes('16float')).map(({ name }) => name);
  const of = ([name, numbers]) => [name, halves.includes(name) ? Uint16Array.from(numbers, half) : numbers];
  return Object.fromEntries(Object.entries(made).map(of));
}

/// Host inputs by name, as the description says of each.
export function inputs({ parameters, axes }) {
  const kind = axes.light;
  if (kind !== 'spot') throw new Problem(`these surfaces are seen by a spot light, not by light ${kind}`);
  const [position, right, up, forward, tangent] = LIGHT;
  const origin = XYZ.map((i) => (LOW[i] + HIGH[i]) / 2.0);
  const radius = Math.sqrt(XYZ.reduce((sum, i) => sum + (HIGH[i] - LOW[i]) ** 2, 0.0)) / 2.0;
  const cone = { light: kind, tan_half_angle: tangent, intensity: INTENSITY, inner: INNER, outer: OUTER };
  const of = { ...cone, radius, emitter: axes.emitter, sharpness: axes.sharpness, ...parameters };
  const computed = Object.entries(INPUTS).filter(([name]) => name !== 'normal_offset' && !name.includes('.'));
  const view = { position, right, up, forward, tan_half_angle: tangent, half_extent: 0.0, intensity: INTENSITY };
  const members = ['cone_scale', 'cone_offset'].map((name) => [name, INPUTS[`light.${name}`](of)]);
  const light = { ...view, ...Object.fromEntries(members) };
  const zeros = Object.entries(light).map(([name, value]) => [name, Array.isArray(value) ? [0.0, 0.0, 0.0] : 0.0]);
  return {
    ...Object.fromEntries(computed.map(([name, compute]) => [name, compute(of)])),
    eye: CAMERA[0], light, light_eye: [...position, 1.0], origin,
    camera_light: { ...Object.fromEntries(zeros), position: CAMERA[0] },
  };
}
