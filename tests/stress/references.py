"""The references of the first random scenes, as they were computed once: references.json, of `python tests/stress/references.py`.

They take four times as long as all solvers of this repository. Each is kept with a digest of what its scene says, and is computed
anew where that has changed.
"""

import json
import sys
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path

import numpy as np

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).parents[1]))

from helpers.maximal import Motion, reference
from helpers.random_scenes import RandomScene, random_scene
from helpers.reference import Array

TIMES = (0.25, 0.5, 0.75, 1.0)
KEPT = 200
_FILE = Path(__file__).with_suffix(".json")
_MAX_STEP = 0.05  # s, of the reference: that no kink is met twice within a step
_NUDGE = 1e-7  # m/s, by which the start is changed to see what the motion magnifies


@dataclass(frozen=True)
class Expected:
    """Rows of what is picked at the first `count` TIMES, and how much larger an error is there than at the start, (count,)."""

    rows: Array
    count: int
    growth: Array


def expected(seed: int, scene: RandomScene) -> Expected:
    """As it is kept, or computed."""
    kept = _kept().get(str(seed))
    if kept is None or kept["of"] != _digest(scene):
        return compute(scene)
    count = len(kept["growth"])
    return Expected(np.array(kept["rows"], float).reshape(count, len(scene.picked)), count, np.array(kept["growth"], float))


def compute(scene: RandomScene) -> Expected:
    """By bodies in maximal coordinates."""
    right = reference(scene.system, scene.x0, scene.v0, TIMES, max_step=_MAX_STEP)
    return Expected(right.rows[: right.count, list(scene.picked)], right.count, _growth(scene, right))


def _growth(scene: RandomScene, right: Motion) -> Array:
    """How much larger an error is at each time than at the start; inf where the nudged motion goes another way."""
    random = np.random.default_rng(1)
    nudged = reference(scene.system, scene.x0, scene.v0 + _NUDGE * random.standard_normal(scene.v0.size), TIMES,
                       max_step=_MAX_STEP)
    apart = np.full(right.count, np.inf)
    count = min(right.count, nudged.count)
    apart[:count] = np.abs(nudged.rows[:count] - right.rows[:count]).max(axis=1) / _NUDGE
    if nudged.events != right.events:
        apart *= 10  # an event more or less: at a place where motions part
    return 1 + np.maximum.accumulate(apart)


def _digest(scene: RandomScene) -> str:
    return sha256(scene.text.encode() + scene.x0.tobytes() + scene.v0.tobytes() + repr(scene.picked).encode()).hexdigest()[:16]


@cache
def _kept() -> dict[str, dict]:
    return json.loads(_FILE.read_text(encoding="utf-8")) if _FILE.exists() else {}


def _written(seed: int) -> dict[str, object]:
    """What is kept already, or computed."""
    scene = random_scene(seed)
    found = expected(seed, scene)
    return {"of": _digest(scene), "rows": [[float(f"{x:.12g}") for x in row] for row in found.rows],
            "growth": [float(f"{x:.3g}") for x in found.growth]}


def write() -> None:
    """All that is to be kept, now and then on the way."""
    lines: dict[int, str] = {}
    for seed in range(KEPT):
        lines[seed] = json.dumps(_written(seed))
        if seed % 20 == 19:
            others = {int(k): json.dumps(v) for k, v in _kept().items() if int(k) not in lines}
            whole = sorted({**others, **lines}.items())
            _FILE.write_text("{" + ",\n".join(f'"{k}": {text}' for k, text in whole) + "}\n", encoding="utf-8")


if __name__ == "__main__":
    write()
