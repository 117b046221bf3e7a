"""Poincare sections: the states in which a quantity rises through a value, found between the rows.

Between two rows each quantity is the polynomial through the six rows around it (its error goes with interval^6); those
through four of these tell how far it is to be trusted.
"""

from collections.abc import Sequence

import numpy as np

from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass

_AROUND, _FEWER = 6, 4
_TRUSTED = 1e-2  # of the range of a quantity: so far apart the polynomials may be, of which the best one is meant
_HALVINGS = 60


@dataclass(frozen=True)
class Section:
    """`times` (k,) in s and `values` (quantities, k); `coarse`: how many crossings were left out, as rows are too far apart
    to tell where they are."""

    times: np.ndarray
    values: np.ndarray
    coarse: int


def find_section(time: np.ndarray, crossing: np.ndarray, level: float, shown: Sequence[np.ndarray]) -> Section:
    """Where `crossing` (rows,) rises through `level`: the `shown` quantities there, (rows,) each. Raises LagError L0706."""
    if len(time) < _AROUND:
        fail("L0706", f"a section needs {_AROUND} rows at least, here are {len(time)}", None, "a smaller --interval gives more")
    apart = crossing - level
    rises = np.flatnonzero((apart[:-1] < 0) & (apart[1:] >= 0) & (np.diff(time) > 0))
    ranges = [float(np.ptp(x[np.isfinite(x)])) if np.isfinite(x).any() else 0.0 for x in (crossing, *shown)]
    times, values, coarse = [], [], 0
    for k in rises:
        begin = max(0, min(int(k) - _AROUND // 2 + 1, len(time) - _AROUND))
        rows = [slice(begin, begin + _AROUND), *(slice(begin + aside, begin + aside + _FEWER) for aside in (0, 1, 2))]
        if not (np.diff(time[rows[0]]) > 0).all():
            coarse += 1
            continue
        t = _root(time[rows[0]], apart[rows[0]], float(time[k]), float(time[k + 1]))
        fine, *rough = (np.array([_at(time[part], x[part], t) for x in (crossing, *shown)]) for part in rows)
        if not all((np.abs(fine - x) <= _TRUSTED * np.array(ranges) + 1e-300).all() for x in rough):
            coarse += 1
            continue
        times.append(t)
        values.append(fine[1:])
    found = np.array(values).T if values else np.empty((len(shown), 0))
    return Section(np.array(times), found, coarse)


def _at(t: np.ndarray, x: np.ndarray, where: float) -> float:
    """The polynomial through (t, x): Neville's scheme."""
    p = x.astype(float).copy()
    for m in range(1, len(t)):
        p = ((where - t[m:]) * p[:-1] - (where - t[:-m]) * p[1:]) / (t[:-m] - t[m:])
    return float(p[0])


def _root(t: np.ndarray, x: np.ndarray, low: float, high: float) -> float:
    """By halves: the polynomial is below zero at `low`, and not at `high`."""
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if _at(t, x, middle) < 0:
            low = middle
        else:
            high = middle
    return high
