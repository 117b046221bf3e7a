"""`Model.animate` and `lag animate`: a run, and the file that shows it move."""

import io
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lagrangia.base.diagnostics import fail, suggest
from lagrangia.base.result_files import Target, write_text
from lagrangia.draw.animation import Curve, write_animation
from lagrangia.draw.drawing import Drawable, figures_of, require_picture, save_page, states_of
from lagrangia.draw.page import Page, build_page, view_of
from lagrangia.draw.reel import Reel, build_reel, strokes_at
from lagrangia.draw.several import Beside, joined, labelled
from lagrangia.draw.strokes import ARROWS, Shape, Stroke
from lagrangia.draw.svg import write_svg
from lagrangia.run.request import Values
from lagrangia.view.trajectory import Trajectory

Vector = NDArray[np.float64]
FORMATS = (".html", ".gif", ".webp")
MOST_CURVES = 8
MOST_FRAMES = 3000  # of a page; longer runs show each so-manieth row
_FILM_FRAMES, _FILM_RATE = 150, 25.0  # pictures of a film, and how many a second
_FILM_DPI = 130
_DEGREE = 180.0 / np.pi


def require_film(path: str | os.PathLike[str]) -> None:
    """Raises LagError L0004, L0918 for a file whose name ends in no format of animations."""
    suffix = Path(path).suffix.lower()
    if suffix in (".mp4", ".svg"):
        fail("L0918", f"not supported yet: animations as {suffix[1:].upper()}", None, "write .html, .gif or .webp")
    if suffix not in FORMATS:
        fail("L0004", f"'{path}' is no animation that can be written", None, f"its name should end in {', '.join(FORMATS)}")


def reel_of(model: Drawable, run: Trajectory, values: Values, names: Mapping[str, str], traces: Sequence[str]) -> Reel:
    """The reel of a run, as far as it went. Raises LagError: L0701 for traces of no frame, L0702 for a run without rows."""
    if not len(run.rows):
        fail("L0702", "nothing was computed that could be shown")
    require_traces(model, traces)
    return build_reel(model.compilation, figures_of(model), states_of(model, run, values), names, traces)


def require_traces(model: Drawable, traces: Sequence[str]) -> None:
    """Raises LagError L0701 for what is no frame."""
    frames = model.compilation.flat.frames
    for name in traces:
        if name not in frames or name in model.compilation.graph.unused_frames:
            fail("L0701", f"there is no frame '{name}' to be traced", None, *filter(None, [suggest(name, frames)]))


def thinned(run: Trajectory, most: int) -> Trajectory:
    """At most so many rows, the last among them."""
    rows = run.rows
    if len(rows) <= most:
        return run
    kept = np.unique(np.linspace(0, len(rows) - 1, most).round().astype(int))
    return Trajectory(run.scene, rows[kept], run.progress, run.observe, run.show)


def animate_run(model: Drawable, run: Trajectory, values: Values, path: str | os.PathLike[str] | None = None, *,
                names: Mapping[str, str] | None = None, traces: Sequence[str] = (), quantities: Sequence[str] = (),
                tell: Callable[[int, int], None] | None = None, beside: Sequence[Beside] = ()) -> str:
    """The text of the page; with a path (.html, .gif, .webp) the file is written. `quantities` are the curves beside it, the
    coordinates by default; `tell` hears how many pictures of how many are made; `beside` are other runs in the same picture.
    Raises LagError."""
    if path is not None:
        require_film(path)
    shown = thinned(run, MOST_FRAMES)
    others = [(other, thinned(other.run, MOST_FRAMES)) for other in beside]
    reel = joined(reel_of(model, shown, values, names or {}, traces),
                  [reel_of(other.model, its, other.values, {}, traces) for other, its in others])
    curves = curves_of(shown, quantities)
    for other, its in others:
        curves += labelled(curves_of(its, quantities), other.label)
    text = write_animation(reel, run.scene.description or run.scene.name, curves, energies_of(shown))
    if path is None:
        return text
    target = Path(path)
    if target.suffix.lower() == ".html":
        write_text(target, text)
    else:
        save_film(reel, target, tell)
    return text


def curves_of(run: Trajectory, names: Sequence[str]) -> list[Curve]:
    """Quantities in the units they are shown in. Raises LagError L0701."""
    chosen = names or [column.name for column in (*run.scene.coordinates, *run.scene.outputs)][:MOST_CURVES]
    known = {column.name: column for column in run.columns}
    found = []
    for name in chosen:
        column = known.get(name)
        unit = (column.display_unit or column.unit) if column is not None else ""
        values = np.asarray(run[name], dtype=float)
        found += [Curve(name, unit, values * (_DEGREE if unit.startswith("deg") else 1.0))] if values.ndim == 1 else []
    return found


def energies_of(run: Trajectory) -> list[Curve]:
    """Kinetic and potential energy, and what was dissipated."""
    energy = run.energy
    found = [Curve("T", "J", energy.kinetic), Curve("V", "J", energy.potential)]
    return [*found, Curve("dissipated", "J", energy.dissipated)] if np.any(energy.dissipated != 0) else found


# -------------------------------------------------------------------- films and strobes


def frame_page(reel: Reel, moment: int) -> Page:
    """One picture of a film: all of them are as large."""
    corners = Stroke(np.array([reel.low, reel.high]), 0)
    view = view_of([corners], np.inf)
    return build_page([(Shape(strokes_at(reel, moment)), None)], view)


def save_film(reel: Reel, path: Path, tell: Callable[[int, int], None] | None) -> None:
    """A GIF or WebP; `tell` hears how many pictures of how many are made. Raises LagError L0004."""
    from PIL import Image

    from lagrangia.draw.paint import paint_page

    count = len(reel.t)
    kept = np.unique(np.linspace(0, count - 1, min(count, _FILM_FRAMES)).round().astype(int))
    images = []
    for k, moment in enumerate(kept):
        picture = io.BytesIO()
        paint_page(frame_page(reel, int(moment))).savefig(picture, dpi=_FILM_DPI, format="png", facecolor="white")
        images.append(Image.open(picture).convert("RGB" if path.suffix.lower() == ".webp" else "P"))
        if tell is not None:
            tell(k + 1, len(kept))
    length = float(reel.t[-1] - reel.t[0])
    each = 1000 * max(1 / _FILM_RATE, length / len(kept)) if length <= 30 else 1000 / _FILM_RATE  # ms; long runs are shown faster
    with Target(path, binary=True) as target:
        images[0].save(target.stream, format=path.suffix[1:].upper(), save_all=True, append_images=images[1:],
                       duration=round(each), loop=0)


def draw_stroboscope(model: Drawable, run: Trajectory, values: Values, count: int, path: str | os.PathLike[str] | None,
                     traces: Sequence[str] = ()) -> str:
    """So many positions in one picture, the first ones thin: the text of the SVG; the file too, where a path is given."""
    if path is not None:
        require_picture(path)
    reel = reel_of(model, thinned(run, MOST_FRAMES), values, {}, traces)
    moments = np.unique(np.linspace(0, len(reel.t) - 1, count).round().astype(int))
    shapes = []
    for moment in moments:
        is_last = moment == moments[-1]
        own = [stroke for stroke in strokes_at(reel, int(moment)) if stroke.layer != ARROWS]
        shapes.append((Shape([s if is_last else replace(s, line="thin", fill="none") for s in own]), None))
    ways = [points[np.isfinite(points).all(axis=1)] for _, points in reel.traces]
    shapes.append((Shape([Stroke(way, ARROWS, "dashed") for way in ways if len(way) > 1]), None))
    strokes = [stroke for shape, _ in shapes for stroke in shape.strokes]
    page = build_page(shapes, view_of(strokes, np.inf), run.scene.description or run.scene.name)
    text = write_svg(page)
    if path is not None:
        save_page(page, text, Path(path))
    return text
