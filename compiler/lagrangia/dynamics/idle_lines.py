"""Energies -> warnings of forces along lines without length: of springs, dampers and actuators between two places that are one,
now or for ever, or belong to one rigid body."""

from collections.abc import Iterator, Mapping, Sequence

import casadi as ca
import numpy as np

from lagrangia.algebra.orthogonal import Vector
from lagrangia.base.diagnostics import Report
from lagrangia.base.records import dataclass
from lagrangia.constraints.assembly import assembled
from lagrangia.constraints.initial import InitialConditions
from lagrangia.constraints.parameters import at_declared_values, at_start, default_parameters, usual_parameters
from lagrangia.frames.evaluation import origin_of, scalars_of
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.flat import Energy, FlatModel, Work, is_frame
from lagrangia.language.mentions import children
from lagrangia.language.tree import Call, Flat, FrameRef, Ref

_NOTHING = 1e-13  # m: less is one place
_NEAR, _FAR = 1e-7, 1e-4  # m or rad beside the start
_STAYS = 0.5  # the share of a force that is left where it is looked at so much nearer
_LOOKS = 3
Ends = tuple[Flat, Flat]


@dataclass(frozen=True)
class _Line:
    """A statement that acts along distances alone."""

    statement: Energy | Work
    ends: tuple[Ends, ...]


def find_idle_lines(kinematics: Kinematics, initial: InitialConditions) -> Report:
    """L0224 for what never does anything, L0607 for what begins with no direction to act in."""
    report, groups = Report(), _lines(kinematics.graph.model)
    if not groups:
        return report
    places = _Places(kinematics, initial, [line for group in groups for line in group])
    for group in groups:
        statement = group[0].statement
        name = f"'{statement.component}'" if statement.component else "this"
        if all(places.is_idle(line) for line in group):
            report.warning("L0224", f"{name} does nothing: the distance of its two ends never changes", statement.span,
                           "they are one place, or held at a distance: give it other ends, or leave it out")
        elif any(places.is_undecided(line) for line in group):
            report.warning("L0607", f"the two ends of {name} are one place at the start, where its force has no direction",
                           statement.span, "start them apart; on a line, bind the stretch, as stretch = block.s - s0")
    return report


# ------------------------------------------------------------ what a model states


def _lines(model: FlatModel) -> list[list[_Line]]:
    """Of each component all it states, where that acts along distances alone."""
    stated: dict[object, list[Energy | Work]] = {}
    everything: tuple[Energy | Work, ...] = (*model.energies, *model.works)
    for k, statement in enumerate(everything):
        stated.setdefault(statement.component or k, []).append(statement)
    found = [[_line(statement, model) for statement in statements] for statements in stated.values()]
    return [[line for line in group if line is not None] for group in found if None not in group]


def _line(statement: Energy | Work, model: FlatModel) -> _Line | None:
    if isinstance(statement, Energy) and statement.kind == "kinetic":
        return None
    ends: dict[Ends, None] = {}
    for node in _reached(statement.value if isinstance(statement, Energy) else statement.position, model):
        if (pair := _ends(node)) is not None:
            ends[pair] = None
        elif isinstance(node, FrameRef) or (isinstance(node, Ref) and model.variables[node.name].kind == "coordinate"):
            return None
    return _Line(statement, tuple(ends)) if ends else None


def _reached(root: Flat, model: FlatModel) -> Iterator[Flat]:
    """Every node, through the bindings of variables, but not those inside of a distance."""
    pending, seen = [root], set[str]()
    while pending:
        node = pending.pop()
        yield node
        if _ends(node) is None:
            pending += children(node)
        if isinstance(node, Ref) and node.name not in seen:
            seen.add(node.name)
            variable = model.variables.get(node.name)
            if variable is not None and variable.kind == "variable" and variable.binding is not None:
                pending.append(variable.binding)


def _ends(node: Flat) -> Ends | None:
    """Of the distance of two frames: both."""
    if not (isinstance(node, Call) and node.function == "distance" and all(map(is_frame, node.arguments))):
        return None
    a, b = node.arguments
    return a, b


# ------------------------------------------------------------ where that is


def _bodies(kinematics: Kinematics) -> dict[str, str]:
    """Of each frame the first one of its rigid body."""
    found: dict[str, str] = {}
    for edge in kinematics.graph.edges:
        if edge.is_rigid:
            found[edge.child] = found.get(edge.parent, edge.parent)
    return found


def _is_rigid(ends: Ends, bodies: Mapping[str, str]) -> bool:
    names = [node.name if isinstance(node, FrameRef) else "" for node in ends]
    return "" not in names and bodies.get(names[0], names[0]) == bodies.get(names[1], names[1])


def _lengths(vectors: ca.DM, count: int) -> Vector:
    """Of so many vectors, one behind the other."""
    found: Vector = np.hypot.reduce(np.array(vectors).reshape(count, -1), axis=1)
    return found


class _Places:
    """Numbers for where the ends of lines are: at the start, and elsewhere."""

    def __init__(self, kinematics: Kinematics, initial: InitialConditions, lines: Sequence[_Line]) -> None:
        self.kinematics, self.bodies = kinematics, _bodies(kinematics)
        self.q, self.v = (ca.vertcat(ca.SX(0, 1), *s.values()) for s in (kinematics.symbols.positions, kinematics.symbols.rates))
        p, values = default_parameters(kinematics)
        n = self.q.numel()  # behind these stand those that are given by others
        self.start, self.rates = (np.array(ca.evalf(ca.substitute(x[:n], p, values))).ravel() for x in (initial.q, initial.v))
        ends = list(dict.fromkeys(ends for line in lines for ends in line.ends))
        between = [self._between(pair) for pair in ends]
        apart = ca.Function("apart", [self.q, p], at_start(kinematics, [ca.vertcat(*between)]))
        random, others = np.random.default_rng(1), usual_parameters(kinematics)[1]
        looks = np.array([_lengths(apart(random.uniform(0.4, 1.6, self.start.size), others), len(ends)) for _ in range(_LOOKS)])
        stays = [not ca.depends_on(r, kinematics.symbols.time) and np.ptp(looks[:, k]) < _NOTHING for k, r in enumerate(between)]
        now = _lengths(apart(self.start, values), len(ends))
        if initial.residuals.numel() > 0 and now.min(initial=1.0) < _NOTHING:  # by the guesses: equations may ask for others
            state, failed = assembled(kinematics, initial)
            if failed < 0:
                self.start, self.rates = state[:n], state[state.size // 2 :][:n]
                now = _lengths(apart(self.start, values), len(ends))
        self.rigid = {pair for k, pair in enumerate(ends) if stays[k]}
        self.one = {pair for k, pair in enumerate(ends) if stays[k] and looks[0, k] < _NOTHING}
        self.now = {pair for k, pair in enumerate(ends) if now[k] < _NOTHING}

    def _between(self, ends: Ends) -> ca.SX:
        a, b = (ca.vertcat(*scalars_of(self.kinematics.evaluator.value(origin_of(node)))) for node in ends)
        return a - b

    def is_idle(self, line: _Line) -> bool:
        """Whether its ends are one place wherever the scene is; what only resists asks for a length that never changes."""
        resists = isinstance(line.statement, Energy) and line.statement.kind == "dissipation"
        return all(_is_rigid(ends, self.bodies) or ends in (self.rigid if resists else self.one) for ends in line.ends)

    def is_undecided(self, line: _Line) -> bool:
        """Whether a force acts along a line that has no length at the start, and nothing moves yet."""
        if self.now.isdisjoint(line.ends) or self.rates.any():
            return False
        statement, value = line.statement, self.kinematics.evaluator.value
        if isinstance(statement, Energy):
            V = ca.SX(value(statement.value)) if statement.kind == "potential" else ca.SX(0)
            force = ca.densify(ca.gradient(V, self.q))
        else:
            force = ca.jtimes(ca.vertcat(*scalars_of(value(statement.position))), self.q,
                              ca.vertcat(*scalars_of(value(statement.force))), True)
        (force,) = at_declared_values(self.kinematics, [ca.substitute(ca.densify(force), self.v, ca.SX.zeros(self.v.numel()))])
        look, way = ca.Function("look", [self.q], [force]), np.random.default_rng(2).uniform(0.4, 1.6, self.start.size)
        near, far = (float(np.linalg.norm(np.array(look(self.start + step * way)))) for step in (_NEAR, _FAR))
        return near > _STAYS * far > 0


