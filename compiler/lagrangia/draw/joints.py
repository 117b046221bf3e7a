"""What moves what: joints by their coordinates, trees of frames, and what a quantity is made of."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lagrangia.frames.edges import Edge
from lagrangia.frames.graph import ComponentGraph
from lagrangia.frames.joints import component_of
from lagrangia.language.flat import FlatModel
from lagrangia.language.mentions import leaves
from lagrangia.language.tree import Array, Binary, Call, Flat, Ref, Unary

Vector = NDArray[np.float64]
Form = Mapping[str, Vector]  # of coordinates, their coefficients


@dataclass(frozen=True)
class Joint:
    """An edge that a coordinate moves: `way` is how its child moves with it, along the parent's axes, or how much it turns."""

    parent: str
    child: str
    kind: str  # "shift" or "turn"
    way: Vector


@dataclass
class Tree:
    """The frames of a scene as a tree; `value` gives numbers for expressions that do not move."""

    graph: ComponentGraph
    value: Callable[[Flat], Vector]

    @cached_property
    def above(self) -> dict[str, Edge]:
        """The edge that leads to each frame."""
        return {edge.child: edge for edge in self.graph.edges}

    @cached_property
    def below(self) -> dict[str, list[str]]:
        """The frames that hang on each."""
        found: dict[str, list[str]] = {}
        for edge in self.graph.edges:
            found.setdefault(edge.parent, []).append(edge.child)
        return found

    @cached_property
    def bodies(self) -> dict[str, str]:
        """Frames that keep their places to each other share the first of them."""
        found = {root.frame: root.frame for root in self.graph.roots}
        for edge in self.graph.edges:
            found[edge.child] = found[edge.parent] if edge.is_rigid else edge.child
        return found

    @cached_property
    def grounded(self) -> set[str]:
        """Frames that stand still, or are moved by nothing but the time."""
        found = {root.frame for root in self.graph.roots if root.is_ground}
        for edge in self.graph.edges:
            if edge.parent in found and not edge.coordinates:
                found.add(edge.child)
        return found

    @cached_property
    def joints(self) -> dict[str, Joint]:
        """By their coordinates."""
        found = {}
        for edge in self.graph.edges:
            for step in edge.steps:
                form = self.form(step.amount) or {}
                for name, way in form.items() if len(form) == 1 else ():
                    found[name] = Joint(edge.parent, edge.child, step.kind, -way if step.is_inverse else way)
                if step.kind == "turn":
                    break  # what comes behind moves along axes that turn
        return found

    def path(self, frame: str) -> list[Edge]:
        """The edges from the root to a frame, the last first."""
        found = []
        while frame in self.above:
            found.append(self.above[frame])
            frame = found[-1].parent
        return found

    def subtree(self, frame: str) -> list[str]:
        """A frame and all that hangs on it."""
        found, pending = [], [frame]
        while pending:
            found.append(pending.pop())
            pending += self.below.get(found[-1], [])
        return found

    def holder(self, frame: str) -> str:
        """The frame of another component that a port is bound to, or the port itself."""
        here = frame
        while here in self.above and self.above[here].is_rigid and component_of(here) == component_of(frame):
            here = self.above[here].parent
        return here

    def body_of(self, frame: str) -> list[str]:
        """The frames that are rigid with one and hang on it."""
        found, pending = [], [frame]
        while pending:
            found.append(pending.pop())
            pending += [name for name in self.below.get(found[-1], []) if self.bodies[name] == self.bodies[frame]]
        return found

    # ------------------------------------------------------------ linear forms

    @property
    def model(self) -> FlatModel:
        """What the expressions are of."""
        return self.graph.model

    @cached_property
    def _bindings(self) -> dict[str, Flat | None]:
        return {name: variable.binding for name, variable in self.model.variables.items()}

    def is_moving(self, node: Flat) -> bool:
        """Whether it depends on the motion, or on time."""
        def moves(leaf: Flat) -> bool:
            return not isinstance(leaf, Ref) or self.model.variables[leaf.name].kind in ("coordinate", "input")

        return any(map(moves, leaves([node], self._bindings)))

    def form(self, node: Flat) -> Form | None:
        """Coefficients of coordinates, or of their rates, in what is linear in them; None for the rest."""
        if not self.is_moving(node):
            return {}
        match node:
            case Ref(name, index, _):
                variable = self.model.variables[name]
                if variable.kind == "coordinate" and not index:
                    return {name: np.array(1.0)}
                return self.form(variable.binding) if variable.binding is not None and not index else None
            case Call("der", (inner,), _, _):
                return self.form(inner)
            case Unary("-", operand, _):
                return _scaled(self.form(operand), np.array(-1.0))
            case Binary("+" | "-" as sign, left, right, _):
                return _joined(self.form(left), _scaled(self.form(right), np.array(1.0 if sign == "+" else -1.0)))
            case Binary("*", left, right, _) if not self.is_moving(left):
                return _scaled(self.form(right), self.value(left))
            case Binary("*", left, right, _) if not self.is_moving(right):
                return _scaled(self.form(left), self.value(right))
            case Binary("/", left, right, _) if not self.is_moving(right):
                return _scaled(self.form(left), 1 / self.value(right))
            case Array((first, second), _):
                parts = [_scaled(self.form(item), unit) for item, unit in zip((first, second), np.eye(2), strict=True)]
                return _joined(*parts)
        return None


def _scaled(form: Form | None, by: Vector) -> Form | None:
    return None if form is None else {name: factor * by for name, factor in form.items()}


def _joined(a: Form | None, b: Form | None) -> Form | None:
    if a is None or b is None:
        return None
    return {name: a.get(name, np.array(0.0)) + b.get(name, np.array(0.0)) for name in dict.fromkeys((*a, *b))}
