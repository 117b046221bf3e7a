"""What Modelica has and this language has not: what to write instead."""

import re
from collections.abc import Collection, Mapping

from lagrangia.base.diagnostics import nearest
from lagrangia.language.functions import ALIASES

_ENERGY = "forces follow from energies and from `work force on position`: a connector has a position alone"
_SAMPLED = "what is sampled is held: when sample(0, 0.01) then u = ...; end when;"

# Words that begin a declaration, a section or a statement, or stand before a class.
FOREIGN_WORDS: Mapping[str, tuple[str, str]] = {
    "flow": ("flow variables", _ENERGY),
    "stream": ("stream variables", "fluids are no part of this language: only positions are connected"),
    "external": ("external functions", "write the function as an algorithm, or give its values as a table of a file"),
    "while": ("while loops among equations", "they stand in the algorithms of functions; here: for i in 1:n loop ... end for;"),
    "break": ("break in loops", "let an if in the loop say what the remaining passes do"),
    "return": ("return in functions", "let an if say what the rest of the algorithm does"),
    "operator": ("operator classes", "write functions with names of their own: add(a, b)"),
    "pure": ("the word pure", "every function is pure here: leave the word out"),
    "impure": ("impure functions", "a function has no memory: what changes in time is a state, or held by `when sample(...)`"),
    "expandable": ("expandable connectors", "write the connector with all its variables"),
    "optimization": ("optimization classes", "lag sweep varies parameters, and lag export --to casadi serves optimizers"),
    "transition": ("state machines", "write `when condition then ... end when` and held values for each state"),
    "initialState": ("state machines", "write `when condition then ... end when` and held values for each state"),
}
FOREIGN_PAIRS: Mapping[tuple[str, str], tuple[str, str]] = {
    ("initial", "algorithm"): ("initial algorithms", "write equations: initial equation x = ...;"),
    ("operator", "record"): ("operator records", "write a record and functions with names of their own: add(a, b)"),
    ("operator", "function"): ("operator functions", "write functions with names of their own: add(a, b)"),
}

# Types of other languages, and what they are called here.
FOREIGN_TYPES: Mapping[str, str] = {
    **dict.fromkeys(("double", "float", "real", "number"), "a number is a Real, or a quantity such as Length"),
    **dict.fromkeys(("int", "long", "integer"), "whole numbers are an Integer"), "string": "texts are a String",
    **dict.fromkeys(("bool", "boolean", "logical"), "what is true or false is a Boolean"),
    **dict.fromkeys(("Complex", "complex"), "complex numbers are not of this language: write two Reals"),
    **dict.fromkeys(("enum", "enumeration"), "write: type E = enumeration(low, high);"),
}

# Functions and operators, which parse as calls.
FOREIGN_CALLS: Mapping[str, str] = {
    **dict.fromkeys(("inStream", "actualStream"), "fluids are no part of this language: only positions are connected"),
    **dict.fromkeys(("branch", "root", "potentialRoot", "isRoot", "rooted"), "loops of frames are found and cut without help: "
                    "leave out what is of Connections"),
    **dict.fromkeys(("Clock", "previous", "hold", "subSample", "superSample", "shiftSample", "backSample", "noClock",
                     "firstTick", "interval"), f"clocks are not of this language: {_SAMPLED}"),
    **dict.fromkeys(("activeState", "ticksInState", "timeInState", "transition", "initialState"), "state machines are not of "
                    "this language: write `when condition then ... end when` and held values for each state"),
    **dict.fromkeys(("edge", "change"), "it is the condition of an event alone: when edge(x > 0) then, which is when x > 0 then"),
    "spatialDistribution": "what runs along a line is not of this language: delay(x, T) gives what was some time ago",
    "cardinality": "count what is connected yourself, with a parameter Integer n",
    "initial": "it is the condition of an event alone: when initial() then, or when {initial(), x > 0} then; what holds at the "
               "start stands under `initial equation`",
    "terminal": "what is asked at the end is read from the results",
    "getInstanceName": "texts are not made of names",
    "symmetric": "write the matrix: (A + transpose(A))/2",
    "promote": "write the matrix: matrix(x), or {x}",
    "pure": "every function is pure here: leave the word out",
    "loadResource": "files are named by their paths: table(x, \"file.csv\")",
}

# Names and functions of other languages and of typeset text.
_RATE = "a rate is written der(x), and its rate der(der(x))"
_NAMES: Mapping[str, str] = {"t": "time", "π": "pi", "Pi": "pi", "PI": "pi", "True": "true", "False": "false",
                             "TRUE": "true", "FALSE": "false", "½": "1/2", "¼": "1/4"}
_SECTIONS = {"gleichung": "equation", "gleichungen": "equation", "eq": "equation", "energie": "energy"}
_FUNCTIONS: Mapping[str, str] = {
    **dict.fromkeys(("d", "D", "diff", "ddt", "deriv", "derivative", "ddot", "derivate"), _RATE),
    "range": "a range is written 1:n, with steps 1:2:n", "length": "write: size(x, 1), or norm(x)",
    **dict.fromkeys(("heaviside", "Heaviside"), "write: if x > 0 then 1 else 0"),
    "len": "write: size(x, 1)", "round": "write: floor(x + 0.5)",
    "step": "write: if time > 1 then 1 else 0", "integral": "declare a state: Real y(start = 0); ... der(y) = x",
}
_POWERS = "²³"


def name_meant(name: str, known: Collection[str]) -> str:
    """What an unknown name is likely to mean in another language: a hint, or ""."""
    if name in _NAMES:
        return f"write: {_NAMES[name]}"
    if name[-1:] in _POWERS and name[:-1]:
        return f"a power is written {name[:-1]}^{_POWERS.index(name[-1]) + 2}"
    rate = re.fullmatch(r"dd?(.+?)(?:_?dt)?|(.+?)_?d?dot", name)
    of = (rate[1] or rate[2] if rate else "").lstrip("_")
    return f"a rate is written der({of})" if of in known else ""


def function_meant(name: str) -> str:
    """What an unknown function is likely to mean in another language: a hint, or ""."""
    return f"it is called '{ALIASES[name]}' here" if name in ALIASES else _FUNCTIONS.get(name, "")


def section_meant(type_name: str) -> str:
    """The section that a word means which was read as a type; "" where it means none."""
    near = nearest(type_name, ("equation", "algorithm")) or _SECTIONS.get(type_name.lower())
    return f"did you mean the section `{near}`?" if near else ""
