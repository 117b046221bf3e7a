"""Kinetic terms -> inertias of rigid bodies.

A kinetic term that reads only the velocities of frames of one rigid body, is quadratic in its twist, and does not change when
the body is moved and turned, is that body's inertia: mass, first moment and second moment about one of its frames.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import casadi as ca

from lagrangia.algebra import Scalar
from lagrangia.energies import Energies, Term
from lagrangia.evaluation import Evaluator, Value
from lagrangia.flat import FlatModel
from lagrangia.graph import ComponentGraph
from lagrangia.kinematics import Kinematics, Pose
from lagrangia.tree import Call, FrameRef, Ref, Time
from lagrangia.walk import nodes


@dataclass(frozen=True)
class Inertia:
    """Of a rigid body about the origin of one of its frames, in that frame's axes: kg, kg.m, kg.m2."""

    frame: str
    mass: Scalar
    moment_x: Scalar
    moment_y: Scalar
    second_moment: Scalar


@dataclass(frozen=True)
class Bodies:
    """What moves: the inertias, and the kinetic terms that are no rigid body's.

    `home` names the reference frame of the body of each frame, `local` says where the frame sits in it.
    """

    inertias: tuple[Inertia, ...]
    rest: tuple[Term, ...]
    home: Mapping[str, str]
    local: Mapping[str, Pose]


@dataclass(frozen=True)
class _Candidate:
    term: Term
    frame: str
    straight: ca.SX  # Hessian with the body at angle 0
    turned: ca.SX  # and at a general angle


def find_bodies(kinematics: Kinematics, energies: Energies) -> Bodies:
    """Splits the kinetic energy into rigid bodies and the rest."""
    home, local = _rigid_clusters(kinematics)
    angle = ca.SX.sym("c"), ca.SX.sym("s")
    candidates = [_candidate(kinematics, term, home, local, angle) for term in energies.kinetic]
    rigid = _are_rigid([c for c in candidates if isinstance(c, _Candidate)], angle, kinematics)
    inertias, rest = [], []
    for candidate, term in zip(candidates, energies.kinetic, strict=True):
        if candidate is None or not next(rigid):
            rest.append(term)
        else:
            H = candidate.straight
            inertias.append(Inertia(candidate.frame, H[0, 0], H[1, 2], -H[0, 2], H[2, 2]))
    return Bodies(tuple(inertias), tuple(rest), home, local)


def _rigid_clusters(kinematics: Kinematics) -> tuple[dict[str, str], dict[str, Pose]]:
    """Frames joined by rigid edges: their reference frame, the one nearest to the root, and their poses in it."""
    graph: ComponentGraph = kinematics.graph
    home, local = {}, {}
    for frame in (*(root.frame for root in graph.roots), *(edge.child for edge in graph.edges if not edge.is_rigid)):
        home[frame], local[frame] = frame, Pose(0.0, 0.0, 0.0, 1.0, 0.0)
    for edge in graph.edges:
        if edge.is_rigid:
            home[edge.child], local[edge.child] = home[edge.parent], kinematics.follow(edge, local[edge.parent], 0)
    return home, local


def _candidate(
    kinematics: Kinematics, term: Term, home: Mapping[str, str], local: Mapping[str, Pose], angle: tuple[ca.SX, ca.SX]
) -> _Candidate | None:
    frames = _velocities_read(kinematics.graph.model, term)
    if not frames or len({home[name] for name in frames}) != 1:
        return None
    frame = min(frames)
    straight, turned = (_hessian(kinematics, term, local, frame, c, s) for c, s in ((1.0, 0.0), angle))
    return _Candidate(term, frame, straight, turned)


def _velocities_read(model: FlatModel, term: Term) -> set[str] | None:
    """The frames whose velocity the term reads; None when it reads positions, time, or rates of anything else."""
    frames: set[str] = set()
    seen: set[str] = set()
    pending = [term.statement.value]
    while pending:
        for node in nodes(pending.pop()):
            if (isinstance(node, Call) and node.function in ("der", "distance")) or isinstance(node, Time):
                return None
            if isinstance(node, FrameRef):
                if node.attribute not in ("v", "w"):
                    return None
                frames.add(node.name)
            if isinstance(node, Ref) and node.name not in seen:
                seen.add(node.name)
                variable = model.variables[node.name]
                if variable.kind == "coordinate":
                    return None
                if variable.kind == "variable" and variable.binding is not None:
                    pending.append(variable.binding)
    return frames


def _hessian(kinematics: Kinematics, term: Term, local: Mapping[str, Pose], frame: str, cosine: Scalar, sine: Scalar) -> ca.SX:
    """d2T/d(twist)2, the twist being that of `frame` in the body's axes, the body at the angle given by cosine and sine."""
    twist = ca.SX.sym("twist", 3)
    probe = _Probe(kinematics, local, frame, twist, cosine, sine)
    value = Evaluator(kinematics.graph.model, kinematics.algebra, probe).value(term.statement.value)
    slope = ca.gradient(ca.SX(value), twist)
    hessian = ca.densify(ca.jacobian(slope, twist))
    return ca.substitute(hessian, twist, ca.SX.nan(3)) if ca.depends_on(hessian, twist) else hessian


class _Probe:
    """Leaves of an evaluator in which the velocities of one body's frames come from a free twist in its own axes."""

    def __init__(self, kinematics: Kinematics, local: Mapping[str, Pose], frame: str, twist: ca.SX, cosine: Scalar,
                 sine: Scalar) -> None:
        self.kinematics, self.local, self.origin = kinematics, local, local[frame]
        self.twist, self.cosine, self.sine = twist, cosine, sine

    def symbol(self, name: str, level: int) -> Value | None:
        return self.kinematics.symbol(name, level)

    def time(self, level: int) -> Scalar:
        return self.kinematics.time(level)

    def frame(self, name: str, attribute: str, level: int) -> Value:
        vx, vy, w = (self.twist[k] for k in range(3))
        if attribute == "w":
            return w
        place = self.local[name]
        if place is not self.origin:
            vx, vy = vx - w * (place.y - self.origin.y), vy + w * (place.x - self.origin.x)
        return (self.cosine * vx - self.sine * vy, self.sine * vx + self.cosine * vy)


def _are_rigid(candidates: list[_Candidate], angle: tuple[ca.SX, ca.SX], kinematics: Kinematics) -> Iterator[bool]:
    """For each candidate: is its Hessian constant, isotropic in the mass, and the same at every angle?

    The last is an identity between expressions (c c + s s = 1 among others); it is tested with numbers at a general angle.
    """
    if not candidates:
        return iter(())
    gaps = [ca.norm_inf(ca.vertcat(ca.vec(c.straight - c.turned), c.straight[0, 0] - c.straight[1, 1], c.straight[0, 1]))
            for c in candidates]
    sizes = [ca.norm_inf(ca.vec(c.straight)) for c in candidates]
    table = ca.horzcat(ca.vertcat(*gaps), ca.vertcat(*sizes))
    moving = ca.vertcat(kinematics.algebra.state, kinematics.symbols.time)
    steady = [True] * len(candidates)
    if ca.depends_on(table, moving):
        steady = [not ca.depends_on(c.straight, moving) for c in candidates]
    free = ca.symvar(table)
    numbers = {angle[0].__hash__(): 0.6, angle[1].__hash__(): 0.8}
    values = [numbers.get(s.__hash__(), 0.7 + 0.31 * (k % 17)) for k, s in enumerate(free)]
    result = ca.Function("identity", [ca.vertcat(*free)], [table])(ca.DM(values)) if free else ca.evalf(table)
    return iter([flag and float(gap) <= 1e-12 * float(size) for flag, (gap, size) in zip(steady, result.full(), strict=True)])
