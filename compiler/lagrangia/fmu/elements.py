"""What each number of an array depends on, as lists by value reference for fmi3GetVariableDependencies: fmu.h."""

from collections.abc import Mapping

from lagrangia.fmu.entries import as_in_fmi3
from lagrangia.fmu.factors import CONSTANT, DEPENDENT, TUNABLE
from lagrangia.fmu.variables import FmuModel
from lagrangia.fmu.xml import initial_unknowns, known_when_running

_MOST = 50_000  # dependencies; in a file they take some 16 bytes each
_RUNNING = ("known_first", "knowns", "known_kinds")
_STARTING = ("start_first", "starts", "start_kinds")
_KINDS = {CONSTANT: 1, TUNABLE: 3, DEPENDENT: 5}  # fmi3DependencyKind


def provides_elements(model: FmuModel) -> bool:
    """Whether these lists are there: where there are arrays, and where they are no burden, since the description says it of whole
    arrays anyway."""
    return bool(model.arrays) and sum(map(len, model.dependencies.values())) <= _MOST


def element_lists(model: FmuModel) -> Mapping[str, list[int]]:
    """By the names of the members of LagFmu; empty where nobody needs them."""
    if not provides_elements(model):
        return {name: [] for name in (*_RUNNING, *_STARTING)}
    uniform = as_in_fmi3(model)
    running = {v.name: known_when_running(uniform, v.name, True) for v in uniform.of("slope", "output")}
    running |= {v.name: dict(uniform.dependencies[v.name]) for v in uniform.of("parameter") if v.causality != "parameter"}
    starting = {v.name: knowns for v, knowns in initial_unknowns(uniform)}
    return {**_lists(uniform, running, _RUNNING),
            **_lists(uniform, starting, _STARTING)}


def _lists(model: FmuModel, rows: Mapping[str, Mapping[str, str]], names: tuple[str, str, str]) -> dict[str, list[int]]:
    first, knowns, kinds = [0], [], []
    for variable in model.variables:
        row = {model.named(name).reference: _KINDS[kind] for name, kind in rows.get(variable.name, {}).items()}
        knowns += sorted(row)
        kinds += [row[reference] for reference in sorted(row)]
        first.append(len(knowns))
    return dict(zip(names, (first, knowns, kinds), strict=True))
