"""Pictures of mode shapes and frequency responses."""

import math
import os
from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lagrangia.base.records import dataclass
from lagrangia.frames.planar import ANGLES, LENGTHS
from lagrangia.view.curves import new_figure, own_style, require_format, save
from lagrangia.view.mechanism import Mechanism

Vector = NDArray[np.float64]
_MOST_DRAWN = 12
_DEFLECTION = 0.14  # of the scene's size
_COLUMNS = 3
_COILS, _COIL_WIDTH = 7, 0.03
_MOST_NAMES = 24
_MOST_INSIDE = 4  # curves, named in the panel itself
_MOST_MARKED, _APART = 30, 1.03  # resonances; ratio of two that are told from each other


@dataclass(frozen=True)
class Shapes:
    """Modes to be drawn: each a title and its shape (coordinates,), about the position `q` (coordinates,)."""

    name: str
    coordinates: tuple[str, ...]
    q: Vector
    shapes: tuple[tuple[str, Vector], ...]
    mechanism: Mechanism | None


@dataclass(frozen=True)
class Curves:
    """Responses to be drawn: frequencies in Hz; magnitude, and phase in degrees, (frequencies, outputs, inputs)."""

    name: str
    inputs: tuple[str, ...]
    labels: tuple[tuple[str, ...], ...]  # a pair, by output, then by input
    frequencies: Vector
    magnitude: Vector
    phase: Vector
    resonances: Mapping[tuple[int, int], tuple[float, ...]]  # Hz, by the places of output and input


@own_style()
def draw_modes(modes: Shapes, path: str | os.PathLike[str] | None = None, first: int = _MOST_DRAWN) -> Any:
    """A panel for each mode: the mechanism at rest and deflected, or bars of its coordinates; returns the matplotlib Figure.

    Raises LagError L0004 when the picture cannot be written.
    """
    if path is not None:
        require_format(path)
    shown, q = modes.shapes[:first], modes.q
    mechanism = modes.mechanism if modes.mechanism is not None and modes.mechanism.is_drawable(q) else None
    columns = max(1, min(_COLUMNS, len(shown)))
    rows = max(1, math.ceil(len(shown) / columns))
    figure = new_figure(1.0 + 3.4 * columns, 0.6 + 3.1 * rows)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for panel in panels[len(shown) :]:
        panel.set_visible(False)
    for k, (panel, (title, shape)) in enumerate(zip(panels, shown, strict=False)):
        if mechanism is not None:
            _draw_deflected(panel, mechanism, q, shape)
        else:
            _draw_bars(panel, modes.coordinates, shape)
        panel.set_title(f"{k + 1}: {title}", fontsize=10)
    more = f" (the first {len(shown)} of {len(modes.shapes)})" if len(shown) < len(modes.shapes) else ""
    figure.suptitle(f"{modes.name}: modes{more}", fontsize=11)
    if path is not None:
        save(figure, Path(path))
    return figure


def _draw_bars(panel: Any, coordinates: tuple[str, ...], values: Vector) -> None:
    places = np.arange(len(values))
    panel.axhline(0.0, color="0.6", linewidth=0.8)
    if len(values) <= _MOST_NAMES:
        panel.bar(places, values, width=0.6, color=["C0" if x >= 0 else "C3" for x in values])
        panel.set_xticks(places, coordinates, rotation=90 if len(values) > 3 else 0, fontsize=8)
        panel.set_xlim(min(-0.6, -1.6 + 0.5 * len(values)), max(len(values) - 0.4, 0.6 + 0.5 * len(values)))
    else:
        panel.plot(places + 1, values, color="C0", linewidth=1.2)
        panel.set_xlabel("coordinate", fontsize=8)
    reach = 1.1 * float(np.abs(values).max(initial=0.0)) or 1.0
    panel.set_ylim(-reach, reach)
    panel.tick_params(axis="y", labelsize=8)
    panel.grid(True, axis="y", alpha=0.3)


def _draw_deflected(panel: Any, mechanism: Mechanism, q: Vector, shape: Vector) -> None:
    """At rest in grey, deflected to one side in colour and to the other lightly."""
    factor = factor_of(mechanism, q, shape)
    size = mechanism.size(q)
    for place, style in ((q, {"color": "0.7", "zorder": 1}), (q - factor * shape, {"color": "C0", "alpha": 0.35, "zorder": 2}),
                         (q + factor * shape, {"color": "C0", "zorder": 3})):
        _draw(panel, mechanism, mechanism.places(place), size, style)
    panel.set_aspect("equal", adjustable="datalim")
    panel.margins(0.08)
    panel.tick_params(labelsize=7)
    panel.set_xlabel("x [m]", fontsize=7)
    panel.set_ylabel("y [m]", fontsize=7)
    panel.grid(True, alpha=0.2)


def factor_of(mechanism: Mechanism, q: Vector, shape: Vector) -> float:
    """Such that no frame moves further than a part of the scene's size, and nothing turns by more than half a radian."""
    small = 1e-4
    moved = (mechanism.places(q + small * shape) - mechanism.places(q)) / small
    furthest = float(np.linalg.norm(moved[:, LENGTHS], axis=1).max(initial=0.0))
    turned = float(np.abs(moved[:, ANGLES]).max(initial=0.0))
    return seen_well(furthest, turned, mechanism.size(q))


def seen_well(furthest: float, turned: float, size: float) -> float:
    """How many times a motion is shown that moves what is seen so far, m, turns it so far, rad, in a scene so large, m."""
    limits = [_DEFLECTION * size / furthest if furthest > 0 else math.inf, 0.5 / turned if turned > 0 else math.inf]
    return min(limits) if math.isfinite(min(limits)) else 0.0


def _draw(panel: Any, mechanism: Mechanism, places: Vector, size: float, style: dict[str, Any]) -> None:
    for a, b in mechanism.springs:
        panel.plot(*_coil(places[a, LENGTHS], places[b, LENGTHS], _COIL_WIDTH * size), linewidth=0.9, **style)
    for a, b in mechanism.bodies:
        panel.plot(places[[a, b], 0], places[[a, b], 1], linewidth=2.2, solid_capstyle="round", **style)
    for frame, radius in mechanism.discs:
        x, y, phi = places[frame]
        around = np.linspace(0.0, 2 * np.pi, 49)
        panel.plot(x + radius * np.cos(around), y + radius * np.sin(around), linewidth=1.6, **style)
        panel.plot([x, x + radius * math.cos(phi)], [y, y + radius * math.sin(phi)], linewidth=1.0, **style)
    points = list(mechanism.points)
    panel.plot(places[points, 0], places[points, 1], linestyle="none", marker="o", markersize=4, **style)


def _coil(a: Vector, b: Vector, width: float) -> tuple[Vector, Vector]:
    """A zigzag from a to b."""
    along = b - a
    length = float(np.linalg.norm(along))
    if length == 0:
        return np.array([a[0]]), np.array([a[1]])
    across = np.array([-along[1], along[0]]) / length
    parts = np.concatenate([[0.0, 0.15], np.linspace(0.2, 0.8, 2 * _COILS), [0.85, 1.0]])
    sides = np.concatenate([[0.0, 0.0], width * np.resize([1.0, -1.0], 2 * _COILS), [0.0, 0.0]])
    points = a + parts[:, None] * along + sides[:, None] * across
    return points[:, 0], points[:, 1]


@own_style()
def draw_bode(response: Curves, path: str | os.PathLike[str] | None = None) -> Any:
    """Magnitude and phase over frequency, a column for each input; returns the matplotlib Figure. Raises LagError L0004."""
    if path is not None:
        require_format(path)
    count = max(1, len(response.inputs))
    figure = new_figure(1.2 + 6.2 * count, 6.2)
    panels = figure.subplots(2, count, sharex=True, squeeze=False, height_ratios=[3, 2])
    phase = response.phase
    for i, j in product(range(len(response.labels)), range(len(response.inputs))):
        curve = response.magnitude[:, i, j]
        usable = np.where(np.isfinite(curve) & (curve > 0), curve, np.nan)
        panels[0, j].loglog(response.frequencies, usable, label=response.labels[i][j], linewidth=1.3)
        panels[1, j].semilogx(response.frequencies, phase[:, i, j] + 0.0, linewidth=1.3)
        panels[0, j].set_title(f"from {response.inputs[j]}", fontsize=10)
    for j in range(count):
        panels[0, j].set_ylabel("magnitude")
        panels[1, j].set_ylabel("phase [deg]")
        panels[1, j].set_xlabel("frequency [Hz]")
        panels[1, j].yaxis.set_major_locator(_quarter_turns(phase[:, :, j] if phase.size else phase))
        for panel in panels[:, j]:
            panel.grid(True, which="both", alpha=0.2)
            panel.margins(x=0)
        _mark(panels[:, j], sorted(x for (_, of), peaks in response.resonances.items() if of == j for x in peaks))
        if len(response.labels) <= _MOST_INSIDE:
            panels[0, j].legend(frameon=False, fontsize=8)
    if len(response.labels) > _MOST_INSIDE:
        panels[0, -1].legend(frameon=False, fontsize=8, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    figure.suptitle(f"{response.name}: frequency response", fontsize=11)
    if path is not None:
        save(figure, Path(path))
    return figure


def _mark(panels: Any, resonances: Sequence[float]) -> None:
    """Lines through magnitude and phase; one of several that are nearly the same."""
    before = 0.0
    for frequency in resonances[:_MOST_MARKED]:
        if frequency < _APART * before:
            continue
        for panel in panels:
            panel.axvline(frequency, color="0.4", linewidth=0.8, linestyle=":")
        panels[0].annotate(f"{frequency:.4g} Hz", (frequency, 0.0), xycoords=("data", "axes fraction"), xytext=(2, 4),
                           textcoords="offset points", rotation=90, fontsize=7, color="0.3", va="bottom")
        before = frequency


def _quarter_turns(phase: Vector) -> Any:
    from matplotlib.ticker import MultipleLocator

    spread = float(np.ptp(phase[np.isfinite(phase)])) if np.isfinite(phase).any() else 0.0
    return MultipleLocator(45 * max(1, math.ceil(spread / 360)))
