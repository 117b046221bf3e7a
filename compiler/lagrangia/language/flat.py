"""FlatModel: one list of variables, frames, equations and energy terms, with names like `link[2].phi`."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field
from typing import Literal, TypeVar

from lagrangia.base.diagnostics import Diagnostic, Span
from lagrangia.base.records import dataclass
from lagrangia.language.frame_attributes import Space
from lagrangia.language.function_variables import FlatFunction
from lagrangia.language.functions import FRAME_FUNCTIONS
from lagrangia.language.lookups import Lookup, ReadPlane, ReadTable
from lagrangia.language.spaces import Found
from lagrangia.language.tree import Array, Call, EnergyKind, Flat, FrameRef, Number, Ref

T = TypeVar("T")
Kind = Literal["parameter", "input", "coordinate", "variable", "held", "delayed"]


@dataclass(frozen=True)
class Variable:
    """A quantity of the flat model; `shape` is () for a scalar. Values are in SI units."""

    name: str
    kind: Kind
    shape: tuple[int, ...]
    unit: str  # as declared; "" when no unit is known
    display_unit: str
    binding: Flat | None
    start: Flat | None
    is_fixed: bool
    minimum: float | None
    maximum: float | None
    is_output: bool
    description: str
    span: Span
    is_evaluated: bool = False  # annotation(Evaluate = true)
    may_vary: bool = False  # annotation(Varying = true): a parameter, unless what it is bound to changes during the run
    locked: str = ""  # "final" or "protected" where it cannot be set from outside
    is_attitude: bool = False  # a coordinate of the type Rotation
    is_inertia: bool = False  # of three axes, in space
    type_name: str = "Real"  # or "Integer", "Boolean": of discrete variables

    def elements(self) -> list[tuple[str, tuple[int, ...]]]:
        """Names and indices of the scalars it is made of."""
        if not self.shape:
            return [(self.name, ())]
        indices: list[tuple[int, ...]] = [()]
        for size in self.shape:
            indices = [(*index, i) for index in indices for i in range(1, size + 1)]
        core = self.name.rstrip(")")  # der(y[1]) of the input der(y)
        return [(core + (f"[{','.join(map(str, i))}]" if i else "") + self.name[len(core) :], i) for i in indices]


@dataclass(frozen=True)
class Frame:
    """A frame with what its declaration says about its start."""

    name: str
    is_ground: bool
    starts: Mapping[str, Flat]  # of its attributes
    fixed: frozenset[str]
    owner: str  # class of the component whose port it is
    span: Span


@dataclass(frozen=True)
class FrameEquation:
    """left = right, both frame expressions: a frame, or shift(...) and turn(...) of one."""

    left: Flat
    right: Flat
    span: Span


@dataclass(frozen=True)
class Equation:
    """left = right, with its line and the component that states it."""

    left: Flat
    right: Flat
    span: Span
    component: str = ""


@dataclass(frozen=True)
class Energy:
    """A term of T, V or D."""

    kind: EnergyKind
    value: Flat
    component: str
    span: Span
    is_of_library: bool = False
    is_signal: bool = False  # of a first-order state: no energy of the mechanism


@dataclass(frozen=True)
class Work:
    """A term of the virtual work: force . delta(position)."""

    force: Flat
    position: Flat
    component: str
    span: Span
    is_signal: bool = False  # the rate of a first-order state: no work on the mechanism


@dataclass(frozen=True)
class State:
    """A first-order state, der(name) = rate: the rate of a coordinate of its own (states.py)."""

    name: str
    coordinate: str
    rate: Flat
    component: str
    span: Span
    equation: Equation  # as written

    @property
    def is_kept(self) -> bool:
        """Whether it changes at events alone, as discrete variables do."""
        return isinstance(self.rate, Number) and self.rate.value == 0


@dataclass(frozen=True)
class Reset:
    """`reinit(rate, value)`: the rate is to have this value after the event; or n = value, of a discrete variable (`is_kept`)."""

    rate: Flat
    value: Flat
    span: Span
    is_kept: bool = False


@dataclass(frozen=True)
class Guard:
    """What has to hold in a run, which warns (`kind` "warning") or fails ("error") where it breaks; or ("end") what ends it
    well where it comes true."""

    condition: Flat
    text: str
    kind: Literal["error", "warning", "end"]
    component: str
    span: Span

    def expressions(self) -> tuple[Flat, ...]:
        """All that it reads."""
        return (self.condition,)


@dataclass(frozen=True)
class When:
    """`when condition then ... end when`: what happens at the moment at which the condition comes true."""

    condition: Flat
    resets: tuple[Reset, ...]
    component: str
    span: Span
    order: tuple[int, int, int] = (0, 0, 0)  # its rank at an instant, its `when`, and its branch there: at_one_instant.py
    endings: tuple[Guard, ...] = ()  # of the run, that come with it, not by themselves
    comes_at_start: bool = False  # where its condition is true there

    def expressions(self) -> tuple[Flat, ...]:
        """All that it reads."""
        return (self.condition, *(x for reset in self.resets for x in (reset.rate, reset.value)))


@dataclass(frozen=True)
class Held:
    """The value that a variable has from an instant on."""

    name: str
    value: Flat
    span: Span
    rank: int = 0  # at an instant: at_one_instant.py


@dataclass(frozen=True)
class Sampler:
    """`when sample(start, interval) then ... end when`: what is held from each of these instants to the next, times in s."""

    start: Flat
    interval: Flat
    held: tuple[Held, ...]
    component: str
    span: Span

    def expressions(self) -> tuple[Flat, ...]:
        """All that it reads."""
        return (self.start, self.interval, *(held.value for held in self.held))


@dataclass(frozen=True)
class Delay:
    """The variable `name` is `value` as it was `lag` seconds earlier; before the start, `before`, or as it is there."""

    name: str
    value: Flat
    lag: Flat
    before: Flat | None
    span: Span

    def expressions(self) -> tuple[Flat, ...]:
        """All that it reads."""
        return (self.value, self.lag, *(() if self.before is None else (self.before,)))


@dataclass(frozen=True)
class Figure:
    """A statement of a drawing section: a word of figures.py with its arguments and options."""

    word: str
    arguments: tuple[Flat, ...]
    options: Mapping[str, Flat]
    component: str
    span: Span

    def expressions(self) -> tuple[Flat, ...]:
        """All that it reads."""
        return (*self.arguments, *self.options.values())


@dataclass(frozen=True)
class Experiment:
    """Times in s and the tolerance that a model declares."""

    start: float = 0.0
    stop: float = 1.0
    tolerance: float = 1e-8
    interval: float | None = None
    ends: bool = False  # its StopTime is stated


@dataclass(frozen=True)
class FlatModel:
    """A model without classes: variables, frames, edges, equations and energies by their full names."""

    name: str
    description: str
    variables: Mapping[str, Variable]
    frames: Mapping[str, Frame]
    frame_equations: tuple[FrameEquation, ...]
    constraints: tuple[Equation, ...]
    energies: tuple[Energy, ...]
    works: tuple[Work, ...]
    initial_equations: tuple[Equation, ...]
    whens: tuple[When, ...]
    functions: Mapping[str, FlatFunction]
    structural: Mapping[str, float | bool | str]
    experiment: Experiment
    span: Span
    warnings: tuple[Diagnostic, ...] = ()
    figures: tuple[Figure, ...] = ()  # of people's classes; of the library's as well, where a picture is asked for
    states: Mapping[str, State] = field(default_factory=dict)  # by their names
    lookups: Mapping[Lookup, Span] = field(default_factory=dict)  # tables of files that are asked for
    tables: Mapping[Lookup, ReadTable] = field(default_factory=dict)  # as they were read
    planes: Mapping[Lookup, ReadPlane] = field(default_factory=dict)  # those in two variables
    samplers: tuple[Sampler, ...] = ()
    delays: tuple[Delay, ...] = ()
    guards: tuple[Guard, ...] = ()
    at_rest: Span | None = None  # where it says that it starts in equilibrium
    moving_inputs: Mapping[str, bool] = field(default_factory=dict)  # in places or energies; whether their rates matter
    allowed: tuple[str, ...] = ()  # codes of warnings that the model says are meant: annotation(allow = "L0224")
    components: Mapping[str, str] = field(default_factory=dict)  # descriptions of those that have one, by their names
    flanges: Mapping[str, str] = field(default_factory=dict)  # of connectors: the class of the library they are on, or ''
    connections: tuple[tuple[str, str], ...] = ()  # of such variables
    read: tuple[str, ...] = ()  # the other files that were read for it
    found: Found = Found()  # whether it lies in a plane
    # And structural parameters, and limits, as they are written, but for bare literals and what is stamped out: for checks alone.
    constants: tuple[Variable, ...] = field(default=(), repr=False, compare=False)
    # Parts of the model, by their ids, that differ from others in nothing but the index of an element (stamps.py): what holds of
    # the others' dimensions holds of them.
    repeats: Mapping[int, object] = field(default_factory=dict, repr=False, compare=False)

    def news(self, items: Iterable[T]) -> Iterator[T]:
        """Of parts of the model, those that are no repeats of others."""
        return (x for x in items if id(x) not in self.repeats)

    @property
    def set_at_events(self) -> str:
        """What events set, in words: discrete variables alone, or rates, too."""
        resets = [reset for when in self.whens for reset in when.resets]
        return "discrete variables change" if resets and all(reset.is_kept for reset in resets) else "rates are reset"

    def looks(self) -> tuple[Flat, ...]:
        """All that events, samplers, delays and guards read."""
        return tuple(x for look in (*self.whens, *self.samplers, *self.delays, *self.guards) for x in look.expressions())

    def given_at_events(self) -> Mapping[str, list[Flat]]:
        """Values that variables have after events, by the names of the variables."""
        found: dict[str, list[Flat]] = {}
        for reset in (reset for when in self.whens for reset in when.resets):
            if isinstance(reset.rate, Ref):
                found.setdefault(reset.rate.name, []).append(reset.value)
        for held in (held for sampler in self.samplers for held in sampler.held):
            found.setdefault(held.name, []).append(held.value)
        return found

    def stated(self) -> Iterator[Flat]:
        """All that is stated, but the bindings and starts of variables, and the rates of states."""
        for equation in (*self.constraints, *self.initial_equations):
            yield from (equation.left, equation.right)
        for joint in self.frame_equations:
            yield from (joint.left, joint.right)
        yield from (energy.value for energy in self.energies)
        for work in self.works:
            yield from (work.force, work.position)
        yield from self.looks()
        for figure in self.figures:
            yield from figure.expressions()
        for frame in self.frames.values():
            yield from frame.starts.values()

    @property
    def space(self) -> Space:
        """What frames are made of."""
        return self.found.space


def places_of(node: Flat) -> tuple[Flat, ...]:
    """The places that a word which takes many is given as one: those of an array of frames or of positions."""
    def is_place(item: Flat) -> bool:
        return is_frame(item) or isinstance(item, Array) or (isinstance(item, FrameRef) and item.attribute == "r")

    return node.items if isinstance(node, Array) and any(map(is_place, node.items)) else (node,)


def is_frame(node: Flat) -> bool:
    """Whether an expression stands for a frame."""
    return (isinstance(node, FrameRef) and node.attribute == "") or (isinstance(node, Call) and node.function in FRAME_FUNCTIONS)


def rate_of(variable: Variable) -> str | None:
    """The name of x when the variable is bound to der(x), else None."""
    binding = variable.binding
    if isinstance(binding, Call) and binding.function == "der" and isinstance(binding.arguments[0], Ref):
        return binding.arguments[0].name
    return None
