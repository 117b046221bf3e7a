"""Constraints -> degrees of freedom: assembles the scene with its declared parameters and takes ranks.

The rank is taken at the assembled position and at general positions near it, for a mechanism may start in a singular one. A rank
decision counts singular values above 1e-7 of the largest, rows and columns scaled to unit size at most: half the digits, for a
singular position is not known better.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np

from lagrangia.algebra.orthogonal import Vector
from lagrangia.base.diagnostics import Diagnostic, tell_miss
from lagrangia.base.records import dataclass
from lagrangia.constraints.assemblies import Alternatives, find_alternatives
from lagrangia.constraints.assembly import Assembly, begin
from lagrangia.constraints.initial import InitialConditions
from lagrangia.constraints.positions import Positions, shortest
from lagrangia.constraints.rows import Constraints, Row
from lagrangia.constraints.singular_positions import told
from lagrangia.dynamics.constrained_motion import ConstrainedMotion
from lagrangia.dynamics.double_roots import static_constraints
from lagrangia.dynamics.equilibrium import ways_at
from lagrangia.dynamics.motion import Motion
from lagrangia.frames.closures import is_across
from lagrangia.frames.kinematics import Kinematics

_RANK = 1e-7
_LEAST = 1e-5  # of a row beside the largest one, that is scaled to it: slopes of 1e-12 are what rounding, and _THERE, leave of 0
_THERE = 1e-13  # of a position that is taken to be on the constraints, relative to the scene's size
_SHUT = 1e-6  # what is left of a gap where another start would close it
_NOTHING = 1e-300


@dataclass(frozen=True)
class Freedom:
    """`degrees` of freedom at general positions and `now`, at the start, where `ways` of moving meet if it is singular; rows that
    repeat others, told and by their places; what does not assemble; loops that close in several ways."""

    degrees: int
    now: int
    repeated: tuple[str, ...]
    problem: Diagnostic | None
    alternatives: tuple[Alternatives, ...] = ()
    dependent: tuple[int, ...] = ()
    ways: tuple[str, ...] = ()
    is_rigid: bool = False  # the start: nothing moves there


def is_held_still(
    kinematics: Kinematics, motion: Motion, constraints: Constraints, initial: InitialConditions,
    functions: Mapping[str, ca.Function]
) -> bool:
    """Whether no freedom is left. Ranks are taken only where there are as many constraints as coordinates."""
    held, n = motion.constrained, motion.q.numel()
    if held is None or held.J.shape[0] < n:
        return bool(n == 0)
    return _find(kinematics, motion, constraints, initial, functions)[0].degrees == 0


def repeated_rows(
    kinematics: Kinematics, motion: Motion, constraints: Constraints, initial: InitialConditions,
    functions: Mapping[str, ca.Function]
) -> tuple[str, ...]:
    """What repeats others, told and by its places, with parameters as declared."""
    return _find(kinematics, motion, constraints, initial, functions)[0].repeated


def find_freedom(
    kinematics: Kinematics, motion: Motion, constraints: Constraints, initial: InitialConditions,
    functions: Mapping[str, ca.Function]
) -> Freedom:
    """The freedom of a scene with its parameters as declared, other assemblies too."""
    found, assembly, x = _find(kinematics, motion, constraints, initial, functions)
    if found.problem is not None or assembly is None:
        return found
    if motion.constrained is not None:
        found = _at_the_start(found, kinematics, motion.constrained, x[: motion.q.numel()])
    return replace(found, alternatives=find_alternatives(kinematics, initial, assembly, x))


def _find(
    kinematics: Kinematics, motion: Motion, constraints: Constraints, initial: InitialConditions,
    functions: Mapping[str, ca.Function]
) -> tuple[Freedom, Assembly | None, Vector]:
    """But for the alternatives; the assembly, and the state it found."""
    held, n = motion.constrained, motion.q.numel()
    told = tuple(dict.fromkeys(_tell(row, kinematics) for row in constraints.repeated))
    if held is None and not initial.residuals.numel():
        return Freedom(n, n, told, None), None, np.zeros(0)
    assembly = begin(kinematics, initial, functions)
    x, worst = assembly.assemble()
    if worst >= 0:
        is_rate = worst >= initial.n_positions
        gaps = assembly.equations(x)[0]
        least = gaps if is_rate else assembly.least_gaps(x)
        closes_elsewhere = np.abs(least).max() < _SHUT * np.abs(gaps).max()
        return Freedom(n, n, told, _problem(initial, worst, gaps if closes_elsewhere else least)), assembly, x
    if held is None:
        return Freedom(n, n, told, None), None, np.zeros(0)
    ranks, dependent = ranks_at(kinematics, held.rows.phi, held.J, x[:n])
    repeated = dict.fromkeys((*told, *(_tell(constraints.rows[k], kinematics) for k in dependent)))
    is_rigid = bool(constraints.touching) and max(ranks) == n
    found = Freedom(n - max(ranks), n - ranks[0], tuple(repeated), None, (), dependent, (), is_rigid)
    return found, assembly, x


def ranks_at(kinematics: Kinematics, phi: ca.SX, J: ca.SX, q: Vector) -> tuple[list[int], tuple[int, ...]]:
    """The ranks of the slopes of all rows at an assembled position and at general ones near it, and the rows that lie in the
    span of those before them where the rank is largest."""
    numbers = _Numbers(kinematics, phi, J)
    slopes = numbers.scaled([q, *numbers.nearby(q)])
    ranks = [_rank(found) for found in slopes]
    return ranks, tuple(_dependent_rows(slopes[int(np.argmax(ranks))]))


def _at_the_start(found: Freedom, kinematics: Kinematics, held: ConstrainedMotion, q: Vector) -> Freedom:
    """Where constraints are dependent, what second order allows of what first order does."""
    ways = ways_at(static_constraints(kinematics, held.rows.phi, held.J), q)
    if ways is None or ways.is_open:
        return found
    names = [c.name for c in kinematics.graph.coordinates]
    if len(ways.planes) > 1:
        return replace(found, ways=tuple(told(plane, names) for plane in ways.planes))
    now = ways.planes[0].shape[1] if ways.planes else 0
    return replace(found, degrees=now, now=now, is_rigid=ways.is_rigid)


def _tell(row: Row, kinematics: Kinematics) -> str:
    if row.loop is not None and is_across(kinematics, row.loop, row.part):
        return f"{row.told} repeats across its plane what others already impose: what its joints carry there is not unique"
    shared = ": how its joints share what they carry is not unique" if row.loop and kinematics.geometry.by_poses else ""
    return f"{row.told} repeats in part what others already impose{shared}"


def _problem(initial: InitialConditions, worst: int, residuals: Vector) -> Diagnostic:
    """A loop misses by the length of its gap, whichever way that points."""
    span, loop = initial.residual_spans[worst], initial.residual_loops[worst]
    is_rate = worst >= initial.n_positions
    alike = range(initial.n_positions, len(initial.residual_spans)) if is_rate else range(initial.n_positions)
    together = [k for k in alike if loop and initial.residual_loops[k] == loop]
    gap = float(np.linalg.norm(residuals[together or [worst]]))
    unit = "m/s or rad/s" if is_rate else "m or rad"
    return Diagnostic("error", "L0606", f"{initial.complaint(worst)}: {tell_miss(gap, unit)}", span, "",
                      ("change the lengths, the places of the joints, or the start values it is solved from",))


def freedom_notes(freedom: Freedom) -> dict[str, Any]:
    """As plain data, for a scene that is kept."""
    return {"degrees_of_freedom": freedom.degrees, "degrees_at_start": freedom.now, "repeated": list(freedom.repeated),
            "ways_at_start": list(freedom.ways), "is_rigid_at_start": freedom.is_rigid,
            "assemblies": [item.text for item in freedom.alternatives],
            "given_by_loops": [name for item in freedom.alternatives for name in item.coordinates],
            "problem": freedom.problem.render() if freedom.problem else ""}


class _Numbers:
    """Positions near an assembled one, and the slopes of all rows there."""

    def __init__(self, kinematics: Kinematics, phi: ca.SX, J: ca.SX) -> None:
        self.positions = Positions(kinematics, phi, J)

    def nearby(self, q: Vector) -> list[Vector]:
        """General positions near an assembled one: a small step along what the constraints allow, and back onto them."""
        random = np.random.default_rng(1)
        size = max(1.0, float(np.abs(q).max(initial=0.0)))
        J = self.positions.slopes(q)
        found = []
        for length in (0.1, 0.03, 0.01):
            wish = random.standard_normal(q.size)
            x = self.positions.onto(q + length * (wish - shortest(J, J @ wish)))
            if self.positions.gap(x) < _THERE * size:
                found.append(x)
        return found

    def scaled(self, places: list[Vector]) -> list[Vector]:
        """The slopes at each place, columns and rows scaled by what they are at most: what vanishes at one stays small, and what
        does at all of them."""
        slopes = [self.positions.slopes(q) for q in places]
        columns = np.max([np.abs(J).max(axis=0, initial=0.0) for J in slopes], axis=0)
        slopes = [J / np.maximum(columns, _NOTHING) for J in slopes]
        rows = np.max([np.linalg.norm(J, axis=1) for J in slopes], axis=0)
        return [J / np.maximum(rows, max(_LEAST * rows.max(initial=0.0), _NOTHING))[:, None] for J in slopes]


def _rank(J: Vector) -> int:
    values = np.linalg.svd(J, compute_uv=False)
    return int((values > _RANK * values.max(initial=0.0)).sum())


def _dependent_rows(J: Vector) -> list[int]:
    """Rows that lie in the span of the rows before them."""
    basis: list[Vector] = []
    found = []
    for k, row in enumerate(J):
        rest = row.copy()
        for _ in range(2):
            for b in basis:
                rest -= (rest @ b) * b
        size = float(np.linalg.norm(rest))
        if size > _RANK:
            basis.append(rest / size)
        else:
            found.append(k)
    return found
