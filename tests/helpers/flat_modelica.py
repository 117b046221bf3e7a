"""A reader of the flat Modelica models that are exported by instructions: derivatives of their states at any state."""

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

_CHOICE = re.compile(r"if (.*) then (.*) else (.*)")


def _python(text: str) -> str:
    """An expression, with a choice as a whole alone."""
    choice = _CHOICE.fullmatch(text)
    if choice is not None:
        when, then, otherwise = map(_python, choice.groups())
        return f"(({then}) if {when} else ({otherwise}))"
    return text.replace("^", "**")


class FlatModelica:
    """`starts` and `values` are of states, and of parameters and inputs; `sources` what states are in the model."""

    def __init__(self, text: str) -> None:
        head, _, body = text.partition("\nequation\n")
        public = head.partition("\nprotected\n")[0]
        states = re.findall(r'^  Real (\w+)\(start = (\S+?), fixed = true.*?\) "(.*)";$', public, re.MULTILINE)
        self.starts = {name: float(x) for name, x, _ in states}
        self.sources = {name: source for name, _, source in states}
        given = re.findall(r'^  (?:parameter|input) Real (\w+)(?:\(unit = "[^"]*"\))?(?:\(start)? = ([^\s;)]+)', public, re.M)
        self.values = {name: float(x) for name, x in given}
        unit = r'(?:\((?:each )?unit = "[^"]*"\))?'
        self.outputs = dict(re.findall(rf'^  output Real (\w+)(?:\[\d+\])?{unit} = (.*?)(?: "[^"]*")?;$', public, re.MULTILINE))
        written = body.partition("\n  annotation(")[0].splitlines()
        equations = [line.strip().rstrip(";").partition(" = ") for line in written]
        steps = [(a, b) for a, _, b in equations if re.fullmatch(r"x_*\d+", a)]
        self.rates = {a[4:-1]: _python(b) for a, _, b in equations if a.startswith("der(")}
        rest = [(a, b) for a, _, b in equations if not re.fullmatch(r"x_*\d+|der\(.*", a)]
        self.unknowns = re.findall(r"^  Real (\w+);", head, re.MULTILINE)
        self.steps = compile("\n".join(f"{a} = {_python(b)}" for a, b in steps), "steps", "exec")
        self.gaps = compile("[" + ", ".join(f"({_python(a)}) - ({_python(b)})" for a, b in rest) + "]", "gaps", "eval")
        self.rates_code = compile(f"[{', '.join(self.rates[name] for name in self.starts)}]", "rates", "eval")
        assert len(rest) == len(self.unknowns) and set(self.rates) == set(self.starts)

    def solved(self, t: float, state: Mapping[str, float], **changes: float) -> dict[str, Any]:
        """All quantities at a state."""
        known = {name: getattr(np, name) for name in ("sin", "cos", "tan", "sqrt", "exp", "log", "abs", "sign", "tanh", "floor")}
        known |= {"atan2": np.arctan2, "min": min, "max": max, "noEvent": bool, "time": t, **self.values, **changes, **state}
        known |= dict.fromkeys(self.unknowns, 0.0)
        exec(self.steps, known)

        def gaps(x: np.ndarray) -> np.ndarray:
            return np.array(eval(self.gaps, known | dict(zip(self.unknowns, x.tolist(), strict=True))))

        n = len(self.unknowns)
        zero = gaps(np.zeros(n))
        matrix = np.array([gaps(row) - zero for row in np.eye(n)]).T
        found = np.linalg.solve(matrix, -zero)
        known |= dict(zip(self.unknowns, found.tolist(), strict=True))
        exec(self.steps, known)  # of paces
        return known

    def slope(self, t: float, y: np.ndarray, **changes: float) -> np.ndarray:
        """Of the states in their order."""
        return np.array(eval(self.rates_code, self.solved(t, dict(zip(self.starts, y.tolist(), strict=True)), **changes)))
