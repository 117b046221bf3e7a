"""Names in a function: its own variables, and the functions and constants of the kernel."""

from collections.abc import Callable, Mapping, Set
from dataclasses import replace

from lagrangia.base.diagnostics import Span, fail
from lagrangia.language.component_sizes import shape_of_records
from lagrangia.language.enumerations import ordinal_of, subscripts_of
from lagrangia.language.function_variables import Assertion, Tree, flat_of, part_of
from lagrangia.language.instances import Scope
from lagrangia.language.names import Names
from lagrangia.language.requirements import implied, with_cells
from lagrangia.language.tree import Array, Call, Declaration, Expression, Flat, Local, Ref, Reference, Whole
from lagrangia.language.truths import truth_of

_OF_SCENES = {"virtual": "it belongs in an equation between positions: give the function what it needs of it",
              "pre": "give the function the value before: f(pre(x))"}


class LocalNames(Names):
    """Name resolution inside a function: its own variables, and the functions and constants of the kernel."""

    def __init__(self, names: Names, trees: Mapping[str, Tree], current: Mapping[str, str], constants: Mapping[str, Flat],
                 truths: Set[str], asserts: Callable[[Assertion], None], declared: Mapping[str, Declaration]) -> None:
        super().__init__(names.table, names.report, names.define, work=names.work, made=names.made,
                         lookups=names.lookups, make_package=names.make_package,
                         packages=names.packages, written=names.written, space=names.space)
        self.trees, self.current, self.constants, self.truths, self.asserts = trees, current, constants, truths, asserts
        self.declared = declared

    def require(self, one: Assertion, cells: Mapping[str, Flat], span: Span, scope: Scope) -> None:
        """Of a function that is called here: it has to hold here, too."""
        self.asserts(replace(one, condition=implied(self.under, with_cells(one.condition, cells))))

    def late(self, call: Call[Flat]) -> Ref:
        """Raises LagError L0901."""
        fail("L0901", "not supported yet: delay in a function", call.span, "delay what the function is given, or what it gives")

    def checked_call(self, node: Call[Flat]) -> Flat:
        """Raises LagError L0302 for what has a meaning in a scene alone."""
        if node.function in _OF_SCENES:
            fail("L0302", f"{node.function}(...) cannot stand in a function", node.span, _OF_SCENES[node.function])
        return super().checked_call(node)

    def fields(self, node: Expression, scope: Scope) -> list[str]:
        """The names of what a record has that a name stands for; none for anything else."""
        if isinstance(node, Reference) and node.parts[0].name in self.trees:
            tree = self.picked(node, scope)
            return list(tree) if isinstance(tree, dict) else []
        return super().fields(node, scope)

    def shape_of_components(self, node: Expression, scope: Scope) -> tuple[int, ...] | None:
        """Of an array of records; None for anything else."""
        if not isinstance(node, Reference) or node.parts[0].name not in self.trees:
            return super().shape_of_components(node, scope)
        return shape_of_records(self.picked(node, scope), node, self.declared, self.table)

    def picked(self, node: Reference, scope: Scope) -> Tree:
        """The variable, or what of it is named. Raises LagError L0214, L0216."""
        tree, subscripts = self.trees[node.parts[0].name], list(node.parts[0].subscripts)
        for part in node.parts[1:]:
            tree = part_of(tree, part.name, part.span)
            subscripts += part.subscripts
        return self._at(tree, subscripts, scope, node.span)

    def _at(self, tree: Tree, subscripts: list[Expression], scope: Scope, span: Span) -> Tree:
        if not subscripts:
            return tree
        if isinstance(tree, dict):
            return {name: self._at(part, subscripts, scope, span) for name, part in tree.items()}
        if isinstance(tree, str):
            fail("L0214", f"'{span.text}' has more subscripts than dimensions", span)
        picks = self._picks(subscripts[0], len(tree), scope)
        for pick in [picks] if isinstance(picks, int) else picks:
            if not 1 <= pick <= len(tree):
                fail("L0214", f"there are {len(tree)} elements, not {pick}", span)
        if isinstance(picks, int):
            return self._at(tree[picks - 1], subscripts[1:], scope, span)
        return tuple(self._at(tree[pick - 1], subscripts[1:], scope, span) for pick in picks)

    def _picks(self, node: Expression, size: int, scope: Scope) -> int | list[int]:
        if isinstance(node, Whole):
            return list(range(1, size + 1))
        inner = scope.bind("end", size)
        flat = self.flatten(node, inner)
        if (ordinal := ordinal_of(flat)) is not None:
            return ordinal
        if not isinstance(flat, Array):
            return self.integer(node, inner, "a subscript")
        return subscripts_of(flat.items, node.span)

    def resolve(self, node: Reference, scope: Scope) -> Flat:
        """What a name stands for in the function. Raises LagError L0204."""
        name = node.parts[0].name
        if name in self.trees and name not in scope.iterators:
            return flat_of(self.picked(node, scope), lambda leaf: self._leaf(leaf, node.span), node.span)
        if name == "time":
            fail("L0204", "a function knows no time", node.span, "pass it as an input")
        return super().resolve(node, scope)

    def _leaf(self, leaf: str, span: Span) -> Flat:
        local = Local(self.current[leaf], span)
        return self.constants.get(leaf) or (truth_of(local) if leaf in self.truths else local)
