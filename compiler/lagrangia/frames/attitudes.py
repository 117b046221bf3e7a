"""Attitudes that are coordinates: runtime/state/attitudes.c says what their three positions s and their reference are.

Q = Q_ref (1 - |s|^2/16, s/2) / (1 + |s|^2/16); rates are the angular velocity w of the turned frame against the other one, in its
own axes: dQ/dt = Q (0, w)/2. They are no derivatives of s but where s is 0: what can be derived by w is not derived by s.
"""

from collections.abc import Sequence
from typing import Any, Protocol

import casadi as ca

from lagrangia.algebra.duals import Dual, Scalar, dot, minus, plus, rate_of, times, value_of
from lagrangia.base.diagnostics import fail
from lagrangia.frames.evaluation import Value
from lagrangia.frames.quaternions import NOT_TURNED, Quaternion, quaternion_product
from lagrangia.frames.spatial import Matrix, Vector
from lagrangia.language.attitudes import parts_of
from lagrangia.language.frame_steps import Step
from lagrangia.language.tree import Ref


def present(reference: Sequence[Scalar], s: Sequence[Scalar]) -> Quaternion:
    """The unit quaternion, in plain scalars."""
    square = dot(s, s) / 16
    half = 0.5 / (1 + square)
    return quaternion_product(reference, (2 * (1 - square) * half, *(times(x, half) for x in s)))


def with_rates(quaternion: Quaternion, s: Sequence[Scalar], level: int) -> Quaternion:
    """A plain unit quaternion at a level; `s`: its coordinates at the level, which have angular velocities for rates."""
    if level == 0:
        return quaternion
    lower = with_rates(quaternion, tuple(map(value_of, s)), level - 1)
    half = (0.0, *(times(0.5, rate_of(x)) for x in s))
    return tuple(Dual(x, rate) for x, rate in zip(lower, quaternion_product(lower, half), strict=True))


def matrix_of(quaternion: Quaternion) -> Matrix:
    """What takes vectors in the turned axes to the others."""
    w, x, y, z = quaternion
    xx, yy, zz, xy, yz, zx = (times(a, b) for a, b in ((x, x), (y, y), (z, z), (x, y), (y, z), (z, x)))
    wx, wy, wz = (times(w, a) for a in (x, y, z))

    def twice(a: Scalar) -> Scalar:
        return times(2.0, a)

    return ((minus(1.0, twice(plus(yy, zz))), twice(minus(xy, wz)), twice(plus(zx, wy))),
            (twice(plus(xy, wz)), minus(1.0, twice(plus(zz, xx))), twice(minus(yz, wx))),
            (twice(minus(zx, wy)), twice(plus(yz, wx)), minus(1.0, twice(plus(xx, yy)))))


def turned_by(s: Sequence[Scalar], correction: Sequence[Scalar]) -> Vector:
    """N(s) x: what small turns about the turned axes change of s."""
    along = dot(s, correction) / 8
    kept = 1 - dot(s, s) / 16
    found = []
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        across = minus(times(s[i], correction[j]), times(s[j], correction[i])) / 2
        found.append(plus(plus(times(kept, correction[k]), across), times(along, s[k])))
    return tuple(found)


class Attitudes(Protocol):
    """What kinematics.py knows of attitudes that are coordinates."""

    symbols: Any
    graph: Any
    quaternions: dict[str, Quaternion]
    axes: dict[str, Matrix]

    def coordinate(self, name: str, level: int) -> Scalar:
        """A coordinate at a level."""

    def rates_of_attitude(self, name: str, level: int) -> Value:
        """For der(S), which is all that can be asked of it. Raises LagError L0302 for the attitude itself."""
        if level == 0:
            fail("L0302", f"'{name}' is an attitude, and no number", self.graph.model.variables[name].span,
                 "turn(a, S) turns a frame by it, and der(S) is its angular velocity; what it turns has f.R (a matrix) and f.Q")
        return tuple(self.coordinate(part, level) for part in parts_of(name))

    def attitude_of(self, step: Step) -> str | None:
        """The coordinate that a turn is by, if it is an attitude."""
        amount = step.amount
        return amount.name if isinstance(amount, Ref) and amount.name in self.symbols.attitudes else None

    def paced(self, rates: Sequence[Scalar]) -> ca.SX:
        """What rates, or small motions, (n,), are of positions, (n,): the same, but of attitudes."""
        found = dict(zip(self.symbols.positions, rates, strict=True))
        for name in self.symbols.attitudes:
            parts = parts_of(name)
            turned = turned_by([self.symbols.positions[part] for part in parts], [found[part] for part in parts])
            found |= zip(parts, turned, strict=True)
        return ca.vertcat(ca.SX(0, 1), *found.values())

    @property
    def turning(self) -> ca.SX | None:
        """dq/dt, (n,), where attitudes are among the coordinates; else it is v."""
        return self.paced([*self.symbols.rates.values()]) if self.symbols.attitudes else None

    @property
    def turned(self) -> tuple[str, ...]:
        """The coordinates of attitudes."""
        return tuple(part for name in self.symbols.attitudes for part in parts_of(name))

    def by_turns(self, value: ca.SX) -> ca.SX:
        """The gradient of a number by positions, (n, 1): by small turns about the turned axes where these are attitudes."""
        q = ca.vertcat(ca.SX(0, 1), *self.symbols.positions.values())
        if not self.symbols.attitudes:
            return ca.gradient(value, q)
        small = ca.SX.sym("small", q.numel())
        return ca.densify(ca.gradient(ca.jtimes(value, q, self.paced(ca.vertsplit(small))), small))

    def carried(self, momentum: ca.SX) -> ca.SX:
        """What momenta (n, 1) of attitudes change by because they are told in axes that turn: w x p; 0 for all others."""
        found = ca.SX(momentum.numel(), 1)
        places = {name: k for k, name in enumerate(self.symbols.positions)}
        for name in self.symbols.attitudes:
            at = [places[part] for part in parts_of(name)]
            found[at] = ca.cross(ca.vertcat(*[self.symbols.rates[part] for part in parts_of(name)]), momentum[at])
        return found

    def by_places(self, forces: ca.SX) -> ca.SX:
        """Forces (n, 1) on small turns about the turned axes as forces on positions: N^-T x = N x/(1 + |s|^2/16)^2."""
        found = ca.SX(forces)
        places = {name: k for k, name in enumerate(self.symbols.positions)}
        for name in self.symbols.attitudes:
            s = [self.symbols.positions[part] for part in parts_of(name)]
            at = [places[part] for part in parts_of(name)]
            found[at] = ca.vertcat(*turned_by(s, ca.vertsplit(found[at]))) / (1 + dot(s, s) / 16) ** 2
        return found

    def attitude_named(self, name: str) -> Value | None:
        """The unit quaternion of a coordinate that is an attitude, or one of its parts; None for other names."""
        attitudes = self.symbols.attitudes
        attitude, _, index = (name, "", "") if name in attitudes else name.removesuffix("]").rpartition("[")
        if attitude not in attitudes:
            return None
        parts = self.quaternion(attitude, 0)
        return parts[int(index) - 1] if index else parts

    def turn_by(self, step: Step, level: int) -> Quaternion | None:
        """The quaternion of a turn by an attitude; None of other steps."""
        attitude = self.attitude_of(step)
        return None if attitude is None else self.quaternion(attitude, level)

    def unturned(self, expressions: list[ca.SX]) -> list[ca.SX]:
        """With references of attitudes that turn nothing, for looks at numbers: any four numbers are no attitude."""
        references = [x for reference in self.symbols.attitudes.values() for x in reference]
        nothing = [ca.SX(x) for x in NOT_TURNED] * len(self.symbols.attitudes)
        return ca.substitute(expressions, references, nothing) if references else expressions

    def quaternion(self, attitude: str, level: int) -> Quaternion:
        """Of a coordinate that is one, (4,)."""
        parts = parts_of(attitude)
        if attitude not in self.quaternions:
            here = [self.symbols.positions[part] for part in parts]
            self.quaternions[attitude] = present(self.symbols.attitudes[attitude], here)
        return with_rates(self.quaternions[attitude], [self.coordinate(part, level) for part in parts], level)

    def axes_of(self, attitude: str) -> Matrix:
        """What takes vectors in the turned axes to the others."""
        if attitude not in self.axes:
            self.axes[attitude] = matrix_of(self.quaternion(attitude, 0))
        return self.axes[attitude]
