"""Virtual displacements: what moves with them has slopes along them, and no condition, step or table changes place by them."""

from dataclasses import field

import casadi as ca

from lagrangia.algebra.scalars import Expression, as_expression
from lagrangia.base.records import dataclass


@dataclass
class Displacements:
    """Their symbols, which are kept: hashes tell only what lives."""

    symbols: dict[int, ca.SX] = field(default_factory=dict)  # by their hashes
    columns: list[ca.SX] = field(default_factory=list)  # new ones

    def new(self, count: int, name: str = "displacement") -> Expression:
        """A column of them."""
        self.columns.append(ca.SX.sym(name, count))
        return as_expression(self.columns[-1])

    def at_rest(self, x: ca.SX) -> ca.SX:
        """The same in the real motion, where displacements are 0."""
        for column in self.columns:
            self.symbols.update((s.__hash__(), s) for s in ca.symvar(column))
        self.columns.clear()
        moved = [s for s in ca.symvar(x) if s.__hash__() in self.symbols] if self.symbols else []
        return as_expression(ca.substitute([x], moved, [ca.SX(0)] * len(moved))[0]) if moved else x
