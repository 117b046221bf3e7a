"""What every solver says of a random scene, held against the reference in maximal coordinates.

A run is right, refused (it ends with a sentence), or wrong: rows further from the reference than the tolerance explains, rods and
hinges that are open, an energy account that is open, rows that another solver contradicts at the same tolerance. Wrong is
what must not be.
"""

import tempfile
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from os import cpu_count
from pathlib import Path

import numpy as np

import lagrangia as lag
from helpers.random_scenes import RandomScene, drawn, random_scene
from helpers.reference import Array
from lagrangia.base.diagnostics import RunError
from lagrangia.run.solvers import AUTO, applicable
from stress.references import TIMES, Expected, expected

TOLERANCES = (1e-3, 1e-6, 1e-9, 1e-12)
_MOST_STEPS = 100_000
_EXPLAINED = 300.0  # tolerances, for each size that an error at the start grows to
_REFERENCE = 1e-9  # what the reference itself may err by, likewise
_APART = 1e-9  # m, of rods and hinges
_ROUNDING = 2e-15  # of each size, times the ratio of the masses: what a row of rods makes of a last digit
_OPEN = {("rods", "adams")}  # between masses far apart Adams' methods err by up to a thousand tolerances; auto does not take them


@dataclass(frozen=True)
class Verdict:
    scene: str  # its seed and draw
    family: str
    solver: str
    tolerance: float
    word: str  # "right", "refused", "wrong"
    figure: float  # the error in what is explained; below 1 where it is right
    said: str = ""

    def __str__(self) -> str:
        return f"{self.scene} {self.family} {self.solver} {self.tolerance:g}: {self.word} ({self.figure:.2g}) {self.said}"


def look_at(seed: int, draws: int = 1) -> list[Verdict]:
    """The verdicts on all solvers that can run the scene, in each of its draws: but for the first, at every other tolerance."""
    scene = random_scene(seed)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.lag"
        path.write_text(scene.text, encoding="utf-8")
        model = lag.Model(path, outputs=scene.columns)
        model.native = False
        solvers = [AUTO, *applicable(model.scene)]
        solvers = [name for name in solvers if (scene.family, name) not in _OPEN or not scene.is_uneven]
        return [x for draw in range(draws) for x in _of_draw(model, drawn(scene, seed, draw), solvers, seed, draw)]


def _of_draw(model: lag.Model, scene: RandomScene, solvers: list[str], seed: int, draw: int) -> list[Verdict]:
    right, name = expected(seed, draw, scene), f"{seed}.{draw}"
    tolerances = TOLERANCES if draw == 0 else TOLERANCES[draw % 2 :: 2]
    return [x for tolerance in tolerances for x in _together(model, scene, right, solvers, tolerance, name)]


def _together(model: lag.Model, scene: RandomScene, right: Expected, solvers: list[str], tolerance: float, name: str
              ) -> list[Verdict]:
    """All at one tolerance: each is held against the reference, and against the first."""
    judged = [_judge(model, scene, right, solver, tolerance, name) for solver in solvers]
    first = next((rows for _, rows in judged if rows is not None), np.zeros((0, 0)))
    size, known = max(1.0, float(np.abs(first).max(initial=0.0))), slice(right.count)
    bound = 2 * (_EXPLAINED * tolerance + _ROUNDING * _unevenness(scene)) * size * right.growth

    def compared(verdict: Verdict, rows: Array | None) -> Verdict:
        apart = 0.0 if rows is None else _largest(np.abs(rows - first).max(axis=1)[known] / bound)
        return replace(verdict, word="wrong", figure=apart, said="another solver") if apart > 1 else verdict

    return [compared(verdict, rows) if verdict.word == "right" else verdict for verdict, rows in judged]


def _unevenness(scene: RandomScene) -> float:
    """The ratio of masses that are far apart."""
    return max(scene.system.m) / min(scene.system.m) if scene.is_uneven else 0.0


def _judge(model: lag.Model, scene: RandomScene, right: Expected, solver: str, tolerance: float, name: str
           ) -> tuple[Verdict, Array | None]:
    """With the rows of a run that was not refused."""
    try:
        run = model.simulate(at=[0.0, *TIMES], tolerance=tolerance, solver=solver, max_steps=_MOST_STEPS,
                             parameters=scene.parameters)
    except RunError as error:
        return Verdict(name, scene.family, solver, tolerance, "refused", 0.0, str(error).splitlines()[0][:160]), None
    got = np.array([run[name] for name in scene.columns]).T[1:]
    if run.statistics.energy_is_open:
        return Verdict(name, scene.family, solver, tolerance, "refused", 0.0, run.warnings[0]), None
    count, rows, growth = right.count, right.rows, right.growth
    bound = _EXPLAINED * tolerance + _REFERENCE + _ROUNDING * _unevenness(scene)
    size = max(1.0, float(np.abs(rows).max(initial=0.0)))
    figures = {"rows": _largest(np.abs(got[:count] - rows).max(axis=1) / (size * growth * bound))}
    state = np.zeros((len(got), len(scene.x0)))
    state[:, list(scene.picked)] = got
    opened = [np.abs(tie.residual(x)).max() / (_APART * size) for x in state for tie in scene.system.ties]
    figures["ties"] = _largest(np.array(opened))
    account = run.energy
    stored = max(1e-3, float(np.ptp(account.kinetic)), float(np.ptp(account.potential)), float(np.abs(account.work).max()))
    figures["account"] = _largest(np.abs(account.residual[: count + 1]) / (stored * bound * (growth[-1] if count else np.inf)))
    worst = max(figures, key=lambda name: figures[name])
    word = "wrong" if figures[worst] > 1 else "right"
    return Verdict(name, scene.family, solver, tolerance, word, figures[worst], f"{worst}; {'; '.join(run.warnings)}"), got


def _largest(values: Array) -> float:
    return float(np.nan_to_num(values, nan=np.inf, posinf=np.inf).max(initial=0.0))


def look_at_all(seeds: Iterable[int], draws: int = 1) -> list[Verdict]:
    """On all cores."""
    with ProcessPoolExecutor(cpu_count()) as pool:
        return [verdict for verdicts in pool.map(partial(look_at, draws=draws), seeds, chunksize=4) for verdict in verdicts]
