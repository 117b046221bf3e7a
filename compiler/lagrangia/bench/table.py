"""Points of work and precision -> the time each solver takes to an error, and who is fastest there; tables and pictures of it."""

import csv
import io
import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from lagrangia.bench.measure import Point

ERRORS = tuple(10.0**-k for k in range(3, 13))
_LOST = 0.1


def front(points: Sequence[Point]) -> list[Point]:
    """Those points that no other beats in both time and error, from the largest error to the smallest."""
    kept: list[Point] = []
    for point in sorted((p for p in points if math.isfinite(p.error)), key=lambda p: (p.seconds, p.error)):
        if not kept or point.error < kept[-1].error:
            kept.append(point)
    return kept


def seconds_at(points: Sequence[Point], error: float) -> float | None:
    """The time to an error: straight lines between the points of the front on logarithmic scales; None where none is so good.

    From a run that lost the motion altogether no line is drawn: how early it failed says nothing.
    """
    kept = front([point for point in points if point.error < _LOST])
    if not kept or kept[-1].error > error:
        return None
    before: Point | None = None
    for point in kept:
        if point.error <= error:
            if before is None:
                return point.seconds
            low, high = max(point.error, 1e-300), before.error
            share = math.log(high / error) / math.log(high / low)
            return float(before.seconds * (point.seconds / before.seconds) ** share)
        before = point
    return None


def by_solver(points: Sequence[Point]) -> dict[str, list[Point]]:
    """In the order they were measured."""
    found: dict[str, list[Point]] = {}
    for point in points:
        found.setdefault(point.solver, []).append(point)
    return found


def duel(points: Sequence[Point], ours: Sequence[str], floor: float = 0.0) -> list[tuple[float, Point | None, Point | None]]:
    """At each of ERRORS above the floor: our fastest and the fastest of the others, as points at just this error."""
    groups = by_solver(points)
    rows = []
    for error in (e for e in ERRORS if e > floor):
        best: list[Point | None] = []
        for side in (True, False):
            times = {name: seconds_at(group, error) for name, group in groups.items() if (name in ours) == side}
            known = {name: seconds for name, seconds in times.items() if seconds is not None}
            name = min(known, key=lambda n: known[n], default=None)
            best.append(None if name is None else Point(name, error, known[name], error))
        rows.append((error, best[0], best[1]))
    return rows


def as_text(points: Sequence[Point], ours: Sequence[str], floor: float) -> list[str]:
    """Every point, and who is first at each error."""
    width = max((len(p.solver) for p in points), default=6)
    lines = [f"{'solver':{width}} {'tolerance':>9} {'time':>10} {'error':>8}"]
    for name, group in by_solver(points).items():
        lines += [f"{name:{width}} {p.tolerance:9.0e} {duration(p.seconds):>10} {p.error:8.1e}" for p in group]
    rows = duel(points, ours, floor)
    if any(other for _, _, other in rows):
        lines += ["", f"{'error':>8} {'ours':>10} {'best other':>10}  ratio"]
        lines += [_duel_line(*row) for row in rows]
    return lines


def _duel_line(error: float, own: Point | None, other: Point | None) -> str:
    first, second = (duration(p.seconds) if p else "-" for p in (own, other))
    ratio = f"{own.seconds / other.seconds:6.2f}" if own and other else 6 * " "
    names = f"  {own.solver if own else 'none'} : {other.solver if other else 'none'}"
    return f"{error:8.0e} {first:>10} {second:>10} {ratio}{names}"


def duration(seconds: float) -> str:
    """Three digits and a unit."""
    for limit, unit, factor in ((1e-3, "us", 1e6), (1.0, "ms", 1e3)):
        if seconds < limit:
            return f"{seconds * factor:.3g} {unit}"
    return f"{seconds:.3g} s"


def as_csv(points: Sequence[Point]) -> str:
    """A line for each solver and tolerance."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(["solver", "tolerance", "seconds", "error"])
    writer.writerows([p.solver, repr(p.tolerance), repr(p.seconds), repr(p.error)] for p in points)
    return stream.getvalue()


def as_json(points: Sequence[Point], facts: Mapping[str, Any]) -> str:
    """All points, with facts about the machine and the scene; errors that are not finite are null."""
    rows = [{"solver": p.solver, "tolerance": p.tolerance, "seconds": p.seconds,
             "error": p.error if math.isfinite(p.error) else None} for p in points]
    return json.dumps({**facts, "points": rows}, indent=1) + "\n"
