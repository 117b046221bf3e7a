"""Connectors: what `connect` joins has one position, and what gives it.

A variable of a connector that its class leaves open is given by an equation of the component that has it (`flange_a.phi = phi`),
or by what it is connected to; where nothing gives it, all that meet there share a coordinate of their own, which has no mass. Two
that are given and meet are tied by an equation. Forces need no variable: they follow from virtual work.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Protocol

from lagrangia.base.diagnostics import Report, Source, Span, fail
from lagrangia.base.records import dataclass
from lagrangia.language.classes import ClassTable
from lagrangia.language.elements import array_of, element, length
from lagrangia.language.flat import Equation, Variable
from lagrangia.language.instances import FrameSlot, Instance, Member, Scope, Slot
from lagrangia.language.mentions import leaves, nodes
from lagrangia.language.tree import Array, Call, Expression, Flat, Ref, Reference, Whole

_POSITIONS = frozenset({"rad", "m"})  # units of what a motion may decide


@dataclass(frozen=True)
class Connection:
    """Two variables of connectors that are one."""

    a: str
    b: str
    span: Span
    component: str


class Names(Protocol):
    """What names mean (names.py)."""

    def integer(self, expression: Expression, scope: Scope, what: str) -> int:
        """The integer that an expression must be. Raises LagError L0210."""
    def flatten(self, expression: Expression, scope: Scope) -> Flat:
        """The expression as it is in the flat model. Raises LagError."""


def connected(call: Call[Expression], scope: Scope, span: Span, names: Names) -> list[Connection] | None:
    """What connect(a, b) makes one; None where neither is a connector. Raises LagError L0221 where one alone is."""
    a, b = (_connector_at(argument, scope, names) for argument in call.arguments)
    if a is not None and b is not None:
        return list(_between(a, b, span, scope.instance.path))
    for end, other in ((a, call.arguments[1]), (b, call.arguments[0])):
        if end is not None:
            names.flatten(other, scope)  # a name that is not known is told as such
            fail("L0221", f"'{end.path}' is a connector: what it is connected to must be one too", other.span)
    return None


def bound_to(connector: Instance, names: Names) -> list[Connection]:
    """Of a connector that is given another one in a modification, J(flange_a = spring.flange_b). Raises LagError L0221."""
    bound = connector.joined_to
    if bound is None:
        return []
    other = _connector_at(bound.expression, bound.scope, names, [index for index, _ in bound.selection])
    if other is None:
        names.flatten(bound.expression, bound.scope)
        fail("L0221", f"'{connector.path}' is a connector: what it is connected to must be one too", bound.expression.span)
    return list(_between(other, connector, bound.expression.span, ""))


def _connector_at(expression: Expression, scope: Scope, names: Names, selection: Sequence[int] = ()) -> Instance | None:
    """The connector that an expression names; None for anything else. `selection` picks from arrays without subscripts."""
    if isinstance(expression, Array) and selection and selection[0] <= len(expression.items):
        return _connector_at(expression.items[selection[0] - 1], scope, names, selection[1:])
    if not isinstance(expression, Reference) or _is_port(expression, scope.instance):
        return None
    members: Mapping[str, Member] = scope.instance.members
    found: Member | None = None
    left = list(selection)
    for part in expression.parts:
        found = members.get(part.name)
        if not isinstance(found, Instance | list) or any(isinstance(subscript, Whole) for subscript in part.subscripts):
            return None
        picks = [names.integer(subscript, scope, "a subscript") for subscript in part.subscripts]
        while isinstance(found, list) and (picks or left):
            pick = (picks or left).pop(0)
            if not 1 <= pick <= len(found):
                fail("L0214", f"'{part.name}' has {len(found)} elements, not {pick}", part.span)
            found = found[pick - 1]
        members = found.members if isinstance(found, Instance) and not picks else {}
    return found if isinstance(found, Instance) and found.definition.kind == "connector" else None


def _is_port(expression: Reference, within: Instance) -> bool:
    """Whether it surely is a frame, as most that is connected: elements of an array are of one class, whatever the subscripts."""
    found: Member | None = within
    for part in expression.parts:
        found = found.members.get(part.name) if isinstance(found, Instance) else None
        while isinstance(found, list):
            found = found[0] if found else None
    return isinstance(found, FrameSlot)


def _between(a: Instance, b: Instance, span: Span, component: str) -> Iterator[Connection]:
    """One connection for each variable of two connectors. Raises LagError L0221 where they are of different kinds."""
    names = [{name for name, member in end.members.items() if isinstance(member, Slot)} for end in (a, b)]
    if names[0] != names[1]:
        first, second = (", ".join(sorted(found)) or "nothing" for found in names)
        fail("L0221", f"'{a.path}' has {first}, '{b.path}' has {second}: they cannot be connected", span,
             "connect what turns to what turns, and what slides to what slides")
    for name in sorted(names[0]):
        yield Connection(f"{a.path}.{name}", f"{b.path}.{name}", span, component)


def find_repeated(connections: Iterable[Connection], library: Collection[Source], report: Report) -> None:
    """L0224 for connections of people's own between what is connected already."""
    first, told = dict[str, str](), set[Span]()

    def find(name: str) -> str:
        while (over := first.get(name)) is not None:
            first[name] = first.get(over, over)
            name = over
        return name

    for connection in connections:
        if (one := find(connection.a)) != (other := find(connection.b)):
            first[one] = other
        elif connection.span not in told and connection.span.source not in library:
            told.add(connection.span)
            a, b = (end.rpartition(".")[0] for end in (connection.a, connection.b))
            what = "this joins a connector to itself" if a == b else f"'{a}' and '{b}' are joined already"
            report.warning("L0224", what, connection.span, "leave it out")


class Bindings:
    """What gives each variable its value, as far as it is found."""

    def __init__(self, variables: Mapping[str, Variable], ends: frozenset[str]) -> None:
        self.variables = dict(variables)
        self.ends = ends  # variables of connectors
        self.values = {name: variable.binding for name, variable in variables.items()}

    def take(self, equations: Sequence[Equation]) -> list[Equation]:
        """Equations `y = expression` of variables without a binding become their bindings, those of all elements, `y[i] =
        expression`, together one; returns the others. Raises LagError L0211 where some elements have one and others none."""
        for variable in self.variables.values():
            if 0 in variable.shape and self._is_open(variable.name):
                self._bind(variable, array_of(variable.shape, (), {}, variable.span))
        later = [self._joins_two(equation) for equation in equations]  # what is stated of either comes first, as in `of = to`
        given = {k for k in sorted(range(len(equations)), key=later.__getitem__) if self._give(equations[k])}
        left = [part for k, equation in enumerate(equations) if k not in given for part in self._dealt(equation)]
        parts: dict[str, dict[tuple[int, ...], tuple[int, Flat]]] = {}
        for k, equation in enumerate(left):
            for side, other in ((equation.left, equation.right), (equation.right, equation.left)):
                if isinstance(side, Ref) and side.index and self._is_open(side.name) and (
                        side.index not in parts.setdefault(side.name, {})):
                    parts[side.name][side.index] = k, other
                    break
        for name, elements in parts.items():
            variable = self.variables[name]
            missing = [label for label, index in variable.elements() if index not in elements]
            if missing:
                fail("L0211", f"some elements of '{name}' have a value, '{missing[0]}' has none", variable.span,
                     f"write: {missing[0]} = ...")
            self._bind(variable, array_of(variable.shape, (), {index: x for index, (_, x) in elements.items()}, variable.span))
        taken = {k for elements in parts.values() for k, _ in elements.values()}
        return [equation for k, equation in enumerate(left) if k not in taken]

    def _dealt(self, equation: Equation) -> list[Equation]:
        """Of a slice, z[1:2] = x or A[1, :] = x: the equations of its elements; any other one as it is."""
        def size(ref: Ref) -> int | None:
            variable = self.variables.get(ref.name)
            return variable.shape[len(ref.index)] if variable is not None and len(variable.shape) > len(ref.index) else None

        def deal(left: Flat, right: Flat) -> Iterator[Equation]:
            count = length(left, size)
            if count is None or length(right, size) != count:
                yield replace(equation, left=left, right=right)
                return
            for k in range(1, count + 1):
                yield from deal(element(left, k, size), element(right, k, size))

        is_slice = any(
            named and all(isinstance(node, Array) or (isinstance(node, Ref) and self._is_open(node.name)) for node in named)
            for named in (list(nodes(side)) for side in (equation.left, equation.right)
                          if isinstance(side, Array) or (isinstance(side, Ref) and side.index)))
        return list(deal(equation.left, equation.right)) if is_slice else [equation]

    def _joins_two(self, equation: Equation) -> bool:
        """Whether an equation says of two variables, neither of a connector, that they are one."""
        sides = (equation.left, equation.right)
        named = {x.name for x in sides if isinstance(x, Ref) and not x.index and x.name not in self.ends}
        return len(named) == 2 and all(name in self.variables and self.variables[name].kind == "variable" for name in named)

    def _is_open(self, name: str) -> bool:
        variable = self.variables.get(name)
        return variable is not None and variable.kind == "variable" and variable.binding is None and name not in self.ends

    def _give(self, equation: Equation) -> bool:
        sides = ((equation.left, equation.right), (equation.right, equation.left))
        for among_ends in (False, True):  # what a component calls its own is given before where it ends
            for side, other in sides:
                if isinstance(side, Ref) and not side.index and (side.name in self.ends) is among_ends:
                    variable = self.variables.get(side.name)
                    if variable is None or variable.kind != "variable" or variable.binding is not None:
                        continue
                    if among_ends and self._asks(other, {side.name}):
                        continue
                    self._bind(variable, other)
                    return True
        return False

    def _bind(self, variable: Variable, value: Flat) -> None:
        self.variables[variable.name] = replace(variable, binding=value)
        self.values[variable.name] = value

    def _asks(self, value: Flat, names: set[str]) -> bool:
        """Whether the value depends on one of the variables."""
        return any(isinstance(leaf, Ref) and leaf.name in names for leaf in leaves([value], self.values))

    def connect(self, connections: Sequence[Connection]) -> list[Equation]:
        """Gives every end of a connector its value; returns the equations between those that have one already."""
        return [equation for meeting in self._meetings(connections) for equation in self._join(meeting)]

    def _meetings(self, connections: Sequence[Connection]) -> list[list[tuple[str, Connection | None]]]:
        """The variables that are one, each with the connection that first named it, in the order of their declaration."""
        home = {name: name for name in self.variables if name in self.ends}
        by: dict[str, Connection] = {}

        def find(name: str) -> str:
            while home[name] != name:
                home[name] = name = home[home[name]]
            return name

        for connection in connections:
            by.setdefault(connection.a, connection)
            by.setdefault(connection.b, connection)
            home[find(connection.b)] = find(connection.a)
        meetings: dict[str, list[tuple[str, Connection | None]]] = {}
        for name in home:
            meetings.setdefault(find(name), []).append((name, by.get(name)))
        return list(meetings.values())

    def with_inputs(self, inputs: set[str]) -> dict[str, Variable]:
        """The variables; of those that components call inputs, what nothing gives comes from outside."""
        return {name: replace(x, kind="input") if name in inputs and not self._is_given(x) else x
                for name, x in self.variables.items()}

    def _join(self, meeting: Sequence[tuple[str, Connection | None]]) -> Iterator[Equation]:
        names = {name for name, _ in meeting}
        given = [name for name, _ in meeting if self._is_given(self.variables[name])]
        first = next((name for name in given if not self._asks_back(name, names)), None)
        if first is None:
            first = next((name for name, _ in meeting if name not in given), meeting[0][0])
            self._let_move(self.variables[first])
        for name, by in meeting:
            if name != first and name not in given:
                self._bind(self.variables[name], Ref(first, (), _where(by, self.variables[name])))
        for name, by in meeting:
            if name != first and name in given and self._end_of(name) != self._end_of(first):
                span = _where(by, self.variables[name])
                yield Equation(Ref(first, (), span), Ref(name, (), span), span, by.component if by is not None else "")

    def _end_of(self, name: str) -> str:
        """The variable that this is another name of."""
        while isinstance(value := self.values.get(name), Ref) and not value.index:
            name = value.name
        return name

    @staticmethod
    def _is_given(variable: Variable) -> bool:
        return variable.binding is not None or variable.kind != "variable"

    def _let_move(self, variable: Variable) -> None:
        """Makes a coordinate of what nothing gives; where it is no position it stays without a value, and is told."""
        if not self._is_given(variable) and variable.unit in _POSITIONS:
            self.variables[variable.name] = replace(variable, kind="coordinate")

    def _asks_back(self, name: str, meeting: set[str]) -> bool:
        value = self.values[name]
        return value is not None and self._asks(value, meeting)


def _where(connection: Connection | None, variable: Variable) -> Span:
    return connection.span if connection is not None else variable.span


def require_bindings(variables: Mapping[str, Variable], equations: Sequence[Equation], report: Report) -> None:
    """Reports L0211 for variables that nothing gives a value; `equations` have none alone on one side."""
    missing = {v.name for v in variables.values() if v.kind == "variable" and v.binding is None}
    named = {node.name: equation for equation in reversed(equations if missing else ())
             for node in nodes(equation.left, equation.right) if isinstance(node, Ref)}
    for variable in variables.values():
        if variable.name in missing:
            *component, name = variable.name.split(".")
            hint = f"write: {component[-1]}({name} = ...)" if component else f"write: {name} = ..., or an equation for it"
            if variable.name in named:
                hint = (f"the equation at {named[variable.name].span} is not solved for it: write {name} = ..., for positions "
                        "alone follow from what equations hold together")
            report.error("L0211", f"the variable '{variable.name}' has no value", variable.span, hint,
                         "what the motion decides is a coordinate: declare it with `coordinate`; a first-order state "
                         f"has an equation for its rate, der({name}) = ...; what events decide is given a value in a `when`")


def flanges_of(table: ClassTable, connector: Instance) -> dict[str, str]:
    """The variables of a connector, with the class of the library that its component is of or extends; '' for any other."""
    if connector.parent is None:
        return {}
    classes = table.lineage(connector.parent.definition)
    kind = next((c.name.rpartition(".")[2] for c in classes if c.name_span.source in table.library_sources), "")
    return {member.path: kind for member in connector.members.values() if isinstance(member, Slot)}
