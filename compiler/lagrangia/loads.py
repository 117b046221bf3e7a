"""Loads as states: each function of time that acts on a linear scene as a combination of w, with dw/dt = G w.

w holds the inputs and their slopes (inputs are linear in time between the rows of their table), then chains: for a wave and a
degree m the states t^j exp(E) (c cos A + s sin A) and, where the wave has an angle, t^j exp(E) (s cos A - c sin A), j = 0 ... m.
Waves whose factors depend on parameters alone are shared by all loads (c = 1, s = 0). Factors that change at time events go into
the state: w jumps there, and the matrices stay.
"""

from dataclasses import dataclass

import casadi as ca

from lagrangia.waves import DEPTH, Sum, Waves


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
        self.n_w = 2 * n_inputs
        sums = self.waves.decompose(loads, [modes, p]) if loads.numel() else []
        shared = self._share(sums, needs_one)
        self.one = shared[0].first if needs_one else -1
        places = [self._places(one, shared) for one in sums]
        self.factors = ca.SX(len(sums), self.n_w)
        for row, found in enumerate(places):
            for place, factor in found:
                self.factors[row, place] += factor

    def _share(self, sums: list[Sum], needs_one: bool) -> dict[int, _Chain]:
        degrees = {0: 0} if needs_one else {}
        for wave, power in (key for one in sums for key in one if not self._is_own(one, key)):
            degrees[wave] = max(power, degrees.get(wave, 0))
        return {wave: self._new(wave, power, ca.SX(1), ca.SX(0)) for wave, power in degrees.items()}

    def _is_own(self, one: Sum, key: tuple[int, int]) -> bool:
        return bool(self.modes.numel()) and ca.depends_on(ca.vertcat(*one[key]), self.modes)

    def _places(self, one: Sum, shared: dict[int, _Chain]) -> list[tuple[int, ca.SX]]:
        found = []
        for (wave, power), (c, s) in one.items():
            if self._is_own(one, (wave, power)):
                found.append((self._own(wave, power, c, s).place(power), ca.SX(1)))
                continue
            chain = shared[wave]
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
