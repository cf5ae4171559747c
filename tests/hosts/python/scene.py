"""A floor, a wall and a ball as a light and a camera see them, and what a host computes for them.

Surfaces take + - * / and square roots of 64 bits alone, in this order, so that every language has the same numbers.
"""

import struct
from math import floor, sqrt

from graph import Problem
from inputs import INPUTS

# Position; unit axes to the right, up and into the scene; half the image's height at unit distance.
LIGHT = ([0.5, 3.5, 1.0], [1.0, 0.0, 0.0], [0.0, 0.6, -0.8], [0.0, -0.8, -0.6], 0.75)
CAMERA = ([-0.25, 1.5, 4.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0], 0.625)
INTENSITY, INNER, OUTER = [20.0, 18.0, 15.0], 0.5, 0.8  # W/sr; angles of the cone
LOW, HIGH, CENTRE, BALL = [-2.0, 0.0, -2.0], [2.0, 3.0, 2.0], [0.25, 0.625, -0.5], 0.625
# Axis of the normal; base colour and metallic; roughness alpha.
FLOOR, WALL = (1, [0.75, 0.5, 0.25, 0.0], 0.25), (2, [0.25, 0.625, 0.75, 0.0], 0.5)
BALL_COLOR, BALL_ALPHA, DIELECTRIC, NOTHING = [0.875, 0.75, 0.5, 0.75], 0.125, 0.04, [0.0] * 4


def surface(eye, ray):
    """Position, normal and base colour of what a ray meets first, with what stands in their fourth components."""
    along = lambda t: [eye[i] + t * ray[i] for i in range(3)]
    nearest, found = float("inf"), ([0.0, 0.0, 0.0, -1.0], NOTHING, NOTHING)
    for axis, color, alpha in (FLOOR, WALL):
        t = (LOW[axis] - eye[axis]) / ray[axis] if ray[axis] < 0.0 else nearest
        inside = t < nearest and all(i == axis or LOW[i] <= p <= HIGH[i] for i, p in enumerate(along(t)))
        if inside:
            nearest, found = t, ([*along(t), DIELECTRIC], [*(float(i == axis) for i in range(3)), alpha], color)
    offset = [eye[i] - CENTRE[i] for i in range(3)]
    dot = lambda p, q: p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
    a, b, c = dot(ray, ray), dot(ray, offset), dot(offset, offset) - BALL * BALL
    if b * b > a * c and (t := (-b - sqrt(b * b - a * c)) / a) < nearest:
        # Rounded so that 16 bits hold it.
        normal = [floor((p - centre) / BALL * 1024.0 + 0.5) / 1024.0 for p, centre in zip(along(t), CENTRE)]
        found = ([*along(t), DIELECTRIC], [*normal, BALL_ALPHA], BALL_COLOR)
    return found


def image(prefix, view, width, height):
    """The three surface textures of a view, row by row from the top."""
    eye, right, up, forward, tangent = view
    texels = []
    for row in range(height):
        for column in range(width):
            u = (2.0 * (column + 0.5) / width - 1.0) * tangent * (width / height)
            v = (1.0 - 2.0 * (row + 0.5) / height) * tangent
            texels.append(surface(eye, [forward[i] + u * right[i] + v * up[i] for i in range(3)]))
    names = [prefix + name for name in ("position", "normal", "base_color")]
    return {name: [part for texel in texels for part in texel[i]] for i, name in enumerate(names)}


def triangles():
    """Positions and indices of the floor, the wall, and an octahedron in the ball."""
    (x, y, z), (right, top, front) = LOW, HIGH
    positions = [[x, y, front], [right, y, front], [right, y, z], [x, y, z], [right, top, z], [x, top, z]]
    for axis, side in ((0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0), (2, -1.0), (2, 1.0)):
        positions.append([c + (BALL * side if i == axis else 0.0) for i, c in enumerate(CENTRE)])
    indices = [0, 1, 2, 0, 2, 3, 3, 2, 4, 3, 4, 5]
    indices += [6 + corner for i in (0, 1) for j in (2, 3) for k in (4, 5) for corner in (i, j, k)]
    return positions, indices


def counts():
    """What the description calls the numbers of the triangles."""
    positions, indices = triangles()
    return {"occluder_vertex_count": len(positions), "occluder_index_count": len(indices)}


def points(count, subsets):
    """Points on the triangles, evenly over their area, as discs that cover it; each subset is such by itself."""
    positions, indices = triangles()
    corners = [[positions[i] for i in indices[at : at + 3]] for at in range(0, len(indices), 3)]
    edges = [([b[i] - a[i] for i in range(3)], [c[i] - a[i] for i in range(3)]) for a, b, c in corners]
    normals = [[p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]] for p, q in edges]
    lengths = [sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) for n in normals]
    ends = [sum(lengths[: at + 1]) for at in range(len(lengths))]
    found = []
    for place in range(count * subsets):
        subset, turn = place // count, place % count
        along = (turn * subsets + subset + 0.5) / (count * subsets) * ends[-1]
        at = next(at for at, end in enumerate(ends) if along < end)
        # [Turk 1990, Graphics Gems, Generating random points in triangles]
        root, across = sqrt((along - ends[at] + lengths[at]) / lengths[at]), (0.618 * turn + 0.755 * subset) % 1.0
        (p, q), (a, _, _) = edges[at], corners[at]
        found += [a[i] + root * (1.0 - across) * p[i] + root * across * q[i] for i in range(3)]
        found += [sqrt(ends[-1] / count / 4.0), *(part / lengths[at] for part in normals[at]), 0.0]
    return found


def supplied(frame):
    """Textures and buffers by name."""
    numbers, (positions, indices) = frame.parameters, triangles()
    made = image("rsm_", LIGHT, numbers["map"], numbers["map"])
    made |= image("gbuffer_", CAMERA, numbers["width"], numbers["height"])
    made |= {"occluder_positions": [part for position in positions for part in position], "occluder_indices": indices}
    if frame.axes["visibility"] == "imperfect":
        made["points"] = points(numbers["shadow_points"], frame.named("point_subsets"))
    return made


def packed(numbers, form=""):
    """Little-endian bytes of whole or real numbers, these in 16 bits if a texture's format has them."""
    letter = "I" if isinstance(numbers[0], int) else "e" if "16float" in form else "f"
    return struct.pack(f"<{len(numbers)}{letter}", *numbers)


def contents(frame, supplied):
    """The same as bytes in the formats of the frame's resources."""
    textures = {one["name"]: one["texture"]["format"] for one in frame.resources if "texture" in one}
    return {name: packed(numbers, textures.get(name, "")) for name, numbers in supplied.items()}


def inputs(frame):
    """Host inputs by name, as the description says of each."""
    numbers, axes = frame.parameters, frame.axes
    if axes["light"] != "spot":
        raise Problem(f"these surfaces are seen by a spot light, not by light {axes['light']}")
    eye, right, up, forward, tangent = LIGHT
    origin = [(low + high) / 2.0 for low, high in zip(LOW, HIGH)]
    radius = sqrt(sum((high - low) ** 2 for low, high in zip(LOW, HIGH))) / 2.0
    of = {"light": "spot", "tan_half_angle": tangent, "intensity": INTENSITY, "inner": INNER, "outer": OUTER}
    of |= {"radius": radius} | {name: axes[name] for name in ("emitter", "sharpness")} | numbers
    made = {name: compute(of) for name, compute in INPUTS.items() if name != "normal_offset"}
    light = {"position": eye, "right": right, "up": up, "forward": forward, "tan_half_angle": tangent}
    light |= {"half_extent": 0.0, "intensity": INTENSITY}
    light |= {name.removeprefix("light."): made.pop(name) for name in ("light.cone_scale", "light.cone_offset")}
    nothing = {name: [0.0] * 3 if isinstance(value, list) else 0.0 for name, value in light.items()}
    made |= {"eye": CAMERA[0], "light": light, "light_eye": [*eye, 1.0], "origin": origin}
    return made | {"camera_light": nothing | {"position": CAMERA[0]}}
