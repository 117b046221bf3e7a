"""Rigid and articulated bodies of space: inertias, wrenches and twists in six numbers, vx, vy, vz, wx, wy, wz, in a body's axes.

About the frame's origin, with the mass m, the first moment b and the second moment J: p = m v + w x b, L = J w + b x v. Of
symmetric matrices the upper triangle is kept. What is the number 0 costs nothing; turns about a coordinate axis take 9
operations where three entries of a symmetric block mix, by u = s (a - b) + 2 c h: a' = a - s u, b' = b + s u, h' = c u - h.
"""

from collections.abc import Callable, Sequence

from lagrangia.algebra.duals import Scalar, added, dot, is_zero, minus, plus, times
from lagrangia.base.records import dataclass

Vector = list[Scalar]  # (3,), or (6,) of a twist or a wrench
Matrix = Sequence[Sequence[Scalar]]  # 3 by 3
Inertia = list[Vector]  # 6 by 6; I[i][j] with i <= j
SIZE = 6
_CYCLE = ((0, 1, 2), (1, 2, 0), (2, 0, 1))
SAME: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


# -------------------------------------------------------------------- vectors of three


def cross(a: Sequence[Scalar], b: Sequence[Scalar]) -> Vector:
    """a x b."""
    return [minus(times(a[i], b[j]), times(a[j], b[i])) for _, i, j in _CYCLE]


def carried(w: Sequence[Scalar], turning: Sequence[Scalar], ahead: Sequence[Scalar], is_shared: bool = False) -> Vector:
    """How a point at d from an origin that rests is accelerated: a x d + w x (w x d) with a = dw/dt; where d is along an axis by
    sums of products of w, and where it is along two if others need those, too."""
    along = [k for k, x in enumerate(ahead) if not is_zero(x)]
    if len(along) > 1 + is_shared:
        return added(cross(turning, ahead), cross(w, cross(w, ahead)))
    found: Vector = [0.0] * 3
    for k, i, j in (_CYCLE[k] for k in along):
        found[i] = plus(found[i], times(ahead[k], plus(_of_two(w, k, i), turning[j])))
        found[j] = plus(found[j], times(ahead[k], minus(_of_two(w, k, j), turning[i])))
    for k, i, j in (_CYCLE[k] for k in along):
        found[k] = minus(found[k], times(ahead[k], plus(times(w[i], w[i]), times(w[j], w[j]))))
    return found


def _of_two(w: Sequence[Scalar], i: int, j: int) -> Scalar:
    """Their product, the same whichever comes first."""
    return times(w[min(i, j)], w[max(i, j)])


def scaled(factor: Scalar, a: Sequence[Scalar]) -> Vector:
    """A multiple, of any length."""
    return [times(factor, x) for x in a]


def product(R: Matrix, vector: Sequence[Scalar]) -> Vector:
    """R v."""
    return [dot(row, vector) for row in R]


def transposed(R: Matrix) -> list[Vector]:
    """R^T."""
    return [[row[j] for row in R] for j in range(3)]


def composed(a: Matrix, b: Matrix) -> list[Vector]:
    """a b."""
    return transposed([product(a, column) for column in transposed(b)])


def is_nothing(vector: Sequence[Scalar]) -> bool:
    """Whether all of its components are the number 0."""
    return all(map(is_zero, vector))


# -------------------------------------------------------------------- rigid bodies


@dataclass(frozen=True)
class RigidInertia:
    """About the origin of a frame, along its axes: kg, kg.m, kg.m2."""

    mass: Scalar
    moment: Sequence[Scalar]  # mass times centre of mass, (3,)
    second_moment: Matrix  # symmetric, all of it is kept
    is_flat: bool = False  # whether its mass lies where z = 0, so that J[2][2] = J[0][0] + J[1][1]

    def placed(self, R: Matrix, origin: Sequence[Scalar]) -> "RigidInertia":
        """The same body in a frame in which this one's axes are the columns of R, and its origin is there (parallel axes)."""
        moment = product(R, self.moment)
        J = composed(composed(R, self.second_moment), transposed(R))
        whole = plus(times(2.0, dot(origin, moment)), times(self.mass, dot(origin, origin)))
        ahead = [plus(x, times(self.mass, o)) for x, o in zip(moment, origin, strict=True)]  # J - o b^T - (b + m o) o^T + whole
        J = [[minus(plus(J[i][j], whole if i == j else 0.0), plus(times(origin[i], moment[j]), times(ahead[i], origin[j])))
              for j in range(3)] for i in range(3)]
        return RigidInertia(self.mass, ahead, J)

    def with_other(self, other: "RigidInertia") -> "RigidInertia":
        """Of two bodies that are one."""
        J = [added(a, b) for a, b in zip(self.second_moment, other.second_moment, strict=True)]
        return RigidInertia(plus(self.mass, other.mass), added(self.moment, other.moment), J)

    def scaled(self, factor: float) -> "RigidInertia":
        """Of as many times the mass."""
        J = [scaled(factor, row) for row in self.second_moment]
        return RigidInertia(times(factor, self.mass), scaled(factor, self.moment), J, self.is_flat)

    def turned(self, turn: "Turn") -> "RigidInertia":
        """The same body in a frame that is followed by the turn."""
        I = turn.inertia_to_parent([[0.0] * SIZE] * 3 + [[0.0] * 3 + [*row] for row in self.second_moment])
        J = [[I[3 + min(i, j)][3 + max(i, j)] for j in range(3)] for i in range(3)]
        return RigidInertia(self.mass, turn.to_parent(self.moment), J, self.is_flat and turn.axis == 2)

    @property
    def is_nothing(self) -> bool:
        """Whether it is that of no body."""
        return is_zero(self.mass) and is_nothing(self.moment) and all(map(is_nothing, self.second_moment))

    def matrix(self) -> Inertia:
        """In the numbers of a twist."""
        I = no_inertia()
        x, y, z = self.moment
        B = [[0.0, z, minus(0.0, y)], [minus(0.0, z), 0.0, x], [y, minus(0.0, x), 0.0]]
        for i in range(3):
            I[i][i] = self.mass
            I[i][3:] = B[i]
            I[3 + i][3 + i :] = self.second_moment[i][i:]
        return I

    @property
    def is_diagonal(self) -> bool:
        """Whether its frame's axes are principal ones of its second moment."""
        J = self.second_moment
        return is_zero(J[0][1]) and is_zero(J[0][2]) and is_zero(J[1][2])

    def load(self, w: Sequence[Scalar], granted: Sequence[Scalar], is_shared: bool = False) -> Vector:
        """The wrench (6,) that the body asks for when it turns with w and its frame has the acceleration (6,). `is_shared`:
        whether others need products of w."""
        return [*self.force(w, granted, is_shared), *self.torque(w, granted)]

    def force(self, w: Sequence[Scalar], granted: Sequence[Scalar], is_shared: bool = False) -> Vector:
        """Of its load, (3,)."""
        return added(scaled(self.mass, granted[:3]), carried(w, granted[3:], self.moment, is_shared))

    def torque(self, w: Sequence[Scalar], granted: Sequence[Scalar]) -> Vector:
        """Of its load, (3,)."""
        return added(cross(self.moment, granted[:3]), self._torque(w, granted[3:]))

    def _torque(self, w: Sequence[Scalar], turning: Sequence[Scalar]) -> Vector:
        """J a + w x J w; of a flat body by the sums that carried() has."""
        J = self.second_moment
        if not self.is_diagonal:
            if is_nothing(turning):  # w x J w is that of J less a multiple of the identity
                less = [[minus(x, J[1][1]) if i == j else x for j, x in enumerate(row)] for i, row in enumerate(J)]
                less[1][1] = 0.0
                return cross(w, [dot(row, w) for row in less])
            if self.is_flat:
                return self._flat_torque(w, turning)
            return added([dot(row, turning) for row in J], cross(w, [dot(row, w) for row in J]))
        found = []
        for k, i, j in _CYCLE:
            if self.is_flat and k == 0:
                found.append(times(J[0][0], plus(_of_two(w, 1, 2), turning[0])))
            elif self.is_flat and k == 1:
                found.append(minus(0.0, times(J[1][1], minus(_of_two(w, 0, 2), turning[1]))))
            else:
                found.append(plus(times(J[k][k], turning[k]), times(minus(J[j][j], J[i][i]), _of_two(w, i, j))))
        return found

    def _flat_torque(self, w: Sequence[Scalar], turning: Sequence[Scalar]) -> Vector:
        """The same by those sums, W: points of mass m at d, accelerated by W d, have the moment (W S)_ji - (W S)_ij about k,
        where S is the sum of m d d^T: J[1][1], J[0][0] and 0, and beside these -J."""
        J, W = self.second_moment, [[0.0] * 3 for _ in range(3)]  # but for its diagonal, whose differences are those of squares
        for k, i, j in _CYCLE:
            W[j][i], W[i][j] = plus(_of_two(w, i, j), turning[k]), minus(_of_two(w, i, j), turning[k])
        own = [times(W[2][1], J[0][0]), minus(0.0, times(W[2][0], J[1][1])),
               minus(times(W[1][0], J[1][1]), times(W[0][1], J[0][0]))]
        if is_zero(turning[2]):
            own[2] = times(W[0][1], minus(J[1][1], J[0][0]))
        found = []
        for k, i, j in _CYCLE:
            mixed = times(minus(times(w[i], w[i]), times(w[j], w[j])), J[i][j])
            found.append(plus(plus(mixed, own[k]), minus(times(W[i][k], J[k][j]), times(W[j][k], J[k][i]))))
        return found


# -------------------------------------------------------------------- matrices of a twist


def no_inertia() -> Inertia:
    """A matrix of zeros."""
    return [[0.0] * SIZE for _ in range(SIZE)]


def together(a: Inertia, b: Inertia) -> Inertia:
    """a + b."""
    return [[0.0] * i + added(a[i][i:], b[i][i:]) for i in range(SIZE)]


def momentum(I: Inertia, twist: Sequence[Scalar]) -> Vector:
    """I s."""
    return [dot([I[min(i, j)][max(i, j)] for j in range(SIZE)], twist) for i in range(SIZE)]


@dataclass(frozen=True)
class Turn:
    """On the way to a child: about a coordinate axis, by an angle."""

    axis: int
    c: Scalar  # the cosine of the angle
    s: Scalar  # its sine

    def to_parent(self, vector: Sequence[Scalar]) -> Vector:
        """Components along the parent's axes, (3,) or (6,)."""
        return self._by_pairs(vector, self._pair)

    def to_child(self, vector: Sequence[Scalar]) -> Vector:
        """Components along the child's axes, (3,) or (6,)."""
        return self._by_pairs(vector, self._pair_back)

    def _by_pairs(self, vector: Sequence[Scalar], pair: Callable[[Scalar, Scalar], tuple[Scalar, Scalar]]) -> Vector:
        found, (_, i, j) = [*vector], _CYCLE[self.axis]
        for at in range(0, len(vector), 3):
            found[at + i], found[at + j] = pair(vector[at + i], vector[at + j])
        return found

    def inertia_to_parent(self, I: Inertia) -> Inertia:
        """R I R^T, block by block."""
        found, (k, i, j) = [row[:] for row in I], _CYCLE[self.axis]
        for at in (0, 3):
            self._mix_symmetric(I, found, at + i, at + j, at + k)
        rows = [[I[r][3 + c] for c in range(3)] for r in range(3)]
        a, f, g, b = self._mixed(rows[i][i], rows[i][j], rows[j][i], rows[j][j])
        found[i][3 + i], found[i][3 + j], found[j][3 + i], found[j][3 + j] = a, f, g, b
        found[i][3 + k], found[j][3 + k] = self._pair(rows[i][k], rows[j][k])
        found[k][3 + i], found[k][3 + j] = self._pair(rows[k][i], rows[k][j])
        return found

    def _mix_symmetric(self, I: Inertia, found: Inertia, i: int, j: int, k: int) -> None:
        def put(a: int, b: int, value: Scalar) -> None:
            found[min(a, b)][max(a, b)] = value

        def get(a: int, b: int) -> Scalar:
            return I[min(a, b)][max(a, b)]

        a, h, _, b = self._mixed(get(i, i), get(i, j), get(i, j), get(j, j))
        put(i, i, a)
        put(i, j, h)
        put(j, j, b)
        x, y = self._pair(get(i, k), get(j, k))
        put(i, k, x)
        put(j, k, y)

    def _pair(self, x: Scalar, y: Scalar) -> tuple[Scalar, Scalar]:
        return minus(times(self.c, x), times(self.s, y)), plus(times(self.s, x), times(self.c, y))

    def _pair_back(self, x: Scalar, y: Scalar) -> tuple[Scalar, Scalar]:
        return plus(times(self.c, x), times(self.s, y)), minus(times(self.c, y), times(self.s, x))

    def _mixed(self, a: Scalar, f: Scalar, g: Scalar, b: Scalar) -> tuple[Scalar, Scalar, Scalar, Scalar]:
        """R [[a, f], [g, b]] R^T."""
        c, s = self.c, self.s
        if is_zero(s):
            return a, f, g, b
        if is_zero(c):
            return b, minus(0.0, g), minus(0.0, f), a
        if isinstance(c, float) and isinstance(s, float):
            return self._mixed_by_numbers(a, f, g, b)
        across = times(times(2.0, c), f) if f is g else times(c, plus(f, g))
        u = plus(times(s, 0.0 if a is b else minus(a, b)), across)
        more = times(s, u)
        near = times(c, u)
        return minus(a, more), minus(near, g), minus(near, f), plus(b, more)

    def _mixed_by_numbers(self, a: Scalar, f: Scalar, g: Scalar, b: Scalar) -> tuple[Scalar, Scalar, Scalar, Scalar]:
        """The same where the angle is told in numbers: u is divided by the larger one of its two."""
        c, s = self.c, self.s
        less, across = 0.0 if a is b else minus(a, b), times(2.0, f) if f is g else plus(f, g)
        if abs(s) >= abs(c):
            u, size = plus(less, times(2.0 * c / s, f) if f is g else times(c / s, across)), s
        else:
            u, size = plus(times(0.5 * s / c, less), f) if f is g else plus(times(s / c, less), across), 2.0 * c if f is g else c
        more, near = times(s * size, u), times(c * size, u)
        return minus(a, more), minus(near, g), minus(near, f), plus(b, more)


@dataclass(frozen=True)
class Rotation:
    """On the way to a child, whose axes are the columns of R along the parent's."""

    R: Matrix

    def to_parent(self, vector: Sequence[Scalar]) -> Vector:
        """Components along the parent's axes, (3,) or (6,)."""
        return [x for at in range(0, len(vector), 3) for x in product(self.R, vector[at : at + 3])]

    def to_child(self, vector: Sequence[Scalar]) -> Vector:
        """Components along the child's axes, (3,) or (6,)."""
        back = transposed(self.R)
        return [x for at in range(0, len(vector), 3) for x in product(back, vector[at : at + 3])]

    def inertia_to_parent(self, I: Inertia) -> Inertia:
        """R I R^T, block by block."""
        found = no_inertia()
        for at in (0, 3):
            block = [[I[at + min(i, j)][at + max(i, j)] for j in range(3)] for i in range(3)]
            half = composed(self.R, block)
            for i in range(3):
                for j in range(i, 3):
                    found[at + i][at + j] = dot(half[i], self.R[j])
        B = composed(self.R, [I[i][3:] for i in range(3)])
        for i in range(3):
            found[i][3:] = product(self.R, B[i])
        return found


@dataclass(frozen=True)
class Shift:
    """On the way to a child, whose origin is further by a vector. `rate`, `second`: of it, where it moves, but for what second
    derivatives of coordinates add. `is_behind`: whether it is along the axis of the hinge, which then is before it."""

    ahead: Sequence[Scalar]
    rate: Sequence[Scalar] = (0.0,) * 3
    second: Sequence[Scalar] = (0.0,) * 3
    is_behind: bool = False

    def wrench_to_parent(self, wrench: Sequence[Scalar]) -> Vector:
        """With its moment about the parent's origin."""
        return [*wrench[:3], *added(wrench[3:], cross(self.ahead, wrench[:3]))]

    def twist_to_child(self, twist: Sequence[Scalar]) -> Vector:
        """That of the child's origin."""
        return [*added(twist[:3], cross(twist[3:], self.ahead)), *twist[3:]]

    def acceleration_to_child(self, w: Sequence[Scalar], acceleration: Sequence[Scalar],
                              is_shared: bool = False) -> Vector:
        """Of the child's origin, (3,), where the parent turns with w and has the acceleration (6,): a + dw/dt x d + w x (w x d)
        + 2 w x d' + d''."""
        found = added(acceleration[:3], carried(w, acceleration[3:], self.ahead, is_shared))
        if not is_nothing(self.rate):
            found = added(found, scaled(2.0, cross(w, self.rate)))
        return added(found, self.second)

    def inertia_to_parent(self, I: Inertia) -> Inertia:
        """X^T I X, where X is v + w x d: with D = -[d] B + M D, J + D^T B + (B + M D)^T D."""
        found = [row[:] for row in I]
        B = [row[3:] for row in I[:3]]
        for i in range(3):
            for j in range(3):
                terms = [(sign, m, I[min(i, k)][max(i, k)]) for k, m, sign in _COLUMN[j]]
                found[i][3 + j] = plus(B[i][j], self._sum(terms))
        moved = [row[3:] for row in found[:3]]
        for i in range(3):
            for j in range(i, 3):
                near, far = (i, j) if sum(is_zero(row[i]) for row in B) <= sum(is_zero(row[j]) for row in B) else (j, i)
                terms = [(sign, m, B[k][far]) for k, m, sign in _COLUMN[near]]
                terms += [(sign, m, moved[k][near]) for k, m, sign in _COLUMN[far]]
                found[3 + i][3 + j] = plus(I[3 + i][3 + j], self._sum(terms))
        return found

    def _sum(self, terms: list[tuple[int, int, Scalar]]) -> Scalar:
        """Of sign times d[m] times a number: what has one d[m] is added first."""
        total: Scalar = 0.0
        for m, x in enumerate(self.ahead):
            if is_zero(x):
                continue
            part: Scalar = 0.0
            for sign, _, value in sorted((t for t in terms if t[1] == m), key=lambda t: -t[0]):
                part = plus(part, value) if sign > 0 else minus(part, value)
            total = plus(total, times(x, part))
        return total


# Of the columns of D = -[d], the entries that are not 0: (row, component of d, sign). Column j is e_j x d.
_COLUMN = (((1, 2, -1), (2, 1, 1)), ((0, 2, 1), (2, 0, -1)), ((0, 1, -1), (1, 0, 1)))
Move = Turn | Rotation | Shift
