"""Kinetic terms -> inertias of rigid bodies.

A kinetic term that reads only the velocities of frames of one rigid body, is quadratic in its twist, and does not change when
the body is moved and turned, is that body's inertia: mass, first moment and second moment about one of its frames.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import casadi as ca

from lagrangia.algebra.duals import Scalar
from lagrangia.base.records import dataclass
from lagrangia.dynamics.energies import Energies, Term
from lagrangia.frames.alike import evaluate_all
from lagrangia.frames.evaluation import Evaluator, Value
from lagrangia.frames.geometry import Inertia, Pose
from lagrangia.frames.graph import ComponentGraph
from lagrangia.frames.kinematics import Kinematics
from lagrangia.frames.rigid_poses import follow_rigid
from lagrangia.language.flat import FlatModel
from lagrangia.language.frame_attributes import is_velocity
from lagrangia.language.mentions import nodes
from lagrangia.language.tree import Call, FrameRef, Ref, Time


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
    energy: Scalar  # of a free twist in the frame's axes, with the body at a general angle


def find_bodies(kinematics: Kinematics, energies: Energies) -> Bodies:
    """Splits the kinetic energy into rigid bodies and the rest, without first-order states."""
    home, local = _rigid_clusters(kinematics)
    body = kinematics.geometry.free_body()
    kinetic = [term for term in energies.kinetic if not term.statement.is_signal]
    candidates = _candidates(kinematics, kinetic, home, local, body)
    turned = body.hessians([candidate.energy for candidate in candidates])
    straight = body.straight(turned)
    rigid = _are_rigid(straight, turned, body, kinematics)
    known = kinematics.geometry.inertias([c.frame for c in candidates], straight)
    solved = {id(c.term) for c, is_rigid in zip(candidates, rigid, strict=True) if is_rigid}
    rest = tuple(term for term in kinetic if id(term) not in solved)
    return Bodies(tuple(x for x, is_rigid in zip(known, rigid, strict=True) if is_rigid), rest, home, local)


def _rigid_clusters(kinematics: Kinematics) -> tuple[dict[str, str], dict[str, Pose]]:
    """Frames joined by rigid edges: their reference frame, the one nearest to the root, and their poses in it."""
    graph: ComponentGraph = kinematics.graph
    home, local = {}, {}
    for frame in (*(root.frame for root in graph.roots), *(edge.child for edge in graph.edges if not edge.is_rigid)):
        home[frame], local[frame] = frame, kinematics.seen_from_itself(frame)
    rigid = [edge for edge in graph.edges if edge.is_rigid]
    for edge in rigid:
        home[edge.child] = home[edge.parent]
    follow_rigid(kinematics, rigid, local)
    return home, local


def _candidates(
    kinematics: Kinematics, terms: Sequence[Term], home: Mapping[str, str], local: Mapping[str, Pose], body: Any
) -> list[_Candidate]:
    model, read = kinematics.graph.model, [_velocities_read(kinematics.graph.model, term) for term in terms]
    found = [(term, min(frames)) for term, frames in zip(terms, read, strict=True)
             if frames and len({home[name] for name in frames}) == 1]
    evaluators = [Evaluator(model, kinematics.algebra, _Probe(kinematics, local, frame, body)) for _, frame in found]
    energies = evaluate_all([term.statement.value for term, _ in found], evaluators)
    return [_Candidate(term, frame, energy) for (term, frame), energy in zip(found, energies, strict=True)]


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
                if not is_velocity(node.attribute):
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


class _Probe:
    """Leaves of an evaluator in which the velocities of one body's frames come from a free twist in its own axes."""

    def __init__(self, kinematics: Kinematics, local: Mapping[str, Pose], frame: str, body: Any) -> None:
        self.kinematics, self.local, self.own, self.body = kinematics, local, local[frame], body

    def symbol(self, name: str, level: int) -> Value | None:
        return self.kinematics.symbol(name, level)

    def time(self, level: int) -> Scalar:
        return self.kinematics.time(level)

    def frame(self, name: str, attribute: str, level: int) -> Value:
        return self.body.velocity(attribute, self.local[name], self.own)


def _are_rigid(straight: ca.SX, turned: ca.SX, body: Any, kinematics: Kinematics) -> list[bool]:
    """For each row: is its Hessian constant, isotropic in the mass, and the same at every angle?

    The last is an identity between expressions (c c + s s = 1 among others); it is tested with numbers at a general angle.
    """
    rows = straight.size1()
    if not rows:
        return []
    gaps = ca.horzcat(straight - turned, kinematics.geometry.unlike_a_body(straight))
    table = ca.horzcat(gaps, straight)
    moving = ca.vertcat(kinematics.algebra.state, kinematics.symbols.time)
    steady = [True] * rows
    if ca.depends_on(table, moving):
        steady = [not ca.depends_on(straight[k, :], moving) for k in range(rows)]
    free = ca.symvar(table)
    values = [body.general.get(s.__hash__(), 0.7 + 0.31 * (k % 17)) for k, s in enumerate(free)]
    found = ca.Function("identity", [ca.vertcat(*free)], [table])(ca.DM(values)) if free else ca.evalf(table)
    sizes, count = abs(found.full()), gaps.size2()
    are_small = sizes[:, :count].max(axis=1) <= 1e-12 * sizes[:, count:].max(axis=1)
    return [flag and is_small for flag, is_small in zip(steady, are_small.tolist(), strict=True)]
