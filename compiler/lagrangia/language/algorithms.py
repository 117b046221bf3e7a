"""User functions -> FlatFunction: a list of assignments, loops unrolled and branches merged into if expressions."""

from collections.abc import Mapping
from typing import Any

from lagrangia.base.diagnostics import Span, fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.language.foreign_words import FOREIGN_WORDS
from lagrangia.language.instances import Instance, Scope
from lagrangia.language.names import Names
from lagrangia.language.tree import (
    Assignment,
    Call,
    ClassDefinition,
    Clause,
    Declaration,
    Flat,
    ForBlock,
    IfBlock,
    IfExpression,
    Local,
    Ref,
    Reference,
    Results,
    Section,
    String,
)
from lagrangia.language.units_written import read_unit


@dataclass(frozen=True)
class FlatFunction:
    """output = the value of `output` after the steps, each an assignment to a local name."""

    name: str
    inputs: tuple[str, ...]
    units: Mapping[str, str]  # declared unit of each variable, "" when none
    steps: tuple[tuple[str, Flat], ...]
    output: str
    span: Span

    def arrange(self, call: Call[Flat]) -> tuple[Any, ...]:
        """The arguments of a call in the order of the inputs. Raises LagError L0215."""
        given = dict(zip(self.inputs, call.arguments, strict=False))
        if len(call.arguments) > len(self.inputs):
            wanted = f"{len(self.inputs)} argument{'s' if len(self.inputs) != 1 else ''} ({', '.join(self.inputs)})"
            fail("L0215", f"{self.name} takes {wanted}, not {len(call.arguments)}", call.span)
        for name, value in call.named:
            if name not in self.inputs or name in given:
                fail("L0215", f"{self.name} has no other input '{name}'", call.span, *filter(None, [suggest(name, self.inputs)]))
            given[name] = value
        missing = [name for name in self.inputs if name not in given]
        if missing:
            fail("L0215", f"{self.name} also needs {', '.join(missing)}", call.span)
        return tuple(given[name] for name in self.inputs)


def flatten_function(definition: ClassDefinition, names: Names) -> FlatFunction:
    """Raises LagError for a function that has no single output, or does what no formula can say."""
    return _Builder(definition, names).build()


class _Builder:
    def __init__(self, definition: ClassDefinition, names: Names) -> None:
        self.definition, self.names = definition, names
        if inherited := next((e for e in definition.elements if not isinstance(e, Declaration)), None):
            fail("L0902", "not supported yet: a function that extends another one", inherited.span, "call it: y := other(x);")
        self.declarations = [e for e in definition.elements if isinstance(e, Declaration)]
        self.inputs = tuple(d.name for d in self.declarations if "input" in d.prefixes)
        self.units: dict[str, str] = {}
        self.count = 0
        for declaration in self.declarations:
            base = names.table.base_type(declaration.type_name, declaration.type_span)
            if base is None or base.builtin not in ("Real", "Integer") or declaration.dimensions or base.dimensions:
                fail("L0902", "not supported yet: a function variable that is no scalar number", declaration.name_span)
            units = [a.value.value for a in (*base.attributes, *declaration.arguments)
                     if a.name == "unit" and isinstance(a.value, String)]
            if units:
                read_unit(units[-1], declaration.span)
            self.units[declaration.name] = units[-1] if units else ""
        # under which name a variable's value is found; its own, unless branches gave it
        self.current = {name: name for name in self.units}
        self.given = set(self.inputs)  # the names that have a value

    def build(self) -> FlatFunction:
        definition = self.definition
        outputs = [d for d in self.declarations if "output" in d.prefixes]
        if not outputs:
            fail("L0211", f"the function '{definition.name}' has no output", definition.name_span, "declare one: output Real y;")
        if len(outputs) != 1:
            fail("L0902", f"not supported yet: the function '{definition.name}' with {len(outputs)} outputs",
                 definition.name_span)
        steps: list[tuple[str, Flat]] = []
        for declaration in self.declarations:
            if declaration.binding is not None and "input" not in declaration.prefixes:
                self._assign(declaration.name, self._flatten(declaration.binding, {}), steps, declaration.name)
        for section in definition.sections:
            self._section(section, steps)
        output = self.current[outputs[0].name]
        if output not in {name for name, _ in steps}:
            fail("L0211", f"the output '{outputs[0].name}' is never given a value", outputs[0].name_span)
        return FlatFunction(definition.name, self.inputs, self.units, tuple(steps), output, definition.name_span)

    def _section(self, section: Section, steps: list[tuple[str, Flat]]) -> None:
        if section.kind != "algorithm":
            place = section.clauses[0].span if section.clauses else self.definition.name_span
            fail("L0222", f"a function has an algorithm, no section of this kind ({section.kind})", place,
                 "write: algorithm, and name := expression; below it")
        for clause in section.clauses:
            self._statement(clause, {}, steps)

    def _flatten(self, expression: Any, iterators: Mapping[str, int]) -> Flat:
        """Local names first: they are members of a stand-in instance whose variables flatten to Local."""
        scope = Scope(Instance("", self.definition, expression.span), iterators)
        return _LocalNames(self.names, self.current).flatten(expression, scope)

    def _statement(self, clause: Clause, iterators: Mapping[str, int], steps: list[tuple[str, Flat]], in_branch: bool = False
                   ) -> None:
        match clause:
            case Assignment(Reference(parts, span), value, _):
                name = parts[0].name
                if name not in self.units or len(parts) > 1 or parts[0].subscripts:
                    fail("L0204", f"'{span.text}' is no variable of {self.definition.name}", span)
                self._assign(name, self._flatten(value, iterators), steps, self._fresh(name) if in_branch else name)
            case ForBlock(loops, body, _):
                for scope in self.names.loop(loops, Scope(Instance("", self.definition, clause.span), iterators), len(body)):
                    for inner in body:
                        self._statement(inner, scope.iterators, steps, in_branch)
            case IfBlock(condition, then, otherwise, span):
                self._branch(self._flatten(condition, iterators), then, otherwise, iterators, steps, span)
            case _:
                if (word := clause.span.text.rstrip(";").strip()) in FOREIGN_WORDS:
                    fail("L0901", f"not of this language: {FOREIGN_WORDS[word][0]}", clause.span, FOREIGN_WORDS[word][1])
                if isinstance(clause, Assignment) and isinstance(clause.target, Results):
                    fail("L0901", "not supported yet: several results of a function", clause.span,
                         "write a function for each of them")
                fail("L0222", "this is no assignment", clause.span, "write: name := expression;")

    def _assign(self, name: str, value: Flat, steps: list[tuple[str, Flat]], place: str) -> None:
        steps.append((place, value))
        self.given.add(place)
        self.current[name] = place

    def _fresh(self, name: str) -> str:
        self.count += 1
        place = f"{name}#{self.count}"
        self.units[place] = self.units[name]
        return place

    def _branch(self, condition: Flat, then: tuple[Clause, ...], otherwise: tuple[Clause, ...], iterators: Mapping[str, int],
                steps: list[tuple[str, Flat]], span: Span) -> None:
        """Both branches with fresh names, then one if expression for each variable that either assigns, under a fresh name too:
        what the condition and the other values read stays as it was. What one branch alone gives a value has none behind them."""
        before, ends = self.current, []
        for clauses in (then, otherwise):
            self.current = dict(before)
            for clause in clauses:
                self._statement(clause, iterators, steps, in_branch=True)
            ends.append(self.current)
        self.current = dict(before)
        for name, old in before.items():
            places = [end[name] for end in ends]
            if places != [old, old] and self.given.issuperset(places):
                taken, other = (Local(place, span) for place in places)
                self._assign(name, IfExpression(condition, taken, other, span), steps, self._fresh(name))


class _LocalNames(Names):
    """Name resolution inside a function: its own variables, and the functions and constants of the kernel."""

    def __init__(self, names: Names, known: Mapping[str, str]) -> None:
        super().__init__(names.table, names.report, names.functions, names.define, work=names.work,
                         lookups=names.lookups, make_package=names.make_package,
                         packages=names.packages)
        self.known = known  # the name that each variable's value has

    def late(self, call: Call[Flat]) -> Ref:
        fail("L0901", "not supported yet: delay in a function", call.span, "delay what the function is given, or what it gives")

    def resolve(self, node: Reference, scope: Scope) -> Flat:
        name = node.parts[0].name
        if name in self.known and len(node.parts) == 1 and not node.parts[0].subscripts:
            return Local(self.known[name], node.span)
        if name == "time":
            fail("L0204", "a function knows no time", node.span, "pass it as an input")
        return super().resolve(node, scope)
