"""What is seen of a motion in space: solids with their poses, lines, words and traces over time."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lagrangia.draw.page import Words
from lagrangia.solids.shapes import Solid, coil

Vector = NDArray[np.float64]
SHADES = ("white", "grey", "black")


@dataclass(frozen=True)
class Body:
    """A solid and where it is: `poses` (T, 7), m and a unit quaternion, the real part first. `shade` is one of SHADES, `name`
    that of the component it is of, or nothing."""

    solid: Solid
    poses: Vector
    shade: str = "white"
    name: str = ""


@dataclass(frozen=True)
class Line:
    """A polyline over time: `points` (T, n, 3), m, NaN where there is nothing; `line` as in a drawing section. With turns: a coil
    of this radius, m, between two points. `name` as of a body."""

    points: Vector
    line: str = "normal"
    turns: int = 0
    radius: float = 0.0
    name: str = ""

    def at(self, moment: int) -> Vector:
        """(n, 3), m."""
        points: Vector = self.points[moment]
        return coil(points[0], points[1], self.radius, self.turns) if self.turns else points


@dataclass(frozen=True)
class Caption:
    """Words about a place over time, (T, 3), m."""

    words: Words
    at: Vector


@dataclass(frozen=True)
class Stage:
    """All that is seen; `symbol` is the size of symbols, m, `up` the direction that points upwards on paper."""

    t: Vector
    bodies: tuple[Body, ...]
    lines: tuple[Line, ...]
    captions: tuple[Caption, ...]
    traces: tuple[tuple[str, Vector], ...]  # (T, 3) each
    symbol: float
    up: Vector

    @cached_property
    def corners(self) -> Vector:
        """The lowest and the highest corner of all moments, (2, 3), m."""
        found = [np.zeros((0, 3))]
        for body in self.bodies:
            reach = float(np.linalg.norm(body.solid.vertices, axis=1).max())
            found += [body.poses[:, :3] - reach, body.poses[:, :3] + reach]
        found += [line.points.reshape(-1, 3) for line in self.lines] + [points for _, points in self.traces]
        points = np.concatenate(found)
        points = points[np.isfinite(points).all(axis=1)]
        if not len(points):
            return np.array([-np.ones(3), np.ones(3)])
        return np.array([points.min(axis=0), points.max(axis=0)])


def matrices(quaternions: Vector) -> Vector:
    """(..., 4), the real part first, of any length but 0 -> (..., 3, 3)."""
    w, x, y, z = np.moveaxis(quaternions / np.linalg.norm(quaternions, axis=-1, keepdims=True), -1, 0)
    rows = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def quaternions(turns: Vector) -> Vector:
    """(T, 3, 3) -> (T, 4), continuous in their sign. By the largest of four ways (Shepperd, 1978)."""
    trace = np.trace(turns, axis1=1, axis2=2)
    diagonal = np.diagonal(turns, axis1=1, axis2=2)
    squares = np.column_stack([1 + trace, *(1 + 2 * diagonal - trace[:, None]).T])
    best = squares.argmax(axis=1)
    found = np.empty((len(turns), 4))
    for k, (turn, way) in enumerate(zip(turns, best, strict=True)):
        skew = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
        if way == 0:
            row = np.array([squares[k, 0], *skew])
        else:
            i = way - 1
            row = np.array([skew[i], *(turn[i] + turn[:, i])])
            row[way] = squares[k, way]
        row /= np.linalg.norm(row)
        found[k] = -row if k and row @ found[k - 1] < 0 else row
    if len(found) and found[0, 0] < 0:
        found = -found
    return found
