"""A run, and what is shown beside it -> a picture."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lagrangia.base.diagnostics import fail
from lagrangia.base.tables import read_table
from lagrangia.language.units import parse_unit, spell
from lagrangia.run.scene import Column, Scene
from lagrangia.view.plots import Pair, Picture, Series, Wanted, build_picture, read_pair
from lagrangia.view.sight import Sight


def choose(scene: Scene, sight: Sight, names: Sequence[str], spectra: Sequence[str] = (),
           section: tuple[str, float] | None = None) -> Wanted:
    """What is shown: vectors by their elements; of nothing named, the coordinates over time, or a section's usual pair.

    Raises LagError: L0701 for unknown quantities, L0706 for what does not go together.
    """
    pairs: list[Pair] = []
    for text in names:
        pair = read_pair(text)
        elements = _columns(scene, sight, pair.y)
        if pair.x and (len(elements) > 1 or len(_columns(scene, sight, pair.x)) > 1):
            fail("L0706", f"'{text}' is of vectors", None, f"name elements: {elements[0].name}")
        pairs += [pair] if pair.x else [Pair("", column.name) for column in elements]
    lines = tuple(column.name for name in spectra for column in _columns(scene, sight, read_pair(name).y))
    if section is not None:
        if any(not pair.x for pair in pairs) or lines:
            fail("L0706", "a section shows one quantity against another", None, "name pairs: --plot-quantities \"theta:theta'\"")
        if len(_columns(scene, sight, section[0])) > 1:
            fail("L0706", f"'{section[0]}' is a vector", None, f"name an element: {sight.columns_of(section[0])[0].name}")
        return Wanted(tuple(pairs) or (_usual_pair(scene, section[0]),), (), section)
    if not pairs and not lines:
        pairs = [Pair("", column.name) for column in scene.moving]
    return Wanted(tuple(pairs), lines)


def _columns(scene: Scene, sight: Sight, name: str) -> tuple[Column, ...]:
    """The elements of a quantity. Raises LagError L0706 for small turns of an attitude, which say nothing of a run."""
    if name in scene.turned:
        whole = name.rpartition(".")[0]
        fail("L0706", f"'{name}' is a small turn, counted from where each step began: it says nothing of a run", None,
             f"name {whole}[1] to {whole}[4], the quaternion, or der({whole})[1] to der({whole})[3]")
    return sight.columns_of(name)


def _usual_pair(scene: Scene, crossed: str) -> Pair:
    """A coordinate that is not the one crossed, and its rate."""
    for coordinate, rate in zip(scene.coordinates, scene.rates, strict=True):
        if coordinate.name != crossed:
            return Pair(coordinate.name, rate.name)
    fail("L0706", "a section of this scene needs a pair to be shown", None, "name one: --plot-quantities \"theta:theta'\"")


def picture_of(run: Series, rows: np.ndarray, sight: Sight, wanted: Wanted, beside: Sequence[Series] = (),
               is_linear: bool = False) -> Picture:
    """The run, whose `rows` are (rows, width), with what is shown beside it.

    Raises LagError L0702 of a run without rows, L0706; RunError where there is no small motion."""
    if not len(rows):
        fail("L0702", "nothing was computed that could be shown")
    series = [run, *beside]
    if is_linear:
        series.append(Series("small motion", run.time, sight.small_motion(rows, wanted.names).get, is_linear=True))
    return build_picture(series, wanted, lambda name: sight.columns_of(name)[0])


def table_series(path: Path, sight: Sight, wanted: Wanted) -> Series:
    """A CSV file with a column `time` in s, and columns named as quantities are: in SI units, or as `bob.x [mm]` says.

    Raises LagError L0703 where it cannot be read, or has nothing that the picture shows.
    """
    times, columns = read_table(path)
    found: dict[str, Any] = {}
    for head, values in columns.items():
        name, space, unit = head.partition(" [")
        name = read_pair(name).y
        if name not in wanted.names:
            continue
        if name in found:
            fail("L0703", f"the table '{path}' has two columns '{name}'")
        factor, offset = _unit(path, head, unit, sight.columns_of(name)[0].unit) if space else (1.0, 0.0)
        found[name] = np.array(values) * factor + offset
    shown = [*({pair.names for pair in wanted.pairs}), *((name,) for name in wanted.spectra)]
    if not any(set(names) <= set(found) for names in shown) or (wanted.section and wanted.section[0] not in found):
        fail("L0703", f"the table '{path}' has nothing that the picture shows", None,
             f"the picture shows {', '.join(wanted.names)}; the table has {', '.join(columns) or 'the time alone'}")
    return Series(path.name, np.array(times), found.get, is_measured=True)


def _unit(path: Path, head: str, text: str, wanted: str) -> tuple[float, float]:
    try:
        unit = parse_unit(text.rstrip().removesuffix("]"))
    except ValueError as error:
        fail("L0703", f"{path}: the column '{head}': {error}")
    if unit.dimension != parse_unit(wanted or "1").dimension:
        told = f"the quantity in {wanted}" if wanted else "no unit of the quantity is declared"
        fail("L0703", f"{path}: the column '{head}' is in {spell(unit.dimension)}, but {told}")
    return unit.factor, unit.offset
