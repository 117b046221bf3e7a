"""What is said of a scene that is too large to read: its energies, component by component, and which coordinates act on which."""

from collections.abc import Mapping

import sympy as sp

from lagrangia.algebra.normal_form import TooLarge
from lagrangia.algebra.with_sympy import Expr, exact_throughout
from lagrangia.dynamics.energies import Term
from lagrangia.paper.document import Block, Display, Document, Heading, Inline, Table, display, paragraph, say
from lagrangia.paper.grouping import Symbols
from lagrangia.paper.layout import Grid, Name, Node, Relation, Words, added
from lagrangia.paper.notation import own_name
from lagrangia.paper.presentation import Presentation
from lagrangia.paper.symbolic import SymbolicScene
from lagrangia.paper.textbook import loads_of, ranks, weights_of

_MOST_SHOWN = 40
_MOST_LETTERS = 400
_PRODUCTS_OF_A_TERM = 3_000


def structure_page(scene: SymbolicScene, names: Mapping[Expr, Name], large: TooLarge) -> Document:
    """`large` says how large."""
    model = scene.kinematics.graph.model
    n, m = len(scene.q), len(scene.rows)
    is_kinetic = large.kinetic is not None and large.terms == len(large.kinetic.args)
    counts = str(n), str(m), str(large.terms)
    if is_kinetic:
        size = say("Coordinates: {0}; constraints: {1}; terms in the kinetic energy alone: {2}.", *counts)
    elif large.kinetic is not None:
        size = say("Coordinates: {0}; constraints: {1}; terms in the equations of motion: {2}.", *counts)
    else:
        size = say("Coordinates: {0}; constraints: {1}; terms in the equations of motion: more than {2}.", *counts)
    if scene.turnings:  # whose small motion is told by lag linearize alone
        told = say("That is too many to read. Here are the energies and the structure; --force writes everything.")
    else:
        told = say("That is too many to read. Here are the energies and the structure; --form linear gives the small motion, "
                   "--force writes everything.")
    blocks: list[Block] = [paragraph(f"{model.description}.")] if model.description else []
    blocks += [paragraph(size, " ", told), _coordinates(scene, names)]
    e = scene.energies
    for heading, base, terms in ((say("Kinetic energy"), "T", e.kinetic), (say("Potential energy"), "V", e.potential),
                                 (say("Dissipation function"), "D", e.dissipation)):
        lines = _terms(scene, names, base, terms)
        blocks += [Heading(heading, 2), *display(lines)] if lines else []
    return Document(model.name, (*blocks, *(_pattern(scene, large.kinetic) if large.kinetic is not None else [])))


def _coordinates(scene: SymbolicScene, names: Mapping[Expr, Name]) -> Block:
    pairs: list[tuple[Inline, ...]] = [(names[q], name) for q, name in zip(scene.q, scene.names, strict=True)]
    left = len(pairs) - _MOST_SHOWN
    more: list[tuple[Inline, ...]] = [("...", say("and {0} more", str(left)))] if left > 0 else []
    return Table(("", say("in the model")), (*pairs[:_MOST_SHOWN], *more))


def _terms(scene: SymbolicScene, names: Mapping[Expr, Name], base: str, terms: tuple[Term, ...]) -> list[Node]:
    """Each component's energy as it is stated, where that can be written in a few lines."""
    components: dict[str, list[Term]] = {}
    for term in terms:
        if term.value != 0:
            components.setdefault(term.component, []).append(term)
    lines: list[Node] = []
    for component, mine in list(components.items())[:_MOST_SHOWN]:
        name = own_name(base, component.replace(".", " ").replace("[", " ").replace("]", ""), names.values())
        lines.append(Relation(name, _stated(scene, names, mine)))
    left = len(components) - _MOST_SHOWN
    return [*lines, *([Words(f"... and {left} more")] if left > 0 else [])]


def _stated(scene: SymbolicScene, names: Mapping[Expr, Name], terms: list[Term]) -> Node:
    moving = frozenset({scene.t, *scene.inputs.values(), *(x for g in scene.given for x in g.moving)})
    symbols = Symbols(names, ranks(scene), scene.placed, scene.v, scene.a, (), moving, 0, {}, loads_of(scene), weights_of(scene))
    presentation = Presentation(symbols, _PRODUCTS_OF_A_TERM)
    values = [exact_throughout(term.value) for term in terms]
    try:
        if sum(_letters(x) for x in values) <= _MOST_LETTERS:
            return added(*(presentation.gentle(x) for x in values))
    except TooLarge:
        pass
    return Words(f"({sum(sp.count_ops(x) for x in values)} operations)")


def _letters(x: Expr) -> int:
    """How many leaves the tree has, counted no further than matters."""
    count, stack = 0, [x]
    while stack and count <= _MOST_LETTERS:
        node = stack.pop()
        count += not node.args
        stack.extend(node.args)
    return count


def _pattern(scene: SymbolicScene, T: Expr) -> list[Block]:
    """Which entries of M are there: the rates whose products stand in T."""
    if len(scene.v) > _MOST_SHOWN:
        return []
    rates = set(scene.v)
    pairs = {frozenset(term.free_symbols & rates) for term in sp.Add.make_args(T)}
    rows = tuple(tuple(Words("•" if frozenset((a, b)) in pairs else "·") for b in scene.v) for a in scene.v)
    return [Heading(say("Structure"), 2), paragraph(say("The mass matrix couples the coordinates so:")),
            Display((Relation(Name("M", is_bold=True), Grid(rows)),))]
