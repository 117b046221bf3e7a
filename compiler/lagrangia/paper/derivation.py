"""The whole derivation as a textbook develops it: from virtual work to Lagrange's equations, a section a step."""

from collections.abc import Callable, Mapping

from lagrangia.base.diagnostics import fail, suggest
from lagrangia.paper.book import (
    Book,
    constants_block,
    constraints_block,
    coordinates_table,
    equal,
    events_block,
    given_functions,
    lengths,
    parameters_table,
    positive_block,
)
from lagrangia.paper.document import Block, Display, Document, Heading, Inline, display, lettered, paragraph
from lagrangia.paper.energy_steps import dissipation, kinetic, potential
from lagrangia.paper.equation_steps import equations_of_motion, forces
from lagrangia.paper.forms import matrix_blocks, opening, title
from lagrangia.paper.layout import Name, Node, Slope
from lagrangia.paper.linear_matrices import Linear
from lagrangia.paper.small_steps import small_motion
from lagrangia.paper.virtual_steps import positions, principle

Section = Callable[[Book, "Linear | None"], list[Block]]


def worked_form(book: Book, linear: Linear | None) -> Document:
    """The derivation; `linear` is its small motion, where there is one. Raises LagError L0704 for an unknown section."""
    for name in book.sections:
        if name not in SECTIONS:
            fail("L0704", f"--sections: there is no section '{name}'", None, *filter(None, [suggest(name, SECTIONS)]),
                 f"the sections are {', '.join(SECTIONS)}")
    wanted = book.sections or [name for name in SECTIONS if book.level != "short" or name not in _LONG]
    blocks = [block for name in SECTIONS if name in wanted for block in SECTIONS[name](book, linear)]
    return lettered(Document(f"{title(book)}: the equations of motion", tuple(blocks)), book.first_letter)


def exercise_form(book: Book) -> Document:
    """The statement of a problem: the scene, its coordinates and data, and what is asked, without the solution."""
    asked = "Derive the equation of motion of each coordinate by Lagrange's equations."
    blocks = [*_system(book, None), *_coordinates(book, None), *_data(book, None), Heading("Problem", 2), paragraph(asked)]
    return Document(f"{title(book)}: an exercise", tuple(blocks))


def _system(book: Book, _: Linear | None) -> list[Block]:
    """What it is, and what is assumed."""
    e, p = book.equations, book.parts
    weights = bool(book.presentation.symbols.weights & _used(book))
    words: list[Inline] = [f"Assumed: {'' if weights else 'no '}gravity acts; joints are ideal, their forces do no virtual work"]
    if p.sources:
        names = ", ".join(dict.fromkeys(load.statement.component for load, _ in p.sources))
        words += [f"; {names}, given in time, {'have potentials' if len(p.sources) > 1 else 'has a potential'}"]
    others = list(dict.fromkeys(x.statement.component or "a force of the model" for x in (*p.applied, *p.drags)))
    words += [f"; {', '.join(others)}: by virtual work alone"] if others else []
    unit = [paragraph("Events: between them the equations hold.")] if e.scene.events else []
    return [Heading("System", 2), *opening(book), paragraph(*words, "."), *positive_block(book), *unit]


def _used(book: Book) -> set[object]:
    e = book.equations
    return set(e.V_field.free_symbols) | {x for f in e.f for x in f.free_symbols}


def _coordinates(book: Book, _: Linear | None) -> list[Block]:
    """The coordinates that are left, those that others give, and how many degrees of freedom there are."""
    e = book.equations
    degrees = e.n - len(e.rows)
    many = "one generalised coordinate" if e.n == 1 else f"{e.n} generalised coordinates"
    if e.rows:
        held = "a constraint" if len(e.rows) == 1 else f"{len(e.rows)} constraints"
        why = f"{many} under {held} leave {degrees} degree{'s' if degrees != 1 else ''} of freedom."
    else:
        why = f"The position is known by {many}, which nothing ties: {degrees} degree{'s' if degrees > 1 else ''} of freedom."
    why = why[0].upper() + why[1:]
    names: list[Inline] = []
    for k, q in enumerate(book.q):
        names += [", " if k else "", Name(q.base, q.sub, prefix="δ")]
    return [Heading("Coordinates", 2), paragraph(why), *coordinates_table(book),
            paragraph("The virtual displacements ", *names, " are arbitrary, simultaneous, and taken at a fixed time",
                      ", but for the constraints." if e.rows else ".")]


def _data(book: Book, _: Linear | None) -> list[Block]:
    table, functions = parameters_table(book), given_functions(book)
    found: list[Block] = [*table, *([paragraph("Given:")] if functions else []), *display(functions)]
    return [Heading("Data", 2), *found] if found else []


def _constraints(book: Book, _: Linear | None) -> list[Block]:
    e = book.equations
    if not e.rows:
        return []
    slopes: list[Node] = []
    for i, row in enumerate(e.J):
        label = str(i + 1) if len(e.rows) > 1 else ""
        for k, x in enumerate(row):
            if x != 0:
                name, q = Name("Phi", label), book.q[k] if i < e.scene.holonomic else book.rate(k)
                slopes.append(equal(Slope(name, q), book.sum(x)))
    return [Heading("Constraints", 2), *constraints_block(book), paragraph("with the slopes"), Display(tuple(slopes)),
            paragraph("Each multiplier is the generalised force that keeps its constraint.")]


def _matrices(book: Book, _: Linear | None) -> list[Block]:
    return [Heading("In matrix form", 2), *matrix_blocks(book), *events_block(book)]


def _constants(book: Book, _: Linear | None) -> list[Block]:
    return constants_block(book)


def _potential(book: Book, _: Linear | None) -> list[Block]:
    roots = lengths(book)
    return [*potential(book), *([paragraph("with")] if roots else []), *display(roots)]


SECTIONS: Mapping[str, Section] = {
    "system": _system, "coordinates": _coordinates, "data": _data, "positions": lambda b, _: positions(b),
    "principle": lambda b, _: principle(b), "kinetic": lambda b, _: kinetic(b), "potential": _potential,
    "dissipation": lambda b, _: dissipation(b), "forces": lambda b, _: forces(b), "constraints": _constraints,
    "equations": lambda b, _: equations_of_motion(b), "small": small_motion, "matrices": _matrices, "constants": _constants,
}
_LONG = ("positions", "principle", "forces", "small")  # left out of the short derivation
