"""ComponentGraph -> position, angle, velocity and rate of every frame as functions of q, v and t.

Along a tree: shift(a, d): r_b = r_a + R(phi_a) d;  turn(a, alpha): phi_b = phi_a + alpha. The poses are evaluated with
Duals, so the velocities come with the positions. Only this module, the frame functions and the library know that there are two
dimensions.
"""

from dataclasses import dataclass, field
from typing import Any

import casadi as ca

from lagrangia.algebra import CasadiAlgebra, Dual, Scalar, rate_of, value_of
from lagrangia.diagnostics import fail
from lagrangia.evaluation import Evaluator, Value
from lagrangia.graph import ComponentGraph, Edge, Step


@dataclass(frozen=True, slots=True)
class Pose:
    """Place of a frame: origin, angle, and the cosine and sine of the angle."""

    x: Scalar
    y: Scalar
    phi: Scalar
    cos: Scalar
    sin: Scalar


ORIGIN = Pose(0.0, 0.0, 0.0, 1.0, 0.0)


@dataclass(frozen=True)
class Symbols:
    """The symbols of one scene. tau is the rate of time, 1: kept apart so that powers of moving supports can be told."""

    time: Scalar
    tau: Scalar
    positions: dict[str, Scalar]
    rates: dict[str, Scalar]
    accelerations: dict[str, Scalar]
    values: dict[str, Any]  # parameters and inputs; tuples for arrays


@dataclass
class Kinematics:
    """Frames and symbols at each level; the `Leaves` of an Evaluator."""

    graph: ComponentGraph
    symbols: Symbols
    algebra: CasadiAlgebra
    evaluator: Evaluator = field(init=False)
    _poses: list[dict[str, Pose]] = field(default_factory=lambda: [{}, {}, {}])

    def __post_init__(self) -> None:
        self.evaluator = Evaluator(self.graph.model, self.algebra, self)

    # ------------------------------------------------------------ leaves of expressions

    def symbol(self, name: str, level: int) -> Value | None:
        if name in self.symbols.positions:
            return self.coordinate(name, level)
        return self.symbols.values.get(name)

    def coordinate(self, name: str, level: int) -> Scalar:
        q, v, a = (values[name] for values in (self.symbols.positions, self.symbols.rates, self.symbols.accelerations))
        return (q, Dual(q, v), Dual(Dual(q, v), Dual(v, a)))[level]

    def time(self, level: int) -> Scalar:
        t, tau = self.symbols.time, self.symbols.tau
        return (t, Dual(t, tau), Dual(Dual(t, tau), Dual(tau, 0.0)))[level]

    def frame(self, name: str, attribute: str, level: int) -> Value:
        if attribute in ("v", "w"):
            if level >= 2:
                fail("L0503", f"the second derivative of {name}.{attribute} is not known", self.graph.model.frames[name].span)
            pose = self.pose(name, level + 1)
            return rate_of(pose.phi) if attribute == "w" else (rate_of(pose.x), rate_of(pose.y))
        pose = self.pose(name, level)
        return {"r": (pose.x, pose.y), "phi": pose.phi, "x": pose.x, "y": pose.y}[attribute]

    # ------------------------------------------------------------ poses

    def pose(self, name: str, level: int) -> Pose:
        """Raises LagError L0401 for a frame that is joined to nothing."""
        if level == 0:
            pose = self.pose(name, 1)
            return Pose(*(value_of(x) for x in (pose.x, pose.y, pose.phi, pose.cos, pose.sin)))
        if not self._poses[level]:
            self._place_all(level)
        if name not in self._poses[level]:
            fail("L0401", f"the frame '{name}' is joined to nothing", self.graph.model.frames[name].span)
        return self._poses[level][name]

    def _place_all(self, level: int) -> None:
        poses = self._poses[level]
        for root in self.graph.roots:
            poses[root.frame] = self._root_pose(root.frame, root.attributes, level)
        for edge in self.graph.edges:
            poses[edge.child] = self.follow(edge, poses[edge.parent], level)

    def _root_pose(self, frame: str, attributes: tuple[str, ...], level: int) -> Pose:
        place = {a: self.coordinate(f"{frame}.{a}", level) for a in attributes}
        origin = Pose(place.get("x", 0.0), place.get("y", 0.0), 0.0, 1.0, 0.0)
        return self.turned(origin, place["phi"], level) if "phi" in place else origin

    def follow(self, edge: Edge, pose: Pose, level: int, evaluator: Evaluator | None = None) -> Pose:
        """The pose of the edge's child, given its parent's."""
        for step in edge.steps:
            pose = self._step(step, pose, (evaluator or self.evaluator).value(step.amount, level), level)
        return pose

    def _step(self, step: Step, pose: Pose, amount: Value, level: int) -> Pose:
        if step.kind == "turn":
            if isinstance(amount, tuple):
                fail("L0303", "an angle is a number", step.amount.span)
            return self.turned(pose, -amount if step.is_inverse else amount, level)
        if not isinstance(amount, tuple) or len(amount) != 2:
            fail("L0303", "a shift needs a vector of two components", step.amount.span, "write {x, y}")
        x, y = (-a for a in amount) if step.is_inverse else amount
        ahead_x, ahead_y = rotated(pose.cos, pose.sin, rate_of(pose.phi), x, y)
        return Pose(pose.x + ahead_x, pose.y + ahead_y, pose.phi, pose.cos, pose.sin)

    def turned(self, pose: Pose, angle: Scalar, level: int) -> Pose:
        phi = pose.phi + angle
        algebra = self.evaluator.algebras[level]
        return Pose(pose.x, pose.y, phi, algebra.call("cos", phi), algebra.call("sin", phi))


def rotated(cos: Scalar, sin: Scalar, w: Scalar, x: Scalar, y: Scalar) -> tuple[Scalar, Scalar]:
    """R d with d = (x, y). Its rate is R d' + w x (R d), which reuses R d instead of differentiating the cosine and sine."""
    moving = (cos, sin, x, y)
    if not any(isinstance(s, Dual) for s in moving):
        return cos * x - sin * y, sin * x + cos * y
    c, s, dx, dy = (value_of(m) for m in moving)
    ahead_x, ahead_y = rotated(c, s, value_of(w), dx, dy)
    stretch_x, stretch_y = rotated(c, s, value_of(w), rate_of(x), rate_of(y))
    return Dual(ahead_x, stretch_x - w * ahead_y), Dual(ahead_y, stretch_y + w * ahead_x)


def build_kinematics(graph: ComponentGraph) -> Kinematics:
    """The kinematics of a scene in fresh CasADi symbols."""
    def symbols(names: list[str]) -> dict[str, ca.SX]:
        return {name: ca.SX.sym(name) for name in names}

    names = [c.name for c in graph.coordinates]
    positions, rates = symbols(names), {name: ca.SX.sym(f"der({name})") for name in names}
    accelerations = {name: ca.SX.sym(f"der(der({name}))") for name in names}
    time, tau = ca.SX.sym("t"), ca.SX.sym("tau")
    variables = [v for v in graph.model.variables.values() if v.kind in ("parameter", "input")]
    values = {v.name: _shaped(v.name, v.shape, ()) for v in variables}
    inputs = [x for v in variables if v.kind == "input" for x in _leaves(values[v.name])]
    moving = ca.vertcat(*positions.values(), *rates.values(), *accelerations.values(), *inputs)
    return Kinematics(graph, Symbols(time, tau, positions, rates, accelerations, values), CasadiAlgebra(time, moving))


def _shaped(name: str, shape: tuple[int, ...], index: tuple[int, ...]) -> Value:
    if not shape:
        return ca.SX.sym(name + (f"[{','.join(map(str, index))}]" if index else ""))
    return tuple(_shaped(name, shape[1:], (*index, i)) for i in range(1, shape[0] + 1))


def _leaves(value: Value) -> list[Scalar]:
    return [x for item in value for x in _leaves(item)] if isinstance(value, tuple) else [value]
