"""Starts that do not hold: what a run begins with in place of what was stated, in words."""

import math
from collections.abc import Iterator, Sequence

from lagrangia.run.interpret import evaluate
from lagrangia.run.request import Values
from lagrangia.run.scene import Column, Scene
from lagrangia.run.simulate import Progress

GUESS, FIXED, FREE, LOOSE = range(4)  # LAG_START_... of runtime/model/model.h
_MOVED = 1e-3  # less is taken for the rounding of a start value
_FAR = 0.16  # of it, or rad: loops are drawn roughly
_FAST, _DRIVEN = 1e6, 1e2  # times what was stated: rates near a dead point; where a place gave way to it
_ROUNDING = 1e-14  # m or rad


def moved_starts(scene: Scene, progress: Progress, values: Values, row: Sequence[float]) -> Iterator[str]:
    """Of the first `row` (t, q, v, y): starts that were stated and do not hold, and where no equation is of places, those that
    nobody stated and that moved."""
    if not (scene.sizes["n_initial"] and len(row) and row[0] == progress.experiment.start):
        return
    guess = [part[: scene.n] for part in evaluate(scene.tapes["start"], progress.parameters)]
    kinds = [*scene.fixed[: scene.n], *scene.fixed[len(scene.fixed) // 2 :][: scene.n]]
    begun = row[1 : 1 + 2 * scene.n]
    stated = zip((*scene.coordinates, *scene.rates), kinds, [*guess[0], *guess[1]], (*values.q, *values.v), begun, strict=True)
    gave_way = False
    for k, (column, kind, wanted, given, value) in enumerate(stated):
        if kind == GUESS and scene.notes["loops"]:
            moved = [*_moved(column, wanted, given, value, _FAR)]
            gave_way |= bool(moved) and k < scene.n
            yield from moved
        elif kind == GUESS or (kind == FREE and k < scene.n and not scene.sizes["n_initial_positions"]):
            yield from _moved(column, wanted, given, value)
    yield from _driven(scene, guess[1], values, row, _DRIVEN if gave_way else _FAST)
    if scene.notes["loops"]:
        return
    yield from _lost(scene, progress, values, row)
    yield from _balanced(scene, values, row)


def _moved(column: Column, wanted: float, given: float, value: float, part: float = _MOVED) -> Iterator[str]:
    size = 1.0 if part == _FAR and column.unit == "rad" else max(abs(value), abs(wanted))
    if math.isnan(given) and abs(value - wanted) > max(part * size, _ROUNDING):
        yield (f"{column.name} begins at {quantity(value, column.unit)}, not at {quantity(wanted, column.unit)}: the "
               "equations ask for it")


def _driven(scene: Scene, guess: Sequence[float], values: Values, row: Sequence[float], most_driven: float) -> Iterator[str]:
    """Rates that others drive so near to a dead point that digits of the positions decide them."""
    stated = [wanted if math.isnan(given) else given for wanted, given in zip(guess, values.v, strict=True)]
    most = max(map(abs, stated), default=0.0)
    rates = zip(scene.rates, row[1 + scene.n : 1 + 2 * scene.n], strict=True)
    driven = [f"{x.name} at {quantity(value, x.unit)}" for x, value in rates if most and abs(value) > most_driven * most]
    if driven:
        yield (f"near a dead point rates that are stated drive others: {', '.join(driven[:4])}; digits of the positions "
               "decide them, so begin at that point, or state these rates instead")


def _lost(scene: Scene, progress: Progress, values: Values, row: Sequence[float]) -> Iterator[str]:
    """The same of coordinates that others give and that have starts of their own."""
    outputs = {column.name: k for k, column in enumerate(scene.outputs, 1 + 2 * scene.n)}
    guess = [x for part in evaluate(scene.tapes["start"], progress.parameters) for x in part[scene.n :]]
    for name, (k, _) in scene.lost.items():
        if name in outputs and _kind_of_lost(scene, k) == GUESS:
            yield from _moved(scene.outputs[outputs[name] - 1 - 2 * scene.n], guess[k], values.lost[k], row[outputs[name]])


def _kind_of_lost(scene: Scene, k: int) -> int:
    """How the start of the k-th of scene.lost is stated."""
    n_lost, half = scene.sizes["n_lost"], len(scene.fixed) // 2
    return scene.fixed[scene.n + k] if k < n_lost else scene.fixed[half + scene.n + k - n_lost]


def _balanced(scene: Scene, values: Values, row: Sequence[float]) -> Iterator[str]:
    """Places without mass where nobody stated one, if dampers hold back some of them: where these begin, the others follow."""
    balanced, kinds = {*scene.notes["balanced"]}, dict(zip((x.name for x in scene.coordinates), scene.fixed, strict=False))
    if all(name not in balanced or kind == LOOSE for name, kind in kinds.items()):
        return
    told = {x.name for x in scene.outputs} | {name for name, kind in kinds.items() if kind >= FREE}
    stated = {x.name for x, given in zip(scene.coordinates, values.q, strict=True) if not math.isnan(given)}
    stated |= {name for name, (k, _) in scene.lost.items()
               if _kind_of_lost(scene, k) in (GUESS, FIXED) or not math.isnan(values.lost[k])}
    for k, column in enumerate((*scene.coordinates, *scene.rates, *scene.outputs), 1):
        if column.name in (balanced & told) - stated and abs(row[k]) > _ROUNDING:
            yield f"{column.name} begins at {quantity(row[k], column.unit)}, where the forces on it are in balance"


def quantity(value: float, unit: str) -> str:
    """To four digits; angles from -180 to 180 degrees."""
    return f"{math.degrees(math.remainder(value, 2 * math.pi)):.4g} deg" if unit == "rad" else f"{value:.4g} {unit}"
