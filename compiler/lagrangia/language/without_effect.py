"""What people write and what changes nothing: annotations and attributes that nobody knows, `each` for one, empty sections,
frames that are joined already, resets to what is there, structural numbers and imports that nothing uses."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import fields, is_dataclass
from functools import lru_cache
from typing import Any

from lagrangia.base.diagnostics import Report, Span
from lagrangia.language.attributes import NEVER_READ
from lagrangia.language.classes import ClassTable
from lagrangia.language.discrete_arrays import variables_of
from lagrangia.language.flat import FlatModel, Reset
from lagrangia.language.idle import expressions_of
from lagrangia.language.idle_branches import find_idle_branches
from lagrangia.language.instances import Instance, Slot
from lagrangia.language.mentions import nodes, reached
from lagrangia.language.never import find_never
from lagrangia.language.overwritten import find_overwritten
from lagrangia.language.spaces import ANNOTATION
from lagrangia.language.syntax_parts import fields_of
from lagrangia.language.tree import (
    Argument,
    Assignment,
    Boolean,
    Call,
    ClassDefinition,
    Declaration,
    Extends,
    Flat,
    ForBlock,
    FrameRef,
    IfBlock,
    ImportFile,
    Number,
    Range,
    Reference,
    Results,
    Syntax,
    WhileBlock,
)
from lagrangia.language.unread import inside
from lagrangia.language.zero_factors import find_zero_factors

CODE = "L0224"
_MOST_CLASSES = 20_000
_MOST_ELEMENTS = 50_000
_OF_MODELS = ("experiment", "allow")
_OF_PARAMETERS = ("Evaluate", "Varying", ANNOTATION)
_PLACES = ((_OF_MODELS, "on a line of its own in a model"), (_OF_PARAMETERS, "behind a parameter"))
# Of Modelica's annotations, those for people and their editors; a vendor's own begin with two underscores.
_FOR_PEOPLE = frozenset("""absoluteValue choices choicesAllMatching conversion dateModified defaultComponentName
    defaultComponentPrefixes Diagram DiagramMap Dialog Documentation DocumentationClass DynamicSelect Figure Figures HideResult
    Icon IconMap Inline InlineAfterIndexReduction LateInline License Line mayOnlyConnectOnce missingInnerMessage mustBeConnected
    obsolete Placement preferredView Protection revisionId smoothOrder TestCase Text unassignedMessage uses version versionBuild
    versionDate""".split())
_OF_FUNCTIONS = {"derivative": "functions are differentiated exactly", "inverse": "equations are solved as they stand",
                 "GenerateEvents": "branches of functions are found where they change"}
# Attributes that change nothing where a kind of variable has them; "" stands for every kind.
_IDLE = {"": NEVER_READ, "parameter": ("start", "fixed"), "coordinate": ("min", "max"),
         "variable": ("min", "max"), "input": ("fixed",), "held": ("min", "max", "fixed")}
_IDLE_ANYWHERE = frozenset().union(*_IDLE.values())
_IDLE_IN_FUNCTIONS = _IDLE_ANYWHERE | {"displayUnit"}
_WHY = {"min": "limits are those of parameters and inputs", "max": "limits are those of parameters and inputs",
        "start": "a parameter has its value alone", "fixed": "it is for coordinates and their rates"}


def find_without_effect(model: FlatModel, root: Instance, table: ClassTable) -> Report:
    """A warning for each, in the classes of people's own that the model is made of."""
    report = Report()
    instances = [root, *inside(root)]
    definitions = {(c.span.source.name, c.span.start): c  # of which there may be copies (variants.py)
                   for instance in instances for c in table.lineage(instance.definition)}
    own = [c for c in definitions.values() if c.name_span.source not in table.library_sources]
    for definition in own:
        _look_at_class(definition, report)
        for element in definition.elements:
            _look_at_each(element, report)
    _look_at_attributes(instances, model, table, report)
    _look_at_inner(instances, table, report)
    _look_at_parameters(own, table, {id(c) for c in table.lineage(root.definition)}, report)
    for literal in (x for c in table.user.values() for x in c.literals):
        _look_at_annotation(literal.annotation, (), report)
    called = dict.fromkeys(name.partition("(")[0] for name in model.functions)
    functions = [table.user[name] for name in called if name in table.user]
    _look_at_functions(functions, report)
    _look_at_joints(model, table, report)
    for when in model.whens:
        for reset in when.resets:
            if _is_idle(reset) and reset.span.source not in table.library_sources:
                what = f"'{reset.rate.span.text}'" if reset.is_kept else "a rate"
                report.warning(CODE, f"this sets {what} to what it is: nothing happens", reset.span, "give another value")
    find_never(model, report, CODE)
    find_zero_factors([*own, *functions], report, CODE)
    find_idle_branches([*own, *functions], report, CODE)
    if any("virtual" in source.text for source in {c.name_span.source for c in own}):
        _look_at_virtual(model, table, report)
    return report


def find_idle_words(syntax: Syntax, files: Sequence[tuple[ImportFile, Sequence[Syntax]]]) -> Report:
    """Annotations of a file's statements that nobody knows; and of the files that it imports, each with all that it brings, those
    of which nothing is mentioned; likewise of names."""
    report, mentioned, seen = Report(), set(_words(syntax.classes)), set[int]()
    _look_at_annotation(syntax.annotations, (), report)
    for item, brought in files:
        if id(brought[0]) in seen:
            report.warning(CODE, f"'{item.path}' is imported already", item.span, "leave it out")
        elif not any(c.name in mentioned for file in brought for c in file.classes):
            report.warning(CODE, f"nothing uses '{item.path}'", item.span, "leave it out")
        seen.add(id(brought[0]))
    for named in (*syntax.named, *(item for c in _all_classes(syntax.classes) for item in c.imports)):
        _look_at_annotation(named.annotation, (), report)
        for short, _ in named.names:
            if short != "*" and short not in mentioned:
                report.warning(CODE, f"nothing uses '{short}'", named.span, "leave it out")
    for definition in (c for c in _all_classes(syntax.classes) if c.imports):
        own = {element.name for element in definition.elements if isinstance(element, Declaration)}
        for named in definition.imports:
            for short in own.intersection(short for short, _ in named.names):
                report.warning(CODE, f"nothing uses this '{short}': {definition.name} has one of its own", named.span,
                               f"leave it out, or give it another name: import x = {dict(named.names)[short]}")
    return report


def _all_classes(classes: Iterable[ClassDefinition]) -> Iterator[ClassDefinition]:
    for definition in classes:
        yield definition
        yield from _all_classes(definition.classes)


def _look_at_virtual(model: FlatModel, table: ClassTable, report: Report) -> None:
    """virtual(x) where no equation reads it."""
    bindings = {name: v.binding for name, v in model.variables.items()}
    sides = [side for equation in model.constraints for side in (equation.left, equation.right)]
    read = {node.span for node in reached(sides, bindings) if isinstance(node, Call) and node.function == "virtual"}
    states = [state.rate for state in model.states.values()]
    for node in nodes(*expressions_of(model), *states):
        if isinstance(node, Call) and node.function == "virtual" and node.span not in read:
            read.add(node.span)
            if node.span.source not in table.library_sources:
                report.warning(CODE, "virtual(x) is 0 here, and changes nothing", node.span,
                               "in an equation between positions it says where the force acts that holds them")


# -------------------------------------------------------------------- classes


def _look_at_class(definition: ClassDefinition, report: Report) -> None:
    _look_at_annotation(definition.annotation, _OF_MODELS, report)
    for element in definition.elements:
        if isinstance(element, Declaration):
            known = _OF_PARAMETERS if "parameter" in element.prefixes else ()
            _look_at_annotation(element.annotation, known, report)
            if "output" in element.prefixes and (what := element.prefixes & {"parameter", "constant", "coordinate"}):
                report.warning(CODE, f"'output' has no effect on a {min(what)}", element.name_span,
                               "it is known as it is" if "coordinate" not in what else "it has a column as it is")
            if "output" in element.prefixes and (hidden := [x for x in element.annotation if x.name == "HideResult"]):
                report.warning(CODE, "the annotation 'HideResult' has no effect", hidden[0].name_span,
                               "results are what is output, or --outputs names")
            if "discrete" in element.prefixes and element.binding is not None:
                report.warning(CODE, "'discrete' has no effect", element.name_span, "a variable follows from what it is bound to")
    for section in definition.sections:
        if not section.clauses and section.kind != "drawing":  # which takes the place of an inherited one
            report.warning(CODE, "this section is empty", section.span, "leave it out")
        _look_at_blocks(section.clauses, report)


def _look_at_annotation(annotation: Iterable[Argument], known: Sequence[str], report: Report) -> None:
    for argument in annotation:
        if argument.name in known or argument.name in _FOR_PEOPLE or argument.name.startswith("__"):
            continue
        hints = [f"it belongs {where}" for names, where in _PLACES if argument.name in names]
        report.warning(CODE, f"the annotation '{argument.name}' has no effect here", argument.name_span, *hints)


def _look_at_blocks(clauses: Iterable[Any], report: Report) -> None:
    for clause in clauses:
        if isinstance(clause, ForBlock | IfBlock):
            parts = (clause.body,) if isinstance(clause, ForBlock) else (clause.then, clause.otherwise)
            if not any(parts):
                report.warning(CODE, "nothing stands in this block", clause.span, "leave it out")
            if isinstance(clause, ForBlock):
                _look_at_range(clause, report)
            elif isinstance(clause.condition, Boolean) and any(parts):
                report.warning(CODE, f"this condition is {str(clause.condition.value).lower()}, whatever happens",
                               clause.condition.span, "write what counts alone")
            for part in parts:
                _look_at_blocks(part, report)


def _look_at_range(clause: ForBlock, report: Report) -> None:
    """Of numbers as they are written: nobody means 3:1."""
    for iterator in clause.iterators:
        values = iterator.range
        if isinstance(values, Range) and isinstance(values.start, Number) and isinstance(values.stop, Number):
            step = 1.0 if values.step is None else values.step.value if isinstance(values.step, Number) else 0.0
            if (values.stop.value - values.start.value) * step < 0:
                report.warning(CODE, "this loop has no pass: its range is empty", values.span,
                               f"a range that falls has a step: {values.start.value:g}:-1:{values.stop.value:g}")


def _look_at_each(element: Declaration | Extends, report: Report) -> None:
    """`each` where there is one alone; an array may stand further in."""
    if isinstance(element, Declaration) and element.dimensions:
        return
    for argument in element.arguments:
        if "each" in argument.prefixes:
            report.warning(CODE, "'each' has no effect: this is no array", argument.name_span, "leave it out")


# -------------------------------------------------------------------- variables


def _look_at_attributes(instances: Iterable[Instance], model: FlatModel, table: ClassTable, report: Report) -> None:
    told: set[Span] = set()
    slots = (m for instance in instances for m in instance.members.values() if isinstance(m, Slot))
    for slot in slots:
        if _IDLE_ANYWHERE.isdisjoint(slot.attributes):
            continue
        kind = next((x.kind for x in variables_of(slot, model.variables)), "parameter")  # structural ones are no variables
        for name, bound in slot.attributes.items():
            place = bound.expression.span
            if name not in (*_IDLE[""], *_IDLE[kind]) or place.source in table.library_sources or place in told:
                continue
            told.add(place)
            report.warning(CODE, f"'{name}' of '{slot.path}' has no effect", place, *[_WHY[name]] if name in _WHY else [])


def _look_at_inner(instances: Iterable[Instance], table: ClassTable, report: Report) -> None:
    """`inner` before what no component around asks for by `outer`."""
    asked = {name for instance in instances for name in instance.outer}
    for instance in instances:
        for name in instance.inner - asked - {"world"}:
            declared = table.declared(instance.definition).get(name)
            if declared is not None and declared.name_span.source not in table.library_sources:
                report.warning(CODE, f"'inner' has no effect: no component inside has an outer '{name}'", declared.name_span,
                               "leave the word out, or declare it there: outer")


def _look_at_parameters(own: Sequence[ClassDefinition], table: ClassTable, of_root: set[int], report: Report) -> None:
    """Constants and parameters whose names stand nowhere; idle.py tells of the others of the scene itself."""
    mentioned = frozenset().union(*(_words_of(_This(x)) for x in (*own, *_all_classes(table.user.values()))))
    for definition in own:
        for element in definition.elements:
            is_looked_at = isinstance(element, Declaration) and "inner" not in element.prefixes and (
                "constant" in element.prefixes or (
                    "parameter" in element.prefixes and (id(definition) not in of_root or _decides(element, table))))
            if is_looked_at and isinstance(element, Declaration) and element.name not in mentioned:
                what = "constant" if "constant" in element.prefixes else "parameter"
                report.warning(CODE, f"nothing reads the {what} '{element.name}'", element.name_span, "leave it out")


def _decides(declaration: Declaration, table: ClassTable) -> bool:
    """Whether a parameter is structural by its type."""
    if declaration.type_name in ("Integer", "Boolean", "String"):
        return True
    found = table.found(declaration.type_name, declaration.type_span)
    return found is not None and bool(found.literals)


def _look_at_functions(functions: Iterable[ClassDefinition], report: Report) -> None:
    """Inputs and variables of functions whose names stand nowhere in them."""
    for function in functions:
        for argument in function.annotation:
            if argument.name not in _FOR_PEOPLE and not argument.name.startswith("__"):
                report.warning(CODE, f"the annotation '{argument.name}' has no effect here", argument.name_span,
                               *([_OF_FUNCTIONS[argument.name]] if argument.name in _OF_FUNCTIONS else []))
        mentioned = _read_in(function)
        for element in function.elements:
            if isinstance(element, Declaration) and "output" not in element.prefixes and element.name not in mentioned:
                what = "input" if "input" in element.prefixes else "variable"
                report.warning(CODE, f"nothing reads the {what} '{element.name}' of {function.name}", element.name_span,
                               "leave it out")
            _look_at_function_attributes(element, function.name, report)
        find_overwritten(function, mentioned, report, CODE)


def _look_at_function_attributes(element: Any, function: str, report: Report) -> None:
    """A variable of a function has its unit alone."""
    for argument in element.arguments if isinstance(element, Declaration) else ():
        if argument.name in _IDLE_IN_FUNCTIONS:
            hints = ["assert(...) in the function says what it takes"] if argument.name in ("min", "max") else []
            report.warning(CODE, f"'{argument.name}' of '{element.name}' of {function} has no effect", argument.name_span, *hints)


def _read_in(function: ClassDefinition) -> set[str]:
    """The names in a function that its results, assertions and branches depend on, sizes and other declarations among them."""
    if any(isinstance(e, Extends) for e in function.elements):  # what it extends may read all of it
        return set(_words((function.elements, function.sections)))
    needed = {e.name for e in function.elements if isinstance(e, Declaration) and "output" in e.prefixes}
    statements: list[tuple[set[str], set[str]]] = []  # which names each gives a value, and which ones that is made of
    for element in function.elements:
        if isinstance(element, Declaration):
            needed |= set(_words((element.dimensions, element.arguments))) | set(element.type_name.split("."))
            statements.append(({element.name}, set(_words((element.binding,)))))
    pending: list[Any] = [clause for section in function.sections for clause in section.clauses]
    while pending:
        clause = pending.pop()
        if isinstance(clause, ForBlock | WhileBlock):
            pending += clause.body
            needed |= set(_words((clause.iterators if isinstance(clause, ForBlock) else clause.condition,)))
        elif isinstance(clause, IfBlock):
            pending += (*clause.then, *clause.otherwise)
            needed |= set(_words((clause.condition,)))
        elif isinstance(clause, Assignment):
            items = clause.target.items if isinstance(clause.target, Results) else (clause.target,)
            targets = [item for item in items if isinstance(item, Reference)]
            needed |= set(_words(tuple(part.subscripts for item in targets for part in item.parts)))
            statements.append(({item.parts[0].name for item in targets}, set(_words((clause.value,)))))
        else:
            needed |= set(_words((clause,)))
    while new := {name for given, made_of in statements if given & needed for name in made_of} - needed:
        needed |= new
    return needed


class _This:
    """A class or an element itself, whose parts nobody compares."""

    __slots__ = ("part",)

    def __init__(self, part: Any) -> None:
        self.part = part

    def __hash__(self) -> int:
        return id(self.part)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _This) and self.part is other.part


@lru_cache(maxsize=_MOST_CLASSES)
def _words_of(this: _This) -> frozenset[str]:
    """Of a class, which are looked for once however many models of a file are looked at."""
    found = set(_words(this.part.sections))
    for element in this.part.elements:
        found |= _words_of_element(_This(element))
    return frozenset(found)


@lru_cache(maxsize=_MOST_ELEMENTS)
def _words_of_element(this: _This) -> frozenset[str]:
    """Of a declaration, which an editor keeps while others are written."""
    return frozenset(_words(this.part))


def _words(part: Any) -> Iterator[str]:
    """Names of all that is mentioned in a piece of syntax, each part of a dotted one, and of types and functions."""
    pending = [part]
    while pending:
        found = pending.pop()
        if isinstance(found, tuple):
            pending += found
            continue
        names = fields_of(found.__class__)
        if isinstance(found, Reference):
            yield from (piece.name for piece in found.parts)
        elif isinstance(found, Declaration | Extends):
            yield from found.type_name.split(".")
        elif isinstance(found, Call):
            yield from found.function.split(".")
        pending += [getattr(found, name) for name in names]


# -------------------------------------------------------------------- what is stated


def _look_at_joints(model: FlatModel, table: ClassTable, report: Report) -> None:
    """Equations between frames that are one already."""
    first: dict[str, str] = {}

    def find(name: str) -> str:
        while name in first:
            name = first[name]
        return name

    for equation in model.frame_equations:
        sides = equation.left, equation.right
        a, b = (node.name if isinstance(node, FrameRef) and not node.attribute else None for node in sides)
        if a is None or b is None:
            continue
        if (one := find(a)) != (other := find(b)):
            first[one] = other
        elif equation.span.source not in table.library_sources:
            what = "this joins a frame to itself" if a == b else f"'{a}' and '{b}' are joined already"
            report.warning(CODE, what, equation.span, "leave it out")


def _is_idle(reset: Reset) -> bool:
    value = reset.value
    if isinstance(value, Call) and value.function == "pre" and len(value.arguments) == 1:
        value = value.arguments[0]
    return bool(_plain(value) == _plain(reset.rate))


def _plain(node: Flat) -> Any:
    """The expression without its places."""
    if is_dataclass(node) and not isinstance(node, Span):
        return type(node).__name__, *(_plain(getattr(node, f.name)) for f in fields(node) if f.name != "span")
    return tuple(map(_plain, node)) if isinstance(node, tuple) else node
