"""`lag modes --animate` of any scene: in space a page that is turned by hand, a film, or glTF."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np

from lagrangia.base.diagnostics import fail
from lagrangia.draw.drawing import Drawable, figures_of
from lagrangia.draw.modes_film import animate_mode, swaying, title_of
from lagrangia.draw.values import States
from lagrangia.solids.orbit import write_orbit
from lagrangia.solids.seen import build_stage
from lagrangia.solids.showing import View, is_in_space, require_any_of, save_stage
from lagrangia.solids.stage import Stage, matrices
from lagrangia.study.analysis import Study
from lagrangia.study.modes import Modes
from lagrangia.study.pictures import seen_well

_LITTLE = 1e-4


def animate_mode_of_any(model: Drawable, study: Study, modes: Modes, k: int, path: str | os.PathLike[str],
                        view: View | None = None) -> None:
    """Mode k (from 0), larger than life, written as the path's name ends. Raises LagError."""
    require_any_of(model, path, view)
    if not is_in_space(model):
        animate_mode(model, study, modes, k, path)
        return
    figures = figures_of(model)

    def stage_of(states: States) -> Stage:
        return build_stage(model.compilation, figures, states, {}, ())

    little = stage_of(swaying(study, modes, k, _LITTLE)[1])
    if not little.bodies and not little.lines:
        fail("L0706", "nothing in this scene has a drawing: `lag help drawing` says how to give it one")
    t, states = swaying(study, modes, k, _LITTLE * _factor(little))
    stage = replace(stage_of(states), t=t)
    save_stage(stage, write_orbit(stage, title_of(modes, k), (), ()), Path(path), view)


def _factor(little: Stage) -> float:
    """By how much what is seen may move further."""
    furthest, turned = 0.0, 0.0
    for points in (*(body.poses[:, None, :3] for body in little.bodies), *(line.points for line in little.lines)):
        furthest = max(furthest, float(np.nanmax(np.linalg.norm(points - points[0], axis=2), initial=0.0)))
    for body in little.bodies:
        turns = matrices(body.poses[:, 3:])
        turned = max(turned, float(np.linalg.norm(turns - turns[0], axis=(1, 2)).max(initial=0.0)) / np.sqrt(2))
    return seen_well(furthest, turned, float(np.linalg.norm(np.ptp(little.corners, axis=0))))
