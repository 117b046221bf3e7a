"""`Model.draw`, `Trajectory.animate`, `lag draw` and `lag animate` of any scene: of the plane by draw/, in space by this room."""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from lagrangia.base.diagnostics import fail
from lagrangia.base.result_files import Target, write_text
from lagrangia.compile.pipeline import Compilation
from lagrangia.draw.drawing import (
    Drawable,
    draw_scene,
    figures_of,
    finished,
    moment_of,
    page_of,
    require_picture,
    states_of,
)
from lagrangia.draw.drive_train import names_elsewhere, with_train
from lagrangia.draw.film import (
    FORMATS,
    animate_run,
    curves_of,
    draw_stroboscope,
    energies_of,
    frames_of,
    require_film,
    require_traces,
    shown_by,
    thinned,
    with_events,
)
from lagrangia.draw.frames import save_frames
from lagrangia.draw.page import Page
from lagrangia.draw.picture import draw_page
from lagrangia.draw.values import States
from lagrangia.language.flat import Figure
from lagrangia.run.request import Request
from lagrangia.solids.camera import Camera, page_at, usual
from lagrangia.solids.gltf import write_gltf
from lagrangia.solids.orbit import write_orbit
from lagrangia.solids.seen import build_stage
from lagrangia.solids.stage import Stage
from lagrangia.view.trajectory import Trajectory

GLTF = ".glb"
Tell = Callable[[int, int], None]
View = tuple[float, float]  # azimuth and elevation, degrees


def is_in_space(model: Drawable) -> bool:
    """Whether a scene has three dimensions."""
    return model.compilation.flat.space.is_spatial


def draw_any(model: Drawable, path: str | os.PathLike[str] | None, request: Request, names: Mapping[str, str],
             tell: Callable[[str], None] | None = None, view: View | None = None) -> str:
    """The text of an SVG, at the request's last time; the file as well where a path is given. `view`: from where a scene in space
    is seen. Raises LagError; RunError where the motion ends before, of which the last moment is drawn."""
    if not is_in_space(model):
        _refuse_view(view)
        return draw_scene(model, path, request, names, tell)
    if path is not None:
        require_picture(path)
    model, states, failure = moment_of(model, request)
    elsewhere = names_elsewhere(model.compilation.flat, names)
    stage = build_stage(model.compilation, figures_of(model), states, elsewhere, ())
    page = page_at(stage, 0, camera_of(stage, view), model.scene.description or model.scene.name)
    page = with_train(page, model.compilation.flat, names)
    if tell is not None and not page.paths and not page.labels:
        tell("nothing in this scene has a drawing: `lag help drawing` says how to give it one")
    return finished(page, path, failure)


def page_any(model: Drawable, request: Request, names: Mapping[str, str]) -> Page:
    """The page of any scene at the request's last time, as draw_any writes it. Raises LagError, RunError."""
    if not is_in_space(model):
        return page_of(model, request, names)[0]
    model, states, _ = moment_of(model, request)
    elsewhere = names_elsewhere(model.compilation.flat, names)
    stage = build_stage(model.compilation, figures_of(model), states, elsewhere, ())
    return with_train(page_at(stage, 0, usual(stage.up)), model.compilation.flat, names)


def icon_of(c: Compilation, figures: Sequence[Figure], states: States) -> Page:
    """A picture without names of any scene at the first moment of `states`. Raises LagError."""
    if not c.flat.space.is_spatial:
        return draw_page(c, figures, states, {}, is_named=False)
    stage = build_stage(c, figures, states, {}, ())
    return page_at(replace(stage, captions=()), 0, usual(stage.up))


def camera_of(stage: Stage, view: View | None) -> Camera:
    """The usual one, or one that is asked for."""
    return usual(stage.up) if view is None else Camera(np.deg2rad(view[0]), np.deg2rad(view[1]), stage.up)


def animate_any(run: Trajectory, path: str | os.PathLike[str] | None = None, *, names: Mapping[str, str] | None = None,
                traces: Sequence[str] = (), quantities: Sequence[str] = (), tell: Tell | None = None,
                beside: Mapping[str, Trajectory] | None = None, note: Callable[[str], None] | None = None,
                view: View | None = None) -> str:
    """As draw.film.animate_run; of scenes in space, as .glb (glTF) as well. Raises LagError."""
    model = shown_by(run).model
    if not is_in_space(model):
        require_any_of(model, path, view)
        return animate_run(run, path, names=names, traces=traces, quantities=quantities, tell=tell, beside=beside, note=note)
    require_any_of(model, path, view)
    if beside:
        fail("L0901", "not supported yet: several runs in one picture of a scene in space", None, "animate them one by one")
    (whole,) = with_events([run])
    first = thinned(whole, frames_of([whole], note))
    stage = stage_of(first, names or {}, traces)
    text = write_orbit(stage, run.scene.description or run.scene.name, curves_of(first, quantities), energies_of(first),
                       whole.events)
    if path is not None:
        save_stage(stage, text, Path(path), view, tell)
    return text


def stage_of(run: Trajectory, names: Mapping[str, str], traces: Sequence[str]) -> Stage:
    """Of a run, as far as it went. Raises LagError: L0701 for traces of no frame, L0702 for a run without rows."""
    if not len(run.rows):
        fail("L0702", "nothing was computed that could be shown")
    shown = shown_by(run)
    require_traces(shown.model, traces)
    states = states_of(shown.model, run, shown.values)
    return build_stage(shown.model.compilation, figures_of(shown.model), states, names, traces)


def save_stage(stage: Stage, text: str, path: Path, view: View | None, tell: Tell | None = None) -> None:
    """The page whose text is given, glTF, or a film. Raises LagError L0004."""
    suffix = path.suffix.lower()
    if suffix == ".html":
        write_text(path, text)
    elif suffix == GLTF:
        with Target(path, binary=True) as target:
            target.stream.write(write_gltf(stage))
    else:
        save_frames(stage.t, partial(_picture, stage, camera_of(stage, view)), path, tell)


def _picture(stage: Stage, camera: Camera, moment: int) -> Page:
    return page_at(stage, moment, camera, whole=True)


def stroboscope_of_any(run: Trajectory, count: int, path: str | os.PathLike[str] | None, traces: Sequence[str] = ()) -> str:
    """As draw.film.draw_stroboscope. Raises LagError L0901 of scenes in space."""
    if is_in_space(shown_by(run).model):
        fail("L0901", "not supported yet: many positions of a scene in space in one picture", None,
             "lag draw --at T draws one, lag animate a page of all")
    return draw_stroboscope(run, count, path, traces)


def require_any(path: str | os.PathLike[str]) -> None:
    """Raises LagError for a file whose name ends in no format of animations of any scene."""
    if Path(path).suffix.lower() != GLTF:
        require_film(path)


def require_any_of(model: Drawable, path: str | os.PathLike[str] | None, view: View | None) -> None:
    """Raises LagError for a file, or a view, that there is not of animations of this scene."""
    if path is not None:
        require_any(path)
    if not is_in_space(model):
        _refuse_view(view)
        _refuse_gltf(path)
    elif path is not None and Path(path).suffix.lower() == ".svg":
        fail("L0901", "not supported yet: moving SVG of scenes in space", None, "of these there are .html, .glb, .gif, .mp4")


def _refuse_gltf(path: str | os.PathLike[str] | None) -> None:
    if path is not None and Path(path).suffix.lower() == GLTF:
        fail("L0004", f"'{path}' would be glTF, which is of scenes in space", None, f"of the plane there is {', '.join(FORMATS)}")


def _refuse_view(view: View | None) -> None:
    if view is not None:
        fail("L0706", "--view says from where a scene in space is seen; this one lies in the plane")
