"""The whole derivation as a textbook develops it: from virtual work to Lagrange's equations, a section a step."""

from collections.abc import Callable, Mapping

from lagrangia.base.diagnostics import fail, suggest
from lagrangia.constraints.rows import Row
from lagrangia.frames.closures import gap_of
from lagrangia.frames.kinematics import Kinematics
from lagrangia.paper.book import (
    Book,
    constraints_block,
    coordinates_table,
    equal,
    events_block,
    given_functions,
    lengths,
    parameters_table,
    positive_block,
)
from lagrangia.paper.check_steps import checks
from lagrangia.paper.document import Block, Display, Document, Heading, Inline, display, lettered, paragraph, say
from lagrangia.paper.energy_steps import dissipation, kinetic, potential
from lagrangia.paper.equation_steps import equations_of_motion, forces
from lagrangia.paper.forms import matrix_blocks, opening, title
from lagrangia.paper.layout import Name, Node, Slope
from lagrangia.paper.linear_matrices import Linear
from lagrangia.paper.reduction import constants_and_rest
from lagrangia.paper.singular import singular_places
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
    return lettered(Document(say("{0}: the equations of motion", title(book)), tuple(blocks)), book.first_letter)


def exercise_form(book: Book) -> Document:
    """The statement of a problem: the scene, its coordinates and data, and what is asked, without the solution."""
    asked = say("Derive the equation of motion of each coordinate by Lagrange's equations.")
    blocks = [*_system(book, None), *_coordinates(book, None), *_data(book, None), Heading(say("Problem"), 2), paragraph(asked)]
    return Document(say("{0}: an exercise", title(book)), tuple(blocks))


def _system(book: Book, _: Linear | None) -> list[Block]:
    """What it is, and what is assumed."""
    e, p = book.equations, book.parts
    weights = book.presentation.symbols.weights
    gravity = say("Assumed: gravity acts") if weights & _used(book) else \
        say("Assumed: gravity does no work here") if weights else say("Assumed: no gravity acts")
    words: list[Inline] = [gravity, "; ", say("joints are ideal, their forces do no virtual work")]
    if p.sources:
        names = ", ".join(dict.fromkeys(load.statement.component for load, _ in p.sources))
        words += ["; ", say("{0}, given in time, have potentials", names) if len(p.sources) > 1 else
                  say("{0}, given in time, has a potential", names)]
    others: list[Inline] = []
    for name in dict.fromkeys(x.statement.component for x in (*p.applied, *p.drags)):
        others += [", " if others else "", name or say("a force of the model")]
    words += ["; ", say("{0}: by virtual work alone", others)] if others else []
    unit = [paragraph(say("Events: between them the equations hold."))] if e.scene.events else []
    return [Heading(say("System"), 2), *opening(book), paragraph(*words, "."), *positive_block(book), *unit]


def _used(book: Book) -> set[object]:
    e = book.equations
    return set(e.V_field.free_symbols) | {x for f in e.f for x in f.free_symbols}


def _coordinates(book: Book, _: Linear | None) -> list[Block]:
    """The coordinates that are left, those that others give, and how many degrees of freedom there are."""
    e = book.equations
    degrees = e.n - len(e.rows)
    if e.rows:
        why = say("Generalised coordinates: {0}; constraints that tie them: {1}; degrees of freedom that are left: {2}.",
                  str(e.n), str(len(e.rows)), str(degrees))
    elif e.n == 1:
        why = say("The position is known by one generalised coordinate, which nothing ties: 1 degree of freedom.")
    else:
        why = say("The position is known by {0} generalised coordinates, which nothing ties: {0} degrees of freedom.", str(e.n))
    names: list[Inline] = []
    for k, q in enumerate(book.q):
        names += [", " if k else "", Name(q.base, q.sub, prefix="δ")]
    free = say("The virtual displacements {0} are arbitrary, simultaneous, and taken at a fixed time.", names)
    tied = say("The virtual displacements {0} are arbitrary but for the constraints, simultaneous, and taken at a fixed time.",
               names)
    return [Heading(say("Coordinates"), 2), paragraph(why), *coordinates_table(book), paragraph(tied if e.rows else free)]


def _data(book: Book, _: Linear | None) -> list[Block]:
    table, functions = parameters_table(book), given_functions(book)
    found: list[Block] = [*table, *([paragraph(say("Given:"))] if functions else []), *display(functions)]
    return [Heading(say("Data"), 2), *found] if found else []


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
    return [Heading(say("Constraints"), 2), *constraints_block(book), paragraph(say("with the slopes")), Display(tuple(slopes)),
            paragraph(say("Each multiplier is the force that keeps its constraint: {0}.", _holders(book)))]


def _holders(book: Book) -> list[Inline]:
    """What each multiplier is: lambda d(gap) is the work on the frame before the cut joint."""
    names = [book.presentation.symbols.names[x] for x in book.equations.multipliers]
    found: list[Inline] = []
    for name, row in zip(names, book.equations.scene.kept, strict=True):
        found += ["; " if found else "", _holder(name, row, book.equations.scene.kinematics)]
    return found


def _holder(name: Name, row: Row, kinematics: Kinematics) -> Inline:
    if row.loop is None:
        return say("{0} of '{1}'", name, row.span.text.rstrip("; "))
    joint, frame = (row.loop.coordinate or row.loop.kept).rpartition(".")[0] or row.loop.around, row.loop.a
    match gap_of(kinematics, row.loop, row.part):
        case "angle":
            return say("{0} the torque in {1}, on {2}", name, joint, frame)
        case "across":
            return say("{0} the force across {1}, on {2}", name, joint, frame)
        case axis:
            return say("{0} the force along {1} in {2}, on {3}", name, Name(axis), joint, frame)


def _matrices(book: Book, _: Linear | None) -> list[Block]:
    return [Heading(say("In matrix form"), 2), *matrix_blocks(book), *singular_places(book), *events_block(book)]


def _constants(book: Book, _: Linear | None) -> list[Block]:
    return constants_and_rest(book)


def _potential(book: Book, _: Linear | None) -> list[Block]:
    roots = lengths(book)
    return [*potential(book), *([paragraph(say("with"))] if roots else []), *display(roots)]


SECTIONS: Mapping[str, Section] = {
    "system": _system, "coordinates": _coordinates, "data": _data, "positions": lambda b, _: positions(b),
    "principle": lambda b, _: principle(b), "kinetic": lambda b, _: kinetic(b), "potential": _potential,
    "dissipation": lambda b, _: dissipation(b), "forces": lambda b, _: forces(b), "constraints": _constraints,
    "equations": lambda b, _: equations_of_motion(b), "small": small_motion, "matrices": _matrices, "constants": _constants,
    "checks": lambda b, _: checks(b),
}
_LONG = ("positions", "principle", "forces", "small", "checks")  # left out of the short derivation
