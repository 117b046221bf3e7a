"""Which numbers of parameters are compiled in: those with which products fall away, and masses of 0.

What moves no mass follows from other equations than what does (massless.py), so that a mass is compiled in where its value as
declared is 0, whatever it is bound to. `annotation(Evaluate = true)` asks for 0, 1 and -1, and of a direction in space for any
number: axes of hinges, when these are known, are laid so that less is left to be worked out (dynamics/spatial_axes.py).
"""

from collections.abc import Mapping
from math import prod

from lagrangia.base.diagnostics import LagError
from lagrangia.language.flat import FlatModel, Variable
from lagrangia.language.folding import numbers_of
from lagrangia.language.tree import Ref
from lagrangia.run.formulas import MASSES

_PLAIN = (0.0, 1.0, -1.0)
Numbers = Mapping[str, tuple[float | None, ...]]  # of the elements of parameters that have some


def compiled_numbers(model: FlatModel, is_general: bool = False, massless: tuple[str, ...] | None = None) -> Numbers:
    """Where it `is_general`, only those that nobody can set. `massless` names the masses of 0 in place of those declared so."""
    declared, found = _Declared(model, is_general), {}
    for variable in (v for v in model.variables.values() if v.kind == "parameter" and v.binding is not None):
        is_open = not variable.locked and is_general
        if massless is None and (is_open or not (variable.is_evaluated or variable.unit in MASSES)):
            continue
        numbers: list[float | None] = [None] * prod(variable.shape)
        if variable.is_evaluated and (variable.locked or not is_general):
            numbers = [x if x in _PLAIN or _is_direction(variable) else None for x in declared.literal(variable)]
        if variable.unit in MASSES and massless is not None:
            numbers = [0.0 if name in massless else x or None for (name, _), x in zip(variable.elements(), numbers, strict=True)]
        elif variable.unit in MASSES and (variable.locked or not is_general):
            numbers = [0.0 if x == 0 else y for x, y in zip(declared.values(variable), numbers, strict=True)]
        if any(x is not None for x in numbers):
            found[variable.name] = tuple(numbers)
    return found


def _is_direction(variable: Variable) -> bool:
    """Whether it is a vector of space without a unit."""
    return variable.shape == (3,) and variable.unit in ("", "1")


def values_as_declared(model: FlatModel, variable: Variable) -> list[float | None]:
    """Of its elements, in SI units; None where they follow from the motion, or are not numbers."""
    return _Declared(model, is_locked=False).values(variable)


class _Declared:
    """Values of parameters as they are declared, those that others can set left out where `is_locked`."""

    def __init__(self, model: FlatModel, is_locked: bool) -> None:
        self.variables, self.is_locked = model.variables, is_locked
        self.known: dict[str, list[float | None]] = {}

    def literal(self, variable: Variable) -> list[float | None]:
        """Those that are written as numbers; what fits no shape is told where it is evaluated."""
        assert variable.binding is not None
        return _fitting(variable, numbers_of(variable.binding, variable.shape))

    def values(self, variable: Variable) -> list[float | None]:
        """None for those that cannot be told."""
        if variable.name not in self.known:
            self.known[variable.name] = [None] * prod(variable.shape)  # while it is looked for: of itself nothing follows
            if variable.binding is not None:
                self.known[variable.name] = self._follow(variable)
        return self.known[variable.name]

    def _follow(self, variable: Variable) -> list[float | None]:
        assert variable.binding is not None
        try:
            if isinstance(variable.binding, Ref) and variable.shape:
                other = self.variables[variable.binding.name]
                return _fitting(variable, self._of(other))
            return _fitting(variable, numbers_of(variable.binding, variable.shape, self._at))
        except LagError:  # it is told where parameters are evaluated
            return [None] * prod(variable.shape)

    def _at(self, ref: Ref) -> float | None:
        variable = self.variables[ref.name]
        shape = variable.shape
        if len(ref.index) != len(shape) or any(not 1 <= i <= n for i, n in zip(ref.index, shape, strict=True)):
            return None
        values = self._of(variable)
        for i, n in zip(ref.index, shape, strict=True):
            row = len(values) // n
            values = values[(i - 1) * row : i * row]
        return values[0]

    def _of(self, variable: Variable) -> list[float | None]:
        is_open = variable.kind != "parameter" or (self.is_locked and not variable.locked)
        return [None] * prod(variable.shape) if is_open else self.values(variable)


def _fitting(variable: Variable, values: list[float | None]) -> list[float | None]:
    count = prod(variable.shape)
    return values if len(values) == count else [None] * count
