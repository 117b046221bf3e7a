"""Starts that do not hold: what a run begins with in place of what was stated, in words."""

import math
from collections.abc import Iterator, Sequence

from lagrangia.base.records import dataclass
from lagrangia.run.interpret import evaluate
from lagrangia.run.request import Values
from lagrangia.run.scene import Column, Scene
from lagrangia.run.simulate import Progress

GUESS, FIXED, FREE, LOOSE = range(4)  # LAG_START_... of runtime/model/model.h
_MOVED = 1e-3  # less is taken for the rounding of a start value
_FAR = 0.16  # of it, or rad: loops are drawn roughly
_FAST, _DRIVEN = 1e6, 1e2  # times what was stated: rates near a dead point; where a place gave way to it
_ROUNDING = 1e-14  # m or rad
_TURNS = 4  # of all angles, in which arms are looked for


def moved_starts(scene: Scene, progress: Progress, values: Values, row: Sequence[float]) -> Iterator[str]:
    """Of the first `row` (t, q, v, y): starts that were stated and do not hold, and where no equation is of places, those that
    nobody stated and that moved."""
    if not (scene.sizes["n_initial"] and len(row) and row[0] == progress.experiment.start):
        return
    whole = evaluate(scene.tapes["start"], progress.parameters)
    guess = [part[: scene.n] for part in whole]
    kinds = [*scene.fixed[: scene.n], *scene.fixed[len(scene.fixed) // 2 :][: scene.n]]
    begun = row[1 : 1 + 2 * scene.n]
    stated = zip((*scene.coordinates, *scene.rates), kinds, [*guess[0], *guess[1]], (*values.q, *values.v), begun, strict=True)
    equations = _Equations(scene, progress.parameters, values, *_with_lost(scene, whole, row))
    arms, blocks = equations.arms(), equations.blocks()
    gave_way = set()
    for k, (column, kind, wanted, given, value) in enumerate(stated):
        if kind == GUESS and scene.notes["loops"]:
            least = _MOVED * equations.extent(k % scene.n, k >= scene.n, arms, blocks)
            moved = [*_moved(column, wanted, given, value, _FAR, least)]
            gave_way |= {k} if moved and k < scene.n else set()
            yield from moved
        elif kind == GUESS or (kind == FREE and k < scene.n and not scene.sizes["n_initial_positions"]):
            yield from _moved(column, wanted, given, value)
    prescribed, n_lost = equations.prescribed(), scene.sizes["n_lost"]
    rates = [wanted if math.isnan(given) else given
             for wanted, given in zip(whole[1], (*values.v, *(values.lost[n_lost:] or [math.nan] * n_lost)), strict=True)]
    for lines, block in blocks:
        most = max([*(arms[j] * abs(rates[j]) for j in block), *(prescribed[i] for i in lines)])
        yield from _driven(scene, block, arms, begun[scene.n :], most * (_DRIVEN if gave_way & {*block} else _FAST))
    if scene.notes["loops"]:
        return
    yield from _lost(scene, progress, values, row)
    yield from _balanced(scene, values, row)


def _moved(column: Column, wanted: float, given: float, value: float, part: float = _MOVED, least: float = 0.0) -> Iterator[str]:
    size = 1.0 if part == _FAR and column.unit == "rad" else max(abs(value), abs(wanted))
    if math.isnan(given) and abs(value - wanted) > max(part * size, least, _ROUNDING):
        yield (f"{column.name} begins at {quantity(value, column.unit)}, not at {quantity(wanted, column.unit)}: the "
               "equations ask for it")


def _driven(scene: Scene, block: Sequence[int], arms: Sequence[float], rates: Sequence[float], most: float) -> Iterator[str]:
    """Rates that others drive so near to a dead point that digits of the positions decide them."""
    driven = [f"{scene.rates[j].name} at {quantity(rates[j], scene.rates[j].unit)}" for j in block
              if j < scene.n and most and arms[j] * abs(rates[j]) > most]
    if driven:
        yield (f"near a dead point rates that are stated drive others: {', '.join(driven[:4])}; digits of the positions "
               "decide them, so begin at that point, or state these rates instead")


def _with_lost(scene: Scene, guess: Sequence[Sequence[float]], row: Sequence[float]) -> tuple[list[float], list[float]]:
    """Positions and rates with which a run begins; those of lost coordinates behind them, as stated where no row tells them."""
    told = {column.name: x for column, x in zip(scene.outputs, row[1 + 2 * scene.n :], strict=False)}
    n, n_lost = scene.n, scene.sizes["n_lost"]
    lost = [*guess[0][n:], *guess[1][n:]]
    for name, (k, _) in scene.lost.items():
        lost[k] = told.get(name, lost[k])
    return [*row[1 : 1 + n], *lost[:n_lost]], [*row[1 + n : 1 + 2 * n], *lost[n_lost:]]


@dataclass
class _Equations:
    """The initial equations where a run begins: which rates they bind to one another, and how strongly."""

    scene: Scene
    parameters: Sequence[float]
    values: Values
    q: Sequence[float]
    v: Sequence[float]

    def blocks(self) -> list[tuple[list[int], list[int]]]:
        """Equations of rates, and the rates that they bind."""
        blocks: list[tuple[list[int], list[int]]] = []
        for i, places in enumerate(self._pattern()):
            rates = {k - len(self.q) for k in places if k >= len(self.q)}
            if i < self.scene.sizes["n_initial_positions"] or not rates:
                continue
            met = [block for block in blocks if rates & {*block[1]}]
            blocks = [block for block in blocks if block not in met]
            blocks.append((sorted({i}.union(*(e for e, _ in met))), sorted(rates.union(*(r for _, r in met)))))
        return blocks

    def arms(self) -> list[float]:
        """What a unit of each rate adds to an equation at most, wherever parts are turned to: for angles, lengths of arms."""
        arms, n = [0.0] * len(self.q), len(self.q)
        slopes = [(k, i >= self.scene.sizes["n_initial_positions"]) for i, x in enumerate(self._pattern()) for k in x]
        is_angle = [c.unit == "rad" for c in self.scene.coordinates] + [False] * self.scene.sizes["n_lost"]
        for turn in range(_TURNS):
            _, found = self._at([x + turn * (1 + 0.37 * k) * is_angle[k] for k, x in enumerate(self.q)], self.v)
            for (k, is_of_rates), slope in zip(slopes, found, strict=False):  # nothing is behind those that are not 0
                if is_of_rates and k >= n and math.isfinite(slope):
                    arms[k - n] = max(arms[k - n], abs(slope))
        return arms

    def prescribed(self) -> list[float]:
        """What is left of each equation where all rates are 0: what time, or a number in it, asks for."""
        return [abs(x) if math.isfinite(x) else 0.0 for x in self._at(self.q, [0.0] * len(self.v))[0]]

    def extent(self, k: int, is_rate: bool, arms: Sequence[float], blocks: Sequence[tuple[list[int], list[int]]]) -> float:
        """How far the k-th place goes at most where what it is bound to turns by 1 rad; its rate, where that moves as it does."""
        block = next((block for _, block in blocks if k in block), [])
        if not block or not arms[k]:
            return 0.0
        is_turned = {j for j, c in enumerate(self.scene.coordinates) if c.unit == "rad" and not is_rate}
        begun = self.v if is_rate else self.q
        return max(arms[j] * (1.0 if j in is_turned else abs(begun[j])) for j in block) / arms[k]

    def _pattern(self) -> list[tuple[int, ...]]:
        """Of each equation, the values, q then v, of which it speaks."""
        found, m = self.scene.patterns["initial_pattern"], self.scene.sizes["n_initial"] + 1
        return [found[m + found[i] : m + found[i + 1]] for i in range(m - 1)]

    def _at(self, q: Sequence[float], v: Sequence[float]) -> list[list[float]]:
        tape = self.scene.tapes["initial"]
        inputs = [*self.values.input_values[: self.scene.sizes["n_inputs"]], *[0.0] * sum(tape.in_sizes[3:])]
        return evaluate(tape, *(q, v, self.parameters, inputs)[: len(tape.in_sizes)])


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
