"""A natural mode as a page or film: the scene swaying in its shape about the point, larger than life."""

import os
from dataclasses import replace
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

_PERIODS, _MOMENTS = 4, 36  # that are shown, and moments of each
_NO_PERIOD = 1.0  # s, of what sways though it does not vibrate


def animate_mode(model: Drawable, study: Study, modes: Modes, k: int, path: str | os.PathLike[str] | None = None) -> str:
    """Mode k (from 0), q = point + A shape sin(omega t) with loops closed, A such that it is well seen: the text of the page; a
    path (.html, .svg, .gif, .webp, .mp4) is written as well. Raises LagError."""
    if path is not None:
        require_film(path)
    mode = modes[k]
    q = np.array([modes.linearization.point[name] for name in modes.coordinates])
    shape = np.array([mode.shape[name] for name in modes.coordinates])
    figures, mechanism = figures_of(model), study.mechanism
    assert mechanism is not None  # figures are refused where there is none
    factor = factor_of(mechanism, q, shape)
    omega = mode.omega or 2 * np.pi / _NO_PERIOD
    t = np.linspace(0, _PERIODS * 2 * np.pi / omega, _PERIODS * _MOMENTS + 1)
    positions = np.array([study.closing(q + factor * shape * side) for side in np.sin(omega * t)]).T
    rates = factor * omega * np.outer(shape, np.cos(omega * t))
    still = np.full((1, t.size), study.time)
    given = np.array([*study.u, *held_at_first(study.scene, study.p.tolist())])
    states = States(still, positions, rates, np.repeat(given.reshape(-1, 1), t.size, axis=1), study.p.reshape(-1, 1))
    reel = replace(build_reel(model.compilation, figures, states, {}, ()), t=t)
    text = write_animation(reel, f"{modes.name}, mode {k + 1}: {mode.title}", (), ())
    if path is not None:
        save_reel(reel, text, Path(path))
    return text
