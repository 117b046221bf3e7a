"""What all forms share: the equations with their layouts, and the parts that stand in several of them."""

from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from fractions import Fraction
from functools import cached_property

import sympy as sp

from lagrangia.algebra.with_sympy import Expr, exact_throughout
from lagrangia.base.records import dataclass
from lagrangia.dynamics.energies import Term
from lagrangia.frames.joints import component_of
from lagrangia.language.frame_attributes import component_named
from lagrangia.paper.document import Block, Display, Heading, Inline, Table, display, paragraph, say
from lagrangia.paper.equations import Constant, Equations
from lagrangia.paper.layout import (
    ZERO,
    Grid,
    Name,
    Node,
    Numeral,
    Phrase,
    Power,
    Product,
    Relation,
    Root,
    Slope,
    Total,
    Words,
    added,
    negative,
    product,
    total,
)
from lagrangia.paper.notation import is_own, own_name
from lagrangia.paper.parts import Parts, parts_of
from lagrangia.paper.presentation import Presentation
from lagrangia.paper.typeset import line, text
from lagrangia.paper.widths import typeset_width

WIDEST_MATRIX = 96  # with what indents it, a line of 100
WIDEST_TYPESET = 70.0  # half ems, on pages of A4


@dataclass(frozen=True)
class Book:
    """`values` are the parameters' numbers by source name, `starts` the coordinates' at the start."""

    equations: Equations
    presentation: Presentation
    names: Mapping[Expr, Name]
    constants: tuple[Constant, ...]
    values: Mapping[str, float]
    has_numbers: bool
    has_kicks: bool = False  # supports jump, or their rates
    has_source_potentials: bool = False  # loads that depend on time alone are told by -F . r in V_f
    level: str = "full"  # of the derivation: short, full or lecture
    sections: tuple[str, ...] = ()  # of the derivation, all if none is named
    first_letter: str = "a"
    letters: Mapping[str, Name] = field(default_factory=dict)  # chosen in place of the pages' own

    @cached_property
    def parts(self) -> Parts:
        """What acts, told apart."""
        return parts_of(self.equations, self.has_source_potentials)

    @property
    def q(self) -> tuple[Name, ...]:
        """The names of the coordinates, in their order."""
        return tuple(self.names[q] for q in self.equations.scene.q)

    def rate(self, k: int, marks: int = 1) -> Name:
        """The k-th coordinate with so many dots; of angular velocities, which are no rates of names, with one less."""
        return replace(self.q[k], marks=marks - (k in self.equations.scene.turned))

    def own(self, letter: str, sub: str = "") -> Name:
        """T, V, L and the like, of the forms' own."""
        chosen = self.letters.get(letter)
        if chosen is None:
            return own_name(letter, sub, self.names.values())
        return replace(chosen, sub=" ".join(filter(None, (chosen.sub, sub))))

    def virtual_work(self, sub: str = "") -> Name:
        """delta W, of a part by its index."""
        return replace(self.letters.get("W", Name("W")), sub=sub, prefix="δ")

    def partial(self, top: str, bottom: Node, sub: str = "") -> Slope:
        """d(top)/d(bottom), of an energy by its letter."""
        return Slope(self.own(top, sub), bottom)

    def sum(self, expression: Expr) -> Node:
        """An expression, laid out as a sum of products."""
        return self.presentation.sum(expression)

    def gentle_sum(self, terms: Sequence[Term], whole: Expr) -> Node:
        """The terms as stated; or collected, where that is shorter."""
        stated, collected = added(*(self.gentle(term.value) for term in terms)), self.sum(whole)
        return stated if len(line(stated)) < len(line(collected)) else collected

    def gentle(self, expression: Expr) -> Node:
        """An expression, laid out without being expanded."""
        return self.presentation.gentle(exact_throughout(expression))


def bold(base: str, marks: int = 0, argument: str = "") -> Name:
    """A vector or matrix."""
    return Name(base, "", marks, argument, True)


TRANSPOSED_J = Power(bold("J"), Words("T"))


def time_derivative(inner: Node) -> Node:
    """d/dt of what stands behind it."""
    return product([Slope(None, Name("t"), True), inner])


def equal(left: Node, right: Node) -> Relation:
    """The relation left = right."""
    return Relation(left, right)


# -------------------------------------------------------------------- blocks


def coordinates_table(book: Book) -> list[Block]:
    """Symbol, name, unit and meaning of each coordinate, with those that others give."""
    model = book.equations.scene.kinematics.graph.model
    rows: list[tuple[Inline, ...]] = []
    for name, q in zip(book.equations.scene.names, book.q, strict=True):
        variable = model.variables.get(name)
        told = model.components.get(component_of(name), "")
        if variable is None:
            is_turn = any(name in found.names for found in book.equations.scene.kinematics.angles.values())
            rows.append((q, name, component_named(name).unit, say("one of Euler's angles") if is_turn else _frame_words(name)))
        else:
            rows.append((q, name, variable.unit, "; ".join(filter(None, [variable.description, told]))))
    for name, value in book.equations.scene.dependents.items():
        shown = book.names.get(sp.Symbol(name, real=True), Name(name))
        variable = model.variables.get(name)
        rows.append((equal(shown, book.sum(value)), name, variable.unit if variable else "", say("given by the others")))
    return [Table(("", say("in the model"), say("unit"), ""), tuple(rows))]


def _frame_words(name: str) -> Phrase:
    return say("angle of a floating body") if component_named(name).is_angle else say("of a floating body")


def parameters_table(book: Book) -> list[Block]:
    """Symbol, name, value and meaning of each parameter."""
    rows: list[tuple[Inline, ...]] = []
    for p in book.equations.scene.parameters:
        if p.symbol in book.names:
            shown: Node = book.names[p.symbol]
            if p.formula is not None:
                shown = equal(shown, book.sum(exact_throughout(p.formula)))
            rows.append((shown, p.name, f"{book.values[p.name]:.6g} {p.unit}".rstrip(), p.description))
    return [Table(("", say("in the model"), say("value"), ""), tuple(rows))] if rows else []


def given_functions(book: Book) -> list[Node]:
    """P(t) = 50 sin 3t, for every given function that is used."""
    scene = book.equations.scene
    return [equal(book.names[g.symbol], book.sum(g.value)) for g in scene.given if g.symbol in book.names]


def where(book: Book) -> list[Block]:
    """What a reader needs to know besides the equations: given functions, formulas of parameters, what names mean."""
    scene = book.equations.scene
    lines = given_functions(book)
    lines += [equal(book.names[p.symbol], book.sum(exact_throughout(p.formula))) for p in scene.parameters
              if p.symbol in book.names and p.formula is not None]
    lines += [equal(book.names[s], book.sum(value)) for name, value in scene.dependents.items()
              for s in [sp.Symbol(name, real=True)] if s in book.names]
    lines += lengths(book)
    return [paragraph(say("where")), Display(tuple(lines))] if lines else []


def lengths(book: Book) -> list[Node]:
    """l = sqrt(x^2 + y^2 - ...), for every root that got a name: those of more than two terms, so that no other is wider than a
    page. Roots are not broken into lines: where one of these would be wider, l^2 = x^2 + y^2 - ..., l >= 0."""
    found: list[Node] = []
    for base, name in book.presentation.symbols.lengths.items():
        root = equal(name, Root(inside := book.sum(base)))
        is_wide = text(root).width > WIDEST_MATRIX or typeset_width(root) > WIDEST_TYPESET
        found += [equal(Power(name, Numeral(Fraction(2))), inside), Relation(name, ZERO, "≥")] if is_wide else [root]
    return found


def events_block(book: Book) -> list[Block]:
    """What holds where rates jump."""
    return [*_kicks(book), *_resets(book)]


def _kicks(book: Book) -> list[Block]:
    """Those of supports."""
    if not book.has_kicks:
        return []
    momentum = book.partial("T", Name("q", "k", 1))
    return [paragraph(say("A support jumps at times, or its rate: there {0} stays as it is, but for what holds the scene and the "
                          "impulses of dampers, and the equations hold in between.", momentum))]


def _resets(book: Book) -> list[Block]:
    """What rates become at events."""
    events = book.equations.scene.events
    if not events:
        return []
    lines: list[Inline] = []
    for event in events:
        changes: list[Inline] = []
        for rate, wanted in event.resets:
            changes += [", " if changes else "", say("{0} becomes {1}", book.sum(rate), book.sum(wanted))]
        lines += ["; " if lines else "", say("where {0} comes to be positive, {1}", book.sum(event.level), changes)]
    return [paragraph(say("At events rates jump: {0}, by an impulse that works on what it is the rate of. In between the "
                          "equations hold.", lines))]


def names_block(book: Book) -> list[Block]:
    """s = guide.s, where the name on paper is not that of the model."""
    scene = book.equations.scene
    pairs: list[Inline] = []
    for k, (name, q) in enumerate(zip(scene.names, book.q, strict=True)):
        pairs += [", " if pairs else "", say("{0} is {1}", q, name)] if k not in scene.turned else []
    for label, x in (*((p.name, p.symbol) for p in scene.parameters), *scene.inputs.items()):
        if x in book.names and not is_own(label, book.names[x]):
            pairs += [", " if pairs else "", say("{0} is {1}", book.names[x], label)]
    return [*([paragraph(*pairs, ".")] if pairs else []), *_attitudes(book), *positive_block(book)]


def _attitudes(book: Book) -> list[Block]:
    """What tells the attitudes that are not written by angles."""
    return [paragraph(say("Of the attitude {0}: {1} are its angular velocity, in the turned axes, {2} its unit quaternion, the "
                          "real part first.", turning.name, _joined([book.q[k] for k in turning.places]),
                          _joined([book.names[x] for x in turning.parts]))) for turning in book.equations.scene.turnings]


def positive_block(book: Book) -> list[Block]:
    """For which signs of lengths the formulas hold."""
    conditions = [Relation(book.names[q], total([]), ">") for q in book.equations.scene.positive]
    return [paragraph(say("All that follows is for {0}.", _joined(conditions)))] if conditions else []


def generic(book: Book) -> Node:
    """d/dt dT/dv - dT/dq + dV/dq + dD/dv + J^T lambda = f, without what is not there."""
    e = book.equations
    k, rate = Name("q", "k"), Name("q", "k", 1)
    items: list[tuple[int, Node]] = [(1, time_derivative(book.partial("T", rate))), (-1, book.partial("T", k))]
    items += [(1, book.partial("V", k))] if e.V_elastic != 0 or e.V_field != 0 else []
    items += [(1, book.partial("D", rate))] if e.D != 0 else []
    items += multiplier_term(book)
    return equal(total(items), Name("f", "k") if any(f != 0 for f in e.f) else book.sum(sp.S.Zero))


def multiplier_term(book: Book) -> list[tuple[int, Node]]:
    """What constraints add to Lagrange's equations, by its sign; nothing without constraints."""
    rows = len(book.equations.rows)
    q = Name("q", "k", 0 if book.equations.scene.holonomic else 1)
    if not rows:
        return []
    if rows == 1:
        return [(1, product([Name("lambda"), Slope(Name("Phi"), q)]))]
    return [(1, product([Name("Sigma"), Name("lambda", "i"), Slope(Name("Phi", "i"), q)]))]


def constraints_block(book: Book) -> list[Block]:
    """The constraints, each by a name and a formula."""
    e = book.equations
    if not e.rows:
        return []
    count, zero = len(e.rows), book.sum(sp.S.Zero)
    names = [Name("Phi", str(k + 1) if count > 1 else "") for k in range(count)]
    lines = [equal(name, Relation(book.sum(row), zero)) for name, row in zip(names, e.rows, strict=True)]
    kind = say("Constraints") if e.scene.holonomic == count else \
        say("Constraints, the last on the rates") if e.scene.holonomic else say("Constraints on the rates")
    multipliers = [book.presentation.symbols.names[x] for x in e.multipliers]
    held = _joined(multipliers)
    words = say("{0}, with the multiplier {1}:", kind, held) if count == 1 else say("{0}, with the multipliers {1}:", kind, held)
    return [paragraph(words), Display(tuple(lines))]


def _joined(names: Sequence[Node]) -> list[Inline]:
    return [part for name in names for part in (", ", name)][1:]


def constants_block(book: Book, level: int = 2) -> list[Block]:
    """Energy and momenta that the motion keeps, under a heading of this level, or none of 0."""
    if not book.constants:
        return []
    blocks: list[Block] = [Heading(say("Constants of the motion"), level)] if level else []
    blocks += [paragraph(say("Between events:"))] if book.equations.scene.events else []
    for c in book.constants:
        if c.name == "momentum":
            assert c.coordinate is not None
            q = book.q[c.coordinate]
            left = Name("p", " ".join(filter(None, (q.base, q.sub))))
            blocks += [paragraph(say("{0} is cyclic: its momentum is constant.", q)),
                       *display([equal(left, equal(book.partial("T", book.rate(c.coordinate)), book.sum(c.value)))])]
        elif c.name == "angular momentum":
            blocks += _angular_momentum(book, c)
        else:
            blocks += _energy_constant(book, c)
    return blocks


def _angular_momentum(book: Book, c: Constant) -> list[Block]:
    assert c.coordinate is not None
    turning = next(x for x in book.equations.scene.turnings if c.coordinate in x.places)
    axis = "xyz"[c.coordinate - turning.first]
    if c.why == "own":
        words = say("About its own {0} axis nothing changes the angular momentum of {1}: it is constant.", axis, turning.name)
        return [paragraph(words), *display([equal(book.partial("T", book.rate(c.coordinate)), book.sum(c.value))])]
    words = say("About the {0} axis of what carries it nothing turns {1}: its angular momentum about it is constant.", axis,
                turning.name)
    return [paragraph(words), *display([equal(Name("p", f"{turning.name.replace('.', ' ')} {axis}"), book.sum(c.value))])]


def _energy_constant(book: Book, c: Constant) -> list[Block]:
    e = book.equations
    V = e.V_elastic + e.V_field
    if c.name == "Jacobi":
        return [paragraph(say("Nothing depends on time and nothing is lost: Jacobi's integral is constant.")),
                *display([equal(book.own("H"), book.sum(c.value))])]
    work = [negative(product([book.sum(f), q])) for f, q in zip(e.f, book.q, strict=True) if f != 0]
    has_V = V != 0 or bool(work and book.has_source_potentials)
    left: Node = added(book.own("T"), *([book.own("V")] if has_V else []), *([] if book.has_source_potentials else work))
    why = say("The loads are constant and nothing is lost: the energy is constant.") if work else \
        say("Nothing depends on time and nothing is lost: the energy is constant.")
    energies = e.scene.energies
    value = book.sum(c.value) if work else book.gentle_sum((*energies.kinetic, *energies.potential), c.value)
    return [paragraph(why), *display([equal(book.own("E"), Relation(left, value))])]


def matrix(name: Node, rows: Sequence[Sequence[Node]], entry: str) -> list[Node]:
    """name = [...], or its entries one by one where the matrix would be too wide."""
    whole = equal(name, Grid(tuple(tuple(row) for row in rows)))
    if text(whole).width <= WIDEST_MATRIX and typeset_width(whole) <= WIDEST_TYPESET:
        return [whole]
    zero = total([])
    found: list[Node] = []
    is_column = all(len(row) == 1 for row in rows)
    is_symmetric = not is_column and len(rows) == len(rows[0]) and all(rows[i][j] == rows[j][i] for i in range(len(rows))
                                                                      for j in range(i))
    for i, row in enumerate(rows):
        for j, cell in enumerate(row):
            if (is_symmetric and j < i) or (cell == zero and not is_column):
                continue
            label = str(i + 1) if is_column else f"{i + 1}{j + 1}" if len(rows) < 10 else f"{i + 1} {j + 1}"
            here: Node = Name(entry, label)
            if is_symmetric and i != j:
                here = equal(here, Name(entry, f"{j + 1}{i + 1}" if len(rows) < 10 else f"{j + 1} {i + 1}"))
            found.append(equal(here, cell))
    return found


def column(items: Sequence[Node]) -> Grid:
    """Formulas below each other."""
    return Grid(tuple((item,) for item in items))


__all__ = ["Book", "Product", "Total", "column", "matrix"]
