"""modelDescription.xml of FMI 3.0.2 (specification of 2024), and the files beside it; variables go by value reference."""

from collections.abc import Sequence

from lagrangia.fmu.variables import FmuModel, Variable
from lagrangia.fmu.xml import (
    LOG_CATEGORIES,
    About,
    dependencies,
    display_unit_of,
    element,
    experiment,
    initial_unknowns,
    known_when_running,
    too_many,
    type_of,
    types,
    unit_definitions,
    unit_of,
)

_HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'


def write_fmi3(model: FmuModel, about: About) -> str:
    """modelDescription.xml of FMI 3."""
    scene = model.scene
    root = {"fmiVersion": "3.0", "modelName": scene.name, "instantiationToken": about.token,
            "description": scene.description or None, **about.info, "generationTool": about.tool,
            "generationDateAndTime": about.date, "variableNamingConvention": "structured"}
    parts = [*_interfaces(about), unit_definitions(model), _types(model),
             element("LogCategories", {}, *(element("Category", {"name": name, "description": text}, indent=2)
                                            for name, text in LOG_CATEGORIES.items())),
             element("DefaultExperiment", experiment(model)),
             element("ModelVariables", {}, *(_variable(model, v) for v in model.variables)), _structure(model)]
    return _HEAD + element("fmiModelDescription", root, *parts, indent=0) + "\n"


def _interfaces(about: About) -> list[str]:
    common: dict[str, object] = {
        "modelIdentifier": about.identifier, "needsExecutionTool": False, "canBeInstantiatedOnlyOncePerProcess": False,
        "canGetAndSetFMUState": True, "canSerializeFMUState": True, "providesDirectionalDerivatives": True,
        "providesAdjointDerivatives": True, "providesPerElementDependencies": False}
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


def _variable(model: FmuModel, variable: Variable) -> str:
    kind = {"Real": "Float64", "Integer": "Int32"}.get(variable.kind, variable.kind)
    attributes: dict[str, object] = {
        "name": variable.name, "valueReference": variable.reference, "description": variable.description or None,
        "causality": variable.causality, "variability": variable.variability, "initial": variable.initial}
    if kind == "String":
        start = element("Start", {"value": variable.start}, indent=3)
        return element(kind, attributes, start, indent=2)
    if kind != "Float64":
        return element(kind, attributes | {"start": variable.start}, indent=2)
    of, start_value = variable.derivative_of, variable.start
    reinit = bool(model.scene.sizes["n_multipliers"]) if variable.group == "state" else None
    attributes |= {"declaredType": type_of(variable), "unit": unit_of(variable), "displayUnit": display_unit_of(variable),
                   "min": variable.minimum, "max": variable.maximum, "nominal": variable.nominal,
                   "start": None if start_value is None else float(start_value),
                   "derivative": None if of is None else model.named(of).reference, "reinit": reinit or None}
    aliases = [element("Alias", {"name": alias}, indent=3) for alias in variable.aliases]
    return element(kind, attributes, *aliases, indent=2)


def _structure(model: FmuModel) -> str:
    outputs = [(v, known_when_running(model, v.name, True)) for v in model.of("output")]
    slopes = [(v, known_when_running(model, v.name, True)) for v in model.of("slope")]
    parts = [*_unknowns(model, "Output", outputs), *_unknowns(model, "ContinuousStateDerivative", slopes),
             *_unknowns(model, "InitialUnknown", initial_unknowns(model)),
             *(element("EventIndicator", {"valueReference": v.reference}, indent=2) for v in model.of("indicator"))]
    return element("ModelStructure", {}, *parts)


def _unknowns(model: FmuModel, name: str, rows: Sequence[tuple[Variable, dict[str, str]]]) -> list[str]:
    everything = too_many([knowns for _, knowns in rows])
    references = {variable.name: variable.reference for variable in model.variables}
    return [element(name, {"valueReference": variable.reference,
                           **({} if everything else dependencies(knowns, references))}, indent=2) for variable, knowns in rows]


def write_build_description(version: str, identifier: str, sources: Sequence[str]) -> str:
    """How to compile the sources: one library of C99. `version` "2" or "3" of the FMU; the file is FMI 3's in both."""
    files = [element("SourceFile", {"name": name}, indent=3) for name in sources]
    names = ["LAG_STATIC", *(["FMI3_OVERRIDE_FUNCTION_PREFIX"] if version == "3" else [])]
    definitions = [element("PreprocessorDefinition", {"name": name, "value": "1"}, indent=3) for name in names]
    libraries = element("Library", {"name": "m", "external": True}, indent=2)
    configuration = element("BuildConfiguration", {"modelIdentifier": identifier, "description": "C99, nothing but its library"},
                            element("SourceFileSet", {"language": "C99"}, *files, *definitions, indent=2), libraries)
    return _HEAD + element("fmiBuildDescription", {"fmiVersion": "3.0"}, configuration, indent=0) + "\n"
