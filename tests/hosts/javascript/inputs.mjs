// What a host computes: each input of the frame from arguments by name, as its description says in words.
//
// The package's inputs.json has arguments and results to compare with.

/// Half the extent of the light's image at the distance of the scene's radius.
const extent = ({ light, half_extent: half, tan_half_angle: tangent = 1.0, radius }) =>
  (light === 'directional' ? half : tangent * radius);

function powerUnit({ light, intensity, map, half_extent: half = 0.0, tan_half_angle: tangent = 0.0 }) {
  const area = { point: 32.0, directional: 4.0 * half ** 2 }[light] ?? 4.0 * tangent ** 2;
  const brightest = (Math.max(...intensity) * area) / map ** 2;
  return brightest > 0.0 ? 2.0 ** Math.min(Math.max(Math.ceil(Math.log2(brightest)) - 15, -126), 126) : 1.0;
}

function diffuseMeanLength({ emitter, sharpness, emission_sharpness: s }) {
  if (emitter !== 'lobe') return 1.0;
  // The difference of the exact form cancels where s is small; s / 3 - s^3 / 45 does not.
  const exact = s < 1e-2 ? s / 3.0 - (s * s * s) / 45.0 : 1.0 / Math.tanh(s) - 1.0 / s;
  return sharpness === 'toksvig' ? s / (s + 1.0) : exact;
}

function bias({ bias_scale: scale, tile }) {
  const half = (1.0 + 1.0 / 16.0) / tile;
  return (scale * Math.sqrt(2.0) * half) / (1.0 - Math.sqrt(6.0) * half);
}

const coneScale = ({ light, inner, outer }) =>
  (light === 'spot' ? 1.0 / Math.max(Math.cos(inner) - Math.cos(outer), 1e-3) : 0.0);

export const INPUTS = {
  minimum_variance: (of) => Math.max(((2.0 * extent(of)) / of.map) ** 2 / 6.0, 1e-12),
  power_unit: powerUnit,
  power_scale: (of) => 1.0 / powerUnit(of),
  diffuse_mean_length: diffuseMeanLength,
  least_near: ({ radius }) => 1e-4 * radius,
  bias,
  depth_bias: () => 1e-5,
  normal_offset: ({ minimum_variance: variance, map }) => (2.0 * Math.sqrt(6.0 * variance) * map) / 2048,
  'light.cone_scale': coneScale,
  'light.cone_offset': (of) => (of.light === 'spot' ? -coneScale(of) * Math.cos(of.outer) : 1.0),
};
