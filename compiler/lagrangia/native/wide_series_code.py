"""The Taylor coefficients of eight motions at once (series.py) as C: the function `wide_taylor`, a LagWideJets.

Recurrences are those of runtime/numbers/wide_jets.h, and digits those of runtime/model/wide_jet_tape.c. All orders share one
body: a loop for several sums of products at a time, then a statement an instruction, whose values stay in registers. Two orders
go together, as their sums ask for the same coefficients, which take longer to read than to multiply; a function for pairs from
each kind of number on knows which of its statements serve.
"""

from collections.abc import Callable, Mapping, Sequence

from lagrangia.native.series import ORDERS, Series
from lagrangia.native.series_writer import OPERANDS, Instruction
from lagrangia.native.tapes import JetOp, Op

_AT_ONCE = 15  # registers of sums in one loop: so many are there on all processors with vectors
_ALONE = "for (int i = 0; i < LAG_WIDE; ++i)"
# Of order 0, and of order k: xa is the present coefficient of jet a, fa that of order 0; s and t number sums without their
# ends, i and l what is the same in all orders.
_FIRST: Mapping[JetOp, str] = {
    JetOp.NUMBER: "{a}", JetOp.DERIVATIVE: "zero", JetOp.NEG: "-{xa}", JetOp.TWICE: "two * {xa}", JetOp.ADD: "{xa} + {xb}",
    JetOp.SUB: "{xa} - {xb}", JetOp.ADD_NUMBER: "{xa} + {b}", JetOp.SUB_NUMBER: "{xa} - {b}", JetOp.NUMBER_SUB: "{a} - {xb}",
    JetOp.SCALE: "{a} * {xb}", JetOp.OVER_NUMBER: "{xa} / {b}", JetOp.IF: "LAG_WIDE_SELECT({a} != zero, {xb}, zero)",
    JetOp.PRODUCT: "{xa} * {xb}", JetOp.SQUARE: "{xa} * {xa}", JetOp.QUOTIENT: "{xa} / {xb}", JetOp.NUMBER_OVER: "{a} / {xb}",
    JetOp.PRODUCT_AND: "{xa} * {xb} + {xc}", JetOp.PRODUCT_FROM: "{xc} - {xa} * {xb}", JetOp.FIRST_AND: "{xa} * {xb} + {xc}",
    JetOp.OVER_REST: "{xa} / ({c} - {d} * ({xb} * {xb}))", JetOp.LOWER: "zero",
    JetOp.SCALE_AND: "{a} * {xb} + {xc}", JetOp.SCALE_FROM: "{xc} - {a} * {xb}", JetOp.SCALE_LESS: "{a} * {xb} - {xc}",
}
_INNER = "LAG_WIDE_INNER(s{s}, {xb}, {fc}) * "
_LATER: Mapping[JetOp, str] = {
    JetOp.NUMBER: "zero", JetOp.DERIVATIVE: "order * {xa}", JetOp.NEG: "-{xa}", JetOp.TWICE: "two * {xa}",
    JetOp.ADD: "{xa} + {xb}", JetOp.SUB: "{xa} - {xb}", JetOp.ADD_NUMBER: "{xa}", JetOp.SUB_NUMBER: "{xa}",
    JetOp.NUMBER_SUB: "-{xb}", JetOp.SCALE: "{a} * {xb}", JetOp.OVER_NUMBER: "{xa} / {b}",
    JetOp.IF: "LAG_WIDE_SELECT({a} != zero, {xb}, zero)", JetOp.PRODUCT: "LAG_WIDE_PRODUCT(s{s}, {fa}, {xa}, {fb}, {xb})",
    JetOp.SQUARE: "lag_wide_square(s{s}, {ja}, {xa}, k)",
    JetOp.QUOTIENT: "LAG_WIDE_FUSED({xa}, i{i}, LAG_WIDE_FUSED({xb}, i{l}, -(s{s} * i{i})))",
    JetOp.NUMBER_OVER: "LAG_WIDE_FUSED({xb}, i{l}, -(s{s} * i{i}))",
    JetOp.SQRT: "LAG_WIDE_FUSED({xa}, i{l}, -(lag_wide_half(s{s}, {jw}, k) * i{i}))",
    JetOp.POWER: "lag_wide_power({ja}, {jw}, {b}, k)", JetOp.INTEGRAL: _INNER + "share",
    JetOp.MINUS_INTEGRAL: _INNER + "negative",
    JetOp.SINE: _INNER + "share", JetOp.COSINE: _INNER + "negative",
    JetOp.PRODUCT_AND: "LAG_WIDE_PRODUCT(s{s} + {xc}, {fa}, {xa}, {fb}, {xb})",
    JetOp.PRODUCT_FROM: "LAG_WIDE_PRODUCT({xc} - s{s}, -{fa}, -{xa}, {fb}, {xb})",
    JetOp.ANGLE: "(LAG_WIDE_INNER(s{s}, {xc}, {fe}) - LAG_WIDE_INNER(s{t}, {xd}, {ff})) * share",
    JetOp.FIRST_AND: "LAG_WIDE_FUSED({fa}, {xb}, {xc})", JetOp.OVER_REST: "{xa} * i{i}",
    JetOp.LOWER: "LAG_WIDE_INNER(s{s}, {xa}, {fb})", JetOp.SCALE_AND: "LAG_WIDE_FUSED({a}, {xb}, {xc})",
    JetOp.SCALE_FROM: "LAG_WIDE_FUSED(-{a}, {xb}, {xc})", JetOp.SCALE_LESS: "LAG_WIDE_FUSED({a}, {xb}, -{xc})",
}
# What is multiplied in every order, and is the same in all: so that latest coefficients wait for one operation.
_INVERSES: Mapping[JetOp, tuple[str, ...]] = {
    JetOp.QUOTIENT: ("one / {fb}", "-{fw} * i{i}"), JetOp.NUMBER_OVER: ("one / {fb}", "-{fw} * i{i}"),
    JetOp.SQRT: ("one / {fw}", "half * i{i}"), JetOp.OVER_REST: ("one / ({c} - {d} * ({fb} * {fb}))",)}
# The jets whose products are summed, by the letters of operands; w is the result.
_SUMS: Mapping[JetOp, tuple[str, ...]] = {
    JetOp.PRODUCT: ("ab",), JetOp.SQUARE: ("aa",), JetOp.QUOTIENT: ("bw",), JetOp.NUMBER_OVER: ("bw",), JetOp.SQRT: ("ww",),
    JetOp.INTEGRAL: ("bc",), JetOp.MINUS_INTEGRAL: ("bc",), JetOp.SINE: ("bc",), JetOp.COSINE: ("bc",), JetOp.ANGLE: ("ce", "df"),
    JetOp.PRODUCT_AND: ("ab",), JetOp.PRODUCT_FROM: ("ab",), JetOp.LOWER: ("ab",),
}


def write_wide_series(series: Series, expression: Callable[[int, str, str], str], number: Callable[[float], str]) -> list[str]:
    """C text. `expression` is C for an operation on numbers of one motion, `number` a literal. Nothing for a long state, whose
    jets lie order by order."""
    if series.pitch > 1:
        return []
    used = [x for i in series.instructions for kind, x in zip(OPERANDS[i.op], i.operands, strict=True) if kind == "n"]
    numbers = {k: f"LAG_WIDE_OF({number(series.numbers[k][1])})" if series.numbers[k][0] == Op.CONST else
               f"lag_wide_read(numbers + {k} * LAG_ABREAST)" for k in used}
    head = ["const LagWide zero = LAG_WIDE_OF(0.0), one = LAG_WIDE_OF(1.0), two = LAG_WIDE_OF(2.0), half = LAG_WIDE_OF(0.5);",
            "(void)numbers; (void)zero; (void)one; (void)two; (void)half;"]
    return ["#define LINE(slot) (line + (slot) * LAG_ABREAST)", "#define JET(slot) (jets + (slot) * LAG_WIDE_JET)",
            "static void wide_first(const double *numbers, double *line)", "{", *_indented(head),
            *_first(series, numbers, expression), "}", "",
            *_later(series, numbers, head), *_ORDERS,
            "static void wide_taylor(int first, int end, const double *numbers, double *jets, double *line)", "{",
            "    for (int lane = 0; lane < LAG_ABREAST; lane += LAG_WIDE)", "        if (first == 0)",
            "            wide_first(numbers + lane, line + lane);", "        else",
            "            wide_orders(first, end, numbers + lane, jets + lane);", "}", ""]


# Read into all lanes at once: to make and spread them takes a tenth of a small scene's time.
_TABLES = tuple(f"static const double {name}[] = {{{', '.join(map(repr, values))}}};" for name, values in (
    ("order_of", [float(k) for k in range(ORDERS + 2)]), ("share_of", [1.0 / max(k, 1) for k in range(ORDERS + 2)]),
    ("negative_share_of", [-1.0 / max(k, 1) for k in range(ORDERS + 2)])))
_ORDERS = (
    *(line for name, told in (("odd", "k > 2 && k % 2 == 1"), ("even", "k > 1 && k % 2 == 0")) for line in (
        f"static void wide_two_{name}(int k, const double *numbers, double *jets, const LagWide *i)", "{",
        f"    LAG_KNOWN({told});", "    wide_two(k, numbers, jets, i);", "}", "")),
    "static void wide_orders(int first, int end, const double *numbers, double *jets)", "{",
    "    LagWide inverse[INVERSES];", "    int k = first;", "    wide_inverses(numbers, jets, inverse);",
    "    if (k == 1 && k + 1 < end) {", "        wide_two(1, numbers, jets, inverse);", "        k = 3;", "    }",
    "    for (; k % 2 == 1 && k + 1 < end; k += 2)", "        wide_two_odd(k, numbers, jets, inverse);",
    "    for (; k % 2 == 0 && k + 1 < end; k += 2)", "        wide_two_even(k, numbers, jets, inverse);",
    "    if (k < end)", "        wide_one(k, numbers, jets, inverse);", "}", "")


def _indented(lines: Sequence[str], by: int = 4) -> list[str]:
    return [" " * by + line for line in lines]


def _letters(i: Instruction, numbers: Mapping[int, str]) -> dict[str, str]:
    """What stands for the operands: numbers, and the present coefficients of jets."""
    shown: dict[str, str] = {}
    for letter, kind, x in zip("abcdef", OPERANDS[i.op], i.operands, strict=False):
        if kind == "n":
            shown[letter] = numbers[x]
        elif kind in "jJ":
            shown[f"x{letter}"] = f"x{x}"
    return shown


def _first(series: Series, numbers: Mapping[int, str], expression: Callable[[int, str, str], str]) -> list[str]:
    """Statements of order 0. What is asked for number by number passes through memory."""
    known = series.known
    angles: set[str] = set()
    lines = [f"    const LagWide x{slot} = lag_wide_read(LINE({slot}));" for slot in range(known)]
    lines += [f"    (void)x{slot};" for slot in range(known)]
    for i in series.instructions:
        shown, name = _letters(i, numbers), f"x{i.out}"
        if i.op in _FIRST:
            lines += [f"    const LagWide {name} = {_FIRST[i.op].format(**shown)};"]
        else:
            lines += _indented(_alone(i, shown, name, angles, expression))
        if i.out in series.kept:
            lines += [f"    lag_wide_write(LINE({series.kept[i.out]}), {name});"]
        else:
            lines += [f"    (void){name};"]
    return lines


def _alone(i: Instruction, shown: Mapping[str, str], name: str, angles: set[str], expression: Callable[[int, str, str], str]
           ) -> list[str]:
    """Functions of numbers; those of `angles` have their sines and cosines."""
    function = Op(i.operands[3]) if i.op in (JetOp.INTEGRAL, JetOp.MINUS_INTEGRAL) else Op.SIN if i.op is JetOp.SINE else Op.COS
    angle = shown["xa"]
    if i.op in (JetOp.INTEGRAL, JetOp.MINUS_INTEGRAL, JetOp.SINE, JetOp.COSINE) and function in (Op.SIN, Op.COS):
        both = f"sine_{angle}", f"cosine_{angle}"
        call = [f"LagWide {', '.join(both)};", f"lag_wide_circular(&{angle}, {', '.join(f'&{x}' for x in both)});"]
        lines = [*([] if angle in angles else call), f"const LagWide {name} = {both[function is Op.COS]};"]
        angles.add(angle)
        return lines
    second = shown.get("b", shown.get("xb", "zero"))
    texts = {JetOp.SQRT: "sqrt(x[i])", JetOp.POWER: "pow(x[i], y[i])", JetOp.ANGLE: "atan2(x[i], y[i])"}
    text = texts.get(i.op) or expression(function, "x[i]", "y[i]")
    return [f"LagWide {name};", "{", "    double x[LAG_WIDE], y[LAG_WIDE];", f"    const LagWide a = {angle}, b = {second};",
            "    memcpy(x, &a, sizeof x);", "    memcpy(y, &b, sizeof y);", f"    {_ALONE}", f"        x[i] = {text};",
            f"    memcpy(&{name}, x, sizeof x);", "}"]


def _later(series: Series, numbers: Mapping[int, str], head: Sequence[str]) -> list[str]:
    """Functions for orders k > 0: the sums, what is the same in all orders, and statements."""
    kept, n = series.kept, len(series.accelerations)
    pairs: list[tuple[int, int]] = []
    inverses: list[str] = []
    statements: list[str] = [f"const LagWide x{slot} = LAG_WIDE_TERM(JET({slot}), k);" for slot in range(series.known)]
    statements += [f"(void)x{slot};" for slot in range(series.known)]
    for i in series.instructions:
        slots = dict(zip("abcdef", i.operands, strict=False)) | {"w": i.out}
        shown = _letters(i, numbers)
        shown |= {f"f{letter}": f"lag_wide_read(JET({kept[x]}))" for letter, x in slots.items() if x in kept}
        shown |= {f"j{letter}": f"JET({kept[x]})" for letter, x in slots.items() if x in kept}
        shown |= {"s": str(len(pairs)), "t": str(len(pairs) + 1), "i": f"[{len(inverses)}]", "l": f"[{len(inverses) + 1}]"}
        pairs += [(kept[slots[both[0]]], kept[slots[both[1]]]) for both in _SUMS.get(i.op, ())]
        inverses += [text.format(**shown) for text in _INVERSES.get(i.op, ())]
        statements += [f"const LagWide x{i.out} = {_LATER[i.op].format(**shown)};"]
        if i.out in kept:
            statements += [f"lag_wide_write(JET({kept[i.out]}) + k * LAG_ABREAST, x{i.out});"]
        else:
            statements += [f"(void)x{i.out};"]
    for c in range(n):
        statements += [f"lag_wide_write(JET({1 + c}) + (k + 1) * LAG_ABREAST, x{1 + n + c} * next);",
                       f"lag_wide_write(JET({1 + n + c}) + (k + 1) * LAG_ABREAST, x{series.accelerations[c]} * next);"]
    first = series.known - 4 * len(series.attitudes)
    statements += [f"lag_wide_jet_turn(JET({first + 4 * m}), JET({1 + n + place}), k);"
                   for m, place in enumerate(series.attitudes)]
    return [*_TABLES, f"enum {{ INVERSES = {max(len(inverses), 1)} }};",
            "static void wide_inverses(const double *numbers, const double *jets, LagWide *i)", "{",
            *_indented([*head, "(void)jets; (void)i;",
                        *(f"i[{m}] = {text};" for m, text in enumerate(inverses))]), "}", "",
            *_by_orders(pairs, [*head, "(void)i;"], statements)]


def _by_orders(pairs: Sequence[tuple[int, int]], head: Sequence[str], statements: Sequence[str]) -> list[str]:
    """The statements of an order as a function of its sums, and functions for one order and for two."""
    shares = ["const LagWide order = LAG_WIDE_OF(order_of[k]), share = LAG_WIDE_OF(share_of[k]);",
              "const LagWide next = LAG_WIDE_OF(share_of[k + 1]), negative = LAG_WIDE_OF(negative_share_of[k]);",
              "(void)order; (void)share; (void)negative;"]
    arguments = "const double *numbers, double *jets, const LagWide *i"
    none = "const LagWide zero = LAG_WIDE_OF(0.0); (void)zero;"
    given = "".join(f", LagWide s{m}" for m in range(len(pairs)))
    here, there = ("".join(f", {letter}{m}" for m in range(len(pairs))) for letter in "st")
    ends = [f"s{m} = lag_wide_half_ends(s{m}, JET({a}), k);" if a == b else
            f"s{m} = lag_wide_ends(s{m}, JET({a}), JET({b}), k);" for m, (a, b) in enumerate(pairs)]
    both = [*_declared("s", len(pairs)), *_declared("t", len(pairs))]
    return [f"LAG_UNROLLED void wide_later(int k, {arguments}{given})", "{",
            *_indented([*head, *shares, *ends, *statements]), "}", "",
            f"static void wide_one(int k, {arguments})", "{",
            *_indented([none, *_declared("s", len(pairs)), *_sums(pairs, 1), f"wide_later(k, numbers, jets, i{here});"]), "}", "",
            f"LAG_UNROLLED void wide_two(int k, {arguments})", "{",
            *_indented([none, *both, *_sums(pairs, 2), f"wide_later(k, numbers, jets, i{here});",
                        f"wide_later(k + 1, numbers, jets, i{there});"]), "}", ""]


def _declared(letter: str, count: int) -> list[str]:
    """Sums that begin at 0."""
    return [f"LagWide {', '.join(f'{letter}{m} = zero' for m in range(count))};"] if count else []


def _sums(pairs: Sequence[tuple[int, int]], orders: int) -> list[str]:
    """All but the ends that wait for the latest coefficients, of order k, and of order k + 1, which asks for the same ones;
    of squares, the half."""
    apart = [m for m, (a, b) in enumerate(pairs) if a != b]
    halves = [m for m, (a, b) in enumerate(pairs) if a == b]
    lines: list[str] = []
    at_once = _AT_ONCE // (2 * orders - 1)
    most = -(-len(apart) // -(-len(apart) // at_once)) if apart else 1  # loops of few sums wait for each addition
    for first in range(0, len(apart), most):
        group = apart[first : first + most]
        if orders == 2:
            lines += [f"LagWide {', '.join(f'b{m} = zero' for m in group)};", "if (k > 2) {",
                      *(f"    b{m} = LAG_WIDE_TERM(JET({pairs[m][1]}), k - 1);" for m in group), "}"]
        lines += ["for (int j = 2; j < k - 1; ++j) {"]
        for m, (a, b) in ((m, pairs[m]) for m in group):
            here, there = f"LAG_WIDE_TERM(JET({a}), j)", f"LAG_WIDE_TERM(JET({b}), k - j)"
            both = [f"const LagWide a{m} = {here}, c{m} = {there};", f"s{m} = LAG_WIDE_FUSED(a{m}, c{m}, s{m});",
                    f"t{m} = LAG_WIDE_FUSED(a{m}, b{m}, t{m});", f"b{m} = c{m};"]
            lines += _indented(both if orders == 2 else [f"s{m} = LAG_WIDE_FUSED({here}, {there}, s{m});"])
        lines += ["}"]
        if orders == 2:
            lines += ["if (k > 2) {", *(f"    t{m} = LAG_WIDE_FUSED(LAG_WIDE_TERM(JET({pairs[m][0]}), k - 1), b{m}, t{m});"
                                        for m in group), "}"]
    return [*lines, *_half_sums([(m, pairs[m][0]) for m in halves], orders)]


def _half_sums(squares: Sequence[tuple[int, int]], orders: int) -> list[str]:
    """Of a_j a_(k - j) those with j < k/2, without the ends; sums by their numbers, with jets."""
    if not squares:
        return []
    here = [f"s{m} = LAG_WIDE_FUSED(LAG_WIDE_TERM(JET({a}), j), LAG_WIDE_TERM(JET({a}), k - j), s{m});" for m, a in squares]
    there = [f"t{m} = LAG_WIDE_FUSED(LAG_WIDE_TERM(JET({a}), j), LAG_WIDE_TERM(JET({a}), k + 1 - j), t{m});" for m, a in squares]
    last = [line.replace("j)", "k / 2)").replace("k + 1 - k / 2)", "k / 2 + 1)") for line in there]
    loop = ["for (int j = 2; 2 * j < k; ++j) {", *_indented([*here, *(there if orders == 2 else [])]), "}"]
    return [*loop, *(["if (k > 2 && k % 2 == 0) {", *_indented(last), "}"] if orders == 2 else [])]
