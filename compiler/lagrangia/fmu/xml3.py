"""modelDescription.xml of FMI 3.0.2 (specification of 2024), and the files beside it; variables go by value reference, and
arrays are one."""

from collections.abc import Sequence

from lagrangia.fmu.elements import provides_elements
from lagrangia.fmu.entries import Entry, as_in_fmi3, entries, places
from lagrangia.fmu.factors import strongest
from lagrangia.fmu.variable import Variable
from lagrangia.fmu.variables import FmuModel
from lagrangia.fmu.xml import (
    LOG_CATEGORIES,
    About,
    dependencies,
    display_unit_of,
    element,
    experiment,
    initial_unknowns,
    known_when_running,
    naming,
    too_many,
    type_of,
    types,
    unit_definitions,
    unit_of,
)

_HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'


def write_fmi3(model: FmuModel, about: About) -> str:
    """modelDescription.xml of FMI 3."""
    scene, model = model.scene, as_in_fmi3(model)
    root = {"fmiVersion": "3.0", "modelName": scene.name, "instantiationToken": about.token,
            "description": scene.description or None, **about.info, "generationTool": about.tool,
            "generationDateAndTime": about.date, "variableNamingConvention": naming(model)}
    parts = [*_interfaces(about, provides_elements(model)), unit_definitions(model), _types(model),
             element("LogCategories", {}, *(element("Category", {"name": name, "description": text}, indent=2)
                                            for name, text in LOG_CATEGORIES.items())),
             element("DefaultExperiment", experiment(model)),
             element("ModelVariables", {}, *(_variable(model, entry) for entry in entries(model))), _structure(model)]
    return _HEAD + element("fmiModelDescription", root, *parts, indent=0) + "\n"


def _interfaces(about: About, has_elements: bool) -> list[str]:
    common: dict[str, object] = {
        "modelIdentifier": about.identifier, "needsExecutionTool": False, "canBeInstantiatedOnlyOncePerProcess": False,
        "canGetAndSetFMUState": True, "canSerializeFMUState": True, "providesDirectionalDerivatives": True,
        "providesAdjointDerivatives": True, "providesPerElementDependencies": has_elements}
    exchange = common | {"needsCompletedIntegratorStep": True, "providesEvaluateDiscreteStates": False}
    cosimulation = common | {
        "canHandleVariableCommunicationStepSize": True, "maxOutputDerivativeOrder": 1, "providesIntermediateUpdate": True,
        "mightReturnEarlyFromDoStep": True, "canReturnEarlyAfterIntermediateUpdate": True, "hasEventMode": True,
        "providesEvaluateDiscreteStates": False}
    found = []
    if "me" in about.kinds:
        found.append(element("ModelExchange", exchange))
    if "cs" in about.kinds:
        found.append(element("CoSimulation", cosimulation))
    return found


def _types(model: FmuModel) -> str:
    found = [element("Float64Type", {"name": name, "quantity": name, "unit": unit, "displayUnit": display}, indent=2)
             for name, unit, display in types(model)]
    return element("TypeDefinitions", {}, *found) if found else ""


def _variable(model: FmuModel, entry: Entry) -> str:
    variable = entry.variable
    kind = {"Real": "Float64", "Integer": "Int32"}.get(variable.kind, variable.kind)
    attributes: dict[str, object] = {
        "name": variable.name, "valueReference": variable.reference, "description": variable.description or None,
        "causality": variable.causality, "variability": variable.variability, "initial": variable.initial}
    if kind == "String":
        start = element("Start", {"value": variable.start}, indent=3)
        return element(kind, attributes, start, indent=2)
    if kind != "Float64":
        return element(kind, attributes | {"start": variable.start}, indent=2)
    of = entry.elements[0].derivative_of
    starts = [repr(float(v.start)) for v in entry.elements if v.start is not None]
    reinit = bool(model.scene.sizes["n_multipliers"]) if variable.group == "state" else None
    attributes |= {"declaredType": type_of(variable), "unit": unit_of(variable), "displayUnit": display_unit_of(variable),
                   "min": variable.minimum, "max": variable.maximum, "nominal": variable.nominal,
                   "start": " ".join(starts) or None,
                   "derivative": None if of is None else model.named(of).reference, "reinit": reinit or None}
    aliases = [element("Alias", {"name": alias}, indent=3) for alias in variable.aliases]
    dimensions = [element("Dimension", {"start": size}, indent=3) for size in entry.shape]
    return element(kind, attributes, *dimensions, *aliases, indent=2)


def _structure(model: FmuModel) -> str:
    outputs = [(v, known_when_running(model, v.name, True)) for v in model.of("output")]
    slopes = [(v, known_when_running(model, v.name, True)) for v in model.of("slope")]
    parts = [*_unknowns(model, "Output", outputs), *_unknowns(model, "ContinuousStateDerivative", slopes),
             *_unknowns(model, "InitialUnknown", initial_unknowns(model)),
             *(element("EventIndicator", {"valueReference": v.reference}, indent=2) for v in model.of("indicator"))]
    return element("ModelStructure", {}, *parts)


def _unknowns(model: FmuModel, name: str, rows: Sequence[tuple[Variable, dict[str, str]]]) -> list[str]:
    """An array depends on all that one of its elements does, in the strongest way that one does."""
    references, everything = places(model), too_many([knowns for _, knowns in rows])
    found: dict[int, dict[str, str]] = {}
    for variable, knowns in rows:
        own = found.setdefault(references[variable.name], {})
        for known, kind in knowns.items():
            whole = model.variables[references[known]].name
            own[whole] = strongest(kind, own.get(whole, kind))
    return [element(name, {"valueReference": reference, **({} if everything else dependencies(knowns, references))}, indent=2)
            for reference, knowns in found.items()]


def write_build_description(version: str, identifier: str, sources: Sequence[str]) -> str:
    """How to compile the sources: one library of C99. `version` "2" or "3" of the FMU; the file is FMI 3's in both."""
    files = [element("SourceFile", {"name": name}, indent=3) for name in sources]
    names = ["LAG_STATIC", *(["FMI3_OVERRIDE_FUNCTION_PREFIX"] if version == "3" else [])]
    definitions = [element("PreprocessorDefinition", {"name": name, "value": "1"}, indent=3) for name in names]
    libraries = element("Library", {"name": "m", "external": True}, indent=2)
    configuration = element("BuildConfiguration", {"modelIdentifier": identifier, "description": "C99, nothing but its library"},
                            element("SourceFileSet", {"language": "C99"}, *files, *definitions, indent=2), libraries)
    return _HEAD + element("fmiBuildDescription", {"fmiVersion": "3.0"}, configuration, indent=0) + "\n"
