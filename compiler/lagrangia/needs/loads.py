"""Loads as states: each function of time that acts on a linear scene as a combination of w, with dw/dt = G w.

w holds the inputs and their slopes (inputs are linear in time between the rows of their table), then chains: for a wave and a
degree m the states t^j exp(E) (c cos A + s sin A) and, where the wave has an angle, t^j exp(E) (s cos A - c sin A), j = 0 ... m.
Waves are shared by all loads whose factors depend on parameters alone (c = 1, s = 0), and by those whose factors are 0 but under
the same conditions (c = 1 there). Other factors that change at time events go into the state. w jumps there; the matrices stay.
"""

from collections.abc import Callable

import casadi as ca

from lagrangia.algebra.scalars import apply
from lagrangia.base.records import dataclass
from lagrangia.needs.waves import DEPTH, Sum, Waves

_DEEPEST, _MOST_TERMS = 16, 8  # of conditions inside conditions; of what is 0 but under some

Guard = frozenset[int]  # conditions, by number, that hold all at once
_Key = tuple[int, Guard]  # a wave, and where it is felt
_Guarded = dict[Guard, ca.SX]  # a sum of what is 0 but under conditions


@dataclass(frozen=True)
class _Chain:
    wave: int
    degree: int
    c: ca.SX
    s: ca.SX
    first: int  # place in w
    width: int  # 2 with an angle, else 1

    def place(self, power: int) -> int:
        return self.first + power * self.width


class LoadStates:
    """`factors` (loads, n_w) of w in each load; `one` is the place in w of the constant 1, where it is wanted."""

    def __init__(self, t: ca.SX, modes: ca.SX, p: ca.SX, loads: ca.SX, n_inputs: int, needs_one: bool) -> None:
        self.t, self.modes, self.n_inputs = t, modes, n_inputs
        self.waves = Waves(t)
        self.chains: list[_Chain] = []
        self.conditions: list[ca.SX] = []
        self.n_w = 2 * n_inputs
        sums = self.waves.decompose(loads, [modes, p]) if loads.numel() else []
        shared = self._share(sums, needs_one)
        self.one = shared[0, Guard()].first if needs_one else -1
        places = [self._places(one, shared) for one in sums]
        self.factors = ca.SX(len(sums), self.n_w)
        for row, found in enumerate(places):
            for place, factor in found:
                self.factors[row, place] += factor

    def _share(self, sums: list[Sum], needs_one: bool) -> dict[_Key, _Chain]:
        degrees: dict[_Key, int] = {(0, Guard()): 0} if needs_one else {}
        for one in sums:
            for (wave, power), pair in one.items():
                for guard in self._split(*pair) or ():
                    degrees[wave, guard] = max(power, degrees.get((wave, guard), 0))
        return {(wave, guard): self._new(wave, power, self._holding(guard), ca.SX(0)) for (wave, guard), power in degrees.items()}

    def _split(self, c: ca.SX, s: ca.SX) -> dict[Guard, tuple[ca.SX, ca.SX]] | None:
        """The factors of a wave under the conditions under which they are not 0, of parameters alone."""
        cosine, sine = self._guarded(c), self._guarded(s)
        if cosine is None or sine is None:
            return None
        pairs = {guard: (cosine.get(guard, ca.SX(0)), sine.get(guard, ca.SX(0))) for guard in {**cosine, **sine}}
        return {guard: pair for guard, pair in pairs.items() if not all(x.is_zero() for x in pair)}

    def _guarded(self, x: ca.SX, depth: int = 0) -> _Guarded | None:
        """x as a sum of what it is under conditions that hold all at once; None where it is no such sum, or a long one."""
        if not (self.modes.numel() and ca.depends_on(x, self.modes)):
            return {Guard(): x}
        rule = _RULES.get(x.op())
        if rule is None or depth > _DEEPEST:
            return None
        if x.is_op(ca.OP_IF_ELSE_ZERO):
            parts: list[_Guarded | None] = [{Guard({self._condition(x.dep(0))}): ca.SX(1)}, self._guarded(x.dep(1), depth + 1)]
        else:
            parts = [self._guarded(x.dep(k), depth + 1) for k in range(x.n_dep())]
        known = [part for part in parts if part is not None]
        found = rule(*known) if len(known) == len(parts) else {}
        return found if 0 < len(found) <= _MOST_TERMS else None

    def _condition(self, x: ca.SX) -> int:
        for number, known in enumerate(self.conditions):
            if ca.is_equal(known, x, DEPTH):
                return number
        self.conditions.append(x)
        return len(self.conditions) - 1

    def _holding(self, guard: Guard) -> ca.SX:
        """1 where all conditions hold, else 0."""
        factor = ca.SX(1)
        for number in sorted(guard):
            factor = apply(ca.OP_IF_ELSE_ZERO, self.conditions[number], factor)
        return factor

    def _places(self, one: Sum, shared: dict[_Key, _Chain]) -> list[tuple[int, ca.SX]]:
        found = []
        for (wave, power), pair in one.items():
            split = self._split(*pair)
            if split is None:
                found.append((self._own(wave, power, *pair).place(power), ca.SX(1)))
            for guard, (c, s) in (split or {}).items():
                chain = shared[wave, guard]
                found.append((chain.place(power), c))
                if chain.width == 2:
                    found.append((chain.place(power) + 1, -s))
        return found

    def _own(self, wave: int, degree: int, c: ca.SX, s: ca.SX) -> _Chain:
        for chain in self.chains:
            if (chain.wave, chain.degree) == (wave, degree) and ca.is_equal(chain.c, c, DEPTH) and ca.is_equal(chain.s, s, DEPTH):
                return chain
        return self._new(wave, degree, c, s)

    def _new(self, wave: int, degree: int, c: ca.SX, s: ca.SX) -> _Chain:
        width = 1 if self.waves.found[wave].angle is None else 2
        chain = _Chain(wave, degree, c, s, self.n_w, width)
        self.chains.append(chain)
        self.n_w += (degree + 1) * width
        return chain

    def values(self) -> ca.SX:
        """w at the time t, zero where the inputs stand."""
        w = ca.SX.zeros(self.n_w)
        for chain in self.chains:
            wave = self.waves.found[chain.wave]
            growth = ca.SX(1) if wave.exponent is None else ca.exp(wave.exponent)
            for j in range(chain.degree + 1):
                place, factor = chain.place(j), growth * self.t**j
                if wave.angle is None:
                    w[place] = factor * chain.c
                else:
                    sine, cosine = ca.sin(wave.angle), ca.cos(wave.angle)
                    w[place] = factor * (chain.c * cosine + chain.s * sine)
                    w[place + 1] = factor * (chain.s * cosine - chain.c * sine)
        return w

    def generator(self) -> ca.SX:
        """G, (n_w, n_w)."""
        G = ca.SX(self.n_w, self.n_w)
        for k in range(self.n_inputs):
            G[k, self.n_inputs + k] = 1
        for chain in self.chains:
            wave = self.waves.found[chain.wave]
            rate, speed = self.waves.slope(wave.exponent), self.waves.slope(wave.angle)
            for k in range(chain.width * (chain.degree + 1)):
                row = chain.first + k
                if wave.exponent is not None:
                    G[row, row] = rate
                if k >= chain.width:
                    G[row, row - chain.width] = k // chain.width
                if chain.width == 2:
                    G[row, row + 1 - 2 * (k % 2)] = -speed if k % 2 else speed
        return G


# -------------------------------------------------------------------- sums of what is 0 but under conditions


def _sum(a: _Guarded, b: _Guarded) -> _Guarded:
    return a | {guard: a[guard] + factor if guard in a else factor for guard, factor in b.items()}


def _negative(a: _Guarded) -> _Guarded:
    return {guard: -factor for guard, factor in a.items()}


def _product(a: _Guarded, b: _Guarded) -> _Guarded:
    found: _Guarded = {}
    for one, x in a.items():
        for other, y in b.items():
            found = _sum(found, {one | other: x * y})
    return found


_RULES: dict[int, Callable[..., _Guarded]] = {
    ca.OP_ADD: _sum, ca.OP_SUB: lambda a, b: _sum(a, _negative(b)), ca.OP_NEG: _negative,
    ca.OP_MUL: _product, ca.OP_IF_ELSE_ZERO: _product,
}
