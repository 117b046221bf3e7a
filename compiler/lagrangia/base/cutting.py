"""Lists as they are written on a command line."""

import re

from lagrangia.base.diagnostics import fail

QUOTED = re.compile(r"(?<![\w'\])])'(?:[^'\\\n]|\\.)+'")  # a name; the sign behind a name, or behind another prime, is a prime
_INDEX = re.compile(r"\[[\d, ]+\]$")


def split_list(text: str) -> list[str]:
    """What stands between commas, as `cut_list` cuts it, without what is empty. Raises LagError L0711."""
    return [item for item in cut_list(text) if item]


def cut_list(text: str) -> list[str]:
    """What stands between commas; those in parentheses, brackets and quoted names belong to theirs. Raises LagError L0711."""
    items, depth, begin = [], 0, 0
    for k, character in enumerate(unquoted(text)):
        depth += (character in "([{") - (character in ")]}")
        if depth < 0:
            break
        if character == "," and depth == 0:
            items.append(text[begin:k])
            begin = k + 1
    if depth:
        fail("L0711", f"'{text}': a parenthesis or bracket is {'missing' if depth > 0 else 'too many'}")
    return [item.strip() for item in (*items, text[begin:])]


def cut_pair(text: str) -> tuple[str, str, str]:
    """What stands before the first `=`, it, and what stands behind it, as `str.partition` has it; not in quoted names."""
    name, sign, _ = unquoted(text).partition("=")
    return text[:len(name)], sign, text[len(name) + len(sign):]


def unquoted(text: str) -> str:
    """As long as `text`, with nothing in its quoted names that could be a sign."""
    return QUOTED.sub(lambda name: "_" * len(name[0]), text)


def stem(label: str) -> str:
    """The variable of which a label names an element: c[2].u of c[2].u[1]. Brackets in quotes are of its name."""
    return _INDEX.sub("", label)
