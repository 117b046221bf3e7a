"""Random linkages of one degree of freedom, written as scenes in Lag: a crank, and pairs of links one after the other, each
between points that are there already. The same seed gives the same scene."""

from dataclasses import dataclass

import numpy as np

from helpers.reference import Array


@dataclass(frozen=True)
class _Point:
    """A frame, where it is at the start, and the angle of its body."""

    frame: str
    place: Array
    angle: float


class _Linkage:
    def __init__(self, seed: int, is_guessed: bool) -> None:
        self.random, self.is_guessed = np.random.default_rng(seed), is_guessed
        self.lines = ["Revolute crank_bearing(a = world, phi(start = 0.7, fixed = true), w(start = 5)); "
                      "Bar crank(m = 1, L = 0.3, a = crank_bearing.b);"]
        self.points = [_Point("crank.b", 0.3 * np.array([np.cos(0.7), np.sin(0.7)]), 0.7)]

    def ground(self, place: Array) -> _Point:
        return _Point(f"shift(world, {{{place[0]}, {place[1]}}})", place, 0.0)

    def bar(self, name: str, start: _Point, end: Array) -> None:
        """On a hinge at a point, as long and turned as it takes to reach the end."""
        length, angle = float(np.hypot(*(end - start.place))), float(np.arctan2(*(end - start.place)[::-1]))
        guess = f", phi(start = {angle - start.angle})" if self.is_guessed else ""
        self.lines.append(f"Revolute {name}_hinge(a = {start.frame}{guess}); "
                          f"Bar {name}(m = {self.random.uniform(0.2, 2):.2f}, L = {length}, a = {name}_hinge.b);")
        self.points.append(_Point(f"{name}.b", end, angle))

    def pair(self, k: int) -> None:
        """Two links between a point that moves and another one, or a link and a slider."""
        moving = self.points[self.random.integers(len(self.points))]
        end = moving.place + self.random.uniform(0.6, 1, 2) * self.random.choice([-1, 1], 2)
        if self.random.random() < 0.3:
            self.bar(f"rod{k}", moving, end)
            along = f"{{1, {self.random.uniform(-0.4, 0.4):.2f}}}"
            self.lines.append(f"Prismatic guide{k}(a = {self.ground(end).frame}, along = {along}); "
                              f"PointMass slider{k}(m = 0.5, center = guide{k}.b); "
                              f"Revolute pin{k}(a = rod{k}.b, b = guide{k}.b);")
            return
        others = [point for point in self.points if point is not moving]
        other = self.ground(end + self.random.uniform(0.3, 0.7, 2)) if not others or self.random.random() < 0.6 else others[0]
        self.bar(f"left{k}", moving, end)
        self.bar(f"right{k}", other, end)
        self.points.pop()
        self.lines.append(f"Revolute pin{k}(a = left{k}.b, b = right{k}.b);")


def random_linkage(seed: int, pairs: int, is_guessed: bool = True) -> str:
    """`is_guessed`: the angles of all links are stated as guesses, else that of the crank alone."""
    linkage = _Linkage(seed, is_guessed)
    for k in range(pairs):
        linkage.pair(k)
    return "model Linkage\n  " + "\n  ".join(linkage.lines) + "\nend Linkage;\n"
