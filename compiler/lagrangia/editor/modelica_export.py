"""A drive train -> Modelica text with the components of the Modelica Standard Library, the way back of modelica_import.py."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

from lagrangia.base.diagnostics import Span, fail
from lagrangia.editor.modelica_import import FILTERED, UNITS
from lagrangia.language.classes import BUILTIN_TYPES
from lagrangia.language.component_library import library_classes
from lagrangia.language.tree import (
    Argument,
    Call,
    CallEquation,
    ClassDefinition,
    Clause,
    Comprehension,
    Declaration,
    Equality,
    Extends,
    ForBlock,
    IfBlock,
    Number,
    Reference,
    Syntax,
    WhenBlock,
)
from lagrangia.language.units_written import in_si

_SOURCES = frozenset("""Torque Torque2 ConstantTorque TorqueStep LinearSpeedDependentTorque QuadraticSpeedDependentTorque Position
    Speed ConstantSpeed Accelerate Force Force2 ConstantForce ForceStep LinearSpeedDependentForce QuadraticSpeedDependentForce
    EddyCurrentTorque EddyCurrentForce""".split())
_OWN = frozenset(("FreeWheel", "HingeFlange", "SliderFlange"))  # which Modelica's library has not
_BLOCKS = {name: part for part, names in {
    "Sources": """Constant RealExpression Step Ramp Sine Cosine Pulse Trapezoid ExpSine TimeTable CombiTimeTable BooleanConstant
        BooleanStep BooleanPulse""",
    "Nonlinear": "Limiter DeadZone VariableLimiter", "Continuous": "Integrator FirstOrder SecondOrder PI PID Derivative LimPID",
    "Math": "Gain Add Add3 Feedback Product Division Abs Sin Cos Max Min Sqrt Sign Tan Exp Log BooleanToReal",
    "Logical": """Switch And Or Not Greater GreaterEqual Less LessEqual GreaterThreshold GreaterEqualThreshold LessThreshold
        LessEqualThreshold Hysteresis""", "Tables": "CombiTable1Ds CombiTable1Dv",
    }.items() for name in names.split()}
_CONTROLLERS = "Blocks.SimpleController."
_TYPES = {own: f"Modelica.Units.SI.{name}" for name, own in reversed(UNITS.items())}
_FUNCTIONS = frozenset("""sin cos tan asin acos atan atan2 sinh cosh tanh exp log log10 abs sqrt sign min max sum floor ceil mod
    div rem der noEvent smooth fill zeros ones size pre connect assert initial edge change sample reinit terminate
    integer""".split())
_WORDS = frozenset("""assert block break class connector constrainedby discrete elsewhen encapsulated enumeration expandable
    external flow impure in inner operator outer pure redeclare replaceable return stream while within""".split())
_INSTEAD = "lag export --to modelica without --components writes the equations of motion"


def used_of(main: Syntax, imported: Iterable[Syntax]) -> list[ClassDefinition]:
    """The classes of imported files that those of a file use."""
    known = {definition.name: definition for syntax in imported for definition in syntax.classes}
    found, pending = dict[str, ClassDefinition](), [*main.classes]
    for definition in pending:
        used = [known[element.type_name] for element in definition.elements if element.type_name in known]
        new = [one for one in used if one.name not in found]
        found |= {one.name: one for one in new}
        pending += [*definition.classes, *new]
    return [*found.values()]


def has_frames(main: Syntax, used: Iterable[ClassDefinition]) -> bool:
    """Whether a file, or what it uses of others, speaks of frames, or of components of the library that are not in its packages:
    joints, bodies."""
    library = library_classes()
    classes = [*main.classes, *used]
    for definition in classes:
        classes += definition.classes  # in packages
    types = {element.type_name for definition in classes for element in definition.elements}
    return "Frame" in types or any(library[name].kind in ("model", "partial model") for name in types & {*library})


def drive_train(main: Syntax, used: Sequence[ClassDefinition]) -> str:
    """The text of a file whose models have drives, blocks and signals alone, behind that of classes that it uses of other files.
    Raises LagError L0901 for anything else."""
    classes = {definition.name: definition for definition in (*used, *main.classes)}

    def edits(some: Iterable[ClassDefinition]) -> Iterator[tuple[tuple[int, int], str]]:
        for definition in some:
            yield from _edits(definition, {*classes}, _names(definition, classes))

    text = [_written(one.span.source.text[: one.span.end], one.span.start, edits([one])) + "\n\n" for one in used]
    gone = [((item.span.start, item.span.end), "") for item in main.imports]
    return "".join([*text, _written(main.source.text, 0, (*gone, *edits(main.classes)))])


def _written(source: str, begin: int, edits: Iterable[tuple[tuple[int, int], str]]) -> str:
    """From a place on, with what stands at places of it."""
    text, at = list[str](), begin
    for (start, end), new in sorted(dict(edits).items()):
        text += [source[at:start], new]
        at = end
    return "".join([*text, source[at:]])


def _refuse(what: str, span: Span) -> None:
    fail("L0901", f"not supported yet: {what} among components of the Modelica Standard Library", span, _INSTEAD)


def _names(definition: ClassDefinition, classes: Mapping[str, ClassDefinition]) -> set[str]:
    """What a class declares, or inherits of these classes. Raises LagError L0901 for words of Modelica."""
    found: set[str] = set()
    pending, seen = [definition], {definition.name}
    for one in pending:
        for element in one.elements:
            if isinstance(element, Declaration):
                found.add(element.name)
                if element.name in _WORDS:
                    _refuse(f"the name '{element.name}', which is a word of Modelica,", element.name_span)
            elif element.type_name not in seen:
                seen.add(element.type_name)
                pending += [classes[element.type_name]] if element.type_name in classes else []
    if definition.name in _WORDS:
        _refuse(f"the name '{definition.name}', which is a word of Modelica,", definition.name_span)
    return found


def _edits(definition: ClassDefinition, own: set[str], names: set[str]) -> Iterator[tuple[tuple[int, int], str]]:
    """Places of the text with what stands there in Modelica."""
    if definition.kind not in ("model", "block", "type") or definition.classes:
        _refuse(f"the {definition.kind} '{definition.name}'", definition.name_span)
    for section in definition.sections:
        if section.kind not in ("equation", "initial"):
            _refuse(f"a section '{section.kind}'", section.span)
        _require_equations(section.clauses)
    for element in definition.elements:
        if isinstance(element, Extends):
            if element.type_name not in own | BUILTIN_TYPES:
                _refuse(f"'{element.type_name}'", element.span)
        elif element.type_name not in own | (BUILTIN_TYPES - {"Frame"}) or "coordinate" in element.prefixes:
            yield (element.type_span.start, element.type_span.end), _type(element)
            if element.type_name in FILTERED:
                yield _made_exact(element)
    yield from _inside((definition.elements, definition.sections), "pi" in names)


def _require_equations(clauses: Iterable[Clause]) -> None:
    """Raises LagError L0901 for what Modelica has not."""
    for clause in clauses:
        match clause:
            case CallEquation(Call("reinit", (rate, *_))) if not isinstance(rate, Reference):
                _refuse("reinit of what is no variable", clause.span)
            case Equality() | CallEquation():
                pass
            case ForBlock():
                _require_equations(clause.body)
            case IfBlock():
                _require_equations((*clause.then, *clause.otherwise))
            case WhenBlock():
                _require_equations((*clause.body, *filter(None, [clause.otherwise])))
            case _:
                _refuse("this", clause.span)


def _made_exact(element: Declaration) -> tuple[tuple[int, int], str]:
    """The argument by which Modelica's component moves as its signal says, which it filters by itself."""
    text, end = element.name_span.source.text, element.name_span.end
    said = "each exact = true" if element.dimensions else "exact = true"
    opened = re.compile(r"\s*(\[[^\]]*\])?\s*").match(text, end)
    at = opened.end() if opened is not None else end
    if text[at : at + 1] != "(":
        return (at, at), f"({said}) " if at > end else f"({said})"
    return (at + 1, at + 1), said if text[at + 1 :].lstrip().startswith(")") else f"{said}, "


def _type(element: Declaration) -> str:
    package, _, name = element.type_name.rpartition(".")
    found = ""
    if package in ("Rotational", "Translational") and name not in _OWN:
        part = "Sensors" if name.endswith("Sensor") else "Sources" if name in _SOURCES else "Components"
        found = f"Modelica.Mechanics.{package}.{part}.{name}"
    elif package == "Blocks" and name in _BLOCKS:
        found = f"Modelica.Blocks.{_BLOCKS[name]}.{name}"
    elif "coordinate" not in element.prefixes:
        found = _TYPES.get(element.type_name, "")
    if not found:
        _refuse(f"'{element.type_name} {element.name}'", element.type_span)
    return found


def _inside(part: Any, has_pi: bool) -> Iterator[tuple[tuple[int, int], str]]:
    """Of expressions: numbers with units in SI units, pi by its place unless it is one's own, functions that Modelica has."""
    if isinstance(part, tuple):
        for item in part:
            yield from _inside(item, has_pi)
    elif isinstance(part, Number):
        if part.unit is not None:
            yield (part.span.start, part.span.end), repr(in_si(part).value)
    elif isinstance(part, Reference) and str(part) == "pi" and not has_pi:
        yield (part.span.start, part.span.end), "Modelica.Constants.pi"
    elif isinstance(part, Reference) and str(part).startswith(_CONTROLLERS):
        yield (part.span.start, part.span.end), f"Modelica.Blocks.Types.{str(part).removeprefix('Blocks.')}"
    elif is_dataclass(part) and not isinstance(part, Span):
        if isinstance(part, Call) and part.function not in _FUNCTIONS:
            _refuse(f"{part.function}(...)", part.span)
        if isinstance(part, Argument) and part.redeclared is not None:
            _refuse("a redeclaration", part.span)
        is_own = has_pi or (isinstance(part, Comprehension) and any(iterator.name == "pi" for iterator in part.iterators))
        for field in fields(part):
            yield from _inside(getattr(part, field.name), is_own)
