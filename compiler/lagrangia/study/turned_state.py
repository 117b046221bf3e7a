"""The state (q, v) of an integrator that is not ours: attitudes are unit quaternions in it, which no step of his moves on."""

from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.run.scene import Scene
from lagrangia.study.turned import present, turned_of

Vector = NDArray[np.float64]


class TurnedState:
    """`positions`, `size`: how many positions it has, and positions and rates. Without attitudes it is (q, v) itself."""

    def __init__(self, scene: Scene) -> None:
        self.n, self.turned = scene.n, turned_of(scene)
        self.positions = scene.n + len(self.turned.names)
        self.size = self.positions + scene.n
        self.modes = scene.patterns["attitudes"][1::2] if self.turned.names else ()

    def begun(self, q: Vector, given: Vector, modes: Vector) -> Vector:
        """Told positions of the start; `given`: values of coordinates from no turn, NaN where they are as declared."""
        if not self.turned.names:
            return q
        references = self.turned.declared(modes, self.modes)
        for k, places in enumerate(self.turned.places):
            if not np.isnan(given[places]).any():
                references[k] = present(np.array([1.0, 0.0, 0.0, 0.0]), given[places])
        found: list[float] = []
        quaternions = dict(zip(self.turned.firsts, references, strict=True))
        for place in range(self.n):
            if place in quaternions:
                found += quaternions[place].tolist()
            elif place not in self.turned.all:
                found.append(float(q[place]))
        return np.array(found)

    def split(self, y: Any, modes: Any) -> tuple[Any, Any, Any, Any]:
        """Of numbers or symbols: coordinates, rates, modes with the references of attitudes, and rates of told positions."""
        v = y[self.positions : self.size]
        if not self.turned.names:
            return y[: self.n], v, modes, v
        parts, d = ca.vertsplit(ca.SX(y) if isinstance(y, ca.SX) else ca.DM(y)), ca.vertsplit(modes)
        firsts = {first: k for k, first in enumerate(self.turned.firsts)}
        q: list[Any] = []
        pace: list[Any] = []
        place = 0
        for k in range(self.n):
            if k in firsts:
                Q = ca.vertcat(*parts[place : place + 4])
                unit = Q / ca.norm_2(Q)
                first = self.modes[firsts[k]]
                d[first : first + 4] = ca.vertsplit(unit)
                w = ca.vertcat(*parts[self.positions + k : self.positions + k + 3])
                real, turn = unit[0], unit[1:]
                pace += [-ca.dot(turn, w) / 2, (real * w + ca.cross(turn, w)) / 2]
                q += [0.0, 0.0, 0.0]
                place += 4
            elif k not in self.turned.all:
                q.append(parts[place])
                pace.append(parts[self.positions + k])
                place += 1
        return ca.vertcat(*q), ca.vertcat(*parts[self.positions : self.size]), ca.vertcat(*d), ca.vertcat(*pace)
