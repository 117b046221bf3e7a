"""User functions -> FlatFunctions: lists of assignments to numbers, loops unrolled and branches merged into if expressions."""

from collections.abc import Iterable, Set
from dataclasses import replace

from lagrangia.base.diagnostics import Span, fail
from lagrangia.language.assertions import read_assertion
from lagrangia.language.attributes import display_unit_of, note_limit, unit_of, unknown_attributes
from lagrangia.language.classes import ENUMERATION, BaseType
from lagrangia.language.folding import fold
from lagrangia.language.foreign_words import FOREIGN_WORDS
from lagrangia.language.function_variables import (
    Assertion,
    Built,
    FlatFunction,
    Given,
    Tree,
    array_of,
    dealt,
    leaves_of,
    needed,
    renamed,
)
from lagrangia.language.functions import FUNCTIONS
from lagrangia.language.instances import Bound, Instance, Iterators, Scope
from lagrangia.language.local_names import LocalNames
from lagrangia.language.mentions import nodes
from lagrangia.language.modifications import modification_of
from lagrangia.language.names import Names
from lagrangia.language.number_checks import CONDITIONS, refuse_no_number
from lagrangia.language.requirements import implied, measured
from lagrangia.language.tree import (
    Assignment,
    Binary,
    Boolean,
    Call,
    CallEquation,
    ClassDefinition,
    Clause,
    Declaration,
    Expression,
    Field,
    Flat,
    ForBlock,
    IfBlock,
    IfExpression,
    Local,
    Number,
    Reference,
    Result,
    Results,
    Section,
    Unary,
    WhileBlock,
    Whole,
)
from lagrangia.language.truths import number_of, truth_of
from lagrangia.language.whole_numbers import WholeNumbers, refuse_broken

_MOST_PASSES = 10_000  # of one while loop
_STATEMENT = 2  # what an assignment costs beside its expression, in operations of Work
_ASSERTED = "assert#"  # with a number: what a condition compares, as the name of a local variable
_KINDS = ("Real", "Integer", "Boolean")
_TEXTS = ("String", ENUMERATION)
_ASSIGN = "write: name := expression;"


class Functions:
    """Those of a model, each made once for what calls give; `flat` has their results by names of their own."""

    names: Names

    def __init__(self) -> None:
        self.flat: dict[str, FlatFunction] = {}
        self._built: dict[tuple[str, str], Built] = {}
        self._unfinished: list[str] = []

    def define(self, definition: ClassDefinition, given: Given, span: Span) -> Built:
        """For what a call at `span` gives. Raises LagError for a function that has no output, calls itself, or does what no
        formula can say."""
        name, key = definition.name, (definition.name, given.signature())
        if name in self._unfinished:
            chain = " > ".join([*self._unfinished, name])
            fail("L0212", f"the function '{name}' calls itself", span, chain, "a loop in its algorithm may do the same")
        if key not in self._built:
            self._unfinished.append(name)
            try:
                self._built[key] = _Builder(definition, given, self.names, span).build()
                self.flat.update(self._built[key].functions)
            finally:
                self._unfinished.pop()
        return self._built[key]


class _Builder:
    def __init__(self, definition: ClassDefinition, given: Given, names: Names, span: Span) -> None:
        self.definition, self.shapes, self.names, self.span = definition, given.shapes, names, span
        self.constants_given = given.constants
        self.declarations = [e for e in definition.elements if isinstance(e, Declaration)]
        self.declared = {d.name: d for d in self.declarations}
        self.inputs = [d for d in self.declarations if "input" in d.prefixes and d.name in given.shapes]
        self.trees: dict[str, Tree] = {}
        self.units: dict[str, str] = {}
        self.whole: set[str] = set()  # leaves of Integer and Boolean variables
        self.truths: set[str] = set()  # of Boolean ones
        self.numbers = WholeNumbers({}, names.made.functions)
        self.constants: dict[str, Flat] = {}  # of those, while they are known
        # under which name a leaf's value is found; its own, unless branches or arrays gave it
        self.current: dict[str, str] = {}
        self.given: set[str] = set()  # the names that have a value
        self.count = 0
        self.steps: list[tuple[str, Flat]] = []
        self.stem = definition.name + given.signature()
        self.asserted: list[Assertion] = []
        self.gaps: dict[str, FlatFunction] = {}  # what assertions compare with 0
        self.under: list[Flat] = []  # conditions of the branches that are being read
        self._declare_all()

    # ------------------------------------------------------------ variables

    def _declare_all(self) -> None:
        """Inputs first, then what sizes may be made of."""
        others = [d for d in self.declarations if d not in self.inputs]
        plain = [d for d in others if not d.dimensions]
        whole = [d for d in plain if d.type_name in ("Integer", "Boolean")]
        for declaration in (*self.inputs, *plain):
            self._declare(declaration)
        self._start(whole)
        for declaration in others:
            if declaration.dimensions:
                self._declare(declaration)
        self._start([d for d in others if d not in whole])

    def _start(self, declarations: list[Declaration]) -> None:
        """Gives them the values that they begin with."""
        for declaration in declarations:
            if declaration.binding is not None and self._text(declaration) is None:
                self._give(self.trees[declaration.name], declaration.binding, self._scope(declaration.span), self.steps, False)

    def _declare(self, declaration: Declaration) -> None:
        constant = self.constants_given.get(declaration.name) or self._text(declaration)
        shape = self.shapes.get(declaration.name)
        base = self.names.table.base_type(declaration.type_name, declaration.type_span)
        sizes = self._sizes((*declaration.dimensions, *(base.dimensions if base else ())), shape, declaration)
        self._place(declaration, sizes)
        if constant is not None:
            self.constants[declaration.name] = constant
        elif shape is not None:
            self.given.update(leaves_of(self.trees[declaration.name]))

    def _text(self, declaration: Declaration) -> Flat | None:
        """What a text, or a variable of an enumeration, is bound to, as all of it that is known; None for any other variable."""
        base = self.names.table.base_type(declaration.type_name, declaration.type_span)
        if base is None or base.builtin not in _TEXTS or declaration.binding is None:
            return None
        return self._local().flatten(declaration.binding, self._scope(declaration.span))

    def _place(self, declaration: Declaration, sizes: tuple[int, ...]) -> None:
        self.trees[declaration.name] = tree = self._tree(declaration.name, declaration, sizes)
        self.current |= {leaf: leaf for leaf in leaves_of(tree)}

    def _sizes(self, dimensions: tuple[Expression, ...], shape: tuple[int, ...] | None, declaration: Declaration
               ) -> tuple[int, ...]:
        """As they are declared, or given."""
        what = f"'{declaration.name}' of {self.definition.name}"
        if shape is not None and len(shape) != len(dimensions):
            own, other = (f"an array of {n} dimension{'s' if n != 1 else ''}" if n else "a number"
                          for n in (len(dimensions), len(shape)))
            fail("L0303", f"{what} is {own}, and is given {other}", self.span)
        if shape is not None:
            self._place(declaration, shape)  # one size may be made of another: A[:, size(A, 1)]
        found = []
        for k, dimension in enumerate(dimensions):
            if isinstance(dimension, Whole):
                if shape is None:
                    fail("L0214", f"the size of {what} is not said", declaration.name_span,
                         "of inputs alone it may be ':'; write: Real y[size(x, 1)]")
                found.append(shape[k])
                continue
            count = self.names.count_of_literals(dimension) if isinstance(dimension, Reference) else None
            found.append(count or self._local().integer(dimension, self._scope(dimension.span), "the size of an array"))
            if shape is not None and shape[k] != found[-1]:
                fail("L0303", f"{what} is an array of {found[-1]}, and is given one of {shape[k]}", self.span)
        return tuple(found)

    def _tree(self, path: str, declaration: Declaration, sizes: tuple[int, ...]) -> Tree:
        table = self.names.table
        base = table.base_type(declaration.type_name, declaration.type_span)
        if base is None and (record := table.lookup(declaration.type_name, declaration.type_span)).kind == "record":
            return {name: self._tree(f"{path}.{name}", part, (*sizes, *self._sizes(part.dimensions, None, part)))
                    for name, part in table.declared(record).items()}
        is_text = base is not None and (declaration.name in self.constants_given or self._text(declaration) is not None)
        if base is None or (base.builtin not in _KINDS and not is_text):
            fail("L0902", "not supported yet: a function variable that is no number, array or record", declaration.name_span)
        unit = self._unit(declaration, base)
        tree = array_of(path, sizes, str)
        for leaf in leaves_of(tree):
            self.units[leaf] = unit
            if base.builtin != "Real":
                self.whole.add(leaf)
            if base.builtin == "Boolean":
                self.truths.add(leaf)
            elif base.builtin == "Integer":
                self.numbers.locals.add(leaf)
        return tree

    def _unit(self, declaration: Declaration, base: BaseType) -> str:
        said = modification_of((*declaration.arguments, *base.attributes), self._scope(declaration.span), None, declaration.span)
        self.names.report.add(unknown_attributes(self.names.table, declaration, base.builtin, said))
        attributes = {name: inner.value for name, inner in said.children.items() if inner.value is not None}

        def flatten(bound: Bound) -> Flat:
            return self._local().flatten(bound.expression, bound.scope)

        path = f"{self.definition.name}.{declaration.name}"
        for attribute in (name for name in attributes if name in ("min", "max")):
            note_limit(self.names.written, path, attribute, declaration, base.builtin, attributes, flatten)
        display_unit_of(attributes, flatten)
        return unit_of(attributes, flatten)

    # ------------------------------------------------------------ the whole

    def build(self) -> Built:
        definition = self.definition
        outputs = [d for d in self.declarations if "output" in d.prefixes]
        if not outputs:
            fail("L0211", f"the function '{definition.name}' has no output", definition.name_span, "declare one: output Real y;")
        for section in definition.sections:
            self._section(section, self.steps)
        for output in outputs:
            for leaf in leaves_of(self.trees[output.name]):
                if self.current[leaf] not in self.given:
                    fail("L0211", f"the output '{leaf}' is never given a value", output.name_span)
        return self._built(outputs, self.steps)

    def _built(self, outputs: list[Declaration], steps: list[tuple[str, Flat]]) -> Built:
        name = self.definition.name
        inputs = {d.name: self.trees[d.name] for d in self.inputs if d.name not in self.constants_given}
        cells = tuple(leaf for tree in inputs.values() for leaf in leaves_of(tree))
        results = {d.name: self.trees[d.name] for d in outputs}
        is_plain = len(results) == 1 and all(isinstance(tree, str) for tree in (*inputs.values(), *results.values())) and all(
            d.name in inputs for d in self.declarations if "input" in d.prefixes) and name not in FUNCTIONS
        if is_plain:
            last = self.current[outputs[0].name]
            function = self._function(name, cells, tuple(steps), last)
            truths = frozenset({name} if outputs[0].name in self.truths else ())
            made = {name: function} | self.gaps
            return Built(inputs, {outputs[0].name: name}, made, tuple(self.asserted), truths | self.truths)
        stem = self.stem
        functions, named = dict(self.gaps), {}
        for output_name, tree in results.items():
            for leaf in leaves_of(tree):
                full = f"{stem}.{leaf}"
                functions[full] = self._function(full, cells, needed(steps, self.current[leaf]), self.current[leaf])
            named[output_name] = renamed(tree, stem)
        truths = frozenset((*self.truths, *(f"{stem}.{leaf}" for leaf in self.truths)))
        return Built(inputs, named, functions, tuple(self.asserted), truths)

    def _function(self, name: str, inputs: tuple[str, ...], steps: tuple[tuple[str, Flat], ...], output: str) -> FlatFunction:
        whole = frozenset(self.whole - self.truths).intersection(inputs)
        return FlatFunction(name, inputs, self.units, steps, output, self.definition.name_span, whole)

    def _section(self, section: Section, steps: list[tuple[str, Flat]]) -> None:
        if section.kind != "algorithm":
            place = section.clauses[0].span if section.clauses else self.definition.name_span
            fail("L0222", f"a function has an algorithm, no section of this kind ({section.kind})", place,
                 "write: algorithm, and name := expression; below it")
        for clause in section.clauses:
            self._statement(clause, {}, steps)

    def _local(self) -> LocalNames:
        return LocalNames(self.names, self.trees, self.current, self.constants, self.truths, self._assert, self.declared)

    def _assert(self, one: Assertion) -> None:
        """That something holds at this place of the algorithm, where it is reached."""
        self.asserted.append(replace(one, condition=measured(implied(self.under, one.condition), self._gap)))

    def _gap(self, value: Flat) -> Flat:
        """A call of the function of the inputs that a value at this place of the algorithm follows from."""
        place = f"{_ASSERTED}{len(self.gaps)}"
        self.names.work.spend(_STATEMENT + sum(1 for _ in nodes(value)), value.span)
        self.units[place] = ""
        steps = needed([*self.steps, (place, value)], place)
        read = {node.name for _, step in steps for node in nodes(step) if isinstance(node, Local)}
        cells = tuple(leaf for d in self.inputs if d.name not in self.constants_given
                      for leaf in leaves_of(self.trees[d.name]) if leaf in read)
        name = f"{self.stem}.{place}"
        self.gaps[name] = self._function(name, cells, steps, place)
        return Call(name, tuple(Local(cell, value.span) for cell in cells), (), value.span)

    def _scope(self, span: Span, iterators: Iterators | None = None) -> Scope:
        """Local names first: they are members of a stand-in instance whose variables flatten to Local."""
        return Scope(Instance("", self.definition, span), iterators or {})

    # ------------------------------------------------------------ statements

    def _statement(self, clause: Clause, iterators: Iterators, steps: list[tuple[str, Flat]], in_branch: bool = False
                   ) -> None:
        scope = self._scope(clause.span, iterators)
        match clause:
            case Assignment(Reference() as target, value, _):
                self._give(self._target(target, scope), value, scope, steps, in_branch)
            case Assignment(Results(items, span), value, _):
                self._give_several(items, value, span, scope, steps, in_branch)
            case ForBlock(loops, body, _):
                passes = [self._kept(inner.iterators, {one.name for one in loops}, steps)
                          for inner in self._local().loop(loops, scope, body)]
                for values in passes:
                    for part in body:
                        self._statement(part, values, steps, in_branch)
            case WhileBlock():
                self._while(clause, iterators, steps, in_branch)
            case IfBlock(condition, then, otherwise, span):
                flat = self._local().flatten(condition, scope)
                known = fold(flat)
                if isinstance(known, bool):
                    for part in then if known else otherwise:
                        self._statement(part, iterators, steps, in_branch)
                else:
                    self._branch(flat, then, otherwise, iterators, steps, span)
            case CallEquation(Call("assert") as call, span):
                self._assert(read_assertion(call, scope, span, self._local(), self.numbers))
            case _:
                self._refuse(clause)

    def _kept(self, iterators: Iterators, of_loop: Set[str], steps: list[tuple[str, Flat]]) -> Iterators:
        """The values of a loop's iterators, by names of their own: elements of an array are as they were when the loop began."""
        kept = dict(iterators)
        for name in of_loop:
            value = kept[name]
            if not isinstance(value, int) and any(isinstance(node, Local) for node in nodes(value)):
                is_truth = isinstance(value, Binary) and value.operator in CONDITIONS
                self.units[name] = ""
                place = self._fresh(name)
                if self.numbers.broken(value) is None:
                    self.numbers.locals.add(place)
                steps.append((place, number_of(value) if is_truth else value))
                self.given.add(place)
                local = Local(place, value.span)
                kept[name] = truth_of(local) if is_truth else local
        return kept

    def _refuse(self, clause: Clause) -> None:
        if (word := clause.span.text.rstrip(";").strip()) in FOREIGN_WORDS:
            fail("L0901", f"not of this language: {FOREIGN_WORDS[word][0]}", clause.span, FOREIGN_WORDS[word][1])
        fail("L0222", "this is no assignment", clause.span, _ASSIGN)

    def _target(self, target: Reference, scope: Scope) -> Tree:
        """What is given a value. Raises LagError L0204."""
        first = target.parts[0]
        if first.name not in self.trees:
            fail("L0204", f"'{target.span.text}' is no variable of {self.definition.name}", target.span)
        if first.name in {d.name for d in self.inputs}:
            fail("L0222", f"'{first.name}' is an input, which is what a call gives", target.span,
                 f"declare a variable under `protected`: Real z = {first.name};")
        return self._local().picked(target, scope)

    def _give(self, tree: Tree, value: Expression, scope: Scope, steps: list[tuple[str, Flat]], in_branch: bool) -> None:
        """All is computed before anything is given."""
        found = list(self._values(tree, value, scope))
        if isinstance(tree, str):
            ((leaf, flat),) = found
            self._assign(leaf, flat, steps, self._fresh(leaf) if in_branch else leaf)
            return
        for leaf, flat in found:
            self._assign(leaf, flat, steps, self._fresh(leaf))

    def _give_several(self, items: tuple[Expression | None, ...], value: Expression, span: Span, scope: Scope,
                      steps: list[tuple[str, Flat]], in_branch: bool) -> None:
        found: list[tuple[str, Flat]] = []
        for k, item in enumerate(items):
            if item is not None and not isinstance(item, Reference):
                fail("L0222", "this is no variable", item.span, "write: (a, b) := f(x);")
            if isinstance(item, Reference):
                found += self._values(self._target(item, scope), Result(value, k, value.span), scope)
        for leaf, flat in found:
            self._assign(leaf, flat, steps, self._fresh(leaf))

    def _values(self, tree: Tree, value: Expression, scope: Scope) -> Iterable[tuple[str, Flat]]:
        if isinstance(tree, dict):
            return [pair for name, part in tree.items() for pair in self._values(part, Field(value, name, value.span), scope)]
        names = self._local()
        flat = names.flatten(value, scope)
        return dealt(flat, tree, names.size, "what is given a value")

    def _while(self, clause: WhileBlock, iterators: Iterators, steps: list[tuple[str, Flat]], in_branch: bool) -> None:
        for _ in range(_MOST_PASSES):
            known = fold(self._local().flatten(clause.condition, self._scope(clause.span, iterators)))
            if not isinstance(known, bool):
                fail("L0902", "not supported yet: a while loop whose passes what is computed decides", clause.condition.span,
                     "a loop has as many passes as is known when the scene is compiled, by Integer variables and sizes: "
                     "for k in 1:20 loop ... end for; with an if in it for what the remaining passes do")
            if not known:
                return
            self.names.work.spend(len(clause.body), clause.span)
            for part in clause.body:
                self._statement(part, iterators, steps, in_branch)
        fail("L0209", f"a loop of more than {_MOST_PASSES} passes", clause.span)

    def _assign(self, leaf: str, value: Flat, steps: list[tuple[str, Flat]], place: str, is_merged: bool = False) -> None:
        self.constants.pop(leaf, None)
        if leaf in self.whole and (known := fold(value)) is not None:
            self.constants[leaf] = Boolean(known, value.span) if isinstance(known, bool) else (
                Number(float(known), None, value.span, float(known).is_integer()))
        self.names.work.spend(_STATEMENT + sum(1 for _ in nodes(value)), value.span)
        if leaf not in self.truths:
            refuse_no_number(value)
        elif not is_merged:  # of numbers already
            value = number_of(value)
        if leaf in self.whole - self.truths:
            self._note_whole(place, value)
        steps.append((place, value))
        self.given.add(place)
        self.current[leaf] = place

    def _note_whole(self, place: str, value: Flat) -> None:
        """Of what an Integer variable is given. Raises LagError L0302."""
        if (wrong := self.numbers.broken(value)) is not None:
            refuse_broken(wrong)
        self.numbers.locals.add(place)

    def _fresh(self, name: str) -> str:
        self.count += 1
        place = f"{name}#{self.count}"
        self.units[place] = self.units[name]
        return place

    def _branch(self, condition: Flat, then: tuple[Clause, ...], otherwise: tuple[Clause, ...], iterators: Iterators,
                steps: list[tuple[str, Flat]], span: Span) -> None:
        """Both branches with fresh names, then one if expression for each variable that either assigns, under a fresh name too:
        what the condition and the other values read stays as it was. What one branch alone gives a value has none behind them."""
        before, known, ends, kept = self.current, self.constants, [], []
        for clauses, taken in ((then, condition), (otherwise, Unary("not", condition, condition.span))):
            self.current, self.constants = dict(before), dict(known)
            self.under.append(taken)
            for clause in clauses:
                self._statement(clause, iterators, steps, in_branch=True)
            self.under.pop()
            ends.append(self.current)
            kept.append(self.constants)
        self.current = dict(before)
        self.constants = {leaf: value for leaf, value in kept[0].items()
                          if leaf in kept[1] and fold(kept[1][leaf]) == fold(value)}
        for name, old in before.items():
            places = [end[name] for end in ends]
            if places != [old, old] and self.given.issuperset(places):
                taken, other = (Local(place, span) for place in places)
                constant = self.constants.get(name)
                self._assign(name, IfExpression(condition, taken, other, span), steps, self._fresh(name), is_merged=True)
                if constant is not None:
                    self.constants[name] = constant
