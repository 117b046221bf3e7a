"""A sweep as a picture: each measure over what is varied, as a histogram where that is random, with the Sobol' indices where
these were asked for, and as parallel coordinates.
"""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from lagrangia.base.diagnostics import LagError
from lagrangia.study.sweep.plan import Job
from lagrangia.study.sweep.sensitivity import sobol_indices
from lagrangia.view.curves import new_figure, own_style, require_format, save

if TYPE_CHECKING:
    import numpy as np

_MOST_MEASURES, _MOST_VARIED = 4, 5
_MOST_LINES, _MOST_DOTS = 500, 100_000  # runs in parallel coordinates, in a panel
_PARALLEL = 3  # values that differ from run to run, from which on these are drawn
_FINEST, _MOST_TICKS = 60, 5  # bars; steps between numbers of runs
_ALIKE, _BESIDE = 1e-12, 0.05  # of the largest value: differences that are rounding; what is shown on both sides of such values
_SIZES = ((200, 14.0), (2000, 5.0), (10**9, 1.5))  # runs up to which dots are so large


class Table(Protocol):
    """Columns of what is varied and of measures, by name, (runs,)."""

    @property
    def job(self) -> Job:
        """What was computed."""

    @property
    def runs(self) -> int:
        """How many."""

    @property
    def names(self) -> list[str]:
        """Of the columns."""

    def units(self) -> list[str]:
        """Of the columns."""

    def __getitem__(self, name: str) -> "np.ndarray":
        """One of them."""


@own_style()
def draw_sweep(sweep: Table, path: str | os.PathLike[str] | None = None) -> Any:
    """A row of panels a measure; below them, over all its width, parallel coordinates coloured by the first measure.

    Raises LagError L0004 when the picture cannot be written.
    """
    if path is not None:
        require_format(path)
    job = sweep.job
    names, measures = job.variations.names[:_MOST_VARIED], [m.text for m in job.measures[:_MOST_MEASURES]]
    units = dict(zip(sweep.names, sweep.units(), strict=True))
    beside = [_histogram, *([_indices] if job.sampling == "saltelli" else [])] if job.sampling else []
    columns, has_lines = len(names) + len(beside), len(names) >= _PARALLEL
    if not columns:
        columns, names = 1, ("run",)
    figure = new_figure(1.2 + 3.0 * columns, 0.6 + 2.5 * (len(measures) + has_lines))
    grid = figure.add_gridspec(len(measures) + has_lines, columns)
    for row, measure in enumerate(measures):
        for column, name in enumerate(names):
            panel = figure.add_subplot(grid[row, column])
            _scatter(panel, sweep, name, measure)
            _tell_empty(panel, sweep, measure)
            panel.set_xlabel(_literal(name, units.get(name, "")) if row == len(measures) - 1 else "", fontsize=9)
            panel.set_ylabel(_literal(measure, units[measure]) if column == 0 else "", fontsize=9)
        for column, draw in enumerate(beside, len(names)):
            panel = figure.add_subplot(grid[row, column])
            draw(panel, sweep, measure)
            _tell_empty(panel, sweep, measure)
    if has_lines:
        panel = figure.add_subplot(grid[len(measures), :])
        _parallel(figure, panel, sweep, [*names], measures[0], units)
        _tell_empty(panel, sweep, measures[0])
    left = len(job.measures) - len(measures), len(job.variations.names) - len(names)
    more = [f"{count} {what} more" for count, what in zip(left, ("measures", "values"), strict=True) if count > 0]
    more += [f"dots of {_MOST_DOTS}"] if sweep.runs > _MOST_DOTS else []
    said = f" ({', '.join(more)})" if more else ""
    figure.suptitle(f"{_literal(job.scene.name)}: {_counted(sweep, measures)}{said}", fontsize=11)
    if path is not None:
        save(figure, Path(path))
    return figure


def _counted(sweep: Table, measures: list[str]) -> str:
    """How many runs, and how many of them have nothing to be drawn."""
    import numpy as np

    without = int(np.all([~np.isfinite(sweep[measure]) for measure in measures], axis=0).sum()) if measures else 0
    return f"{sweep.runs} run{'s' if sweep.runs != 1 else ''}{f', {without} without results' if without else ''}"


def _tell_empty(panel: Any, sweep: Table, measure: str) -> None:
    """Axes around nothing would have ticks that mean nothing."""
    import numpy as np

    if not np.isfinite(sweep[measure]).any():
        _say(panel, "no run has a value")


def _say(panel: Any, text: str) -> None:
    """In place of a picture."""
    for said in panel.texts:
        said.remove()
    panel.text(0.5, 0.5, text, ha="center", va="center", transform=panel.transAxes, fontsize=9)
    panel.set_xticks([])
    panel.set_yticks([])


def _literal(name: str, unit: str = "") -> str:
    return (f"{name} [{unit}]" if unit else name).replace("$", r"\$")


def _values(sweep: Table, name: str) -> "np.ndarray":
    import numpy as np

    return np.arange(sweep.runs) if name == "run" else sweep[name]


def _span(values: "np.ndarray") -> tuple[float, float] | None:
    """Between what a measure is drawn where all its values are one, but for rounding, which has no bars; None: as they lie."""
    import numpy as np

    found = values[np.isfinite(values)]
    size = float(np.abs(found).max(initial=0.0))
    if not len(found) or found.max() / (size or 1) - found.min() / (size or 1) > _ALIKE:
        return None
    middle, beside = float(found[0]), _BESIDE * (size or 1)
    return middle - beside, middle + beside


def _evenly(runs: int, most: int, *also: int) -> "np.ndarray":
    """As many of the runs at most, and those that shall not be missed."""
    import numpy as np

    return np.unique(np.append(np.linspace(0, runs - 1, min(runs, most)), also).astype(int))


def _ends(values: "np.ndarray") -> tuple[int, int]:
    """The runs of the least and the largest of them."""
    import numpy as np

    is_there = np.isfinite(values)
    return int(np.where(is_there, values, np.inf).argmin()), int(np.where(is_there, values, -np.inf).argmax())


def _scatter(panel: Any, sweep: Table, name: str, measure: str) -> None:
    """Dots, where there are many those of evenly chosen runs; a line through them where nothing else is varied, in an order."""
    x, y = _values(sweep, name), sweep[measure]
    if sweep.runs > _MOST_DOTS:
        chosen = _evenly(sweep.runs, _MOST_DOTS, *_ends(x), *_ends(y))
        x, y = x[chosen], y[chosen]
    size = next(size for runs, size in _SIZES if sweep.runs <= runs)
    is_line = len(sweep.job.variations.names) == 1 and not sweep.job.sampling
    if is_line:
        order = x.argsort(kind="stable")
        panel.plot(x[order], y[order], linewidth=1.0, color="C0")
    panel.scatter(x, y, s=size, color="C0", alpha=1.0 if is_line or sweep.runs < _SIZES[0][0] else 0.5, linewidths=0)
    if span := _span(y):
        panel.set_ylim(span)
    panel.tick_params(labelsize=8)
    if name == "run":
        _count_along(panel)
    panel.grid(alpha=0.3)


def _count_along(panel: Any) -> None:
    """Numbers stand at whole ones, however few there are, and large ones apart from each other."""
    panel.locator_params(axis="x", integer=True, min_n_ticks=1, nbins=_MOST_TICKS)


def _histogram(panel: Any, sweep: Table, measure: str) -> None:
    """With the mean as a line; as many bars as the square root of the runs."""
    import numpy as np

    values = sweep[measure]
    found = values[np.isfinite(values)]
    if len(found):
        bars, span = min(_FINEST, max(5, round(len(found) ** 0.5))), _span(values)
        panel.hist(found, bins=bars | 1 if span else bars, range=span, orientation="horizontal", color="C0", alpha=0.7)
        if span:
            panel.set_ylim(span)
        panel.axhline(found.mean(), color="black", linewidth=1.0)
    panel.set_xlabel("runs", fontsize=9)
    panel.tick_params(labelsize=8)
    _count_along(panel)
    panel.grid(alpha=0.3)


def _indices(panel: Any, sweep: Table, measure: str) -> None:
    """Bars of what each value does alone, and in all, with standard errors, if all runs have a value."""
    import numpy as np

    names = sweep.job.variations.names
    try:
        found = sobol_indices(sweep[measure], len(names), sweep.job.seed)
    except LagError as error:
        _say(panel, error.diagnostics[0].message.replace(": ", ":\n"))
        return
    for k, which in enumerate(("first", "total")):
        shares = [getattr(index, which) for index in found[:_MOST_VARIED]]
        panel.barh(np.arange(len(shares)) + 0.4 * k - 0.2, [share.value for share in shares], 0.36, color=f"C{k}", alpha=0.7,
                   xerr=[share.error for share in shares], error_kw={"linewidth": 1.0}, label=("first order", "total")[k])
    panel.set_yticks(range(len(found[:_MOST_VARIED])), [_literal(name) for name in names[:_MOST_VARIED]])
    panel.invert_yaxis()
    panel.set_xlabel("Sobol' indices", fontsize=9)
    panel.tick_params(labelsize=8)
    panel.legend(fontsize=8)
    panel.grid(alpha=0.3, axis="x")


def _parallel(figure: Any, panel: Any, sweep: Table, names: list[str], measure: str, units: dict[str, str]) -> None:
    """Each run a line across axes of what is varied, scaled from least to most; evenly chosen runs where there are many."""
    import numpy as np
    from matplotlib.collections import LineCollection

    runs = _evenly(sweep.runs, _MOST_LINES)
    axes = [*names, measure]
    table = np.stack([_values(sweep, name)[runs] for name in axes], axis=1)
    table = table[np.isfinite(table).all(axis=1)]
    if not len(table):
        return
    least, most = table.min(axis=0), table.max(axis=0)
    scaled = (table - least) / np.where(most > least, most - least, 1.0)
    places = np.arange(len(axes))
    lines = LineCollection([np.stack([places, row], axis=1) for row in scaled], array=table[:, -1], cmap="viridis",
                           linewidths=0.7, alpha=0.6)
    panel.add_collection(lines)
    figure.colorbar(lines, ax=panel, label=_literal(measure, units[measure]), pad=0.01)
    panel.set_xlim(-0.1, len(axes) - 0.9)
    panel.set_ylim(-0.05, 1.05)
    panel.set_xticks(places, [f"{_literal(name, units.get(name, ''))}\n{a:.4g} ... {b:.4g}"
                              for name, a, b in zip(axes, least, most, strict=True)], fontsize=8)
    panel.set_yticks([])
    for k in places:
        panel.axvline(k, color="black", linewidth=0.8)
