"""Convex solids and lines of symbols, in the axes of what they belong to, m."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
_SIDES = 36  # of a cylinder
_PARALLELS = 8  # of a sphere
_STEPS, _STRAIGHT = 12, 0.12  # of a coil: a turn's, and what is straight at either end

# Springs and dampers of torsion, in symbols: half length, turns and radius of a coil; radius, from, to (degrees) of brake shoes.
HALF_HELIX, TURNS_OF_HELIX, RADIUS_OF_HELIX = 0.45, 4, 0.4
BRAKE = ((0.8, 200.0, 310.0), (0.6, 225.0, 285.0))


@dataclass(frozen=True)
class Solid:
    """A convex one: `vertices` (n, 3), `faces` by the numbers of their vertices, counter-clockwise from outside; `smooth`: the
    numbers of those that are parts of one round surface, or of the whole, which is a sphere."""

    vertices: Vector
    faces: tuple[tuple[int, ...], ...]
    smooth: frozenset[int] = frozenset()
    radius: float = 0.0  # of a sphere

    @cached_property
    def edges(self) -> tuple[tuple[int, int, int, int], ...]:
        """Two vertices, and the two faces that meet there."""
        beside: dict[tuple[int, int], list[int]] = {}
        for k, face in enumerate(self.faces):
            for a, b in zip(face, (*face[1:], face[0]), strict=True):
                beside.setdefault((min(a, b), max(a, b)), []).append(k)
        return tuple((a, b, faces[0], faces[1]) for (a, b), faces in beside.items())

    def is_sharp(self, edge: tuple[int, int, int, int]) -> bool:
        """Whether it is seen between two faces that are seen."""
        return not (edge[2] in self.smooth and edge[3] in self.smooth)

    @cached_property
    def normals(self) -> Vector:
        """Of the faces, (faces, 3), outwards, of length 1."""
        found = []
        for face in self.faces:
            a, b, c = (self.vertices[k] for k in face[:3])
            normal = np.cross(b - a, c - a)
            found.append(normal / (float(np.linalg.norm(normal)) or 1.0))
        return np.array(found)


def box(x: float, y: float, z: float) -> Solid:
    """Of these sizes, about the origin."""
    vertices = np.array([[i * x / 2, j * y / 2, k * z / 2] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
    return Solid(vertices, ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)))


def cylinder(radius: float, height: float, top: float | None = None) -> Solid:
    """About the origin, along z; `top`: another radius at its upper end, as of a cone."""
    angles = 2 * np.pi * np.arange(_SIDES) / _SIDES
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    upper = radius if top is None else max(top, 1e-3 * radius)
    vertices = np.concatenate([np.column_stack([radius * ring, np.full(_SIDES, -height / 2)]),
                               np.column_stack([upper * ring, np.full(_SIDES, height / 2)])])
    n = _SIDES
    mantle = tuple((k, (k + 1) % n, n + (k + 1) % n, n + k) for k in range(n))
    return Solid(vertices, (*mantle, tuple(range(n - 1, -1, -1)), tuple(range(n, 2 * n))), frozenset(range(n)))


def sphere(radius: float) -> Solid:
    """About the origin."""
    n, rows = _SIDES, _PARALLELS
    heights = np.linspace(-np.pi / 2, np.pi / 2, rows + 2)[1:-1]
    angles = 2 * np.pi * np.arange(n) / n
    rings = [np.column_stack([np.cos(height) * np.cos(angles), np.cos(height) * np.sin(angles), np.full(n, np.sin(height))])
             for height in heights]
    vertices = radius * np.concatenate([*rings, [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]])
    low, high = rows * n, rows * n + 1
    after = [(k + 1) % n for k in range(n)]
    faces = [(r * n + k, r * n + after[k], (r + 1) * n + after[k], (r + 1) * n + k) for r in range(rows - 1) for k in range(n)]
    caps = [(low, after[k], k) for k in range(n)] + [(high, low - n + k, low - n + after[k]) for k in range(n)]
    return Solid(vertices, (*faces, *caps), frozenset(range(len(faces) + len(caps))), radius)


def moved(solid: Solid, shift: Vector, turn: Vector | None = None) -> Solid:
    """Turned by a matrix (3, 3) and shifted, m."""
    vertices = solid.vertices if turn is None else solid.vertices @ turn.T
    return Solid(vertices + shift, solid.faces, solid.smooth, solid.radius)


def across(axis: Vector) -> Vector:
    """A matrix (3, 3) that turns z into this direction."""
    z = np.asarray(axis, float) / (float(np.linalg.norm(axis)) or 1.0)
    aside = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = aside - (aside @ z) * z
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z], axis=1)


# -------------------------------------------------------------------- lines between two places, over time


def _ways(a: Vector, b: Vector) -> tuple[Vector, Vector, Vector]:
    """Lengths (T,) of the ways from a (T, 3) to b, and two directions across each (T, 3); where there is no way, along z."""
    way = b - a
    length = np.linalg.norm(way, axis=1)
    z = np.where(length[:, None] > 0, way / np.where(length > 0, length, 1.0)[:, None], [0.0, 0.0, 1.0])
    aside = np.where((np.abs(z[:, :1]) < 0.9), [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    x = np.cross(aside, z)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    return length, x, np.cross(z, x)


def turns_of(a: Vector, b: Vector, symbol: float) -> int:
    """Of a spring between places (T, 3), as its greatest length asks for."""
    longest = float(np.nanmax(np.linalg.norm(b - a, axis=1), initial=0.0))
    return int(np.clip(longest / (0.6 * symbol), 4, 16)) if symbol > 0 else 4


def coil(a: Vector, b: Vector, radius: float, turns: int) -> Vector:
    """A helical spring from a (3,) to b: (n, 3), m; straight for an eighth at either end."""
    _, x, y = (part[0] for part in _ways(a[None], b[None]))
    parts = np.linspace(0.0, 1.0, _STEPS * turns + 1)
    steps, angle = _STRAIGHT + (1 - 2 * _STRAIGHT) * parts, 2 * np.pi * turns * parts
    inner = a + np.outer(steps, b - a) + radius * (np.outer(np.cos(angle), x) + np.outer(np.sin(angle), y))
    return np.concatenate([[a], inner, [b]])


def helix(at: Vector, axes: Vector, symbol: float) -> tuple[Vector, Vector, int, float]:
    """A spring of torsion about a hinge at (T, 3), along unit vectors (T, 3): ends, turns and radius of its coil, m."""
    half = HALF_HELIX * symbol * axes
    return at - half, at + half, TURNS_OF_HELIX, RADIUS_OF_HELIX * symbol


def brake(at: Vector, axes: Vector, symbol: float) -> list[Vector]:
    """A damper of torsion about a hinge at (T, 3), along unit vectors (T, 3): two shoes, (T, n, 3) each."""
    frames = np.array([across(axis) if np.isfinite(axis).all() else np.full((3, 3), np.nan) for axis in axes])
    found = []
    for radius, begin, end in BRAKE:
        angles = np.deg2rad(np.linspace(begin, end, 13))
        ring = radius * symbol * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
        found.append(at[:, None] + ring @ frames.transpose(0, 2, 1))
    return found


def dashpot(a: Vector, b: Vector, symbol: float) -> list[Vector]:
    """A damper from a (T, 3) to b: rods and the square of its cylinder, (T, n, 3) each."""
    _, x, _ = _ways(a, b)

    def at(along: float, aside: float) -> Vector:
        found: Vector = a + along * (b - a) + aside * symbol * x
        return found

    return [np.stack(points, axis=1) for points in (
        [at(0, 0), at(0.35, 0)], [at(0.65, 0.25), at(0.35, 0.25), at(0.35, -0.25), at(0.65, -0.25)],
        [at(0.5, 0.18), at(0.5, -0.18)], [at(0.5, 0), at(1, 0)])]


def arrow(a: Vector, b: Vector, symbol: float) -> Vector:
    """From a (T, 3) to b with its head, (T, n, 3)."""
    length, x, _ = _ways(a, b)
    head = np.minimum(0.35 * symbol, 0.5 * length)[:, None]
    way = np.where(length[:, None] > 0, (b - a) / np.where(length > 0, length, 1.0)[:, None], 0.0)
    return np.stack([a, b, b - head * (way - 0.4 * x), b, b - head * (way + 0.4 * x)], axis=1)


def arc(at: Vector, axes: Vector, radius: float, span: float) -> Vector:
    """Part of a circle about `at` (T, 3) in the plane of the first two columns of `axes` (T, 3, 3), with a head: (T, n, 3)."""
    angles = np.linspace(0.0, span, 25)
    x, y = axes[:, :, 0], axes[:, :, 1]
    ring = at[:, None] + radius * (np.cos(angles)[None, :, None] * x[:, None] + np.sin(angles)[None, :, None] * y[:, None])
    way = np.sign(span) * (-np.sin(span) * x + np.cos(span) * y)
    out = np.cos(span) * x + np.sin(span) * y
    tip = ring[:, -1]
    heads = [tip - 0.3 * radius * (way - side * out) for side in (0.5, -0.5)]
    return np.concatenate([ring, heads[0][:, None], tip[:, None], heads[1][:, None]], axis=1)
