"""The equations at rest in numbers: constraints with the contacts and the friction that are to hold among them.

Rows stand in this order: constraints on positions, contacts of places that press, constraints on rates, contacts of rates that
press, friction that sticks.
"""

from collections.abc import Callable, Iterable, Sequence

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.base.records import dataclass
from lagrangia.dynamics.equilibrium import StaticEquations
from lagrangia.study.contacts_at_rest import Grip, GripEquations, Look
from lagrangia.study.linearization import TangentParts
from lagrangia.study.small_motion import SmallMotion

Vector = NDArray[np.float64]
Call = Callable[[ca.Function, Vector, Vector], list[Vector]]  # of a function at q and all multipliers
Slopes = Callable[[Sequence[str], Vector, Vector], dict[str, list[Vector]]]  # of `slopes` by directions

_WRONG = 0.1


@dataclass(frozen=True)
class Resting:
    """`m_h`: how many constraints are on positions; `reach` (n,): natural sizes; `is_angle`: what may go round."""

    e: SmallMotion
    call: Call
    slopes: Slopes
    m_h: int
    reach: Vector
    is_angle: NDArray[np.bool_]
    turned: tuple[tuple[int, ...], ...] = ()  # the places of the coordinates of each attitude

    def equations(self) -> GripEquations:
        """Those of contacts and friction, for grips."""
        return GripEquations(self.look, self.statics, self.e.multipliers, self.reach)

    def statics(self, pressing: tuple[int, ...] = (), sticking: tuple[int, ...] = ()) -> StaticEquations:
        """Those of positions of rest where these contacts press and these frictions stick."""
        e, own = self.e, self.m_h
        placed, one_way = ([k for k in pressing if (k in e.holds.one_way) == is_one_way] for is_one_way in (False, True))
        p = len(placed)

        def static(q: Vector) -> tuple[Vector, Vector, float]:
            free = self.multipliers(q)
            R, phi, _, V = self.call(e.static, q, free)
            gaps = self.call(e.touching, q, free)[0] if placed else np.zeros((0, 1))
            return R.ravel(), np.concatenate([phi.ravel(), gaps.ravel()[placed]]), float(V[0, 0])

        def stiffness(q: Vector, lam: Vector) -> tuple[Vector, Vector, Vector]:
            full = self.multipliers(q)
            if lam.size == full.size and not (pressing or sticking):
                full = lam
            elif lam.size:
                full[:own], full[own : e.m] = lam[:own], lam[own + p : e.m + p]
                full[[e.m + k for k in (*placed, *one_way)]] = np.delete(lam, range(own + p, e.m + p))[own : own + len(pressing)]
            by = self.slopes(("q", "v", *(["lambda"] if pressing else [])) if e.m or pressing or sticking else ("q",), q, full)
            places = np.vstack([by["q"][1], by["q"][3][placed]])
            return by["q"][0], places, self._rows(by, placed, one_way, sticking) if "v" in by else places

        is_rolling = e.m > own or bool(one_way) or bool(sticking)
        return StaticEquations(static, stiffness, self.reach, self.is_angle, is_rolling, self.turned, self.closes)

    def closes(self, q: Vector) -> bool:
        """Whether joints are put together the right way round where constraints hold: those that are not are half a turn off,
        for which what vanishes at the start is about 2."""
        if self.e.begins is None:
            return True
        return bool(np.abs(self.call(self.e.begins, q, self.e.multipliers())[0]).max(initial=0.0) < _WRONG)

    def multipliers(self, q: Vector) -> Vector:
        """Nothing presses; friction is half way, or where it slips at rest already, as on a belt, at its limit."""
        still = self.e.multipliers()
        if not self.e.holds.shares.numel():
            return still
        slips = self.call(self.e.touching, q, still)[2].ravel()
        return self.e.multipliers(shares=np.where(np.abs(slips) > 1e-12, slips > 0, 0.5))

    def look(self, q: Vector) -> Look:
        """All that acts at q, in natural sizes."""
        e, r, c = self.e, self.reach, self.e.holds.forces.numel()
        free = self.multipliers(q)
        R = self.call(e.static, q, free)[0].ravel()
        gaps, guards, slips = (x.ravel() for x in self.call(e.touching, q, free))
        by = self.slopes(("q", "v", "lambda"), q, free)
        pulls, spans = by["lambda"][0][:, e.m : e.m + c].T, by["lambda"][0][:, e.m + c :].T
        pressed = np.zeros((c, slips.size, R.size))
        for k in range(c if slips.size else 0):
            one = free.copy()
            one[e.m + k] = 1.0
            pressed[k] = self.slopes(("lambda",), q, one)["lambda"][0][:, e.m + c :].T - spans
        rows, slip_rows = by["v"][2] * r, by["v"][4] * r
        gap_rows = self._gap_rows(by, "q", "v") * r
        return Look(R * r, rows, pulls * r, gaps, guards > 0, gap_rows, slips, slip_rows, spans * r, pressed * r,
                    e.holds.cones, e.holds.one_way)

    def held(self, parts: TangentParts, by: dict[str, list[Vector]], grip: Grip) -> tuple[TangentParts, list[int]]:
        """The tangent with what holds among the constraints, and the places of its multipliers among all."""
        own, m, c = self.m_h, self.e.m, self.e.holds.forces.numel()
        press, stick = list(grip.pressing), list(grip.sticking)
        places = [*range(own), *(m + k for k in press), *(m + c + k for k in stick), *range(own, m)]
        gap_rows = self._gap_rows(by, "q", "v")
        J = np.vstack([parts.J, gap_rows[press], by["v"][4][stick]])
        pushed = np.vstack([parts.pushed, self._gap_rows(by, "s", "ds")[press], by["ds"][4][stick]])
        rates = np.vstack([J, parts.rates[own:]])
        return TangentParts(parts.M, parts.C, parts.K, J, rates, parts.E, pushed, by["lambda"][0][:, places].T,
                            gap_rows[list(grip.grazing)]), places

    def _gap_rows(self, by: dict[str, list[Vector]], places: str, rates: str) -> Vector:
        """Those of gaps by places, and by rates of contacts of rates."""
        rows = by[places][3].copy()
        rows[list(self.e.holds.one_way)] = by[rates][3][list(self.e.holds.one_way)]
        return rows

    def _rows(self, by: dict[str, list[Vector]], placed: list[int], one_way: list[int], sticking: tuple[int, ...]) -> Vector:
        """What multipliers do: forces of contacts need not be along their gaps."""
        rates, none = by["v"][2], by["q"][3][:0]
        pulls, pulls_back = (by["lambda"][0][:, [self.e.m + k for k in own]].T if own else none for own in (placed, one_way))
        return np.vstack([rates[: self.m_h], pulls, rates[self.m_h :], pulls_back, by["v"][4][list(sticking)]])


# ------------------------------------------------------------ in words


def forces_of_grip(e: SmallMotion, grip: Grip | None) -> tuple[dict[str, float], dict[str, tuple[float, float]]]:
    """Contacts that are closed with their forces, friction that sticks with the size of what it holds and its limit."""
    if grip is None:
        return {}, {}
    contacts = _together((e.holds.contacts[k], grip.forces[k]) for k in sorted((*grip.pressing, *grip.grazing)))
    told = [k for k in grip.sticking if not any(k == j and i in grip.sticking for i, j in grip.cones)]
    held = _together((e.holds.rubs[k], grip.size(k)) for k in told)
    limits = _together((e.holds.rubs[k], grip.limits[k]) for k in told)
    return contacts, {name: (x, limits[name]) for name, x in held.items()}


def _together(pairs: Iterable[tuple[str, float]]) -> dict[str, float]:
    """By names; a component that has several gives them numbers."""
    found: dict[str, float] = {}
    for name, x in pairs:
        label, count = name, 1
        while label in found:
            count += 1
            label = f"{name} ({count})"
        found[label] = float(x)
    return found


def told_grip(e: SmallMotion, grip: Grip | None) -> tuple[str, ...]:
    """What holds at a position of rest, and which way that leaves free."""
    if grip is None:
        return ()
    contacts, friction = forces_of_grip(e, grip)
    grazing = [e.holds.contacts[k] for k in grip.grazing]
    notes = [f"{name} presses with {force:.6g}: it is a constraint, and what moves does so along it; only so much that pulls "
             "lifts it off" for name, force in contacts.items() if name not in grazing]
    notes += [f"{name} just touches: nothing presses, and what moves is free to go away from it, but not into it"
              for name in grazing]
    verge = [e.holds.rubs[k] for k in grip.is_on_the_verge]
    for name, (held, limit) in friction.items():
        notes.append(f"{name} is at its limit of {limit:.6g}: it is a constraint, but slips where anything is added"
                     if name in verge else f"{name} sticks, it holds {held:.6g} of {limit:.6g}: it is a constraint")
    return tuple(notes)
