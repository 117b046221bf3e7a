"""What is printed, for terminals that know ASCII alone, or that are not there; and text of models, which is data and no commands.

Formulas spell Greek letters, fractions, indices and signs in ASCII where the stream cannot show them.
"""

import codecs
import os
import sys
import unicodedata
from contextlib import suppress

_SIGNS = {"−": "-", "·": "*", "×": "*", "√": "sqrt", "∂": "d", "Σ": "sum", "∫": "int", "≈": "~", "≤": "<=", "≥": ">=", "≠": "/=",
          "…": "...", "→": "->", "±": "+-", "∞": "inf", "°": "deg", "′": "'", "″": "''", "⁻": "^-", "λ": "lambda", "µ": "u",
          "–": "-", "—": "-", "’": "'", "‖": "|", "ẋ": "x'", "ẍ": "x''", "⊥": "_|_", "∈": "in", "⁄": "/", "\u0307": "'",
          "\u0308": "''"}
_SUPERSCRIPTS, _SUBSCRIPTS = "⁰¹²³⁴⁵⁶⁷⁸⁹", "₀₁₂₃₄₅₆₇₈₉"


def prepare_output() -> None:
    """Standard output and error take whatever is written, as well as they can: spelt in ASCII, dropped where they are closed."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115
        elif hasattr(stream, "reconfigure"):
            with suppress(ValueError, OSError):
                stream.reconfigure(errors="in_ascii")


def in_ascii(sign: str) -> str:
    """How a sign is written with the letters of ASCII: θ as theta, ½ as 1/2, x₁ as x_1."""
    if sign in _SIGNS:
        return _SIGNS[sign]
    if sign in _SUPERSCRIPTS:
        return f"^{_SUPERSCRIPTS.index(sign)}"
    if sign in _SUBSCRIPTS:
        return f"_{_SUBSCRIPTS.index(sign)}"
    name = unicodedata.name(sign, "")
    if name.startswith("GREEK ") and " LETTER " in name:
        letter = name.split(" LETTER ")[1].split()[0].lower().replace("lamda", "lambda")
        return letter.capitalize() if "CAPITAL" in name else letter
    plain = unicodedata.normalize("NFKD", sign).replace("⁄", "/")
    return plain if plain.isascii() else "?"


def _replace(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(map(in_ascii, error.object[error.start : error.end])), error.end


codecs.register_error("in_ascii", _replace)


def plain_text(text: str) -> str:
    """Text of a model without signs that would command a terminal or turn the reading direction: they are shown by their code."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in "\n\t" else f"\\x{ord(c):02x}" for c in text)


def python_text(text: str) -> str:
    """Text for the inside of a docstring, which ends neither it nor is read as escapes."""
    return text.replace("\\", "\\\\").replace('"', '\\"')


def read_number(text: str) -> float:
    """A number as tables and command lines of any program have it; Python alone takes 1_000, and digits of other scripts. Raises
    ValueError."""
    return float(_plain(text))


def read_whole(text: str) -> int:
    """Likewise without a point. Raises ValueError."""
    return int(_plain(text))


def _plain(text: str) -> str:
    if "_" in text or not text.strip().isascii():
        raise ValueError(f"'{text.strip()}' is no number")
    return text
