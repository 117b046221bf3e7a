"""`Trajectory.animate` and `lag animate`: a run, and the file that shows it move."""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lagrangia.base.diagnostics import RunError, fail, suggest
from lagrangia.base.result_files import write_text
from lagrangia.draw.animation import Curve, write_animation
from lagrangia.draw.drawing import Drawable, figures_of, require_picture, save_page, states_of
from lagrangia.draw.drive_parts import parts_of
from lagrangia.draw.frames import save_frames
from lagrangia.draw.moving_svg import write_moving_svg
from lagrangia.draw.page import Page, build_page, view_of, weight_of
from lagrangia.draw.reel import Reel, build_reel, strokes_at, ways_until
from lagrangia.draw.several import joined, labelled
from lagrangia.draw.strokes import ARROWS, Shape, Stroke
from lagrangia.draw.svg import write_svg
from lagrangia.view.plots import scaled, shown_unit
from lagrangia.view.sight import Shown
from lagrangia.view.trajectory import Trajectory

Vector = NDArray[np.float64]
FORMATS = (".html", ".svg", ".gif", ".webp", ".mp4")
MOST_CURVES = 8
MOST_FRAMES = 3000  # of a page; longer runs show each so-manieth row
MOST_POSITIONS = 200  # of a stroboscope
_MOST_NUMBERS = 6_000_000  # of what moves, over all frames: some 40 MB of a page
_FEWEST_FRAMES = 60
_MOST_EVENTS = 300  # that get rows of their own
_HOW = "`lag help drawing` says how to give it one"
_QUICK = 10.0  # s: what took longer is not run again for them


def require_film(path: str | os.PathLike[str]) -> None:
    """Raises LagError L0004 for a file whose name ends in no format of animations, L0706 where what writes it is missing."""
    suffix = Path(path).suffix.lower()
    if suffix not in FORMATS:
        fail("L0004", f"'{path}' is no animation that can be written", None, f"its name should end in {', '.join(FORMATS)}")
    if suffix == ".mp4" and not find_spec("imageio_ffmpeg"):
        fail("L0706", "films as MP4 are written by ffmpeg, which was not found", None, "pip install imageio-ffmpeg brings it")


def reel_of(run: Trajectory, names: Mapping[str, str], traces: Sequence[str]) -> Reel:
    """The reel of a run, as far as it went. Raises LagError: L0701 for traces of no frame, L0702 for a run without rows."""
    if not len(run.rows):
        fail("L0702", "nothing was computed that could be shown")
    shown = shown_by(run)
    require_traces(shown.model, traces)
    states = states_of(shown.model, run, shown.values)
    return build_reel(shown.model.compilation, figures_of(shown.model), states, names, traces)


def shown_by(run: Trajectory) -> Shown:
    """What a run knows of its model. Raises LagError L0918 where it knows none."""
    if run.show is None:
        fail("L0918", "not supported yet: the animation of a run without its model", None, "animate what simulate returned")
    return run.show


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
    return replace(run, rows=rows[kept])


def animate_run(run: Trajectory, path: str | os.PathLike[str] | None = None, *, names: Mapping[str, str] | None = None,
                traces: Sequence[str] = (), quantities: Sequence[str] = (), tell: Callable[[int, int], None] | None = None,
                beside: Mapping[str, Trajectory] | None = None, note: Callable[[str], None] | None = None) -> str:
    """The text of the page; with a path (.html, .svg, .gif, .webp, .mp4) the file is written. `quantities` are the curves beside
    it, the coordinates by default; `tell` hears how many pictures of how many are made; `beside` are other runs in the same
    picture, `note` hears what is left out. Raises LagError."""
    if path is not None:
        require_film(path)
    labels = [*(beside or {})]
    whole = with_events([run, *(beside or {}).values()])
    most = frames_of(whole, note)
    first, *others = [thinned(one, most) for one in whole]
    reel = joined(reel_of(first, names or {}, traces), [reel_of(other, {}, traces) for other in others])
    curves = curves_of(first, quantities)
    if note is not None and not reel.strokes and not reel.captions:
        how = "`lag draw` shows its drive train" if parts_of(shown_by(run).model.compilation.flat) else _HOW
        note(f"nothing in this scene has a drawing that moves, so a page shows its curves alone: {how}")
    if note is not None and not quantities and len(usual := _usual(run)) > MOST_CURVES:
        note(f"{MOST_CURVES} of {len(usual)} curves are shown: --curves names others")
    for label, other in zip(labels, others, strict=True):
        curves += labelled(curves_of(other, quantities), label)
    text = write_animation(reel, run.scene.description or run.scene.name, curves, energies_of(first), whole[0].events)
    if path is not None:
        save_reel(reel, text, Path(path), tell)
    return text


def save_reel(reel: Reel, text: str, path: Path, tell: Callable[[int, int], None] | None = None) -> None:
    """The page whose text is given, or a film. Raises LagError L0004."""
    suffix = path.suffix.lower()
    if suffix == ".html":
        write_text(path, text)
    elif suffix == ".svg":
        write_text(path, write_moving_svg(reel))
    else:
        save_frames(reel.t, partial(_picture, reel), path, tell)


def _picture(reel: Reel, moment: int) -> Page:
    """One of a film: all of them are as large."""
    view = view_of([Stroke(np.array([reel.low, reel.high]), 0)], np.inf)
    ways = [Stroke(way, ARROWS, "thin") for way in ways_until(reel, moment)]
    return build_page([(Shape([*strokes_at(reel, moment), *ways]), None)], view, weight=weight_of(view.scale * reel.symbol))


def with_events(runs: list[Trajectory]) -> list[Trajectory]:
    """The same runs with rows at their events, too, where these are no more than can be told from each other."""
    times = runs[0].time
    if any(one.show is None or one.progress.seconds > _QUICK or not np.array_equal(one.time, times) for one in runs):
        return runs
    found = np.concatenate([one.events for one in runs])
    inside = found[(found > times[0]) & (found < times[-1])] if len(times) else found[:0]
    missing = np.setdiff1d(inside, times)
    return [_again(one, np.union1d(times, missing)) for one in runs] if 0 < len(missing) <= _MOST_EVENTS else runs


def _again(run: Trajectory, times: Vector) -> Trajectory:
    """A run with rows at other times, of which it has reached the last."""
    shown = shown_by(run)
    try:
        found: Trajectory = shown.model.run(replace(shown.request, at=times.tolist(), interval=None))
    except RunError as error:
        return error.trajectory if error.trajectory is not None and len(error.trajectory.rows) else run
    return found


def frames_of(runs: Sequence[Trajectory], note: Callable[[str], None] | None) -> int:
    """How many rows are shown: fewer of what is large, which is told."""
    moving = sum(3 * len(shown_by(run).model.compilation.flat.frames) for run in runs)
    most = max(_FEWEST_FRAMES, min(MOST_FRAMES, _MOST_NUMBERS // max(1, moving)))
    if len(runs[0].rows) > most and note is not None:
        note(f"{most} of {len(runs[0].rows)} rows are shown: all would make the file too large")
    if note is not None and (said := _turned_unseen(runs[0], most)):
        note(said)
    return most


def _turned_unseen(run: Trajectory, most: int) -> str:
    """That something turns by more than half a turn from one of so many pictures to the next, so that they show another turn."""
    count = min(len(run.rows), most)
    if count < 2:
        return ""
    apart = float(run.time[-1] - run.time[0]) / (count - 1)
    rates = [rate.name for rate in run.scene.rates if rate.unit == "rad/s" and rate.name not in run.scene.hidden]
    turns = {name: apart * float(np.abs(run[name]).max()) / (2 * np.pi) for name in rates}
    fastest = max(turns, key=lambda name: turns[name], default="")
    if not fastest or turns[fastest] <= 0.5:
        return ""
    return (f"{fastest} is up to {turns[fastest]:.3g} turns from one picture to the next, which do not tell how it turns: a "
            "smaller --interval or an earlier --stop does")


def curves_of(run: Trajectory, names: Sequence[str]) -> list[Curve]:
    """Quantities in the units they are shown in, vectors by their elements. Raises LagError L0701."""
    found = []
    for column in [column for name in names or _usual(run)[:MOST_CURVES] for column in run.columns_of(name)]:
        unit = shown_unit(column)
        found.append(Curve(column.name, "" if unit == "1" else unit, scaled(column, np.asarray(run[column.name], dtype=float))))
    return found


def _usual(run: Trajectory) -> list[str]:
    scene = run.scene
    return [*(column.name for column in scene.moving), *scene.signals.values(), *(column.name for column in scene.own_outputs)]


def energies_of(run: Trajectory) -> list[Curve]:
    """Kinetic and potential energy, and what was dissipated."""
    energy = run.energy
    found = [Curve("T", "J", energy.kinetic), Curve("V", "J", energy.potential)]
    return [*found, Curve("dissipated", "J", energy.dissipated)] if np.any(energy.dissipated != 0) else found


def draw_stroboscope(run: Trajectory, count: int, path: str | os.PathLike[str] | None, traces: Sequence[str] = ()) -> str:
    """So many positions in one picture, the first ones thin: the text of the SVG; the file too, where a path is given."""
    if path is not None:
        require_picture(path)
    reel = reel_of(thinned(run, MOST_FRAMES), {}, traces)
    moments = np.unique(np.linspace(0, len(reel.t) - 1, count).round().astype(int))
    shapes = []
    for moment in moments:
        is_last = moment == moments[-1]
        own = [stroke for stroke in strokes_at(reel, int(moment)) if stroke.layer != ARROWS]
        shapes.append((Shape([s if is_last else replace(s, line="thin", fill="none") for s in own]), None))
    ways = [points[np.isfinite(points).all(axis=1)] for _, points in reel.traces]
    shapes.append((Shape([Stroke(way, ARROWS, "dashed") for way in ways if len(way) > 1]), None))
    strokes = [stroke for shape, _ in shapes for stroke in shape.strokes]
    view = view_of(strokes, np.inf)
    page = build_page(shapes, view, run.scene.description or run.scene.name, weight_of(view.scale * reel.symbol))
    text = write_svg(page)
    if path is not None:
        save_page(page, text, Path(path))
    return text
