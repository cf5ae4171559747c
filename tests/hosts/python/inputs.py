"""What a host computes: each input of the frame from arguments by name, as its description says in words.

The package's inputs.json has arguments and results to compare with.
"""

from math import ceil, cos, log2, sqrt, tanh


def extent(of):
    """Half the extent of the light's image at the distance of the scene's radius."""
    return of["half_extent"] if of["light"] == "directional" else of.get("tan_half_angle", 1.0) * of["radius"]


def power_unit(of):
    area = {"point": 32.0, "directional": 4.0 * of.get("half_extent", 0.0) ** 2}
    brightest = max(of["intensity"]) * area.get(of["light"], 4.0 * of.get("tan_half_angle", 0.0) ** 2) / of["map"] ** 2
    return 2.0 ** min(max(ceil(log2(brightest)) - 15, -126), 126) if brightest > 0.0 else 1.0


def diffuse_mean_length(of):
    if of["emitter"] != "lobe":
        return 1.0
    s = of["emission_sharpness"]
    # The difference of the exact form cancels where s is small; s / 3 - s^3 / 45 does not.
    exact = s / 3.0 - s * s * s / 45.0 if s < 1e-2 else 1.0 / tanh(s) - 1.0 / s
    return s / (s + 1.0) if of["sharpness"] == "toksvig" else exact


def bias(of):
    half = (1.0 + 1.0 / 16.0) / of["tile"]
    return of["bias_scale"] * sqrt(2.0) * half / (1.0 - sqrt(6.0) * half)


def cone_scale(of):
    return 1.0 / max(cos(of["inner"]) - cos(of["outer"]), 1e-3) if of["light"] == "spot" else 0.0


INPUTS = {
    "minimum_variance": lambda of: max((2.0 * extent(of) / of["map"]) ** 2 / 6.0, 1e-12),
    "power_unit": power_unit,
    "power_scale": lambda of: 1.0 / power_unit(of),
    "diffuse_mean_length": diffuse_mean_length,
    "least_near": lambda of: 1e-4 * of["radius"],
    "bias": bias,
    "depth_bias": lambda of: 1e-5,
    "normal_offset": lambda of: 2.0 * sqrt(6.0 * of["minimum_variance"]) * of["map"] / 2048,
    "light.cone_scale": cone_scale,
    "light.cone_offset": lambda of: -cone_scale(of) * cos(of["outer"]) if of["light"] == "spot" else 1.0,
}
