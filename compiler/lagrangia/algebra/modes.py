"""Modes: what is constant between two time events, and the table in which the same ones are found."""

from collections.abc import Hashable, Sequence
from dataclasses import field
from functools import cached_property

import casadi as ca

from lagrangia.algebra.displacements import Displacements
from lagrangia.algebra.lookup_functions import TableUse
from lagrangia.algebra.numbering import Numbering
from lagrangia.algebra.scalars import as_expression
from lagrangia.algebra.widths import Divisors
from lagrangia.base.records import dataclass
from lagrangia.base.table_data import Beyond, TableData

RELATIONS = {ca.OP_LT: "<", ca.OP_LE: "<="}


@dataclass
class Mode:
    """A quantity that is constant between two time events: a relation, a floor, or what a table in time says of a line.

    `value` gives it as a function of t (the middle of the segment) and p; the events are where one of the arguments crosses
    zero (kind 0), an integer (kind 1) or a knot of table k (kind 2 + k). Of a table, `use`, it is a number of its piece; of an
    input it is one, too, and has no events of its own.
    """

    symbol: ca.SX
    formula: ca.SX | None
    arguments: Sequence[ca.SX]
    kinds: Sequence[int]  # of each argument
    use: TableUse | None = None
    column: int = 0
    of_input: tuple[int, int, int] | None = None  # the places of one and of its first two rates among the inputs, or -1

    of_sampler: tuple[int, int] | None = None  # whose instants change it, and its rank there; its formula is then its first value
    in_pieces: ca.SX | None = None  # its formula by what inputs are in time, where they move: by pieces of theirs
    of_attitude: str = ""  # whose reference it is a part of: it moves with the steps, from its formula on

    @cached_property
    def hash(self) -> int:
        """Of its symbol."""
        return int(self.symbol.__hash__())

    @property
    def events(self) -> list[tuple[ca.SX, int]]:
        """Its arguments with their kinds."""
        return list(zip(self.arguments, self.kinds, strict=True))

    @property
    def is_relation(self) -> bool:
        """Whether it is 0 or 1, as a comparison says."""
        return self.formula is not None and not self.is_filled_in and self.formula.op() in RELATIONS

    @property
    def is_filled_in(self) -> bool:
        """By the run time, from tables, inputs or at instants."""
        return self.use is not None or self.of_input is not None or self.of_sampler is not None

    @property
    def is_kept(self) -> bool:
        """Whether it is state of the run: no time and parameters say what it is."""
        return self.of_sampler is not None or self.of_attitude != ""

    @property
    def jumps(self) -> bool:
        """Whether what is made of it may jump, or its rate, at an event: splines do not, but where they end and are held."""
        table = None if self.use is None else self.use.table
        return not self.of_attitude and (table is None or table.degree < 3 or table.beyond is Beyond.HOLD)

    @property
    def value(self) -> ca.SX:
        """At a time that is no event."""
        if self.use is not None:
            return as_expression(self.use.pieces[self.column])
        assert self.formula is not None
        return self.formula

    @property
    def in_time(self) -> ca.SX:
        """The same of time, parameters and pieces of inputs."""
        return self.value if self.in_pieces is None else self.in_pieces

    @property
    def written(self) -> ca.SX:
        """The same without calls, which tapes cannot have."""
        return self.value if self.use is None else as_expression(self.use.written_pieces[self.column])


@dataclass
class ModeIndex:
    """Finds the mode that says the same, however its expression was built: what is the same has one number."""

    numbering: Numbering = field(default_factory=Numbering)  # of all parts of arguments
    symbols: dict[Hashable, ca.SX] = field(default_factory=dict)  # by operator and argument
    hashes: set[int] = field(default_factory=set)  # of these symbols, but for references of attitudes
    references: set[int] = field(default_factory=set)  # of those
    modes: list[Mode] = field(default_factory=list)  # all of them, of all islands
    lengths: dict[int, ca.SX] = field(default_factory=dict)  # x of |x| that are lengths, by their numbers
    tables: list[TableData] = field(default_factory=list)  # in time, each once
    literals: dict[Hashable, TableData] = field(default_factory=dict)
    asked: set[str] = field(default_factory=set)  # of the algebra: functions, "choice" for conditions and tables
    displacements: Displacements = field(default_factory=Displacements)
    divisors: Divisors = field(default_factory=Divisors)
