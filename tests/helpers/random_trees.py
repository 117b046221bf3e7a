"""Random trees of bodies, written as scenes in Lag: the same seed gives the same scene."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Body:
    name: str
    m: float
    I: float


@dataclass(frozen=True)
class RandomTree:
    """A scene with springs and dampers between its frames, a force on `force_at` and a torque on `torque_on`.

    The force is (FX, FY sin 2t) in world axes, the torque TORQUE cos 1.5t. In every other scene the base of the tree is moved.
    """

    text: str
    bodies: tuple[Body, ...]
    force_at: str
    torque_on: str


FX, FY, TORQUE = 3.0, -2.0, 0.7


def random_tree(seed: int, count: int) -> RandomTree:
    """`count` bodies: bars and discs, each joined to an earlier one by a hinge, a slider, both, or no joint at all."""
    return _Growth(seed).grow(count)


class _Growth:
    def __init__(self, seed: int) -> None:
        self.random = np.random.default_rng(seed)
        self.lines: list[str] = []
        self.bodies: list[Body] = []
        self.base = "shift(turn(world, 0.2*sin(1.5*time)), {0.3*sin(2*time), 0.1*time})" if seed % 2 else "world"
        self.frames = ["base"]

    def grow(self, count: int) -> RandomTree:
        for k in range(1, count + 1):
            self._add_body(k, self._add_joint(k))
        self._add_forces(count)
        force_at, torque_on = self._frame(), self.bodies[-1].name + ".center"
        text = "\n  ".join([
            "model Tree",
            f"Frame base = {self.base};",
            *self.lines,
            f"AppliedForce push(at = {force_at}, force = {{{FX}, {FY}*sin(2*time)}});",
            f"AppliedTorque twist(on = {torque_on}, torque = {TORQUE}*cos(1.5*time));",
            "annotation(experiment(StopTime = 2));",
        ])
        return RandomTree(f"{text}\nend Tree;\n", tuple(self.bodies), force_at, torque_on)

    def _number(self, low: float, high: float) -> float:
        return round(float(self.random.uniform(low, high)), 3)

    def _vector(self) -> str:
        return f"{{{self._number(-1, 1)}, {self._number(-1, 1)}}}"

    def _frame(self) -> str:
        return str(self.random.choice(self.frames[1:]))

    def _start(self, *names: str) -> str:
        return ", ".join(f"{name}(start = {self._number(-1, 1)})" for name in names)

    def _add_joint(self, k: int) -> str:
        """The joint between a frame that is there and the next body; returns the frame that moves."""
        self.lines.append(f"Weld w{k}(a = {self.random.choice(self.frames)}, offset = {self._vector()}, "
                          f"angle = {self._number(-3, 3)});")
        slider = f"Prismatic s{k}(a = w{k}.b, along = {self._vector()}, {self._start('s')});"
        kind = self.random.choice(["hinge", "slider", "both", "free"], p=[0.5, 0.2, 0.2, 0.1])
        if kind == "free":
            self.lines.append(f"Planar j{k}(a = w{k}.b, {self._start('x', 'y', 'phi')});")
            return f"j{k}.b"
        if kind != "hinge":
            self.lines.append(slider)
        if kind == "slider":
            return f"s{k}.b"
        self.lines.append(f"Revolute j{k}(a = {'s' if kind == 'both' else 'w'}{k}.b, {self._start('phi')});")
        return f"j{k}.b"

    def _add_body(self, k: int, frame: str) -> None:
        m, size = self._number(0.2, 3), self._number(0.2, 1.5)
        if self.random.random() < 0.6:
            self.lines.append(f"Bar b{k}(m = {m}, L = {size}, a = {frame});")
            self.bodies.append(Body(f"b{k}", m, m * size**2 / 12))
            self.frames += [f"b{k}.a", f"b{k}.b"]
        else:
            self.lines.append(f"Disc b{k}(m = {m}, r = {size}, center = shift({frame}, {self._vector()}));")
            self.bodies.append(Body(f"b{k}", m, m * size**2 / 2))
            self.frames.append(f"b{k}.center")

    def _add_forces(self, count: int) -> None:
        for k in range(1, count + 1):
            ends = f"a = world, b = {self._frame()}"
            self.lines += [
                f"Spring p{k}({ends}, k = {self._number(1, 20)}, s_rel0 = {self._number(0, 1)});",
                f"Damper d{k}({ends}, c = {self._number(0.1, 1)});",
                f"TorsionSpringDamper t{k}({ends}, k = {self._number(0.5, 5)}, c = {self._number(0.05, 0.5)});",
            ]
