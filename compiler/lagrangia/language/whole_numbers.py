"""Which expressions are whole numbers, whatever moves: of Integer variables, and of functions of people's own that make some."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import field
from typing import NoReturn

from lagrangia.base.diagnostics import Report, fail
from lagrangia.base.records import dataclass
from lagrangia.language.function_variables import FlatFunction
from lagrangia.language.tree import Array, Binary, Call, Flat, IfExpression, Local, Number, Ref, Unary

_BROKEN, _WRITE = "an Integer takes whole numbers, this may be any", "write: integer(x), the greatest below x"


def refuse_broken(part: Flat) -> NoReturn:
    """Of what an Integer variable is given. Raises LagError L0302."""
    fail("L0302", _BROKEN, part.span, _WRITE)


@dataclass
class WholeNumbers:
    """`types` are those of discrete variables, `functions` people's own."""

    types: Mapping[str, str]
    functions: Mapping[str, FlatFunction]
    locals: set[str] = field(default_factory=set)  # variables of the function that is read which are whole
    _made: dict[str, bool] = field(default_factory=dict)  # whether a function gives whole numbers where it is given some

    def find_broken(self, values: Iterable[Flat], report: Report) -> None:
        """Of Integer variables. Reports L0302."""
        for value in values:
            if (wrong := self.broken(value)) is not None:
                report.error("L0302", _BROKEN, wrong.span, _WRITE)

    def broken(self, node: Flat, may_divide: bool = False, known: frozenset[str] = frozenset()) -> Flat | None:
        """The first part that may be no whole number, or if it `may_divide` no ratio of some; None where there is none. `known`:
        variables of the function it stands in that are whole."""
        parts: Sequence[Flat] = ()
        match node:
            case Number(value) if value.is_integer():
                return None
            case Ref(name) if self.types.get(name) == "Integer":
                return None
            case Local(name) if name in known or name in self.locals:
                return None
            case Call(function, arguments) if function in self.functions:
                if not self._makes_whole(function):
                    return node
                own = self.functions[function]
                parts = [x for name, x in zip(own.inputs, arguments, strict=True) if name in own.whole_inputs]
                may_divide = False
            case Call("floor" | "ceil" | "sign"):
                return None
            case Call("abs" | "min" | "max" | "mod" | "sum" | "product" | "pre", parts) | Array(parts):
                pass
            case Unary("-", operand):
                parts = (operand,)
            case Binary("/", left, right) if may_divide:
                parts = (left, right)
            case Binary("+" | "-" | "*", left, right) | IfExpression(_, left, right):
                parts = (left, right)
            case _:
                return node
        return next((wrong for part in parts if (wrong := self.broken(part, may_divide, known)) is not None), None)

    def _makes_whole(self, name: str) -> bool:
        if name not in self._made:
            function = self.functions[name]
            known = function.whole_inputs
            for place, value in function.steps:
                known = known | {place} if self.broken(value, False, known) is None else known - {place}
            self._made[name] = function.output in known
        return self._made[name]
