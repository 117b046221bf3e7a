"""Text -> Syntax: the parser. The grammar is grammar/lag.lark; each method below makes the node of one rule."""

import marshal
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, cast

from lagrangia.base.diagnostics import Source, Span, fail
from lagrangia.base.folders import data_folder
from lagrangia.language.expression_nodes import _ExpressionNodes, name_of, text_of
from lagrangia.language.reader import NotReadError, Place, Tables, Word, read
from lagrangia.language.shipped import made_of
from lagrangia.language.tree import (
    Argument,
    Array,
    Assignment,
    CallEquation,
    ClassDefinition,
    Constraining,
    Declaration,
    EnergyKind,
    EnergyTerm,
    Equality,
    Expression,
    Extends,
    ForBlock,
    IfBlock,
    Import,
    ImportFile,
    Iterator,
    LiteralDefinition,
    Section,
    Syntax,
    WhenBlock,
    WhileBlock,
    WorkTerm,
    over,
)

_DEEPEST = 100  # brackets in brackets, conditions in conditions, loops in loops
_LESS_DEEP = {"loops": "one loop runs over several: for i in 1:3, j in 1:4 loop",
              "classes": "classes stand beside each other, too"}
_NESTING = re.compile(
    r"""(?P<text>"(?:[^"\\]|\\.)*"? | //[^\n]* | /\*(?:.*?\*/|.*)) | (?P<open>[(\[{]) | (?P<close>[)\]}])
    | (?P<condition>\b(?:else)?if\b) | (?P<done>\bend\s+for\b) | (?P<loop>\bloop\b) | ;
    | (?P<class>\b(?:model|function|record|package|connector)\s+(?:extends\s+)?\w+\b(?!\s*=))
    | (?P<ended>\bend\s+(?!if\b|when\b|while\b)\w+)""", re.DOTALL | re.VERBOSE)
RESERVED = frozenset(
    "algorithm and annotation coordinate connect constant der drawing each else elseif end energy equation extends false final "
    "for function if import initial input loop model not or output package parameter partial protected public record then time "
    "true type when".split()
)
_RIVALS = tuple(map(frozenset, (
    {"parameter", "constant", "discrete", "coordinate"}, {"parameter", "constant", "coordinate", "input"}, {"input", "output"},
    {"flow", "stream"}, {"pure", "impure"})))
_KINDS: Mapping[str, str] = {"class": "model"}  # what a word means that has another one


def parse(source: Source, make: "Callable[[Source], _Nodes] | None" = None) -> Syntax:
    """The syntax tree of one file; `make` gives what makes its nodes. Raises LagError (L01xx)."""
    _check_text(source)
    make = make or _Nodes
    nodes = make(source)
    try:
        items = read(source.text, tables(), nodes)
    except NotReadError:
        from lagrangia.language.expectations import refuse

        refuse(source, tables())
    nodes.report.raise_errors()
    files = tuple(x for x in items if isinstance(x, ImportFile))
    classes = tuple(x for x in items if isinstance(x, ClassDefinition))
    within = next((x[1] for x in items if isinstance(x, tuple)), None)
    return Syntax(source, files, classes, tuple(x for x in items if isinstance(x, Import)), within, tuple(nodes.annotations))


@cache
def tables() -> Tables:
    """The tables of the parser."""
    return Tables(*marshal.loads(made_of("reader", [grammar_file()], reader_tables)))


def grammar_file() -> Path:
    """The grammar of the language."""
    return data_folder("grammar") / "lag.lark"


def reader_tables() -> bytes:
    """The tables of reader.py, as plain data that marshal reads back."""
    from lagrangia.language.grammar_tables import make_tables

    return make_tables(grammar_file())


def _check_text(source: Source) -> None:
    """Refuse what is no text, and nesting deep enough to exhaust the recursion of later phases."""
    if "\0" in source.text:
        at = source.text.index("\0")
        fail("L0101", f"{source.name} is not a text file: it holds a NUL character", Span(source, at, at + 1))
    depth = conditions = loops = classes = 0
    for mark in _NESTING.finditer(source.text):
        depth = max(0, depth + (mark.lastgroup == "open") - (mark.lastgroup == "close"))
        conditions = 0 if mark[0] == ";" else conditions + (mark.lastgroup == "condition")
        loops = max(0, loops + (mark.lastgroup == "loop") - (mark.lastgroup == "done"))
        classes = max(0, classes + (mark.lastgroup == "class") - (mark.lastgroup == "ended"))
        if max(depth, conditions, loops, classes) > _DEEPEST:
            what = ("brackets" if depth > _DEEPEST else "conditions" if conditions > _DEEPEST else "loops" if loops > _DEEPEST
                    else "classes")
            fail("L0102", f"{what} nested deeper than {_DEEPEST}", Span(source, mark.start(), mark.end()), _LESS_DEEP.get(
                 what, "name a part of the expression with a variable of its own"))


class _Nodes(_ExpressionNodes):
    """Of files, classes and sections."""

    def __init__(self, source: Source) -> None:
        super().__init__(source)
        self.annotations: list[Argument] = []  # of statements, which have none in the tree

    def _keep(self, annotation: tuple[str, tuple[Argument, ...]] | None) -> None:
        self.annotations += annotation[1] if annotation else ()

    # ---------------------------------------------------------------- file and classes

    def file(self, meta: Place, children: list[Any]) -> list[Any]:
        return [child for child in children if child is not None]

    def within(self, meta: Place, children: list[Any]) -> tuple[str, str]:
        return "within", children[0][0] if children[0] is not None else ""

    def import_file(self, meta: Place, children: list[Any]) -> ImportFile:
        return ImportFile(text_of(children[0]), self._span(meta))

    def import_name(self, meta: Place, children: list[Any]) -> Import:
        *words, _, annotation = children
        names = list(map(name_of, words))
        return Import(((names[-1], ".".join(names)),), self._span(meta), annotation[1] if annotation else ())

    def import_all(self, meta: Place, children: list[Any]) -> Import:
        *names, star, _, annotation = children
        if star != ".*":
            self.report.error("L0103", f"unexpected '{star}'", self._span(star), f"write: import {'.'.join(names)}.*;")
        return Import((("*", ".".join(map(name_of, names))),), self._span(meta), annotation[1] if annotation else ())

    def import_some(self, meta: Place, children: list[Any]) -> Import:
        text = self._span(meta).text
        package = "".join(text[len("import") : text.index("{")].split())
        count = len(package.rstrip(".").split("."))
        return Import(tuple((str(name), f"{package}{name}") for name in children[count:-2]), self._span(meta),
                      children[-1][1] if children[-1] else ())

    def import_as(self, meta: Place, children: list[Any]) -> Import:
        name, *names, _, annotation = children
        return Import(((name_of(name), ".".join(map(name_of, names))),), self._span(meta), annotation[1] if annotation else ())

    def class_extension(self, meta: Place, children: list[Any]) -> ClassDefinition:
        """redeclare model extends M: extends what M is in what is inherited."""
        at = next(k for k, c in enumerate(children) if isinstance(c, Word) and c.type == "NAME")
        name, arguments, *rest = children[at:]
        made = self.class_definition(meta, [*children[:at], name, *rest])
        inherited = Extends(made.name, arguments or (), self._span(name))
        return replace(made, elements=(inherited, *made.elements), prefixes=made.prefixes | {"extends"})

    def _check_end(self, name: Word, end_name: Word) -> None:
        if str(end_name) != str(name):
            self.report.error("L0106", f"'{name}' ends as '{end_name}'", self._span(end_name), f"write: end {name};",
                              label=f"expected {name}")

    def class_definition(self, meta: Place, children: list[Any]) -> ClassDefinition:
        prefixes, is_partial, (kind, name, *rest) = self._head([c for c in children if isinstance(c, Word)])
        self._check_end(name, rest[-1])
        description = rest[0] if len(rest) > 1 else None
        elements: list[Declaration | Extends] = []
        classes: list[ClassDefinition] = []
        annotation: tuple[Argument, ...] = ()
        hidden: frozenset[str] = frozenset()
        for item in (c for c in children if not isinstance(c, Word)):
            if isinstance(item, tuple) and item and item[0] == "annotation":
                annotation += item[1]
            elif isinstance(item, tuple) and item and item[0] == "visibility":
                hidden = frozenset({"protected"}) & {item[1]}
            elif isinstance(item, list):
                elements += [replace(declaration, prefixes=declaration.prefixes | hidden) for declaration in item]
            elif isinstance(item, Extends):
                elements.append(item)
            elif isinstance(item, ClassDefinition):
                classes.append(replace(item, prefixes=item.prefixes | hidden))
        sections = tuple(c for c in children if isinstance(c, Section))
        imports = tuple(c for c in children if isinstance(c, Import))
        return ClassDefinition(_KINDS.get(kind, str(kind)), is_partial, name_of(name), text_of(description), tuple(elements),
                               sections, annotation, self._span(meta), self._span(name), tuple(classes), imports, prefixes)

    def short_class(self, meta: Place, children: list[Any]) -> ClassDefinition:
        *words, base, dimensions, arguments, constraining, description, annotation = children
        at = next(k for k, word in enumerate(words) if word.type == "NAME")
        prefixes, is_partial, (kind, name) = self._head(words[: at + 1])
        extends = Extends(base[0], _over_limit(arguments or (), constraining), self._span(meta), dimensions or (),
                          frozenset(map(str, words[at + 1 :])))
        return ClassDefinition(_KINDS.get(kind, str(kind)), is_partial, name_of(name), text_of(description), (extends,), (),
                               annotation[1] if annotation else (), self._span(meta), self._span(name), prefixes=prefixes,
                               constraining=constraining)

    def enumeration(self, meta: Place, children: list[Any]) -> ClassDefinition:
        *rest, description, annotation = children
        literals = tuple(x for x in rest if isinstance(x, LiteralDefinition))
        prefixes, _, (kind, name) = self._head(rest[: len(rest) - len(literals)])
        if kind != "type":
            self.report.error("L0103", f"an enumeration is no {kind}", self._span(kind),
                              f"write: type {name} = enumeration(...);")
        is_any = not literals  # enumeration(:), which another one takes the place of
        return ClassDefinition("type", is_any, name_of(name), text_of(description), (), (), annotation[1] if annotation else (),
                               self._span(meta), self._span(name), prefixes=prefixes, literals=literals)

    def literal(self, meta: Place, children: list[Any]) -> LiteralDefinition:
        name, description, annotation = children
        return LiteralDefinition(name_of(name), text_of(description), self._span(name), annotation[1] if annotation else ())

    def _head(self, words: Sequence[Word]) -> tuple[frozenset[str], bool, list[Word]]:
        """Prefixes of a class, whether it is partial, and the rest of its words."""
        at = next(k for k, word in enumerate(words) if word.type == "CLASS_KIND")
        prefixes = self._prefixes(words[:at])
        return prefixes - {"partial"}, "partial" in prefixes, list(words[at:])

    def _prefixes(self, words: Sequence[Word]) -> frozenset[str]:
        """L0103 for one that stands twice, and for two of which one alone can hold."""
        for k, word in enumerate(words):
            before = set(map(str, words[:k]))
            if str(word) in before:
                self.report.error("L0103", f"'{word}' stands twice", self._span(word), "leave one out")
            elif other := next((x for rivals in _RIVALS if str(word) in rivals for x in rivals & before), None):
                self.report.error("L0103", f"'{word}' beside '{other}'", self._span(word), "one of them alone can hold")
        return frozenset(map(str, words))

    def visibility(self, meta: Place, children: list[Any]) -> tuple[str, str]:
        return "visibility", str(children[0])

    def extends(self, meta: Place, children: list[Any]) -> Extends:
        (name, _), arguments, annotation = children
        self._keep(annotation)
        return Extends(name, arguments or (), self._span(meta))

    def annotation(self, meta: Place, children: list[Any]) -> tuple[str, tuple[Argument, ...]]:
        return "annotation", children[0]

    def annotation_item(self, meta: Place, children: list[Any]) -> tuple[str, tuple[Argument, ...]]:
        result: tuple[str, tuple[Argument, ...]] = children[0]
        return result

    def type_name(self, meta: Place, children: list[Any]) -> tuple[str, Span]:
        return ".".join(map(name_of, children)), self._span(meta)

    def declaration(self, meta: Place, children: list[Any]) -> list[Declaration]:
        prefixes = self._prefixes([c for c in children if isinstance(c, Word)])
        (type_name, type_span), dimensions, *declarators = [c for c in children if not isinstance(c, Word)]
        return [_declared(prefixes, type_name, type_span, dimensions, declarator) for declarator in declarators]

    def declarator(self, meta: Place, children: list[Any]) -> tuple[Any, ...]:
        name, dimensions, arguments, binding, condition, constraining, description, annotation = children
        if str(name) in RESERVED:
            self.report.error("L0108", f"'{name}' is a word of the language and cannot be a name", self._span(name))
        return (name_of(name), dimensions, arguments, binding, condition, text_of(description), self._span(meta),
                self._span(name), annotation[1] if annotation else (), constraining)

    def constraining(self, meta: Place, children: list[Any]) -> Constraining:
        (name, _), arguments = children
        return Constraining(name, arguments or (), self._span(meta))

    def modification(self, meta: Place, children: list[Any]) -> tuple[Argument, ...]:
        return tuple(c for c in children if c is not None)

    def argument(self, meta: Place, children: list[Any]) -> Argument:
        *prefixes, name, arguments, value, _ = children
        return Argument(self._prefixes(prefixes), name_of(name), arguments or (), value, self._span(meta),
                        self._span(name))

    def redeclaration(self, meta: Place, children: list[Any]) -> Argument:
        *prefixes, (type_name, type_span), declarator = children
        words = self._prefixes(prefixes)
        declared = _declared(words, type_name, type_span, None, declarator)
        return Argument(words, declared.name, declared.arguments, declared.binding, self._span(meta), declared.name_span,
                        declared)

    def class_redeclaration(self, meta: Place, children: list[Any]) -> Argument:
        *prefixes, kind, name, (type_name, type_span), arguments, constraining, description = children
        words = self._prefixes(prefixes)
        declared = Declaration(words | {"class"}, type_name, type_span, name_of(name), (),
                               _over_limit(arguments or (), constraining), None, None, text_of(description), self._span(meta),
                               self._span(name), (), constraining, _KINDS.get(kind, str(kind)))
        return Argument(words, declared.name, declared.arguments, None, self._span(meta), declared.name_span, declared)

    def left_out(self, meta: Place, children: list[Any]) -> Argument:
        return Argument(frozenset(), name_of(children[0]), (), None, self._span(meta), self._span(children[0]), None, True)

    def left_out_connection(self, meta: Place, children: list[Any]) -> Argument:
        word, *parts = children
        if word != "connect":
            self.report.error("L0103", f"unexpected '{word}'", self._span(word), "write: break connect(a, b), or break name")
        ends = Array(tuple(parts), self._span(meta))
        return Argument(frozenset(), "connect", (), ends, self._span(meta), self._span(meta), None, True)

    # ---------------------------------------------------------------- sections

    def equation_section(self, meta: Place, children: list[Any]) -> Section:
        return Section("equation", tuple(children), self._span(meta))

    def initial_section(self, meta: Place, children: list[Any]) -> Section:
        return Section("initial", tuple(children), self._span(meta))

    def energy_section(self, meta: Place, children: list[Any]) -> Section:
        return Section("energy", tuple(children), self._span(meta))

    def algorithm_section(self, meta: Place, children: list[Any]) -> Section:
        return Section("algorithm", tuple(children), self._span(meta))

    def drawing_section(self, meta: Place, children: list[Any]) -> Section:
        return Section("drawing", tuple(children), self._span(meta))

    def equality(self, meta: Place, children: list[Any]) -> Equality:
        left, right, description, annotation = children
        self._keep(annotation)
        return Equality(left, right, text_of(description), self._span(meta))

    def call_equation(self, meta: Place, children: list[Any]) -> CallEquation:
        self._keep(children[2])
        return CallEquation(children[0], self._span(meta))

    def drawn(self, meta: Place, children: list[Any]) -> CallEquation:
        return CallEquation(children[0], self._span(meta))

    def energy_term(self, meta: Place, children: list[Any]) -> EnergyTerm:
        kind, value, description = children
        return EnergyTerm(cast(EnergyKind, str(kind)), value, text_of(description), self._span(meta))

    def work_term(self, meta: Place, children: list[Any]) -> WorkTerm:
        force, position, description = children
        return WorkTerm(force, position, text_of(description), self._span(meta))

    def assignment(self, meta: Place, children: list[Any]) -> Assignment:
        target, value = children
        return Assignment(target, value, self._span(meta))

    def for_block(self, meta: Place, children: list[Any]) -> ForBlock:
        return ForBlock(children[0], tuple(children[1:]), self._span(meta))

    def while_block(self, meta: Place, children: list[Any]) -> WhileBlock:
        return WhileBlock(children[0], tuple(children[1:]), self._span(meta))

    def else_if(self, meta: Place, children: list[Any]) -> tuple[Any, ...]:
        return "else if", children[0], tuple(children[1:]), self._span(meta)

    def else_branch(self, meta: Place, children: list[Any]) -> tuple[Any, ...]:
        return "else", tuple(children)

    def if_block(self, meta: Place, children: list[Any]) -> IfBlock:
        condition, *rest = children
        branches = [c for c in rest if isinstance(c, tuple)]
        then = tuple(c for c in rest if c is not None and not isinstance(c, tuple))
        otherwise: tuple[Any, ...] = ()
        for branch in reversed(branches):
            otherwise = branch[1] if branch[0] == "else" else (IfBlock(branch[1], branch[2], otherwise, branch[3]),)
        return IfBlock(condition, then, otherwise, self._span(meta))

    def when_block(self, meta: Place, children: list[Any]) -> WhenBlock:
        condition, *body = children
        others = [c for c in body if isinstance(c, WhenBlock)]
        otherwise: WhenBlock | None = None
        for other in reversed(others):
            otherwise = replace(other, otherwise=otherwise)
        return WhenBlock(condition, tuple(c for c in body if not isinstance(c, WhenBlock)), self._span(meta), otherwise)

    def else_when(self, meta: Place, children: list[Any]) -> WhenBlock:
        return WhenBlock(children[0], tuple(children[1:]), self._span(meta))

    def iterators(self, meta: Place, children: list[Any]) -> tuple[Iterator, ...]:
        return tuple(children)

    def iterator(self, meta: Place, children: list[Any]) -> Iterator:
        return Iterator(name_of(children[0]), children[1], self._span(meta))


def _declared(prefixes: frozenset[str], type_name: str, type_span: Span, dimensions: tuple[Expression, ...] | None,
              declarator: tuple[Any, ...]) -> Declaration:
    name, own, arguments, binding, condition, description, span, name_span, annotation, constraining = declarator
    return Declaration(prefixes, type_name, type_span, name, (*(own or ()), *(dimensions or ())),
                       _over_limit(arguments or (), constraining), binding, condition, description, span, name_span, annotation,
                       constraining)


def _over_limit(arguments: tuple[Argument, ...], limit: Constraining | None) -> tuple[Argument, ...]:
    """What modifies something, with what the constraining clause behind it says under that (Modelica 3.6, section 7.3.2)."""
    return over(arguments, limit.arguments) if limit is not None else arguments
