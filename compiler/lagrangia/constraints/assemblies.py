"""The other ways in which the loops of a scene can be assembled.

As many coordinates are taken for dependent as there are independent equations, those nobody guessed first; the others are held.
The block triangular form of the slopes tells which equations close together (Duff and Reid, ACM TOMS 4, 1978). Each block is
solved from many starts, by Levenberg and Marquardt's method, all starts at once; a solution that is new, angles modulo 2 pi, is
taken over, and what depends on it is solved again. The work is bounded: so many starts, so many blocks.
"""

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.algebra.orthogonal import Vector, independent_columns
from lagrangia.base.records import dataclass
from lagrangia.constraints.assembly import Assembly
from lagrangia.constraints.initial import FIXED, FREE, InitialConditions
from lagrangia.constraints.parameters import at_declared_values
from lagrangia.frames.graph import Coordinate
from lagrangia.frames.kinematics import Kinematics

_STARTS, _ITERATIONS, _LONGEST = 16, 40, 1.0
_LARGEST_BLOCK, _MOST_WORK, _FEWEST_BLOCKS, _MOST_BLOCKS = 8, 120, 2, 12
_SOLVED, _SAME, _INDEPENDENT, _NOTHING = 1e-11, 1e-5, 1e-7, 1e-12
_MOST_TOLD, _MOST_SHOWN = 3, 6
_EASE = 10.0  # how much rather a coordinate that nobody guessed is a dependent one


@dataclass(frozen=True)
class Alternatives:
    """A loop that closes in more ways than the one taken: the coordinates it gives, and what is told."""

    coordinates: tuple[str, ...]
    text: str


def find_alternatives(
    kinematics: Kinematics, initial: InitialConditions, assembly: Assembly, x: Vector
) -> tuple[Alternatives, ...]:
    """`x` (2 n,) is the state assembled. Other solutions with the coordinates held that the loops do not give."""
    search = Search(kinematics, initial, assembly, x)
    blocks = search.blocks()
    most = search.most_blocks
    found = [_alternatives(search, rows, columns) for rows, columns in blocks[:most]]
    told = [item for item in found if item is not None]
    if told and len(blocks) > most:
        told.append(Alternatives((), f"{len(blocks) - most} more loops were not tried for other assemblies"))
    return tuple(told)


def _alternatives(search: "Search", rows: list[int], columns: list[int]) -> Alternatives | None:
    others = search.others(rows, columns)
    if not others:
        return None
    initial, shown = search.initial, search.shown(columns, others)
    loops = dict.fromkeys(initial.residual_loops[k] for k in rows if initial.residual_loops[k])
    what = "the loop " + " and ".join(loops) if loops else f"the equation at {initial.residual_spans[rows[0]]}"
    text = (f"{what} closes in {len(others) + 1} ways: taken {search.values(search.x, shown)}; there is "
            f"{search.told(others, shown)} (nearer start values choose it)")
    return Alternatives(tuple(search.names[k] for k in shown), text)


class Search:
    """Of the positions, or of the rates at the positions assembled."""

    def __init__(self, kinematics: Kinematics, initial: InitialConditions, assembly: Assembly, x: Vector, of_rates: bool = False
                 ) -> None:
        self.initial, self.assembly, self.state, self.of_rates = initial, assembly, x, of_rates
        self.coordinates: tuple[Coordinate, ...] = (*kinematics.graph.coordinates, *initial.lost)
        self.n = n = len(self.coordinates)
        self.first = n if of_rates else 0  # of the values
        positions = initial.n_positions
        self.rows = slice(positions, None) if of_rates else slice(positions)
        q = ca.vertcat(*kinematics.symbols.positions.values(), initial.lost_q)
        self.q = ca.vertcat(*kinematics.symbols.rates.values(), initial.lost_v) if of_rates else q
        (self.residuals,) = at_declared_values(kinematics, [initial.residuals[self.rows]])
        if of_rates:
            self.residuals = ca.substitute(self.residuals, q, ca.SX(x[:n]))
        half = slice(self.first, self.first + n)
        self.x, self.fixed, self.reach, self.guess = x[half], assembly.fixed[half], assembly.reach[half], assembly.guess[half]
        self.names = [c.rate_name if of_rates else c.name for c in self.coordinates]
        self.angles = np.zeros(n, bool) if of_rates else assembly.equations.is_angle
        here, general = (self._scaled(jacobian) for jacobian in (assembly.equations(x)[1], assembly.general.jacobian))
        length = assembly.general.length[self.rows]
        self.sizes = np.where(length > 0, length, np.linalg.norm(here, axis=1))
        self.slopes = here / np.where(self.sizes > 0, self.sizes, np.inf)[:, None]
        self.pattern = np.maximum(np.abs(general), np.abs(here)) > _NOTHING * self.sizes[:, None]
        self.dependent: NDArray[np.int_] = np.zeros(0, int)
        self.named = [k for k, c in enumerate(self.coordinates) if not c.attitude]  # by which ways are told apart

    def _scaled(self, jacobian: Vector) -> Vector:
        """Its rows and columns of these equations and values, in natural sizes."""
        return np.asarray(jacobian[self.rows, self.first : self.first + self.n] * self.reach)

    @property
    def most_blocks(self) -> int:
        """So many are looked at."""
        return min(_MOST_BLOCKS, max(_FEWEST_BLOCKS, _MOST_WORK // self.n))

    def blocks(self) -> list[tuple[list[int], list[int]]]:
        """Rows and columns that are solved together, those that depend on no other block first."""
        ease = np.where(self.fixed == FIXED, 0.0, np.where(self.fixed >= FREE, _EASE, 1.0))
        is_told = np.isin(np.arange(self.n), self.named)
        ease = np.where(is_told, ease, ease / _EASE**2)
        self.dependent = independent_columns(self.slopes * ease, _INDEPENDENT)
        rows = independent_columns(self.slopes[:, self.dependent].T, _INDEPENDENT)
        if rows.size < self.dependent.size or not rows.size:
            return []
        pattern = self.pattern[np.ix_(rows, self.dependent)]
        count, row_order, column_order, row_starts, column_starts, *_ = _sparse(pattern).btf()
        found = []
        for k in range(count):
            inside = row_order[row_starts[k] : row_starts[k + 1]]
            columns = column_order[column_starts[k] : column_starts[k + 1]]
            found.append(([int(rows[i]) for i in inside], [int(self.dependent[j]) for j in columns]))
        return found

    def others(self, rows: list[int], columns: list[int]) -> list[Vector]:
        """The whole of it (n,), with another solution of a block."""
        if len(columns) > _LARGEST_BLOCK or len(columns) != len(rows):
            return []
        others: list[Vector] = []
        seen, system = [self.x[columns]], self._system(rows, columns)
        for values in self._solutions(system, rows, columns):
            if any(self._is_same(values, known, columns) or self._is_one(system, values, known, rows) for known in seen):
                continue
            seen.append(values)
            whole = self._complete(values, columns)
            if whole is not None:
                others.append(whole)
        return [x for x in others if not self._is_same(x[self.named], self.x[self.named], self.named)]

    def _is_one(self, system: ca.Function, one: Vector, other: Vector, rows: list[int]) -> bool:
        """Whether what lies between two solutions is one as well: near a root of higher order all is."""
        gaps = system((one + other) / 2)[0].full().ravel() / self.sizes[rows]
        return bool(np.abs(gaps).max() < _SOLVED)

    def _solutions(self, system: ca.Function, rows: list[int], columns: list[int]) -> list[Vector]:
        """Solutions of a block with everything else as it is, from starts spread over the circle and over the natural sizes."""
        places = np.arange(1, _STARTS + 1)[:, None] * np.sqrt([2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0])[: len(columns)] % 1
        angles = self.angles[columns]
        reach = np.where(angles, 1.0, np.maximum(self.reach[columns], np.abs(self.x[columns])))
        y = self.x[columns] + np.where(angles, 2 * np.pi * places, 4 * reach * (places - 0.5))
        size = self.sizes[rows]
        for _ in range(_ITERATIONS):
            g, J = (part.full().T for part in system(y.T))
            g = g / size
            slopes = J.reshape(len(y), len(columns), len(rows)).transpose(0, 2, 1) * reach / size[:, None]
            squares, slope = slopes.transpose(0, 2, 1) @ slopes, slopes.transpose(0, 2, 1) @ g[:, :, None]
            damping = np.minimum(0.1, (g**2).sum(axis=1))[:, None, None] + 1e-15
            step = -np.linalg.solve(squares + damping * np.eye(len(columns)), slope)[:, :, 0]
            step *= np.minimum(1.0, _LONGEST / np.maximum(np.abs(step).max(axis=1), _NOTHING))[:, None]
            y = y + step * reach
        gaps = np.abs(system(y.T)[0].full().T / size).max(axis=1)
        return [values for values, gap in zip(y, gaps, strict=True) if gap < _SOLVED]

    def _system(self, rows: list[int], columns: list[int]) -> ca.Function:
        """y, the columns' values -> the rows' residuals, and their slopes column by column."""
        y = ca.SX.sym("y", len(columns))
        values = ca.SX(self.x)
        values[columns] = y
        g = ca.substitute(self.residuals[rows], self.q, values)
        return ca.Function("block", [y], [ca.densify(g), ca.vec(ca.densify(ca.jacobian(g, y)))])

    def _complete(self, values: Vector, columns: list[int]) -> Vector | None:
        """The whole of it with a block's other solution, what no equation gives held."""
        x = self.state.copy()
        places = self.first + np.array(columns)
        x[places] = np.where(self.angles[columns], self.x[columns] + _turned(values - self.x[columns]), values)
        closed = self.assembly.close(x, self.rows, self.first + self.dependent, self.sizes)
        found = closed[self.first : self.first + self.n] if closed is not None else None
        return found if found is not None and self._is_same(found[columns], values, columns) else None

    def _is_same(self, one: Vector, other: Vector, columns: list[int]) -> bool:
        gap = np.where(self.angles[columns], _turned(one - other), one - other)
        return bool((np.abs(gap) < _SAME * self.reach[columns]).all())

    def shown(self, columns: list[int], others: list[Vector]) -> list[int]:
        """Of a block and of what differs with it, what is told."""
        differing = [k for k in self.dependent.tolist() if not self._is_same(others[0][[k]], self.x[[k]], [k])]
        return [k for k in sorted({*columns, *differing}) if not self.coordinates[k].attitude][:_MOST_SHOWN]

    def told(self, others: list[Vector], columns: list[int]) -> str:
        """The other ways."""
        more = f" or {len(others) - _MOST_TOLD} more" if len(others) > _MOST_TOLD else ""
        return " or ".join(self.values(other, columns) for other in others[:_MOST_TOLD]) + more

    def values(self, x: Vector, columns: list[int]) -> str:
        """In words."""
        return ", ".join(f"{self.names[k]} = {self._value(x[k], k)}" for k in columns)

    def _value(self, x: float, k: int) -> str:
        """To four digits, rounding errors taken for 0; angles from -180 to 180 degrees, -180 left out."""
        if self.angles[k]:
            degrees = round(float(np.degrees(_turned(np.array([x]))[0])), 6)
            return f"{180.0 if degrees == -180.0 else degrees + 0.0:.4g} deg"
        value = x if abs(x) > _SAME * self.reach[k] else 0.0
        unit = self.coordinates[k].unit
        return f"{value:.4g} {unit}{'/s' if self.of_rates else ''}".removesuffix(" 1")


def _turned(x: Vector) -> Vector:
    """Angles from -pi to pi."""
    return np.asarray(x - 2 * np.pi * np.round(x / (2 * np.pi)))


def _sparse(pattern: NDArray[np.bool_]) -> ca.Sparsity:
    rows, columns = np.nonzero(pattern)
    return ca.Sparsity.triplet(*pattern.shape, rows.tolist(), columns.tolist())
