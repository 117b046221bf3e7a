"""Which random values a measure depends on: Sobol' indices from a design of Saltelli, by SciPy.

I. Sobol', Mathematics and Computers in Simulation 55 (2001) 271; A. Saltelli et al., Computer Physics Communications 181 (2010)
259.
"""

from typing import TYPE_CHECKING, Any

from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.study.sweep.statistics import Estimate

if TYPE_CHECKING:
    import numpy as np

_RESAMPLED = 100  # times, for the errors


@dataclass(frozen=True)
class Index:
    """Shares of a measure's variance: `first` by a value alone, `total` with all that it does together with others."""

    first: Estimate
    total: Estimate


def saltelli_points(samples: int, values: int, seed: int) -> "np.ndarray":
    """(samples (values + 2), values) in 0 .. 1: A, B, and A with one column of B for each value. Raises LagError L0712, L0901."""
    import numpy as np

    if samples & (samples - 1) or samples < 2:
        fail("L0712", f"Sobol' sequences take a power of 2 of samples, not {samples}", None,
             f"--samples {1 << samples.bit_length()}")
    if values < 2:
        fail("L0712", "one random value alone has all of the variance: there is nothing to be shared", None, "--sampling random")
    points = _scipy_stats().qmc.Sobol(2 * values, seed=seed).random(samples)
    a, b = points[:, :values], points[:, values:]
    mixed = np.tile(a, (values, 1, 1))
    for k in range(values):
        mixed[k, :, k] = b[:, k]
    found: np.ndarray = np.concatenate([a, b, *mixed])
    return found


def sobol_indices(results: "np.ndarray", values: int, seed: int) -> list[Index]:
    """Of a measure (runs,) of such a design, one for each value; errors by resampling. Raises LagError L0712, L0901."""
    import numpy as np

    if not np.isfinite(results).all():
        fail("L0712", f"{int((~np.isfinite(results)).sum())} runs have no such measure: shares of its variance need all of them")
    parts = results.reshape(values + 2, -1)
    samples = parts.shape[1]
    if not results.std() > 1e-14 * np.abs(results).max():
        fail("L0712", "the measure is the same in all runs: there is no variance to be shared")
    generator = np.random.Generator(np.random.PCG64(seed))
    chosen = [np.arange(samples), *(generator.integers(samples, size=samples) for _ in range(_RESAMPLED))]
    found = np.array([_indices(parts[:, some]) for some in chosen])
    errors = found[1:].std(axis=0, ddof=1)
    return [Index(*(Estimate(float(found[0, which, k]), float(errors[which, k])) for which in (0, 1))) for k in range(values)]


def _indices(parts: "np.ndarray") -> "np.ndarray":
    """(2, values)."""
    import numpy as np

    a, b, *mixed = (part[np.newaxis] for part in parts)
    found = _scipy_stats().sobol_indices(func={"f_A": a, "f_B": b, "f_AB": np.stack(mixed)}, n=parts.shape[1])
    return np.stack([np.ravel(found.first_order), np.ravel(found.total_order)])


def _scipy_stats() -> Any:
    try:
        import scipy.stats
    except ImportError:
        fail("L0901", "SciPy, which estimates Sobol' indices, is not installed", None, "pip install scipy")
    return scipy.stats
