"""The references of the first random scenes, as they were computed once: references.json, of `python tests/stress/references.py`.

They take four times as long as all solvers of this repository. Each is kept with a digest of what its scene says, and is computed
anew where that has changed.
"""

import json
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path

import numpy as np

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))

from helpers.maximal import Motion, reference
from helpers.random_scenes import RandomScene, drawn, random_scene
from helpers.reference import Array

TIMES = (0.25, 0.5, 0.75, 1.0)
DRAWS = 5
LONG = 26  # 90 s in its reference, and long in its runs
KEPT = tuple(seed for seed in range(41) if seed != LONG)  # of DRAWS draws each
_FILE = Path(__file__).with_suffix(".json")
_MAX_STEP = 0.05  # s, of the reference: that no kink is met twice within a step
_NUDGE = 1e-7  # m (rad) and m/s (rad/s), by which the start is changed to see what the motion magnifies


@dataclass(frozen=True)
class Expected:
    """Rows of what is picked at the first `count` TIMES, and how much larger an error is there than at the start, (count,)."""

    rows: Array
    count: int
    growth: Array


def expected(seed: int, draw: int, scene: RandomScene) -> Expected:
    """As it is kept, or computed."""
    kept = _kept().get(f"{seed}.{draw}")
    if kept is None or kept["of"] != _digest(scene):
        return compute(scene)
    count = len(kept["growth"])
    return Expected(np.array(kept["rows"], float).reshape(count, len(scene.picked)), count, np.array(kept["growth"], float))


def compute(scene: RandomScene) -> Expected:
    """By bodies in maximal coordinates."""
    right = reference(scene.system, scene.x0, scene.v0, TIMES, max_step=_MAX_STEP)
    return Expected(right.rows[: right.count, list(scene.picked)], right.count, _growth(scene, right))


def _growth(scene: RandomScene, right: Motion) -> Array:
    """How much larger an error is at each time than at the start; inf where the nudged motion goes another way.

    Places are nudged as well: a light mass on a taut rope goes across by the root of what the rope is too long, 10^4 times an
    error of it. Kept are growths of nudged rates alone, which are smaller.
    """
    rates, places = _NUDGE * np.random.default_rng(1).standard_normal((2, scene.v0.size))
    nudged = reference(scene.system, scene.x0 + places, scene.v0 + rates, TIMES, max_step=_MAX_STEP)
    apart = np.full(right.count, np.inf)
    count = min(right.count, nudged.count)
    apart[:count] = np.abs(nudged.rows[:count] - right.rows[:count]).max(axis=1) / _NUDGE
    if nudged.events != right.events:
        apart *= 10  # an event more or less: at a place where motions part
    return 1 + np.maximum.accumulate(apart)


def _digest(scene: RandomScene) -> str:
    said = scene.text + repr(scene.picked) + repr(sorted(scene.parameters.items()))
    return sha256(said.encode() + scene.x0.tobytes() + scene.v0.tobytes()).hexdigest()[:16]


@cache
def _kept() -> dict[str, dict]:
    return json.loads(_FILE.read_text(encoding="utf-8")) if _FILE.exists() else {}


def _written(place: tuple[int, int]) -> str:
    """What is kept already, or computed."""
    seed, draw = place
    scene = drawn(random_scene(seed), seed, draw)
    found = expected(seed, draw, scene)
    rows = [[float(f"{x:.12g}") for x in row] for row in found.rows]
    return json.dumps({"of": _digest(scene), "rows": rows, "growth": [float(f"{x:.3g}") for x in found.growth]})


def write() -> None:
    """All that is to be kept."""
    places = [(seed, draw) for seed in KEPT for draw in range(DRAWS)]
    with ProcessPoolExecutor() as pool:
        lines = [f'"{seed}.{draw}": {text}' for (seed, draw), text in zip(places, pool.map(_written, places), strict=True)]
    _FILE.write_text("{" + ",\n".join(lines) + "}\n", encoding="utf-8")


if __name__ == "__main__":
    write()
