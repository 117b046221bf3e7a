"""When a sweep of random runs may end: `se(mean(max(y))) < 1e-3`, once a standard error is small enough.

It is looked at after 100 runs, and then each time that there are half as many more: always after the same runs, however many
cores and interruptions there were.
"""

import math
import re
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NoReturn

from lagrangia.base.cutting import cut_list
from lagrangia.base.diagnostics import fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.language.values import read_value
from lagrangia.run.scene import Scene
from lagrangia.study.sweep.measures import Measure, read_measure, unit_of
from lagrangia.study.sweep.statistics import Estimate, deviation, mean, quantile

if TYPE_CHECKING:
    import numpy as np

_FIRST, _GROWTH = 100, 1.5  # runs; from one look to the next
_FORM = re.compile(r"\s*se\s*\(\s*(mean|deviation|quantile)\s*\((.*)\)\s*\)\s*<\s*(.+?)\s*", re.DOTALL)


@dataclass(frozen=True)
class Until:
    """The standard error of `what` (mean, deviation, or the quantile of a share) of a column is below the bound (SI units)."""

    text: str
    what: str
    column: int
    share: float
    bound: float

    def holds(self, results: "np.ndarray") -> bool:
        """Of the results so far, (runs, measures)."""
        return self.estimate(results).error < self.bound

    def estimate(self, results: "np.ndarray") -> Estimate:
        """What is looked at, with its error."""
        import numpy as np

        column = results[:, self.column]
        x = np.sort(column[np.isfinite(column)])
        return quantile(x, self.share) if self.what == "quantile" else mean(x) if self.what == "mean" else deviation(x)


def looks(runs: int) -> Iterator[int]:
    """After how many runs it is looked at; all of them at last."""
    count = float(_FIRST)
    while count < runs:
        yield int(count)
        count *= _GROWTH
    yield runs


def read_until(text: str, scene: Scene, measures: Sequence[Measure]) -> Until:
    """Raises LagError L0711, L0712."""
    match = _FORM.fullmatch(text)
    if match is None:
        _refuse(text, "this is no condition on a standard error")
    what, inside, bound = match.groups()
    arguments = cut_list(inside)
    share = math.nan
    if what == "quantile":
        if len(arguments) < 2:
            _refuse(text, "a quantile takes a measure and the share of runs below it")
        share = _number(text, arguments.pop(), "1")
        if not 0 < share < 1:
            _refuse(text, f"the share of a quantile must lie between 0 and 1, not {share:g}")
    wanted, known = read_measure(", ".join(arguments)).text, [measure.text for measure in measures]
    if wanted not in known:
        fail("L0712", f"'{text}': '{wanted}' is not measured", None, *filter(None, [suggest(wanted, known)]),
             f"name it in the outputs, which are {', '.join(known[:8])}")
    column = known.index(wanted)
    limit = _number(text, bound, unit_of(scene, measures[column]))
    if not limit > 0:
        _refuse(text, f"the bound of an error must be positive, not {limit:g}")
    return Until(text, what, column, share, limit)


def _number(text: str, given: str, unit: str) -> float:
    try:
        value = read_value(given, unit)
    except ValueError as error:
        _refuse(text, str(error))
    if isinstance(value, list) or not math.isfinite(value):
        _refuse(text, f"a number is needed, not {given}")
    return value


def _refuse(text: str, reason: str) -> NoReturn:
    fail("L0712", f"'{text}': {reason}", None,
         "se(mean(max(y))) < 1e-3, se(deviation(y)) < 0.1[mm], se(quantile(max(y), 0.95)) < 0.01")
