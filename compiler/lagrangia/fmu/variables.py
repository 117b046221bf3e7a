"""A compiled scene -> what an FMU says about it: variables with their value references, and exact dependencies.

The groups of value references, and their order, are those of runtime/fmi/fmu.h.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property

from lagrangia.base.records import dataclass
from lagrangia.fmu.arrays import Array, even_nominals, find_arrays
from lagrangia.fmu.exportable import Exportable
from lagrangia.fmu.states import find_states, state_columns, state_kinds
from lagrangia.fmu.variable import Variable
from lagrangia.language.units import per_second
from lagrangia.native.tapes import Tape
from lagrangia.run.request import check_values
from lagrangia.run.scene import Scene

_CONSTANTS = ("real", "integer", "boolean", "string")
KEPT = ("kept_real", "kept_integer", "kept_boolean")  # discrete variables
GROUPS = ("time", "state", "slope", "output", "energy", "input", "parameter", "indicator", KEPT[0], *_CONSTANTS, *KEPT[1:])
_ENERGIES = {"kinetic": "kinetic energy", "potential": "potential energy", "total": "kinetic and potential energy",
             "dissipated": "taken out by dampers since the start", "work": "put in by loads and moving supports since the start",
             "residual": "of the energy account, which is 0 but for errors"}
_DRIFT_RATE = 100  # stabilisation: times in an experiment in which an error of constraints, of quaternions, falls to 1/e


@dataclass(frozen=True)
class FmuModel:
    """`dependencies` of outputs, derivatives and calculated parameters: the knowns of each, by name, and of what kind each is;
    `given` are the parameters (n_p,) of the FMU, `settable` those that an importer may set; `evaluations` of the right-hand side
    were made in one run over the experiment. FMI 3 has variables as `arrays` where it can."""

    scene: Scene
    variables: tuple[Variable, ...]
    arrays: tuple[Array, ...]
    dependencies: Mapping[str, Mapping[str, str]]
    given: tuple[float, ...]
    settable: tuple[bool, ...]
    state_start: tuple[float, ...]
    state_settable: tuple[bool, ...]
    nominal: tuple[float, ...]
    stabilisation: float
    evaluations: int
    forward: Tape
    adjoint: Tape

    @cached_property
    def index(self) -> dict[str, int]:
        """Places in the list of variables, from 1."""
        return {variable.name: k for k, variable in enumerate(self.variables, 1)}

    def of(self, *groups: str) -> tuple[Variable, ...]:
        """The variables of some groups, in their order."""
        return tuple(variable for variable in self.variables if variable.group in groups)

    def named(self, name: str) -> Variable:
        """The variable of that name. Raises KeyError."""
        return self.variables[self.index[name] - 1]


def build_fmu_model(model: Exportable, parameters: Mapping[str, float] | None = None) -> FmuModel:
    """Runs the scene over its experiment once, for nominal values. Raises LagError for parameters it does not have."""
    import numpy as np

    from lagrangia.dynamics.negative_inertia import refuse_negative_inertia
    from lagrangia.fmu.derivatives import build_derivatives

    scene = model.scene
    values = check_values(scene, parameters)
    given = tuple(float(x) for x in model.parameter_values(parameters))
    settable = tuple(not known.locked and (known.value is not None or bool(mask))
                     for known, mask in zip(scene.parameters, values.mask, strict=True))
    refuse_negative_inertia(model.compilation.kinematics, given)
    evaluations, start, nominal = find_states(model, parameters)
    length, attitudes = scene.stop - scene.start, scene.notes.get("attitudes", {})
    has_drift = scene.sizes["n_multipliers"] or attitudes
    stabilisation = _DRIFT_RATE / length if has_drift and length > 0 else 0.0
    outputs = tuple(column.name for column in scene.own_outputs)
    derivatives = build_derivatives(model.compilation, outputs, settable, stabilisation, given)
    kinds = state_kinds(model)
    names = _Names(scene)
    variables = tuple(_variables(scene, names, kinds, start, nominal, given, settable))
    arrays = find_arrays(variables, {*model.outputs})
    nominal = even_nominals(arrays, nominal, 1)
    variables = tuple(replace(v, nominal=nominal[v.reference - 1]) if v.group == "state" else v for v in variables)
    columns = _columns(names, variables)
    rows = [v.name for v in variables if v.group == "slope"] + [v.name for v in variables if v.group == "output"]
    whole = {v.name for v in variables if v.group == "output" and v.kind != "Real"}  # the standards have one kind for these
    dependencies = {row: {columns[k]: "dependent" if row in whole else kind for k, kind in found.items()}
                    for row, found in zip(rows, derivatives.rows, strict=True)}
    free = [p.name for p, is_free in zip(scene.parameters, settable, strict=True) if is_free]
    for parameter, found in zip(scene.parameters, derivatives.parameter_rows, strict=True):
        dependencies[parameter.name] = {free[k]: kind for k, kind in found.items()}
    return FmuModel(scene, variables, arrays, dependencies, given, settable, tuple(np.asarray(start, dtype=float).tolist()),
                    tuple(kind != "calculated" for kind in kinds), nominal, stabilisation, evaluations,
                    derivatives.forward, derivatives.adjoint)


class _Names:
    """Names of states and their derivatives. A rate takes the name its component gives it (hinge.w), so that der(hinge.phi) is
    free for the derivative."""

    def __init__(self, scene: Scene) -> None:
        told = state_columns(scene)
        n = len(told) - scene.n
        taken = {c.name for c in (*told, *scene.outputs)} | {p.name for p in (*scene.parameters, *scene.inputs)}
        taken |= {*scene.aliases, *scene.structural}
        others: dict[int, list[str]] = {}
        for alias, slot in scene.aliases.items():
            if alias not in {c.name for c in scene.outputs}:
                others.setdefault(slot, []).append(alias)
        self.states = [c.name for c in told[:n]]
        self.slopes = [f"der({c.name})" for c in told[:n]]
        self.aliases: dict[str, tuple[str, ...]] = {}
        attitudes = scene.notes.get("attitudes", {})
        parts = {part: f"{name}_rate[{k}]" for name, of in attitudes.items() for k, part in enumerate(of, 1)}
        for k, coordinate in enumerate(scene.coordinates):
            own = others.get(scene.n + k)
            first, *rest = own or [_free(parts.get(coordinate.name, f"{coordinate.name}_rate"), taken)]
            first = held_of(first) if own and coordinate.name in scene.kept else first
            self.states.append(first)
            self.aliases[first] = tuple(rest)
            self.slopes.append(f"der({first})" if own or coordinate.name in parts else f"der({coordinate.name},2)")
        heads = {name.partition(".")[0].partition("[")[0] for name in taken}
        self.energy, self.switch = _free("energy", heads), _free("switch", heads)


def held_of(name: str) -> str:
    """The continuous state at rest that a discrete variable is to solvers, which events set."""
    return f"{name}.held"


def _free(name: str, taken: set[str]) -> str:
    while name in taken:
        name += "_"
    return name


def _variables(scene: Scene, names: _Names, kinds: Sequence[str], start: Sequence[float], nominal: Sequence[float],
               given: Sequence[float], settable: Sequence[bool]) -> Iterator[Variable]:
    count = 0

    def reference() -> int:
        nonlocal count
        count += 1
        return count - 1

    yield Variable("time", "time", reference(), "independent", "continuous", unit="s", description="simulation time")
    columns = state_columns(scene)
    n = len(columns) - scene.n
    for k, column in enumerate(columns):
        text = column.description or ("" if k < n else f"rate of {_told_name(scene, k - n)}")
        if names.states[k] == held_of(column.name):
            text = f"what {column.name} is between events, to solvers"
        yield Variable(names.states[k], "state", reference(), "local", "continuous", kinds[k],
                       None if kinds[k] == "calculated" else start[k], column.unit, column.display_unit, text,
                       nominal=nominal[k], aliases=names.aliases.get(names.states[k], ()))
    for k, column in enumerate(columns):
        yield Variable(names.slopes[k], "slope", reference(), "local", "continuous", "calculated", None,
                       per_second(column.unit), per_second(column.display_unit) if column.display_unit else "",
                       f"derivative of {names.states[k]}", derivative_of=names.states[k])
    yield from _outputs(scene, reference)
    for part, text in _ENERGIES.items():
        yield Variable(f"{names.energy}.{part}", "energy", reference(), "local", "continuous", "calculated", None, "J", "", text)
    for given_input in scene.inputs:
        yield Variable(_structured(given_input.name), "input", reference(), "input", "continuous", None, given_input.value or 0.0,
                       given_input.unit, "", given_input.description, given_input.minimum, given_input.maximum)
    for known, value, is_free in zip(scene.parameters, given, settable, strict=True):
        causality = "parameter" if is_free else "calculatedParameter"
        yield Variable(known.name, "parameter", reference(), causality, "tunable", "exact" if is_free else "calculated",
                       value if is_free else None, known.unit, "", known.description, known.minimum, known.maximum)
    for k in range(1, 1 + scene.sizes["n_switches"]):
        yield Variable(f"{names.switch}[{k}]", "indicator", reference(), "local", "continuous", "calculated", None,
                       description="event indicator: forces bend or jump where it falls to 0")
    yield from _kept(scene, names, KEPT[:1], reference)
    yield from _constants(scene, reference)
    yield from _kept(scene, names, KEPT[1:], reference)


def _outputs(scene: Scene, reference: Callable[[], int]) -> Iterator[Variable]:
    """In their order; those that change at events alone are of their types."""
    types = scene.notes.get("stepwise", {})
    for column in scene.own_outputs:
        stepwise = types.get(column.name)
        unit = ("", "") if stepwise in ("Integer", "Boolean") else (column.unit, column.display_unit)
        yield Variable(column.name, "output", reference(), "output", "discrete" if stepwise else "continuous", "calculated", None,
                       *unit, column.description, type_name=stepwise or "")


def _kept(scene: Scene, names: _Names, groups: Sequence[str], reference: Callable[[], int]) -> Iterator[Variable]:
    """Discrete variables that are no outputs."""
    rates = dict(zip((c.name for c in scene.coordinates), scene.rates, strict=True))
    for group in groups:
        for coordinate, type_name in scene.notes.get("kept", {}).items():
            name, column = scene.signals[coordinate], rates[coordinate]
            if name in scene.discrete and group == f"kept_{type_name.lower()}" and held_of(name) in names.states:
                unit = (column.unit, column.display_unit) if type_name == "Real" else ("", "")
                yield Variable(name, group, reference(), "local", "discrete", "calculated", None, *unit, column.description)


def _told_name(scene: Scene, k: int) -> str:
    """Of the k-th coordinate, or of the attitude that it is a part of."""
    name = scene.coordinates[k].name
    return next((attitude for attitude, parts in scene.notes.get("attitudes", {}).items() if name in parts), name)


def _structured(name: str) -> str:
    """der(y,2), as FMI writes what is der(der(y)) here."""
    return f"der({name[8:-2]},2)" if name.startswith("der(der(") else name


def _constants(scene: Scene, reference: Callable[[], int]) -> Iterator[Variable]:
    groups = {name: _constant_group(value) for name, value in scene.structural.items()}
    for group in _CONSTANTS:
        for name in (name for name, found in groups.items() if found == group):
            yield Variable(name, group, reference(), "local", "constant", "exact", scene.structural[name],
                           description="structural: compiled in")


def _constant_group(value: float | bool | str) -> str:
    if isinstance(value, bool):
        return "boolean"
    if isinstance(value, str):
        return "string"
    return "integer" if isinstance(value, int) else "real"


def _columns(names: _Names, variables: Sequence[Variable]) -> list[str]:
    """The knowns of the derivatives, in the order of their functions' arguments."""
    inputs = [v.name for v in variables if v.group == "input"]
    parameters = [v.name for v in variables if v.group == "parameter"]
    return ["time", *names.states, *inputs, *parameters]
