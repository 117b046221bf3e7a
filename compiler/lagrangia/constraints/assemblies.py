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
    search = _Search(kinematics, initial, assembly, x)
    blocks = search.blocks()
    most = min(_MOST_BLOCKS, max(_FEWEST_BLOCKS, _MOST_WORK // search.n))
    found = [search.alternatives(rows, columns) for rows, columns in blocks[:most]]
    told = [item for item in found if item is not None]
    if told and len(blocks) > most:
        told.append(Alternatives((), f"{len(blocks) - most} more loops were not tried for other assemblies"))
    return tuple(told)


class _Search:
    def __init__(self, kinematics: Kinematics, initial: InitialConditions, assembly: Assembly, x: Vector) -> None:
        self.initial, self.assembly, self.x = initial, assembly, x
        self.q = ca.vertcat(*kinematics.symbols.positions.values(), initial.lost_q)
        self.residuals = at_declared_values(kinematics, [initial.residuals[: initial.n_positions]])[0]
        self.coordinates: tuple[Coordinate, ...] = (*kinematics.graph.coordinates, *initial.lost)
        self.n = len(self.coordinates)
        self.angles = assembly.equations.is_angle
        self.dependent: NDArray[np.int_] = np.zeros(0, int)
        self.told = [k for k, c in enumerate(self.coordinates) if not c.attitude]  # by which ways are told apart

    def blocks(self) -> list[tuple[list[int], list[int]]]:
        """Rows and columns that are solved together, those that depend on no other block first."""
        fixed, positions = self.assembly.fixed[: self.n], self.initial.n_positions
        slopes = self.assembly.slopes(self.x)
        ease = np.where(fixed == FIXED, 0.0, np.where(fixed == FREE, _EASE, 1.0))
        is_told = np.isin(np.arange(self.n), self.told)
        ease = np.where(is_told, ease, ease / _EASE**2)
        self.dependent = independent_columns(slopes * ease, _INDEPENDENT)
        rows = independent_columns(slopes[:, self.dependent].T, _INDEPENDENT)
        if rows.size < self.dependent.size or not rows.size:
            return []
        general = np.abs(self.assembly.general.jacobian[:positions, : self.n]) * self.assembly.reach[: self.n]
        pattern = general[np.ix_(rows, self.dependent)] > _NOTHING * self.assembly.general.length[rows][:, None]
        count, row_order, column_order, row_starts, column_starts, *_ = _sparse(pattern).btf()
        found = []
        for k in range(count):
            inside = row_order[row_starts[k] : row_starts[k + 1]]
            columns = column_order[column_starts[k] : column_starts[k + 1]]
            found.append(([int(rows[i]) for i in inside], [int(self.dependent[j]) for j in columns]))
        return found

    def alternatives(self, rows: list[int], columns: list[int]) -> Alternatives | None:
        if len(columns) > _LARGEST_BLOCK or len(columns) != len(rows):
            return None
        others: list[Vector] = []
        seen = [self.x[columns]]
        for values in self._solutions(rows, columns):
            if any(self._is_same(values, known, columns) for known in seen):
                continue
            seen.append(values)
            whole = self._complete(values, columns)
            if whole is not None:
                others.append(whole)
        others = [x for x in others if not self._is_same(x[self.told], self.x[self.told], self.told)]
        return self._tell(rows, columns, others) if others else None

    def _solutions(self, rows: list[int], columns: list[int]) -> list[Vector]:
        """Solutions of a block with everything else as it is, from starts spread over the circle and over the natural sizes."""
        system = self._system(rows, columns)
        places = np.arange(1, _STARTS + 1)[:, None] * np.sqrt([2.0, 3.0, 5.0, 7.0, 11.0, 13.0, 17.0, 19.0])[: len(columns)] % 1
        angles, reach = self.angles[columns], self.assembly.reach[columns]
        y = self.x[columns] + np.where(angles, 2 * np.pi * places, 4 * reach * (places - 0.5))
        size = self.assembly.general.length[rows]
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
        values = ca.SX(self.x[: self.n])
        values[columns] = y
        g = ca.substitute(self.residuals[rows], self.q, values)
        return ca.Function("block", [y], [ca.densify(g), ca.vec(ca.densify(ca.jacobian(g, y)))])

    def _complete(self, values: Vector, columns: list[int]) -> Vector | None:
        """The whole assembly with a block's other solution, coordinates that no loop gives held."""
        x = self.x.copy()
        x[columns] = np.where(self.angles[columns], self.x[columns] + _turned(values - self.x[columns]), values)
        found = self.assembly.close(x, self.dependent)
        return found if found is not None and self._is_same(found[columns], values, columns) else None

    def _is_same(self, one: Vector, other: Vector, columns: list[int]) -> bool:
        gap = np.where(self.angles[columns], _turned(one - other), one - other)
        return bool((np.abs(gap) < _SAME * self.assembly.reach[columns]).all())

    def _tell(self, rows: list[int], columns: list[int], others: list[Vector]) -> Alternatives:
        loops = dict.fromkeys(self.initial.residual_loops[k] for k in rows if self.initial.residual_loops[k])
        what = "the loop " + " and ".join(loops) if loops else f"the equation at {self.initial.residual_spans[rows[0]]}"
        differing = [k for k in self.dependent.tolist() if not self._is_same(others[0][[k]], self.x[[k]], [k])]
        shown = [k for k in sorted({*columns, *differing}) if not self.coordinates[k].attitude][:_MOST_SHOWN]
        told = " or ".join(self._values(other, shown) for other in others[:_MOST_TOLD])
        more = f" or {len(others) - _MOST_TOLD} more" if len(others) > _MOST_TOLD else ""
        return Alternatives(tuple(self.coordinates[k].name for k in shown), f"{what} closes in {len(others) + 1} ways: taken "
                            f"{self._values(self.x, shown)}; there is {told}{more} (nearer start values choose it)")

    def _values(self, x: Vector, columns: list[int]) -> str:
        return ", ".join(f"{self.coordinates[k].name} = {self._value(x[k], k)}" for k in columns)

    def _value(self, x: float, k: int) -> str:
        """To four digits, rounding errors taken for 0; angles from -180 to 180 degrees, -180 left out."""
        if self.angles[k]:
            degrees = round(float(np.degrees(_turned(np.array([x]))[0])), 6)
            return f"{180.0 if degrees == -180.0 else degrees + 0.0:.4g} deg"
        value = x if abs(x) > _SAME * self.assembly.reach[k] else 0.0
        return f"{value:.4g} {self.coordinates[k].unit}"


def _turned(x: Vector) -> Vector:
    """Angles from -pi to pi."""
    return np.asarray(x - 2 * np.pi * np.round(x / (2 * np.pi)))


def _sparse(pattern: NDArray[np.bool_]) -> ca.Sparsity:
    rows, columns = np.nonzero(pattern)
    return ca.Sparsity.triplet(*pattern.shape, rows.tolist(), columns.tolist())
