"""What a sweep of random runs says of its measures: statistics with their errors, Sobol' indices, why it ended."""

from collections.abc import Iterator

from lagrangia.base.diagnostics import LagError
from lagrangia.study.sweep.measures import Measure
from lagrangia.study.sweep.sensitivity import sobol_indices
from lagrangia.study.sweep.statistics import Estimate, statistics_of
from lagrangia.study.sweep.table import Sweep
from lagrangia.study.sweep.until import Until


def told_of_chance(sweep: Sweep, measure: Measure) -> Iterator[str]:
    """Lines of a measure; none where nothing is random."""
    job = sweep.job
    if job.sampling == "saltelli":
        yield _told_indices(sweep, measure)
    elif job.sampling:
        column = job.measures.index(measure)
        found = statistics_of(sweep.ledger.results[sweep.ok, column])
        if not found.count:
            return
        shares = ", ".join(f"{100 * share:g} % below {_told(x, job.sampling)}" for share, x in found.quantiles.items())
        spread = f", deviation {_told(found.deviation, job.sampling)}" if found.count > 1 else ""
        yield f"mean {_told(found.mean, job.sampling)}{spread}; {shares}"


def ended(sweep: Sweep, until: Until) -> str:
    """Whether what was wanted is reached."""
    found = until.estimate(sweep.ledger.results)
    if found.error < until.bound:
        return f"ended after {sweep.runs} runs: {until.text}; it is {found.value:.6g} +- {found.error:.2g}"
    now = f"it is {found.value:.6g} +- {found.error:.2g}" if found.error < float("inf") else "too few runs have a value"
    return f"not reached in {sweep.runs} runs: {until.text}; {now}: take more --samples"


def _told(x: Estimate, sampling: str) -> str:
    """Errors are those of runs that do not depend on each other, which the slices of a hypercube do."""
    return f"{x.value:.6g}" if sampling != "random" or not x.error < float("inf") else f"{x.value:.6g} +- {x.error:.2g}"


def _told_indices(sweep: Sweep, measure: Measure) -> str:
    names = sweep.job.variations.names
    try:
        found = sobol_indices(sweep[measure.text], len(names), sweep.job.seed)
    except LagError as error:
        return f"no Sobol' indices: {error.diagnostics[0].message}"
    told = [f"{name} {x.first.value:.3f} +- {x.first.error:.1g} (total {x.total.value:.3f} +- {x.total.error:.1g})"
            for name, x in sorted(zip(names, found, strict=True), key=lambda pair: -pair[1].total.value)]
    return f"Sobol' indices: {', '.join(told)}"
