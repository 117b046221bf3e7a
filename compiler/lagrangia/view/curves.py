"""Panels as a picture; matplotlib is imported here and nowhere else in this room."""

import io
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

from lagrangia.base.diagnostics import fail
from lagrangia.base.result_files import Target
from lagrangia.run.scene import Column

if TYPE_CHECKING:
    import numpy as np

    from lagrangia.view.plots import Line, Panel

_FORMATS = (".png", ".svg", ".pdf", ".jpg", ".jpeg", ".webp")
_MOST_IN_LEGEND = 12
_DPI = 120
_LETTERS = 90  # a line of a title
_MARK = 0.05  # of a panel: ticks at events
_FAINTEST = 1e-5  # amplitude that a spectrum shows, of its largest
_NO_STYLE = ("backend", "backend_fallback", "interactive", "toolbar", "webagg", "tk", "macosx", "keymap", "animation")
_STYLES: dict[str, dict[str, Any]] = {
    "line": {"linewidth": 1.2},
    "dashed": {"linewidth": 1.2, "linestyle": (0, (5, 2))},
    "dots": {"linestyle": "none", "marker": "o", "markersize": 3.5, "markerfacecolor": "none"},
    "points": {"linestyle": "none", "marker": ".", "markersize": 4},
}


def require_format(path: str | os.PathLike[str]) -> None:
    """Raises LagError L0004 for a file whose name ends in no format of pictures."""
    if Path(path).suffix.lower() not in _FORMATS:
        fail("L0004", f"'{path}' is no picture that can be drawn", None, f"its name should end in {', '.join(_FORMATS)}")


@cache
def _figure_class() -> Any:
    from matplotlib.figure import Figure

    class Picture(Figure):  # type: ignore[misc] # matplotlib is not typed here
        """A figure that notebooks show, whether or not they were told of matplotlib."""

        def _repr_png_(self) -> bytes:
            content = io.BytesIO()
            self.savefig(content, dpi=_DPI, format="png")
            return content.getvalue()

    return Picture


def new_figure(width: float, height: float) -> Any:
    """A matplotlib Figure, in inches, that notebooks show."""
    return _figure_class()(figsize=(width, height), layout="constrained")


@contextmanager
def own_style() -> Iterator[None]:
    """Texts are names and descriptions, and no commands, and pictures look as everywhere, whatever a matplotlibrc in this folder
    or at home says; what was set in Python since is kept."""
    import matplotlib

    read, now = matplotlib.rcParamsOrig, matplotlib.rcParams
    usual = {name: value for name, value in matplotlib.rcParamsDefault.items()
             if name.partition(".")[0] not in _NO_STYLE and now[name] == read[name] != value}
    with matplotlib.rc_context({**usual, "text.usetex": False, "path.effects": []}):
        yield


def draw(title: str, time: "np.ndarray", curves: "Sequence[tuple[Column, np.ndarray]]",
         path: str | os.PathLike[str] | None = None) -> Any:
    """Quantities over time, one panel a unit, angles in degrees when the quantity is shown so; returns the matplotlib Figure.

    Raises LagError L0004 when the picture cannot be written.
    """
    from lagrangia.view.plots import Pair, Series, Wanted, build_picture

    columns = {column.name: column for column, _ in curves}
    values = {column.name: x for column, x in curves}
    wanted = Wanted(tuple(Pair("", name) for name in columns))
    return draw_panels(title, build_picture([Series("", time, values.get)], wanted, columns.__getitem__).panels, path)


@own_style()
def draw_panels(title: str, panels: "Sequence[Panel]", path: str | os.PathLike[str] | None = None) -> Any:
    """One below the other, those over time with one time axis; returns the matplotlib Figure. Raises LagError L0004."""
    if path is not None:
        require_format(path)
    heights = [2.4 if panel.is_wide else 4.2 for panel in panels] or [2.4]
    figure = new_figure(8, 1.2 + sum(heights))
    axes = figure.subplots(len(heights), 1, squeeze=False, height_ratios=heights)[:, 0]
    shared: dict[str, Any] = {}
    for k, (axis, panel) in enumerate(zip(axes, panels, strict=False)):
        _fill(axis, panel)
        if panel.is_wide:
            axis.sharex(shared.setdefault(panel.axis, axis)) if panel.axis in shared else shared.setdefault(panel.axis, axis)
        is_last = k + 1 == len(panels) or panels[k + 1].axis != panel.axis or panel.axis not in shared
        axis.set_xlabel(panel.x_label if is_last else "")
        axis.tick_params(labelbottom=is_last)
    axes[0].set_title(fill(title, _LETTERS), fontsize=11)  # matplotlib would wrap it as a formula between two dollars
    take_literally(figure)
    if path is not None:
        save(figure, Path(path))
    return figure


def _fill(axis: Any, panel: "Panel") -> None:
    if panel.marks:  # along the lower edge
        axis.vlines(panel.marks, 0, _MARK, transform=axis.get_xaxis_transform(), color="0.35", linewidth=0.7)
    for line in panel.lines:
        _draw_line(axis, line)
    axis.set_ylabel(panel.y_label)
    axis.grid(True, alpha=0.3)
    if panel.is_wide:
        axis.margins(x=0)
    if panel.largest > 0:
        axis.set_yscale("log")
        axis.set_ylim(_FAINTEST * panel.largest, 2 * panel.largest)
    if 1 < len(panel.lines) <= _MOST_IN_LEGEND:
        axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, fontsize=8)


def _draw_line(axis: Any, line: "Line") -> None:
    # a label that begins with _ is none to matplotlib: a space of no width before it keeps the name
    label = f"\u200b{line.label}" if line.label.startswith("_") else line.label
    axis.plot(line.x, line.y, label=label, color=f"C{line.rank % 10}", **_STYLES[line.kind])


def take_literally(figure: Any) -> None:
    """Titles and names are text: a dollar in them begins no formula. Numbers along axes are matplotlib's own."""
    for axis in figure.axes:
        legend = axis.get_legend()
        for text in (axis.title, axis.xaxis.label, axis.yaxis.label, *(legend.get_texts() if legend is not None else ())):
            text.set_parse_math(False)


def save(figure: Any, path: Path) -> None:
    """Writes beside the target first. Raises LagError L0004 when the picture cannot be written."""
    with Target(path, binary=True) as target:
        figure.savefig(target.stream, dpi=_DPI, format=path.suffix[1:].lower())
