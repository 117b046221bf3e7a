"""Energies -> warnings of those that jump where a condition on positions or rates changes: what crosses it gets no impulse.

A force is the slope of an energy, and a jump has none that is finite: `if s > 1 then 5 else 0` would turn back all that comes
with less than 5 J, and an inertia that doubles at a place would take half of the speed there. So the energy account is open from
then on. Each condition is looked at where it changes, found by Newton's method from a few general positions.
"""

from collections.abc import Iterator

import casadi as ca
import numpy as np

from lagrangia.algebra.numbering import Numbering, rebuilt
from lagrangia.algebra.orthogonal import Vector
from lagrangia.algebra.scalars import Expression, symbols_in
from lagrangia.algebra.with_casadi import operations_in
from lagrangia.base.diagnostics import Report
from lagrangia.constraints.parameters import default_parameters
from lagrangia.dynamics.held_switches import WHOLE
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.mentions import reached
from lagrangia.language.tree import Call, Flat, IfExpression

_CONTINUOUS = frozenset(("abs", "max", "min", "sqrt", "exp", "sin", "cos", "dot", "cross", "norm", "rotate", "distance",
                         "der", "sum"))
_COMPARED = (ca.OP_LT, ca.OP_LE, ca.OP_SIGN, *WHOLE)
_ASIDE = 1e-7  # m or rad: how far from the place it is looked at, to both sides
_JUMP, _NOTHING = 10.0, 1e-9  # between both sides, by the changes beyond them; relative
_POINTS, _ITERATIONS, _CLOSE = 8, 30, 1e-12


def find_jumping_energies(kinematics: Kinematics) -> Report:
    """L0744 for kinetic and potential energies, with their places."""
    report, model, symbols = Report(), kinematics.graph.model, kinematics.symbols
    if kinematics.algebra.index.asked <= _CONTINUOUS:
        return report
    bindings = {name: v.binding for name, v in model.variables.items() if v.kind == "variable"}
    asked = [e for e in model.energies if e.kind != "dissipation" and any(map(_may_jump, reached([e.value], bindings)))]
    q, v = (ca.vertcat(ca.SX(0, 1), *x.values()) for x in (symbols.positions, symbols.rates))
    for energy in asked:
        value = ca.SX(kinematics.evaluator.value(energy.value))
        if _jumps(kinematics, value, q, v, ca.SX(0, 1)):
            report.warning("L0744", f"the {energy.kind} energy jumps where a condition on positions changes, which takes a force "
                           "without bound: what crosses the place gets no impulse, and the energy account is open from then on",
                           energy.span, "let it rise over a short way d: min(1, max(0, (x - x0)/d)) for if x > x0 then 1 else 0")
        elif _jumps(kinematics, value, v, ca.SX(0, 1), q):
            report.warning("L0744", f"the {energy.kind} energy jumps where a condition on rates changes, and has no momentum "
                           "there: what passes that rate keeps it, and the energy account is open from then on", energy.span,
                           "let it depend on positions or time: a kinetic energy is of second degree in rates")
    return report


def _may_jump(node: Flat) -> bool:
    return isinstance(node, IfExpression) or (isinstance(node, Call) and node.function not in _CONTINUOUS)


def _jumps(kinematics: Kinematics, value: ca.SX, q: ca.SX, v: ca.SX, fixed: ca.SX) -> bool:
    """Whether a value jumps where a condition on `q` changes that none of `fixed` has a share in; all else is anywhere."""
    if operations_in(value).isdisjoint(_COMPARED):
        return False
    conditions = [g for g in _conditions(value, q) if not ca.depends_on(g, fixed)]
    own = symbols_in(ca.veccat(q, v))
    others = [x for x in ca.symvar(ca.veccat(value, *conditions)) if x.__hash__() not in own]
    p, declared = default_parameters(kinematics)
    known = dict(zip((x.__hash__() for x in p.elements()), np.array(declared).ravel(), strict=True))
    state = [q, v, ca.vertcat(ca.SX(0, 1), *others)]
    energy, random = ca.Function("energy", state, [value]), np.random.default_rng(4)
    for g in conditions:
        changes = ca.Function("changes", state, [g, ca.densify(ca.gradient(g, q))])
        for _ in range(_POINTS):
            place, rates = random.uniform(-1.5, 1.5, q.numel()), random.uniform(0.5, 1.5, v.numel())
            numbers = np.array([known.get(x.__hash__(), random.uniform(0.5, 1.5)) for x in others])
            found = _change_of(changes, place, rates, numbers)
            if found is None:
                continue
            aside = [found[0] + k * _ASIDE * found[1] for k in (-2, -1, 1, 2)]
            if _is_apart(*(float(energy(at, rates, numbers)) for at in aside)):
                return True
    return False


def _conditions(value: ca.SX, q: ca.SX) -> Iterator[Expression]:
    """What changes its sign where a condition on positions does."""
    moving, found = symbols_in(q), dict[int, Expression]()

    def note(op: int, numbers: list[int], operands: list[Expression]) -> None:
        if op in _COMPARED:
            g = ca.sin(ca.pi * operands[0]) if op in WHOLE else operands[0] - operands[1] if op != ca.OP_SIGN else operands[0]
            if not moving.isdisjoint(symbols_in(ca.SX(g))):
                found.setdefault(ca.SX(g).__hash__(), ca.SX(g))

    rebuilt([value], Numbering(), note)
    yield from found.values()


def _change_of(changes: ca.Function, place: Vector, rates: Vector, numbers: Vector) -> tuple[Vector, Vector] | None:
    """A position where the condition changes, and the direction across."""
    for _ in range(_ITERATIONS):
        g, slope = (np.array(x).ravel() for x in changes(place, rates, numbers))
        steep = float(slope @ slope)
        if not np.isfinite(steep) or steep == 0 or not np.isfinite(g).all():
            return None
        if abs(float(g[0])) <= _CLOSE * np.sqrt(steep):
            return place, slope / np.sqrt(steep)
        place = place - slope * (float(g[0]) / steep)
    return None


def _is_apart(far_back: float, back: float, ahead: float, far_ahead: float) -> bool:
    size, beyond = max(abs(back), abs(ahead)), abs(far_ahead - ahead) + abs(back - far_back)
    return bool(np.isfinite(size)) and abs(ahead - back) > _JUMP * beyond + _NOTHING * size
