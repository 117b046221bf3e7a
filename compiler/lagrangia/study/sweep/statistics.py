"""Measures of random runs as random numbers: mean, deviation and quantiles, each with its standard error."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass

if TYPE_CHECKING:
    import numpy as np

SHARES = (0.05, 0.5, 0.95)


@dataclass(frozen=True)
class Estimate:
    """A value and its standard error: the deviation it would have among repetitions of the sweep. NaN, inf: too few runs."""

    value: float
    error: float


@dataclass(frozen=True)
class Statistics:
    """Of a measure over `count` runs; `missing` others have none. Quantiles by the share of runs that lie below."""

    count: int
    missing: int
    least: float
    most: float
    mean: Estimate
    deviation: Estimate
    quantiles: Mapping[float, Estimate]


def statistics_of(values: "np.ndarray", shares: Sequence[float] = SHARES) -> Statistics:
    """Of a measure (runs,), NaN where a run has none. Raises LagError L0712 for shares outside of 0 to 1."""
    import numpy as np

    for share in shares:
        if not 0 < share < 1:
            fail("L0712", f"the share of a quantile must lie between 0 and 1, not {share}")
    found = np.sort(values[np.isfinite(values)])
    least, most = (float(found[0]), float(found[-1])) if len(found) else (math.nan, math.nan)
    return Statistics(len(found), len(values) - len(found), least, most, mean(found), deviation(found),
                      {share: quantile(found, share) for share in shares})


def mean(x: "np.ndarray") -> Estimate:
    """With the error s/sqrt(n)."""
    n = len(x)
    return Estimate(float(x.mean()) if n else math.nan, float(x.std(ddof=1)) / math.sqrt(n) if n > 1 else math.inf)


def deviation(x: "np.ndarray") -> Estimate:
    """s, with the error that follows from the fourth moment about the mean: var(s^2) = (m4 - s^4 (n - 3)/(n - 1))/n."""
    n = len(x)
    if n < 2:
        return Estimate(math.nan, math.inf)
    s = float(x.std(ddof=1))
    if s == 0 or n < 4:
        return Estimate(s, 0.0 if s == 0 else math.inf)
    fourth = float((((x - x.mean()) / s) ** 4).mean())
    return Estimate(s, s / 2 * math.sqrt(max(0.0, fourth - (n - 3) / (n - 1)) / n))


def quantile(x: "np.ndarray", share: float) -> Estimate:
    """Of ascending values, between neighbours; its error is half the way between those whose ranks are a deviation off, as ranks
    are binomial (H. David, H. Nagaraja, Order Statistics, 2003, section 7.1). inf where one of them would be outside."""
    import numpy as np

    n = len(x)
    if not n:
        return Estimate(math.nan, math.inf)
    value = float(np.quantile(x, share))
    middle, off = share * n - 0.5, math.sqrt(n * share * (1 - share))
    if middle - off < 0 or middle + off > n - 1:
        return Estimate(value, math.inf)
    low, high = np.interp((middle - off, middle + off), np.arange(n), x).tolist()
    return Estimate(value, (high - low) / 2)
