"""A natural mode as a page or film: the scene swaying in its shape about the point, larger than life."""

import os
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from lagrangia.draw.animation import write_animation
from lagrangia.draw.drawing import Drawable, figures_of
from lagrangia.draw.film import require_film, save_reel
from lagrangia.draw.reel import build_reel
from lagrangia.draw.values import States
from lagrangia.run.input_pieces import held_at_first
from lagrangia.study.analysis import Study
from lagrangia.study.modes import Modes
from lagrangia.study.pictures import factor_of
from lagrangia.study.turned import Vector

_PERIODS, _MOMENTS = 4, 36  # that are shown, and moments of each
_NO_PERIOD = 1.0  # s, of what sways though it does not vibrate
_DIGITS = 14  # in which a place of one period is that of another


def animate_mode(model: Drawable, study: Study, modes: Modes, k: int, path: str | os.PathLike[str] | None = None) -> str:
    """Mode k (from 0) of a scene in the plane, A such that it is well seen: the text of the page; a path (.html, .svg, .gif,
    .webp, .mp4) is written as well. Raises LagError."""
    if path is not None:
        require_film(path)
    figures, mechanism = figures_of(model), study.mechanism
    assert mechanism is not None  # figures are refused where there is none
    t, states = swaying(study, modes, k, factor_of(mechanism, *point_and_shape(modes, k)))
    reel = replace(build_reel(model.compilation, figures, states, {}, ()), t=t)
    text = write_animation(reel, title_of(modes, k), (), ())
    if path is not None:
        save_reel(reel, text, Path(path))
    return text


def title_of(modes: Modes, k: int) -> str:
    """Of what shows one."""
    return f"{modes.name}, mode {k + 1}: {modes[k].title}"


def point_and_shape(modes: Modes, k: int) -> tuple[Vector, Vector]:
    """In all coordinates that are no discrete variables; attitudes are not turned at the point."""
    point = modes.linearization.point
    return (np.array([point.get(name, 0.0) for name in modes.coordinates]),
            np.array([modes[k].shape[name] for name in modes.coordinates]))


def swaying(study: Study, modes: Modes, k: int, factor: float) -> tuple[Vector, States]:
    """Times, and the moments of q = point + factor shape sin(omega t) with loops closed, attitudes by their quaternions."""
    q, shape = map(study.signals.spread, point_and_shape(modes, k))
    omega = modes[k].omega or 2 * np.pi / _NO_PERIOD
    t = np.linspace(0, _PERIODS * 2 * np.pi / omega, _PERIODS * _MOMENTS + 1)
    here = study.about_point(modes.linearization.point)

    @cache
    def at(side: float) -> tuple[Vector, Vector]:
        return here.turned.centred(here.closing(q + factor * shape * side), here.references)

    moved = [at(side) for side in np.sin(omega * t).round(_DIGITS).tolist()]  # each place of a period is met several times
    rates = factor * omega * np.outer(shape, np.cos(omega * t))
    given = [np.concatenate([study.u, attitudes.ravel(), held_at_first(study.scene, study.p.tolist())]) for _, attitudes in moved]
    return t, States(np.full((1, t.size), study.time), np.array([x for x, _ in moved]).T, rates, np.array(given).T,
                     study.p.reshape(-1, 1))
