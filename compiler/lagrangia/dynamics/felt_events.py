"""Events of scenes in which forces feel reactions: what an impulse of a joint rubs must not change what rates are afterwards.

An impulse L_j of a reset loads a joint by its own, and there friction takes an impulse along a direction d_k of the coordinates:
M dv = J^T Lambda + R^T L + sum_k d_k n_k. Rates R v are what the event sets them to and J v stay 0, whatever else acts. So where
d_k is a combination of the rows of J and R, n_k changes L and Lambda alone, and no rate. It is so of an event that sets all that
can move, and of friction along the very rate that is set; else the law of impulses that rub would have to be known.
"""

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.base.diagnostics import Span, fail
from lagrangia.constraints.parameters import usual_parameters
from lagrangia.dynamics.motion import Felt, Motion
from lagrangia.frames.kinematics import Kinematics

_NOTHING = 1e-9  # relative size of what is rounding


def refuse_rubbing_impulses(kinematics: Kinematics, motion: Motion, felt: Felt, span: Span) -> None:
    """`span`: of the force. Raises LagError L0914."""
    impacts, held = motion.impacts, motion.constrained
    if not impacts.places:
        return
    symbols, multipliers = (held.symbols, held.multipliers) if held else (ca.SX(0, 1), ca.SX(0, 1))
    (values,) = ca.substitute([felt.values], [motion.a, symbols], [motion.acceleration, multipliers])
    slopes = ca.jacobian(felt.laws, felt.reactions)
    by_impulses, by_contacts, along, J, R = _at_some_place(kinematics, motion, [
        slopes @ ca.jacobian(values, impacts.impulses), slopes @ ca.jacobian(values, impacts.forces),
        ca.jacobian(motion.h, felt.amounts), held.J if held else ca.SX(0, motion.v.numel()),
        ca.jacobian(impacts.rates, motion.v)])
    whens = kinematics.graph.model.whens
    for event, when in enumerate(whens):
        if _is_some(by_contacts[:, event]):
            fail("L0914", "not supported yet: forces that feel reactions where something may rest at a contact that loads them",
                 span, f"the contact is at {when.span}; make the stop a stiff spring (Translational.ElastoGap), or leave "
                 "out the friction")
        own = [k for k, place in enumerate(impacts.places[::2]) if place == event]
        for amount in range(felt.amounts.numel()):
            if _is_some(by_impulses[amount, own]) and not _is_combination(along[:, amount], np.vstack([J, R[own]])):
                fail("L0914", "not supported yet: an event whose impulse loads a joint that rubs, and leaves its rate open", span,
                     f"the event is at {when.span}: impulses of joints would rub, too; set the rate of this joint there as well, "
                     "reinit(w, value), or leave out the friction")


def _at_some_place(kinematics: Kinematics, motion: Motion, expressions: list[ca.SX]) -> list[NDArray[np.float64]]:
    """Numbers, with the usual parameters and all else like any other."""
    p, numbers = usual_parameters(kinematics)
    rest = [x for x in ca.symvar(ca.veccat(*expressions)) if not ca.depends_on(p, x)]
    some = np.random.default_rng(5).uniform(0.3, 1.3, len(rest))
    found = ca.Function("look", [p, ca.vertcat(ca.SX(0, 1), *rest)], [ca.densify(x) for x in expressions])(numbers, some)
    return [np.array(x) for x in found]


def _is_some(x: NDArray[np.float64]) -> bool:
    return bool(np.abs(x).max(initial=0.0) > _NOTHING) or not bool(np.isfinite(x).all())


def _is_combination(x: NDArray[np.float64], rows: NDArray[np.float64]) -> bool:
    """Of rows, whose sizes do not count."""
    sizes = np.linalg.norm(rows, axis=1)
    kept = (rows[sizes > 0].T / sizes[sizes > 0])
    left = x - kept @ np.linalg.lstsq(kept, x, rcond=None)[0]
    return bool(np.linalg.norm(left) <= _NOTHING * np.linalg.norm(x))
