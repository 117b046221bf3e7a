"""What Modelica has and this language has not: what to write instead."""

from collections.abc import Mapping

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
