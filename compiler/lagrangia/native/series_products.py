"""Recurrences of Taylor coefficients that take less time: what is asked of them stays the same but for rounding.

A product of two jets costs k + 1 multiplications in order k, a sum of jets or one with a number costs one. So a b + a c is
written as a (b + c), whatever numbers stand before the terms, and (a b) b as a b^2: half of the terms of a square are the other
half once more. Orders wait for each other: what a coefficient of the rates has to pass until it becomes that of accelerations is
kept short. Numbers go to the factor of a product that is there first, and what comes last is multiplied last.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import count

from lagrangia.base.records import dataclass
from lagrangia.native.series_writer import OPERANDS, Instruction, Writer
from lagrangia.native.tapes import JetOp

_LINEAR = frozenset((JetOp.NEG, JetOp.TWICE, JetOp.ADD, JetOp.SUB, JetOp.SCALE))
_PRODUCT = frozenset((JetOp.PRODUCT,))
_TIMES = frozenset((JetOp.SCALE, JetOp.TWICE, JetOp.NEG))


def times_asked(instructions: Sequence[Instruction], found: Sequence[int]) -> Counter[int]:
    """How often each jet is asked for; `found` are once more."""
    operands = (both for i in instructions for both in zip(OPERANDS[i.op], i.operands, strict=True))
    return Counter([*found, *(x for kind, x in operands if kind in "jJ")])


def in_squares(instructions: Sequence[Instruction], found: Sequence[int]) -> list[Instruction]:
    """(a b) b, where nothing else asks for a b, as a b^2; and a (c a), where c is a number, as c a^2. `found` are asked for,
    too."""
    asked = times_asked(instructions, found)
    place = {i.out: k for k, i in enumerate(instructions)}
    written: list[Instruction | tuple[Instruction, Instruction]] = list(instructions)
    free = max(place, default=0) + 1
    for k, i in enumerate(instructions):
        if i.op is not JetOp.PRODUCT:
            continue
        for inner, other in (i.operands, i.operands[::-1]):
            made = written[place[inner]] if inner in place else None
            if not isinstance(made, Instruction):
                continue
            if made.op is JetOp.PRODUCT and asked[inner] == 1 and other in made.operands:
                a, b = made.operands
                written[place[inner]] = Instruction(JetOp.SQUARE, inner, (other,))
                written[k] = Instruction(JetOp.PRODUCT, i.out, (a if b == other else b, inner))
                break
            if made.op is JetOp.SCALE and made.operands[1] == other:
                square = Instruction(JetOp.SQUARE, free, (other,))
                written[k] = square, Instruction(JetOp.SCALE, i.out, (made.operands[0], free))
                free += 1
                break
    return [x for found in written for x in (found if isinstance(found, tuple) else (found,))]


# ------------------------------------------------------------ common factors


@dataclass(frozen=True)
class _Term:
    """A jet times numbers, by their places, added or taken away."""

    jet: int
    numbers: tuple[int, ...] = ()
    is_less: bool = False


@dataclass(frozen=True)
class _Group:
    """A factor, what it is taken times, and the products that this replaces."""

    factor: int
    terms: tuple[_Term, ...]
    products: tuple[int, ...]


@dataclass(frozen=True)
class _Sums:
    """Instructions by the jets that they make, and how often each jet is asked for."""

    writer: Writer
    makers: Mapping[int, Instruction]
    asked: Mapping[int, int]

    def is_own(self, jet: int, ops: frozenset[JetOp]) -> bool:
        """Whether one of `ops` makes it, for one other jet alone."""
        return jet in self.makers and self.makers[jet].op in ops and self.asked[jet] == 1

    def terms(self, root: int) -> tuple[list[_Term], set[int]]:
        """What a sum consists of, with sums that stand in it alone; and these, itself among them."""
        found: list[_Term] = []
        passed: set[int] = set()
        left = [_Term(root)]
        while left:
            term = left.pop()
            if term.jet != root and not self.is_own(term.jet, _LINEAR):
                found.append(term)
                continue
            passed.add(term.jet)
            i = self.makers[term.jet]
            jets, numbers = i.operands, term.numbers
            if i.op in (JetOp.SCALE, JetOp.TWICE):
                numbers += (i.operands[0] if i.op is JetOp.SCALE else self.writer.literal(2.0).place,)
                jets = i.operands[-1:]
            is_less = [term.is_less != turns for turns in (i.op is JetOp.NEG, i.op is JetOp.SUB)]
            left += reversed([_Term(jet, numbers, less) for jet, less in zip(jets, is_less, strict=False)])
        return found, passed

    def scaled(self, jet: int) -> _Term:
        """What a jet is a number times."""
        i = self.makers.get(jet)
        return _Term(i.operands[1], i.operands[:1]) if i is not None and i.op is JetOp.SCALE else _Term(jet)

    def factors(self, term: _Term) -> dict[int, _Term]:
        """Both ways to read a product that nothing else asks for: a factor, and what is left of the term."""
        if not self.is_own(term.jet, _PRODUCT):
            return {}
        a, b = map(self.scaled, self.makers[term.jet].operands)
        numbers = term.numbers + a.numbers + b.numbers
        return {a.jet: _Term(b.jet, numbers, term.is_less), b.jet: _Term(a.jet, numbers, term.is_less)}

    def groups(self, terms: Sequence[_Term]) -> tuple[list[_Group], list[_Term]]:
        """Of terms that have a factor in common, those of most terms first; and the terms that are left."""
        found: list[_Group] = []
        left = [(term, self.factors(term)) for term in terms]
        while True:
            counts = Counter(factor for _, ways in left for factor in ways)
            factor, times = max(counts.items(), key=lambda item: item[1], default=(0, 0))
            if times < 2:
                return found, [term for term, _ in left]
            inner = tuple(ways[factor] for _, ways in left if factor in ways)
            found.append(_Group(factor, inner, tuple(term.jet for term, ways in left if factor in ways)))
            left = [(term, ways) for term, ways in left if factor not in ways]


def in_factors(writer: Writer, instructions: Sequence[Instruction], found: Sequence[int]) -> list[Instruction]:
    """a b + a c as a (b + c), where nothing else asks for a b and a c. `found` are asked for, too."""
    sums = _Sums(writer, {i.out: i for i in instructions}, times_asked(instructions, found))
    inner = {x for i in instructions if i.op in _LINEAR for kind, x in zip(OPERANDS[i.op], i.operands, strict=True)
             if kind == "j" and sums.is_own(x, _LINEAR)}
    free = count(1 + max((i.out for i in instructions), default=0))
    anew: dict[int, list[Instruction]] = {}
    gone: set[int] = set()
    for i in instructions:
        if i.op not in _LINEAR or i.out in inner:
            continue
        terms, passed = sums.terms(i.out)
        groups, terms = sums.groups(terms)
        if not groups:
            continue
        gone |= passed.union(*(group.products for group in groups))
        written: list[Instruction] = []
        for group in groups:
            pieces, total = _added(writer, group.terms, free)
            product = Instruction(JetOp.PRODUCT, next(free), (group.factor, total.jet))
            terms.append(_Term(product.out, (), total.is_less))
            written += [*pieces, product]
        pieces, total = _added(writer, terms, free)
        written += [*pieces, *([Instruction(JetOp.NEG, next(free), (total.jet,))] if total.is_less else [])]
        anew[i.out] = [*written[:-1], Instruction(written[-1].op, i.out, written[-1].operands)]
    return [x for i in instructions for x in anew.get(i.out, () if i.out in gone else (i,))]


def _added(writer: Writer, terms: Sequence[_Term], free: Iterator[int]) -> tuple[list[Instruction], _Term]:
    """What adds terms, in jets that are `free`, and their sum, taken away where all of them are."""
    ordered = sorted(terms, key=lambda term: term.is_less)
    written: list[Instruction] = []
    total: int | None = None
    for term in ordered:
        jet = term.jet
        if term.numbers:
            jet = next(free)
            written.append(Instruction(JetOp.SCALE, jet, (writer.multiplied(term.numbers), term.jet)))
        if total is not None:
            op = JetOp.ADD if term.is_less == ordered[0].is_less else JetOp.SUB
            written.append(Instruction(op, next(free), (total, jet)))
            jet = written[-1].out
        total = jet
    assert total is not None
    return written, _Term(total, (), ordered[0].is_less)


# ------------------------------------------------------------ what elimination leaves


@dataclass(frozen=True)
class _Quotient:
    """w = (e + c a)/(n - m c^2): of two equations that c couples, what is left when one is eliminated. `numbers` are m, `beside`
    is a and `rest` is e, as terms; `gone` are jets that stand in it alone."""

    c: int
    n: int
    numbers: tuple[int, ...]
    beside: tuple[_Term, ...]
    rest: tuple[_Term, ...]
    gone: frozenset[int]


def without_quotients(writer: Writer, instructions: Sequence[Instruction], found: Sequence[int]) -> list[Instruction]:
    """w = (e + c a)/(n - m c^2) as n w = e + c r, r = a + m c w, whose latest coefficients follow from lower ones of w and r: two
    sums in place of those of the quotient, c^2, c a and, where it is asked for, c w. `found` are asked for, too."""
    sums = _Sums(writer, {i.out: i for i in instructions}, times_asked(instructions, found))
    free = count(1 + max((i.out for i in instructions), default=0))
    anew: dict[int, list[Instruction]] = {}
    gone: set[int] = set()
    for i in instructions:
        quotient = _eliminated(sums, i) if i.op is JetOp.QUOTIENT else None
        if quotient is None:
            continue
        again = [other for other in instructions if other.op is JetOp.PRODUCT
                 and {sums.scaled(x).jet for x in other.operands} == {i.out, quotient.c}]
        if not quotient.beside and not again:
            continue
        anew[i.out], coupled = _coupled(writer, quotient, i.out, free)
        gone |= quotient.gone
        for other in again:
            numbers = tuple(x for jet in other.operands for x in sums.scaled(jet).numbers)
            anew[other.out] = [Instruction(JetOp.SCALE, other.out, (_multiplied(writer, numbers), coupled))]
    return [x for i in instructions for x in anew.get(i.out, () if i.out in gone else (i,))]


def _eliminated(sums: _Sums, i: Instruction) -> _Quotient | None:
    """A quotient as such a one, if it is."""
    top, below = i.operands
    if not sums.is_own(below, frozenset((JetOp.NUMBER_SUB,))):
        return None
    n, less = sums.makers[below].operands
    squares, chain = sums.terms(less) if sums.is_own(less, _LINEAR) else ([_Term(less)], set[int]())
    if len(squares) != 1 or squares[0].is_less or not sums.is_own(squares[0].jet, frozenset((JetOp.SQUARE,))):
        return None
    square = squares[0]
    c = sums.makers[square.jet].operands[0]
    terms, passed = sums.terms(top) if sums.is_own(top, _LINEAR) else ([_Term(top)], set[int]())
    ways = [(term, sums.factors(term)) for term in terms]
    beside = tuple(way[c] for _, way in ways if c in way)
    products = {term.jet for term, way in ways if c in way}
    return _Quotient(c, n, square.numbers, beside, tuple(term for term, way in ways if c not in way),
                     frozenset({below, square.jet, *chain, *passed, *products}))


def _multiplied(writer: Writer, numbers: tuple[int, ...]) -> int:
    return writer.multiplied(numbers or (writer.literal(1.0).place,))


def _coupled(writer: Writer, q: _Quotient, out: int, free: Iterator[int]) -> tuple[list[Instruction], int]:
    """What makes the jet `out` of the quotient, and that of c times it."""
    written: list[Instruction] = []

    def added(terms: Sequence[_Term]) -> int:
        pieces, total = _added(writer, terms, free)
        written.extend(pieces)
        return made(JetOp.NEG, total.jet) if total.is_less else total.jet

    def made(op: JetOp, *operands: int, jet: int | None = None) -> int:
        written.append(Instruction(op, next(free) if jet is None else jet, operands))
        return written[-1].out

    beside = (_Term(added(q.beside)),) if q.beside else ()
    lower, all_r = made(JetOp.LOWER, q.c, out), next(free)
    known = added([*q.rest, _Term(made(JetOp.LOWER, q.c, all_r))])
    r = added([*beside, _Term(lower, q.numbers)])
    factor = _multiplied(writer, q.numbers)
    made(JetOp.OVER_REST, made(JetOp.FIRST_AND, q.c, r, known), q.c, q.n, factor, jet=out)
    product = made(JetOp.FIRST_AND, q.c, out, lower)
    scaled = made(JetOp.SCALE, factor, product, jet=None if beside else all_r)
    if beside:
        made(JetOp.ADD, beside[0].jet, scaled, jet=all_r)
    return written, product


# ------------------------------------------------------------ what waits for the rates

_SUM, _ROUND = 4, 8  # cycles of a processor that an addition or multiplication takes, and two that wait for each other
_EARLY = -10 * _ROUND  # positions follow from the rates of the order before
_ONE = frozenset((JetOp.NEG, JetOp.TWICE, JetOp.ADD, JetOp.SUB, JetOp.ADD_NUMBER, JetOp.SUB_NUMBER, JetOp.NUMBER_SUB, JetOp.SCALE,
                  JetOp.OVER_NUMBER, JetOp.IF, JetOp.DERIVATIVE, JetOp.SQUARE, JetOp.FIRST_AND, JetOp.OVER_REST))


def with_numbers_inside(writer: Writer, instructions: Sequence[Instruction], found: Sequence[int]) -> list[Instruction]:
    """c ((d a) b), where nothing else asks for the products, as ((c d) a) b. `found` are asked for, too."""
    sums = _Sums(writer, {i.out: i for i in instructions}, times_asked(instructions, found))
    written = {i.out: i for i in instructions}
    for i in instructions:
        if i.op not in (JetOp.SCALE, JetOp.TWICE) or not sums.is_own(i.operands[-1], _PRODUCT):
            continue
        product = written[i.operands[-1]]
        number = i.operands[0] if i.op is JetOp.SCALE else writer.literal(2.0).place
        for scaled in product.operands:
            if sums.is_own(scaled, frozenset((JetOp.SCALE,))):
                other, jet = written[scaled].operands
                written[scaled] = Instruction(JetOp.SCALE, scaled, (writer.multiplied((number, other)), jet))
                written[i.out] = Instruction(JetOp.PRODUCT, i.out, product.operands)
                del written[product.out]
                break
    return [written[i.out] for i in instructions if i.out in written]


def with_numbers_outside(writer: Writer, instructions: Sequence[Instruction], found: Sequence[int]) -> list[Instruction]:
    """c ((d a) b) as (c d) (a b), where such products alone ask for d a, and c (d a) as (c d) a. `found` are asked for, too."""
    asked, written = times_asked(instructions, found), {i.out: i for i in instructions}
    users: dict[int, list[Instruction]] = {}
    for i in instructions:
        for x in {x for kind, x in zip(OPERANDS[i.op], i.operands, strict=True) if kind in "jJ"}:
            users.setdefault(x, []).append(i)

    def end_of(product: Instruction) -> int | None:
        """What multiplies it by a number, if that alone asks for it."""
        after = users.get(product.out, []) if product.op is JetOp.PRODUCT and asked[product.out] == 1 else []
        return after[0].out if after and after[0].op in _TIMES else None

    for i in instructions:
        products = users.get(i.out, []) if i.op is JetOp.SCALE and i.out not in found else []
        ends = [(product.out, end) for product in products if (end := end_of(product)) is not None]
        if products and len(ends) == len(products):
            number, jet = written.pop(i.out).operands
            for product, end in ends:
                a, b = written[product].operands
                written[product] = Instruction(JetOp.PRODUCT, product, (jet, b) if a == i.out else (a, jet))
                written[end] = _scaled(writer, written[end], number, product)
    for i in instructions:
        inner = written.get(i.operands[-1]) if i.op in _TIMES and i.out in written else None
        if inner is not None and inner.op in _TIMES and asked[inner.out] == 1:
            written[i.out] = _scaled(writer, written[i.out], _number_in(writer, inner), inner.operands[-1])
            del written[inner.out]
    return [written[i.out] for i in instructions if i.out in written]


def _number_in(writer: Writer, i: Instruction) -> int:
    return i.operands[0] if i.op is JetOp.SCALE else writer.literal(2.0 if i.op is JetOp.TWICE else -1.0).place


def _scaled(writer: Writer, i: Instruction, number: int, jet: int) -> Instruction:
    """What `i` multiplies is a number times a jet."""
    return Instruction(JetOp.SCALE, i.out, (writer.multiplied((number, _number_in(writer, i))), jet))


def late_last(instructions: Sequence[Instruction], found: Sequence[int], early: frozenset[int]) -> list[Instruction]:
    """What comes last in an order is multiplied last: it stands first in products, and what is added to one comes in before.
    `early` are there before the others of those that are known; `found` are asked for, too."""
    asked = times_asked(instructions, found)
    when: dict[int, int] = dict.fromkeys(early, _EARLY)
    written: dict[int, Instruction] = {}
    for i in instructions:
        times = [when.get(x, 0) for kind, x in zip(OPERANDS[i.op], i.operands, strict=True) if kind in "jJ"]
        inner = _product_in(i, written, asked, when)
        if inner is not None:
            product, other = written.pop(inner), i.operands[i.operands[0] == inner]
            op = JetOp.PRODUCT_AND if i.op is JetOp.ADD else JetOp.PRODUCT_FROM
            written[i.out] = Instruction(op, i.out, (*product.operands, other))
            when[i.out] = when[inner]
            continue
        written[i.out] = i
        if i.op is JetOp.PRODUCT:
            written[i.out] = i if times[0] == max(times) else Instruction(i.op, i.out, i.operands[::-1])
            when[i.out] = max(max(times) + _SUM, min(times) + _ROUND)
        elif i.op in (JetOp.INTEGRAL, JetOp.MINUS_INTEGRAL, JetOp.SINE, JetOp.COSINE):
            when[i.out] = times[1] + _ROUND
        else:
            when[i.out] = max(times, default=_EARLY) + (_SUM if i.op in _ONE else _ROUND)
    return list(written.values())


def _product_in(i: Instruction, written: Mapping[int, Instruction], asked: Mapping[int, int], when: Mapping[int, int]
                ) -> int | None:
    """The product in a sum that comes so much later than what it is added to, or taken from, that this keeps nothing waiting."""
    if i.op not in (JetOp.ADD, JetOp.SUB):
        return None
    a, b = i.operands
    for product, other in ((b, a), (a, b)) if i.op is JetOp.ADD else ((b, a),):
        is_own = product in written and written[product].op is JetOp.PRODUCT and asked[product] == 1
        if is_own and when.get(other, 0) + _ROUND <= when[product]:
            return product
    return None


def scaled_inside(instructions: Sequence[Instruction], found: Sequence[int]) -> list[Instruction]:
    """n b + c, c - n b and n b - c as one, where nothing else asks for n b. `found` are asked for, too."""
    asked, written = times_asked(instructions, found), {i.out: i for i in instructions}
    for i in instructions:
        if i.op not in (JetOp.ADD, JetOp.SUB):
            continue
        a, b = i.operands
        for scaled, other, op in ((b, a, JetOp.SCALE_FROM), (a, b, JetOp.SCALE_LESS)):
            if asked[scaled] == 1 and scaled in written and written[scaled].op is JetOp.SCALE:
                number, jet = written.pop(scaled).operands
                written[i.out] = Instruction(JetOp.SCALE_AND if i.op is JetOp.ADD else op, i.out, (number, jet, other))
                break
    return [written[i.out] for i in instructions if i.out in written]
