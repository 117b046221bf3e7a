"""Closed loops -> the coordinates to solve for, and in what order the others follow from them.

With as many coordinates given as the loops leave free, the rates of the others are found group by group: a row that brings one
new coordinate, or two rows that bring two, which are what mechanism theory calls an Assur group of class II (a dyad). In space,
where this leads nowhere, points that are held together are looked at along axes of a body (held_points.py). Which
coordinates to solve for is decided at positions along the motion that the loops allow from the start: a crank that turns all
round holds its dyads well everywhere, where with the rocker given they would pass dead points. Source: Wehage and Haug,
Generalized coordinate partitioning, J. Mech. Des. 104 (1982).
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import field, replace
from itertools import islice, takewhile

import casadi as ca
import numpy as np

from lagrangia.base.records import dataclass
from lagrangia.constraints.assembly import assembled
from lagrangia.constraints.held_points import HeldPoints, find_held_points
from lagrangia.constraints.initial import InitialConditions
from lagrangia.constraints.positions import Positions, Vector
from lagrangia.constraints.rows import Constraints
from lagrangia.frames.kinematics import Kinematics

_CLOSED = 1e-9  # of a position on the constraints, relative to the largest slope; and of slopes that are none
_LEGS, _MOST_LEGS = 3, 1000  # ways in random directions; times the square of the number of coordinates
_LEG, _LENGTH = 12, 0.25  # positions on a way, how far apart beside the largest slope
_SHORTEST = 0.1  # lever of a coordinate, beside the longest
_POOR, _GOOD = 0.03, 0.3  # sines of transmission angles
_MOSTLY = 0.9  # the share of positions where no angle is to be poor
_MOST_TRIED, _MOST_ENTRIES = 64, 500  # coordinates that are tried; free ones times all
_FEW = 3  # independent coordinates for which axes of bodies pay: what is left is summed up over bodies for each of them
_NOTHING = 1e-300
# Of a normal distribution, for all legs there can be (by NumPy's generator with seed 1, which takes 5 ms to import).
_WISHES = (
    0.345584192064786, 0.8216181435011584, 0.33043707618338714, -1.303157231604361, 0.9053558666731177, 0.4463745723640113,
    -0.5369532353602852, 0.5811181041963531, 0.36457239618607573, 0.294132496655526, 0.02842224131579679, 0.5467129866124469,
    -0.7364540870016669, -0.16290994799305278, -0.48211931267997826, 0.5988462126346276, 0.03972210748165899, -0.2924567509650886,
    -0.7819084623568421, -0.2571922406188707, 0.008142180518343508, -0.2756029052993704, 1.2940638143982073, 1.0067243153057943,
    -2.7111624789659685, -1.8890132459676727, -0.17477209205516195, -0.42219041157635356, 0.2136429974986111, 0.21732193102256359,
    2.1178387550510482, -1.1120207626922813, -0.37760500712699807, 2.0427716074923303, 0.6467029962018469, 0.6630633723762617,
    -0.5140063716874629, -1.6480751708556527, 0.16746474422274113, 0.10901408782154753, -1.2273520542445742, -0.6832266617805622,
    -0.07204367972722743, -0.9447516230607774, -0.09826996785221727, 0.09548302746945433, 0.03558623705548571,
    -0.5062916583143148, 0.5937480717858228, 0.8911669542823284, 0.3208483045665637, -0.818230227390307, 0.7316522837854408,
    -0.5014400184670523,
)


@dataclass(frozen=True)
class Group:
    """One or two rows, and as many coordinates that follow from them."""

    rows: tuple[int, ...]
    coordinates: tuple[int, ...]


@dataclass(frozen=True)
class Partition:
    """Independent coordinates, and the groups of the others, each of which depends on what stands before it."""

    independent: tuple[int, ...]
    groups: tuple[Group, ...]
    reach: tuple[float, ...]  # of all coordinates: what a unit of them moves, about
    points: tuple[HeldPoints, ...] = ()  # whose rows the groups have along axes of their own

    def part(self, among: Sequence[int], rows: Sequence[int]) -> "Partition":
        """That of some coordinates and of their rows, which are then numbered by their places among these."""
        place, line = ({k: i for i, k in enumerate(numbers)} for numbers in (among, rows))
        groups = [Group(tuple(line[r] for r in group.rows), tuple(place[k] for k in group.coordinates))
                  for group in self.groups if group.rows[0] in line]
        independent = tuple(place[k] for k in self.independent if k in place)
        points = [replace(x, rows=tuple(line[r] for r in x.rows)) for x in self.points if x.rows[0] in line]
        return Partition(independent, tuple(groups), tuple(self.reach[k] for k in among), tuple(points))


def find_partition(kinematics: Kinematics, constraints: Constraints, initial: InitialConditions) -> Partition | None:
    """None where the loops are not chains of such groups, leave more free than they give, or would often be poorly held."""
    rows = constraints.rows
    n, m = len(kinematics.symbols.positions), len(rows)
    if m == 0 or not 0 <= n - m <= m or is_too_large(n, m):
        return None
    phi = ca.vertcat(*[row.value(kinematics, 0) for row in rows if row.is_holonomic])
    rate = ca.substitute(ca.vertcat(*[row.rate(kinematics) for row in rows]), kinematics.symbols.tau, ca.SX(1))
    J = ca.jacobian(rate, ca.vertcat(*kinematics.symbols.rates.values()))
    pattern = J.sparsity()
    if _complete(_Chain.of(pattern), None) is None:
        return _along_own_axes(kinematics, phi, J, find_held_points(rows), initial) if n - m <= _FEW else None
    slopes = _slopes_along(Positions(kinematics, phi, J), kinematics, initial)
    return _complete(_Chain.of(pattern), slopes) if slopes is not None else None


def _along_own_axes(kinematics: Kinematics, phi: ca.SX, J: ca.SX, points: Sequence[HeldPoints], initial: InitialConditions
                    ) -> Partition | None:
    """The same with the rows of points along the axes of that end where they know of fewer coordinates."""
    if not points:
        return None
    both = [turned_rows(kinematics, J, ends) for ends in (points, [x.swapped for x in points])]
    along_both = _slopes_along(Positions(kinematics, phi, ca.vertcat(*both)), kinematics, initial)
    if along_both is None:
        return None
    slopes, other = np.split(along_both, 2, axis=1)
    known, also_known = (np.abs(x).max(axis=0) > _CLOSED * np.abs(x).max() for x in (slopes, other))
    chosen = list(points)
    for k, x in enumerate(points):
        rows = list(x.rows)
        if also_known[rows].sum() < known[rows].sum():
            chosen[k], slopes[:, rows], known[rows] = x.swapped, other[:, rows], also_known[rows]
    partition = _complete(_Chain.of(ca.sparsify(ca.DM(known.astype(float))).sparsity()), slopes)
    return replace(partition, points=tuple(chosen)) if partition is not None else None


def turned_rows(kinematics: Kinematics, x: ca.SX, points: Sequence[HeldPoints]) -> ca.SX:
    """The rows of x (m, k), those of points along axes of their own."""
    found = ca.densify(x)
    for one in points:
        axes = ca.vertcat(*[ca.horzcat(*row) for row in kinematics.pose(one.own, 0).axes])
        found[list(one.rows), :] = axes.T @ found[list(one.rows), :]
    return found


def is_too_large(n: int, m: int) -> bool:
    """Whether independent coordinates are not looked for, of n coordinates and m constraints: M would be full in them."""
    return (n - m) * n > _MOST_ENTRIES


def _slopes_along(positions: Positions, kinematics: Kinematics, initial: InitialConditions) -> Vector | None:
    """J at positions along the motion that the constraints allow, (positions, m, n). None where the start does not close."""
    start, failed = assembled(kinematics, initial)
    if failed >= 0:
        return None
    n, found = positions.n, [start[: positions.n]]
    reach = np.linalg.norm(positions.slopes(found[0]), axis=0)
    largest = max(float(reach.max()), _NOTHING)
    units, wishes = 1 / np.maximum(reach, _SHORTEST * largest), iter(_WISHES)
    for _ in range(min(_LEGS, _MOST_LEGS // n**2)):
        wish = np.array([*islice(wishes, n)])
        way = positions.along(found[-1], wish, units, _LENGTH * largest)
        found += takewhile(lambda q: positions.gap(q) <= _CLOSED * largest, islice(way, _LEG))
    return np.array([positions.slopes(q) for q in found])


# -------------------------------------------------------------------- chains of groups


@dataclass
class _Chain:
    """What follows from the coordinates given so far."""

    members: list[set[int]]  # coordinates of each row
    unknown: list[set[int]]  # those of them that are not known
    users: list[list[int]]  # rows of each coordinate
    depth: dict[int, int] = field(default_factory=dict)  # of known coordinates: so many groups stand one behind the other
    solved: set[int] = field(default_factory=set)  # rows
    given: list[int] = field(default_factory=list)
    groups: list[tuple[tuple[int, ...], tuple[int, ...]]] = field(default_factory=list)
    pairs: dict[frozenset[int], int] = field(default_factory=dict)  # rows that bring the same two coordinates
    repeats: bool = False  # a row says nothing new

    @staticmethod
    def of(pattern: ca.Sparsity) -> "_Chain":
        m, n = pattern.shape
        members, users = [set[int]() for _ in range(m)], [list[int]() for _ in range(n)]
        for row, k in zip(*pattern.get_triplet(), strict=True):
            members[row].add(k)
            users[k].append(row)
        chain = _Chain(members, [set(row) for row in members], users)
        chain._follow(chain._look(range(m)))
        return chain

    def with_given(self, k: int) -> "_Chain":
        """What follows from one more coordinate."""
        more = replace(self, unknown=[set(row) for row in self.unknown], depth=dict(self.depth), solved=set(self.solved),
                       given=[*self.given, k], groups=list(self.groups), pairs=dict(self.pairs))
        more.depth[k] = 0
        more._follow([k])
        return more

    def _follow(self, known: Sequence[int]) -> None:
        pending = list(known)
        while pending:
            k = pending.pop(0)
            for row in self.users[k]:
                self.unknown[row].discard(k)
            pending += self._look([row for row in self.users[k] if row not in self.solved])

    def _look(self, rows: Iterable[int]) -> list[int]:
        """The coordinates that these rows give now."""
        found: list[int] = []
        for row in rows:
            new = self.unknown[row] - set(found)
            if row in self.solved:
                continue
            self.repeats |= not new
            if len(new) == 1:
                found += self._solve((row,), tuple(new))
            elif len(new) == 2 and (other := self.pairs.setdefault(frozenset(new), row)) != row and other not in self.solved:
                found += self._solve((other, row), tuple(sorted(new)))
        return found

    def _solve(self, rows: tuple[int, ...], coordinates: tuple[int, ...]) -> tuple[int, ...]:
        self.groups.append((rows, coordinates))
        self.solved.update(rows)
        behind = 1 + max((self.depth[k] for row in rows for k in self.members[row] if k in self.depth), default=0)
        self.depth |= dict.fromkeys(coordinates, behind)
        return coordinates


def _complete(chain: _Chain, slopes: Vector | None) -> Partition | None:
    """Gives coordinates one by one, each time the one from which most follows, until all is known. With `slopes` (positions, m,
    n): of those whose groups are well held nearly everywhere, else None."""
    n, m = len(chain.users), len(chain.unknown)
    while len(chain.solved) < m:
        left = [k for k in range(n) if chain.users[k] and k not in chain.depth]
        best: tuple[tuple[float, ...], _Chain] | None = None
        for k in left[:: 1 + len(left) // _MOST_TRIED]:
            trial = chain.with_given(k)
            worst, share = _hold(trial, slopes)
            merit = len(trial.solved), min(worst, _GOOD), -max(trial.depth.values()), worst
            if not trial.repeats and share >= _MOSTLY and (best is None or merit > best[0]):
                best = merit, trial
            if best is not None and slopes is None and len(trial.solved) == m:
                break
        if best is None:
            return None
        chain = best[1]
    if chain.repeats or len(chain.depth) - len(chain.given) != m or _hold(chain, slopes)[1] < _MOSTLY:
        return None
    dependent = {k for _, coordinates in chain.groups for k in coordinates}
    reach = np.ones(n) if slopes is None else np.linalg.norm(slopes, axis=1).max(axis=0)
    return Partition(tuple(k for k in range(n) if k not in dependent), tuple(Group(*group) for group in chain.groups),
                     tuple(np.maximum(reach, _NOTHING).tolist()))


def _hold(chain: _Chain, slopes: Vector | None) -> tuple[float, float]:
    """The least sine of a transmission angle at any of the positions, and the share of positions where none is poor."""
    if slopes is None or not chain.groups:
        return 1.0, 1.0
    sines = np.min([np.abs(determinants) / size for determinants, size in _determinants(chain, slopes)], axis=0)
    return float(sines.min()), float((sines >= _POOR).mean())


def _determinants(chain: _Chain, slopes: Vector) -> Iterator[tuple[Vector, float]]:
    """Of each group: at all positions, and what it is where the group is held best. Slopes that are rounding hold nothing."""
    reach = np.linalg.norm(slopes, axis=1).max(axis=0)
    for rows, columns in chain.groups:
        block = slopes[:, list(rows)][:, :, list(columns)]
        size = float(np.prod(np.maximum(np.linalg.norm(block, axis=1).max(axis=0), _CLOSED * reach[list(columns)])))
        yield np.linalg.det(block), max(size, _NOTHING)
