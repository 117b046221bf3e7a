"""Layout -> LaTeX."""

from collections.abc import Mapping
from fractions import Fraction

from lagrangia.paper.layout import (
    LETTERS,
    Apply,
    Bracket,
    Cases,
    Grid,
    Listing,
    Name,
    Node,
    Numeral,
    Pieces,
    Power,
    Product,
    Quotient,
    Relation,
    Root,
    Slope,
    Total,
    Words,
)
from lagrangia.paper.typeset import FUNCTIONS, decimal, is_loose, sign_text
from lagrangia.paper.widths import is_tall

_LATEX_GREEK = {"·": r"\cdot ", "δ": r"\delta ", "ell": r"\ell", "phi": r"\varphi", "epsilon": r"\varepsilon", "omicron": "o",
                "sigmaf": r"\varsigma"}
_DOTS = {0: "%s", 1: r"\dot{%s}", 2: r"\ddot{%s}", 3: r"\dddot{%s}"}


def latex(node: Node) -> str:
    """A formula as LaTeX."""
    match node:
        case Name(base, sub, marks, argument, is_bold, prefix):
            word = rf"\boldsymbol{{{_latex_word(base)}}}" if base in LETTERS else rf"\mathbf{{{base}}}"
            shown = _DOTS[marks] % (word if is_bold else _latex_word(base))
            shown = prefix.replace("Δ", r"\Delta ").replace("δ", r"\delta ") + shown + (f"_{{{_latex_sub(sub)}}}" if sub else "")
            return shown + (f"({argument})" if argument else "")
        case Words(words):
            return rf"\text{{{latex_escape(words)}}}"
        case Numeral(value, digits):
            return _latex_decimal(value, digits) if digits else _latex_number(value)
        case Product(items):
            return r"\,".join(map(_latex_factor, items))
        case Total(items):
            return "".join(sign_text(sign, k).replace("−", "-") + latex(item) for k, (sign, item) in enumerate(items))
        case Quotient(top, bottom):
            return rf"\frac{{{latex(top)}}}{{{latex(bottom)}}}"
        case Power(base, exponent):
            shown = f"{{{latex(base)}}}" if isinstance(base, Name) else _latex_tight(base)
            return f"{shown}^{{{latex(exponent)}}}"
        case Apply(function, argument, power):
            if function == "abs":
                return _fenced(latex(argument), "|", "|", is_tall(argument))
            raised = f"^{{{power}}}" if power != 1 else ""
            name = rf"\{function}" if function in FUNCTIONS else r"\delta" if function == "δ" else rf"\operatorname{{{function}}}"
            inside = latex(argument if isinstance(argument, Name | Bracket | Listing) else Bracket(argument))
            return f"{name}{raised} {inside}"
        case Root(inside):
            return rf"\sqrt{{{latex(inside)}}}"
        case Bracket(inside):
            return _bracketed(inside)
        case Listing(items):
            return _fenced(r",\; ".join(map(latex, items)), "(", ")", is_tall(node))
        case _:
            return _latex_large(node)


def _latex_large(node: Node) -> str:
    match node:
        case Grid(rows):
            body = r" \\ ".join(" & ".join(map(latex, row)) for row in rows)
            return rf"\begin{{bmatrix}} {body} \end{{bmatrix}}"
        case Cases(items, (where, otherwise)):
            conditions = [rf"\text{{{latex_escape(where)} }} {latex(when)}" if when is not None else
                          rf"\text{{{latex_escape(otherwise)}}}" for _, when in items]
            body = r" \\ ".join(f"{latex(value)} & {when}" for (value, _), when in zip(items, conditions, strict=True))
            return rf"\begin{{cases}} {body} \end{{cases}}"
        case Slope(top, bottom, is_total):
            d = r"\mathrm{d}" if is_total else r"\partial "
            return rf"\frac{{{d}{latex(top) if top is not None else ''}}}{{{d}{latex(bottom)}}}"
        case Relation(left, right, symbol):
            return f"{latex(left)} {_LATEX_RELATIONS.get(symbol, symbol)} {latex(right)}"
        case Pieces(items):
            return " ".join(f"{{}}{_latex_signs(sign)} {latex(item)}" if sign else latex(item) for sign, item in items)
        case _:
            raise AssertionError(node)


def _bracketed(inside: Node) -> str:
    return _fenced(latex(inside), "(", ")", is_tall(inside))


def _fenced(inside: str, left: str, right: str, tall: bool) -> str:
    """Brackets stretch around what is tall alone: others get gaps of it."""
    return rf"\left{left}{inside}\right{right}" if tall else f"{left}{inside}{right}"


_LATEX_RELATIONS: Mapping[str, str] = {"≤": r"\le", "≥": r"\ge", "≠": r"\ne", "≈": r"\approx"}


def _latex_signs(signs: str) -> str:
    return " ".join(_LATEX_RELATIONS.get(sign, sign).replace("−", "-") for sign in signs.split())


def _latex_word(base: str) -> str:
    if base in LETTERS or base in _LATEX_GREEK:
        if base.startswith("script "):
            return rf"\mathcal{{{base[-1]}}}"
        return _LATEX_GREEK.get(base, f"\\{base}")
    return base if len(base) == 1 else rf"\mathrm{{{latex_escape(base)}}}"


def _latex_sub(sub: str) -> str:
    parts = [part if part.isdigit() else _latex_word(part) for part in sub.split()]
    return ",".join(parts)


_ESCAPES = {"_": r"\_", "%": r"\%", "&": r"\&", "#": r"\#", "$": r"\$", "{": r"\{", "}": r"\}", "^": r"\^{}", "~": r"\~{}",
            "\\": r"\textbackslash{}", "δ": r"$\delta$", "−": "$-$", "∂": r"$\partial$", "≈": r"$\approx$"}


def latex_escape(words: str) -> str:
    """Words with the signs that LaTeX reads as commands written out."""
    return "".join(_ESCAPES.get(c, c) for c in words)


def _latex_decimal(value: Fraction, digits: int) -> str:
    mantissa, _, exponent = decimal(value, digits).partition("e")
    return rf"{mantissa}\cdot 10^{{{int(exponent)}}}" if exponent else mantissa


def _latex_number(value: Fraction) -> str:
    return str(value.numerator) if value.denominator == 1 else rf"\tfrac{{{value.numerator}}}{{{value.denominator}}}"


def _latex_factor(node: Node) -> str:
    return _bracketed(node) if isinstance(node, Total) else latex(node)


def _latex_tight(node: Node) -> str:
    return _bracketed(node) if is_loose(node) else f"{{{latex(node)}}}"


