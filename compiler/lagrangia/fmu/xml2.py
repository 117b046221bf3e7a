"""modelDescription.xml of FMI 2.0.5 (specification of 2024): variables are counted from 1, in the order of their list."""

from collections.abc import Iterator, Sequence

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


def write_fmi2(model: FmuModel, about: About) -> str:
    """modelDescription.xml of FMI 2."""
    scene = model.scene
    root = {"fmiVersion": "2.0", "modelName": scene.name, "guid": about.token, "description": scene.description or None,
            **about.info, "generationTool": about.tool, "generationDateAndTime": about.date,
            "variableNamingConvention": naming(model), "numberOfEventIndicators": len(model.of("indicator"))}
    variables = [element("ScalarVariable", attributes, value, indent=2) for attributes, value in _variables(model)]
    parts = [*_interfaces(about), unit_definitions(model), _types(model),
             element("LogCategories", {}, *(element("Category", {"name": name, "description": text}, indent=2)
                                            for name, text in LOG_CATEGORIES.items())),
             element("DefaultExperiment", experiment(model)), element("ModelVariables", {}, *variables), _structure(model)]
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + element("fmiModelDescription", root, *parts, indent=0) + "\n"


def _interfaces(about: About) -> list[str]:
    files = element("SourceFiles", {}, *(element("File", {"name": name}, indent=3) for name in about.sources), indent=2)
    common: dict[str, object] = {
        "modelIdentifier": about.identifier, "needsExecutionTool": False, "canBeInstantiatedOnlyOncePerProcess": False,
        "canNotUseMemoryManagementFunctions": True, "canGetAndSetFMUstate": True, "canSerializeFMUstate": True,
        "providesDirectionalDerivative": True}
    exchange = common | {"completedIntegratorStepNotNeeded": False}
    cosimulation = common | {"canHandleVariableCommunicationStepSize": True, "canInterpolateInputs": True,
                             "maxOutputDerivativeOrder": 1, "canRunAsynchronuously": False}
    found = []
    if "me" in about.kinds:
        found.append(element("ModelExchange", exchange, files if about.sources else ""))
    if "cs" in about.kinds:
        found.append(element("CoSimulation", cosimulation, files if about.sources else ""))
    return found


def _types(model: FmuModel) -> str:
    reals = {name: element("Real", {"quantity": name, "unit": unit, "displayUnit": display}, indent=3)
             for name, unit, display in types(model)}
    found = [element("SimpleType", {"name": name}, real, indent=2) for name, real in reals.items()]
    return element("TypeDefinitions", {}, *found) if found else ""


def _variables(model: FmuModel) -> Iterator[tuple[dict[str, object], str]]:
    """In the order of FmuModel.variables; other names of a variable come after all of them."""
    for variable in model.variables:
        yield _scalar(variable, variable.name, variable.initial), _value(model, variable)
    for variable in model.variables:
        for alias in variable.aliases:
            attributes = {"unit": unit_of(variable), "displayUnit": display_unit_of(variable)}
            yield _scalar(variable, alias, None), element("Real", attributes, indent=3)


def _scalar(variable: Variable, name: str, initial: str | None) -> dict[str, object]:
    return {"name": name, "valueReference": variable.reference, "description": variable.description or None,
            "causality": variable.causality, "variability": variable.variability, "initial": initial}


def _value(model: FmuModel, variable: Variable) -> str:
    start = variable.start
    if variable.kind != "Real":
        return element(variable.kind, {"start": start}, indent=3)
    of = variable.derivative_of
    reinit = bool(model.scene.sizes["n_multipliers"]) if variable.group == "state" else None
    attributes = {"declaredType": type_of(variable), "unit": unit_of(variable), "displayUnit": display_unit_of(variable),
                  "min": variable.minimum, "max": variable.maximum, "nominal": variable.nominal,
                  "start": None if start is None else float(start), "derivative": None if of is None else model.index[of],
                  "reinit": reinit or None}
    return element("Real", attributes, indent=3)


def _structure(model: FmuModel) -> str:
    outputs = [(v, known_when_running(model, v.name, False)) for v in model.of("output")]
    slopes = [(v, known_when_running(model, v.name, False)) for v in model.of("slope")]
    parts = [_unknowns(model, name, rows) for name, rows in (("Outputs", outputs), ("Derivatives", slopes),
                                                             ("InitialUnknowns", initial_unknowns(model)))]
    return element("ModelStructure", {}, *parts)


def _unknowns(model: FmuModel, name: str, rows: Sequence[tuple[Variable, dict[str, str]]]) -> str:
    everything = too_many([knowns for _, knowns in rows])
    found = [element("Unknown", {"index": model.index[variable.name],
                                 **({} if everything else dependencies(knowns, model.index))}, indent=3)
             for variable, knowns in rows]
    return element(name, {}, *found, indent=2) if found else ""
