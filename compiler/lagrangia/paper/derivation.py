"""The whole derivation, step by step, as a textbook writes it."""

import sympy as sp

from lagrangia.algebra.with_sympy import Expr, exact_throughout
from lagrangia.frames.planar import ANGLES, LENGTHS
from lagrangia.language.flat import Energy, Work
from lagrangia.language.frame_attributes import COMPONENTS
from lagrangia.language.mentions import leaves
from lagrangia.language.tree import FrameRef
from lagrangia.paper.book import (
    Book,
    constants_block,
    constraints_block,
    coordinates_table,
    equal,
    events_block,
    generic,
    given_functions,
    lengths,
    parameters_table,
    time_derivative,
)
from lagrangia.paper.document import Block, Display, Document, Heading, display, paragraph
from lagrangia.paper.forms import component_sub, energy_blocks, force_blocks, force_name, matrix_blocks, opening, title
from lagrangia.paper.layout import Name, Node, Slope


def worked_form(book: Book) -> Document:
    """The derivation step by step: coordinates, positions, energies, equations."""
    e = book.equations
    blocks = [*opening(book), *_coordinates(book), *_parameters(book), *_positions(book), *energy_blocks(book)]
    roots = lengths(book)
    if roots:
        blocks += [paragraph("with"), Display(tuple(roots))]
    blocks += force_blocks(book)
    if e.rows:
        blocks += [Heading("Constraints", 2), *constraints_block(book), *_jacobian(book)]
    blocks += [Heading("Lagrange's equations", 2), Display((generic(book),))]
    for k in range(e.n):
        blocks += _coordinate(book, k)
    blocks += [Heading("The equations of motion", 2), Display(tuple(_equation(book, k) for k in range(e.n)))]
    blocks += [Heading("In matrix form", 2), *matrix_blocks(book), *events_block(book), *constants_block(book)]
    return Document(f"{title(book)}: the equations of motion", tuple(blocks))


def _coordinates(book: Book) -> list[Block]:
    """The coordinates that are left, those that others give, and what is prescribed."""
    e = book.equations
    degrees = e.n - len(e.rows)
    many = "one coordinate" if e.n == 1 else f"{e.n} coordinates"
    left = f" and {len(e.rows)} constraint{'s' if len(e.rows) > 1 else ''}" if e.rows else ""
    freedom = f", {degrees} degree{'s' if degrees != 1 else ''} of freedom" if e.rows and degrees > 0 else ""
    blocks: list[Block] = [Heading("Coordinates", 2), paragraph(f"The system has {many}{left}{freedom}.")]
    blocks += coordinates_table(book)
    functions = given_functions(book)
    return [*blocks, *([paragraph("Given:"), *display(functions)] if functions else [])]


def _parameters(book: Book) -> list[Block]:
    table = parameters_table(book)
    return [Heading("Parameters", 2), *table] if table else []


# -------------------------------------------------------------------- positions


def _positions(book: Book) -> list[Block]:
    """Where the frames are that energies and loads speak of, and how they move; frames that coincide share a row."""
    kinematics = book.equations.scene.kinematics
    model = kinematics.graph.model
    statements: list[Energy | Work] = [*model.energies, *model.works]
    places: dict[tuple[Expr, ...], list[str]] = {}
    for name in _frames(book, statements):
        pose = kinematics.pose(name, 0)
        key = tuple(book.equations.ring.tidy(exact_throughout(x)) for x in pose.place)
        places.setdefault(key, []).append(name)
    moving = {key: names for key, names in places.items() if any(book.presentation.symbols.moves(x) for x in key)}
    if not moving:
        return []
    blocks: list[Block] = [Heading("Positions and velocities", 2)]
    for names in moving.values():
        blocks += _place(book, names)
    return blocks


def _place(book: Book, names: list[str]) -> list[Block]:
    """The place of frames that share it, and its rate: lengths and their rates, then angles that are not 0."""
    kinematics, tidy = book.equations.scene.kinematics, book.equations.ring.tidy
    place = [tidy(exact_throughout(x)) for x in kinematics.pose(names[0], 0).place]
    twist = [exact_throughout(x) for x in kinematics.pose(names[0], 1).twist]
    sub = component_sub(names[0].removesuffix(".center"))
    labels = [component.name for component in COMPONENTS]
    lines: list[Node] = [equal(Name(label, sub, 0), book.sum(x))
                         for label, x in zip(labels[LENGTHS], place[LENGTHS], strict=True)]
    lines += [equal(Name(label, sub, 1), book.presentation.motion(x))
              for label, x in zip(labels[LENGTHS], twist[LENGTHS], strict=True)]
    lines += [equal(Name(label, sub, marks), book.sum(x))
              for label, phi, w in zip(labels[ANGLES], place[ANGLES], twist[ANGLES], strict=True) if phi != 0
              for marks, x in ((0, phi), (1, tidy(w)))]
    return [paragraph(f"{', '.join(names)}:"), Display(tuple(lines))]


def _frames(book: Book, statements: "list[Energy | Work]") -> list[str]:
    model = book.equations.scene.kinematics.graph.model
    bindings = {name: v.binding for name, v in model.variables.items() if v.kind == "variable"}
    roots = [x for s in statements for x in ((s.value,) if isinstance(s, Energy) else (s.force, s.position))]
    found = [leaf.name for leaf in leaves(roots, bindings) if isinstance(leaf, FrameRef)]
    return sorted(dict.fromkeys(found), key=list(model.frames).index)


# -------------------------------------------------------------------- steps


def _coordinate(book: Book, k: int) -> list[Block]:
    """Every partial derivative of one coordinate's equation, and the equation."""
    e, q, rate = book.equations, book.q[k], book.rate(k)
    step = time_derivative(book.partial("T", rate))
    lines: list[Node] = [equal(book.partial("T", rate), book.presentation.momentum(e.momenta[k])),
                         equal(step, book.presentation.kept(e.momentum_rates[k], sp.S.Zero, k).left),
                         equal(book.partial("T", q), book.sum(e.dT_dq[k]))]
    if e.V_elastic != 0 or e.V_field != 0:
        lines.append(equal(book.partial("V", q), book.sum(e.dV_dq[k])))
    if e.D != 0:
        lines.append(equal(book.partial("D", rate), book.sum(e.dD_dv[k])))
    if any(f != 0 for f in e.f):
        lines.append(equal(force_name(book, k), book.sum(e.f[k])))
    lines += _reaction(book, k)
    return [paragraph("For ", q, ":"), Display(tuple(lines)), paragraph("so that"), Display((_equation(book, k),))]


def _reaction(book: Book, k: int) -> list[Node]:
    e = book.equations
    found: list[Node] = []
    for i, row in enumerate(e.J):
        name = Name("Phi", str(i + 1) if len(e.rows) > 1 else "")
        if row[k] != 0 and i < e.scene.holonomic:
            found.append(equal(Slope(name, book.q[k]), book.sum(row[k])))
        elif row[k] != 0:
            found.append(equal(Slope(name, book.rate(k)), book.sum(row[k])))
    return found


def _equation(book: Book, k: int) -> Node:
    e = book.equations
    return book.presentation.equation(e.left[k] + e.reactions[k], e.f[k], k)


def _jacobian(book: Book) -> list[Block]:
    e = book.equations
    rows = range(e.scene.holonomic)
    if not rows:
        return []
    count = len(e.rows)
    rates: list[Node] = []
    for i in rows:
        name = Name("Phi", str(i + 1) if count > 1 else "", 1)
        rates.append(equal(name, equal(book.sum(e.ring.tidy(e.scene.time_rate(e.rows[i]))), book.sum(sp.S.Zero))))
    return [paragraph("and so for the rates"), Display(tuple(rates))]
