"""Curves over time as a picture; matplotlib is imported here and nowhere else."""

import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lagrangia.base.diagnostics import fail
from lagrangia.base.result_files import Target
from lagrangia.run.scene import Column

if TYPE_CHECKING:
    import numpy as np

_DEGREE = 180.0 / math.pi
_FORMATS = (".png", ".svg", ".pdf", ".jpg", ".jpeg", ".webp")
_MOST_IN_LEGEND = 12


def require_format(path: str | os.PathLike[str]) -> None:
    """Raises LagError L0004 for a file whose name ends in no format of pictures."""
    if Path(path).suffix.lower() not in _FORMATS:
        fail("L0004", f"'{path}' is no picture that can be drawn", None, f"its name should end in {', '.join(_FORMATS)}")


def draw(title: str, time: "np.ndarray", curves: "Sequence[tuple[Column, np.ndarray]]",
         path: str | os.PathLike[str] | None = None) -> Any:
    """One panel a unit, angles in degrees when the quantity is shown so; returns the matplotlib Figure.

    Raises LagError L0004 when the picture cannot be written.
    """
    from matplotlib.figure import Figure

    if path is not None:
        require_format(path)
    panels: dict[str, list[tuple[Column, Any]]] = {}
    for column, values in curves:
        panels.setdefault(column.display_unit or column.unit, []).append((column, values))
    figure = Figure(figsize=(8, 1.2 + 2.4 * max(1, len(panels))), layout="constrained")
    axes = figure.subplots(max(1, len(panels)), 1, sharex=True, squeeze=False)[:, 0]
    for axis, (unit, members) in zip(axes, panels.items(), strict=False):
        for column, values in members:
            axis.plot(time, values * (_DEGREE if unit.startswith("deg") else 1.0), label=column.name, linewidth=1.2)
        axis.set_ylabel(f"{_what(members)} [{unit}]" if unit else _what(members))
        axis.grid(True, alpha=0.3)
        axis.margins(x=0)
        if 1 < len(members) <= _MOST_IN_LEGEND:
            axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    axes[-1].set_xlabel("time [s]")
    axes[0].set_title(title, fontsize=11, wrap=True)
    take_literally(figure)
    if path is not None:
        save(figure, Path(path))
    return figure


def take_literally(figure: Any) -> None:
    """Names are text: a dollar in them begins no formula."""
    from matplotlib.text import Text

    for text in figure.findobj(Text):
        text.set_parse_math(False)


def _what(members: list[tuple[Column, Any]]) -> str:
    return members[0][0].name if len(members) == 1 else ""


def save(figure: Any, path: Path) -> None:
    """Writes beside the target first. Raises LagError L0004 when the picture cannot be written."""
    with Target(path, binary=True) as target:
        figure.savefig(target.stream, dpi=120, format=path.suffix[1:].lower())
