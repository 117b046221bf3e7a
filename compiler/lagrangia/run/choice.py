"""Why a solver goes on: the rows of runtime/choice/choice.c, and what they went by, for people."""

import ctypes as c
import math
from collections.abc import Mapping
from dataclasses import field

from lagrangia.base.records import dataclass

_MEASURED = (
    "tolerance", "coordinates", "constraints", "islands", "rhs_cost", "erk_cost", "series_cost", "series_share", "pirk_cost",
    "poles_cost", "reach", "looks", "swept", "pace", "pace_before", "pace_possible", "gain", "step", "row_spacing", "rows_apart",
    "row_looks", "holding", "limit",
)
_KNOWN = (
    "asked", "is_named", "solver", "explicit_solver", "rows_solver", "turns_solver", "next", "steps", "is_series", "order",
    "trouble", "tried", "is_damped", "fits_transition", "has_jacobian", "has_conditions", "has_corners", "has_modes",
    "has_inputs", "is_swing", "may_hide", "has_attitudes", "rolls",
)
_LARGE = 1e5  # from here on numbers are written with powers of ten


class Facts(c.Structure):
    """LagFacts of runtime/state/facts.h."""

    _fields_ = (*((name, c.c_double) for name in _MEASURED), *((name, c.c_int32) for name in _KNOWN))


class Decision(c.Structure):
    """LagDecision of runtime/state/facts.h."""

    _fields_ = (("facts", Facts), ("rule", c.c_int32), ("to", c.c_int32))


class Rule(c.Structure):
    """LagRule of runtime/choice/choice.h."""

    _fields_ = (("name", c.c_char_p), ("why", c.c_char_p), ("moment", c.c_int32), ("from", c.c_int32), ("to", c.c_int32),
                ("holds", c.c_void_p), ("limit", c.c_void_p))


@dataclass(frozen=True)
class Choice:
    """A solver by its number in C, the row that took it, and the row's reason, in which names of `facts` stand in braces."""

    solver: int = 0
    rule: str = "none"
    reason: str = ""
    facts: Mapping[str, float] = field(default_factory=dict)

    @property
    def why(self) -> str:
        """The reason with its numbers."""
        return self.reason.format_map(self.figures)

    @property
    def figures(self) -> dict[str, str]:
        """The numbers of the reason, by their names."""
        from string import Formatter

        return {name: figure(self.facts[name]) for _, name, _, _ in Formatter().parse(self.reason) if name}


def told(library: c.CDLL, rule: int, solver: int, facts: Facts) -> Choice:
    """What a decision of the run time was; a Choice without a reason where there was none."""
    row = library.lag_rule(rule)
    if not row:
        return Choice()
    measured = {name: getattr(facts, name) for name in _MEASURED}
    return Choice(solver, row.contents.name.decode(), row.contents.why.decode(), measured)


def figure(value: float) -> str:
    """Whole numbers as they are, others to two digits."""
    if math.isfinite(value) and value == int(value) and abs(value) < _LARGE:
        return str(int(value))
    return f"{value:.2g}" if abs(value) < 1 or abs(value) >= _LARGE else f"{value:.{max(0, 1 - int(math.log10(abs(value))))}f}"
