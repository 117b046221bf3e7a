"""Forces that feel reactions: friction of bearings and sliders, mu |R| against the motion; R and accelerations follow together.

Accelerations a and multipliers lambda are affine in the amounts n of these forces (amounts.py), and so are the reactions
R = A + B n. With the laws n = f(R) that is a system of as many equations as there are amounts:

    n = f(A + B n)

One amount n = |R| of a vector is a quadratic equation. Several are found by Newton's method, from what they are without friction;
where the laws are linear, as |N| is while the sign of N is held, it ends at once. The steps are written out: their number does
not depend on the state, and there are Taylor series. It is sure that there is one solution, and but one, where I - |f'| |B| is an
M-matrix, whose pivots are positive, or, of sizes |x|, where the determinant is for all signs. Else friction presses, by the
reaction, more than it takes (P. Painleve, Sur les lois du frottement de glissement, C. R. Acad. Sci. 121 (1895)): there
accelerations are no numbers, and a run stops.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import product

import casadi as ca

from lagrangia.algebra.scalars import symbols_in
from lagrangia.base.diagnostics import fail
from lagrangia.base.later import Later
from lagrangia.constraints.rows import Constraints
from lagrangia.dynamics.amounts import Amounts
from lagrangia.dynamics.bodies import find_bodies
from lagrangia.dynamics.energies import build_energies
from lagrangia.dynamics.felt_events import refuse_rubbing_impulses
from lagrangia.dynamics.impulses import rates_jump
from lagrangia.dynamics.motion import Felt, Motion, Solution
from lagrangia.dynamics.negative_inertia import nothing_unless
from lagrangia.dynamics.reactions import build_reactions
from lagrangia.dynamics.switches import Switches
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.consequences import place_of_felt_reactions

_STEPS = 7  # of Newton's method: from 0.8 of what has no solution to all digits
_LEFT, _NONE = 1e-9, 1e-200  # of what an amount is after these, at most; so that a root has a slope
_MOST_SIGNS, _MOST_AMOUNTS = 3, 4  # whose determinants are written out
_Hold = Callable[[Sequence[ca.SX]], list[ca.SX]]


def feel_reactions(kinematics: Kinematics, constraints: Constraints, motion: Motion) -> Motion:
    """The motion with the reactions that its forces feel solved for; the same where they feel none. Raises LagError L0914."""
    span = place_of_felt_reactions(kinematics.graph.model)
    if span is None:
        return motion
    if rates_jump(kinematics, constraints):
        fail("L0914", "not supported yet: forces that feel reactions in scenes whose supports jump, or jump in their rates", span,
             "impulses of joints would rub, too; let supports move smoothly")
    energies = build_energies(kinematics)
    forces = ca.vertcat(energies.total(energies.dissipation), *(x for load in energies.loads for x in load.force))
    symbols, values = build_reactions(kinematics, find_bodies(kinematics, energies), constraints, motion)
    used = symbols_in(forces)
    chosen = [k for k, x in enumerate(symbols.elements()) if x.__hash__() in used]
    if not chosen:
        return motion
    amounts = Amounts(symbols[chosen])
    *parts, values = amounts.affine([*_parts(motion), values[chosen]])
    found, laws = amounts.of([*parts, values])
    felt = Felt(symbols[chosen], found, laws, values)
    unsolved = replace(_with_parts(motion, parts), felt=felt)
    refuse_rubbing_impulses(kinematics, unsolved, felt, span)
    solution = solve(unsolved, lambda expressions: [*expressions])
    return replace(_with_parts(unsolved, solution.put(_parts(unsolved))), unsolved=unsolved, solution=solution)


def _parts(motion: Motion) -> list[ca.SX]:
    """What forces are in."""
    held = motion.constrained
    of_rows = [held.multipliers, held.load_power] if held else []
    return [motion.acceleration, motion.h, motion.D, motion.dissipated_power, motion.source_power, *of_rows]


def _with_parts(motion: Motion, parts: Sequence[ca.SX]) -> Motion:
    """The motion with others. Where constraints are, there is no shorter way of regular motions: it does not tell multipliers."""
    acceleration, h, D, dissipated, source, *of_rows = parts
    held = motion.constrained
    if held is not None:
        held = replace(held, multipliers=of_rows[0], load_power=of_rows[1], regular=None)
    return replace(motion, acceleration=acceleration, inertial=Later(lambda: h), D=D, dissipated_power=dissipated,
                   source_power=source, constrained=held)


def solve(motion: Motion, hold: _Hold) -> Solution:
    """Of the motion with symbols for its amounts, where what conditions say is held as `hold` does it."""
    felt, held = motion.felt, motion.constrained
    assert felt is not None
    symbols, multipliers = (held.symbols, held.multipliers) if held else (ca.SX(0, 1), ca.SX(0, 1))
    a, multipliers, values, laws = hold([motion.acceleration, multipliers, felt.values, felt.laws])
    (values,) = ca.substitute([values], [motion.a, symbols], [a, multipliers])
    impulses = motion.impacts.impulses  # which rub without changing anything: felt_events.py
    (values,) = ca.substitute([values], [impulses], [ca.SX.zeros(impulses.numel())])
    nothing = ca.SX.zeros(felt.amounts.numel())
    B = ca.jacobian(values, felt.amounts)
    (A,) = ca.substitute([values], [felt.amounts], [nothing])
    bent = [not law.is_symbolic() and law.op() == ca.OP_FABS for law in felt.laws.elements()]
    found, margins = _Laws(felt.reactions, laws, bent).meet(A, B)
    state = ca.vertcat(motion.t, motion.q, motion.v, motion.u)
    found += nothing_unless([x for x in margins if not (x.is_constant() and float(x) > 0)], state)
    return Solution(felt, found, ca.densify(A + B @ found))


class _Laws:
    """n = f(x) of several amounts."""

    def __init__(self, x: ca.SX, laws: ca.SX, bent: Sequence[bool]) -> None:
        self.x, self.f, self.slopes, self.bent = x, laws, ca.jacobian(laws, x), bent
        self.is_linear = not ca.depends_on(self.slopes, x)

    def meet(self, A: ca.SX, B: ca.SX) -> tuple[ca.SX, list[ca.SX]]:
        """n = f(A + B n), and what is positive where that is its only solution."""
        square = self.f**2 if self.f.numel() == 1 else ca.SX(0)
        curve, slope = ca.hessian(square, self.x)
        if self.f.numel() == 1 and not self.is_linear and not ca.depends_on(curve, self.x):
            at_A, along = ca.substitute([square, slope], [self.x], [A])
            whole, half = 1 - B.T @ curve @ B / 2, along.T @ B / 2
            return (half + ca.sqrt(half**2 + whole * at_A)) / whole, [whole]
        found = ca.SX.zeros(self.f.numel())
        for _ in range(1 if self.is_linear else _STEPS):
            f, slopes = ca.substitute([self.f, self.slopes], [self.x], [ca.densify(A + B @ found)])
            step, _ = _eliminate(ca.SX.eye(found.numel()) - slopes @ B, f - found)
            found += step
        f, slopes = ca.substitute([self.f, self.slopes], [self.x], [ca.densify(A + B @ found)])
        margins = self._margins(slopes, B)
        left = [] if self.is_linear else [_LEFT**2 * ca.sumsqr(f) - ca.sumsqr(f - found) + _NONE]
        return found, margins + left


    def _margins(self, slopes: ca.SX, B: ca.SX) -> list[ca.SX]:
        """What is positive where there is but one solution, whatever the directions of norms; of sizes |x|, which are linear for
        either sign, it is known exactly: the determinants for all signs."""
        one, places = ca.SX.eye(self.f.numel()), [k for k, is_bent in enumerate(self.bent) if is_bent]
        is_straight = all(is_bent or law.is_symbolic() for is_bent, law in zip(self.bent, self.f.elements(), strict=True))
        if not is_straight or len(places) > _MOST_SIGNS or self.f.numel() > _MOST_AMOUNTS:
            return _eliminate(one - _sizes(slopes, B), ca.SX.zeros(self.f.numel()))[1]
        found = []
        for signs in product((1.0, -1.0), repeat=len(places)):
            turned = ca.SX(one)
            for place, sign in zip(places, signs, strict=True):
                turned[place, place] = sign
            found.append(ca.det(one - turned @ slopes @ B))
        return found


def _sizes(slopes: ca.SX, B: ca.SX) -> ca.SX:
    """The most that each amount can change with each: of a norm, whose direction may be any, by the sizes of vectors."""
    found = ca.SX(slopes.size1(), B.size2())
    for k in range(slopes.size1()):
        asked = sorted(set(slopes[k, :].sparsity().get_triplet()[1]))
        size = ca.norm_2(slopes[k, asked]) if len(asked) > 1 else ca.fabs(slopes[k, asked])
        for j in range(B.size2()):
            found[k, j] = size * (ca.norm_2(B[asked, j]) if len(asked) > 1 else ca.fabs(B[asked, j]))
    return found


def _eliminate(M: ca.SX, r: ca.SX) -> tuple[ca.SX, list[ca.SX]]:
    """M x = r by Gaussian elimination without exchange of rows, which matrices near that of ones do not need; and the pivots."""
    n, M, r = r.numel(), ca.SX(M), ca.densify(ca.SX(r))
    for k in range(n):
        for i in range(k + 1, n):
            if not M[i, k].is_zero():
                factor = M[i, k] / M[k, k]
                M[i, k + 1 :] -= factor * M[k, k + 1 :]
                r[i] -= factor * r[k]
    for k in reversed(range(n)):
        r[k] = (r[k] - M[k, k + 1 :] @ r[k + 1 :]) / M[k, k] if k + 1 < n else r[k] / M[k, k]
    return r, [M[k, k] for k in range(n)]


def settled(motion: Motion, switches: Switches, groups: Mapping[str, list[ca.SX]]) -> dict[str, list[ca.SX]]:
    """Groups of expressions whose conditions are held, with the amounts put in; those of "switches" are values and rates."""
    if motion.unsolved is None:
        return dict(groups)
    solution = solve(motion.unsolved, switches.hold)
    found = {name: solution.put(group) for name, group in groups.items()}
    if "switches" in found and switches.symbols.numel():
        values, _ = found["switches"]
        found["switches"] = [values, switches.rates_of(values, motion)]
    return found
