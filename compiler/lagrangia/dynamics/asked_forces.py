"""Conditions of events that ask for forces: reactions of joints, forces of equations, and what holds at contacts.

They are levels as other conditions are, of symbols of the forces, too, for which the functions of the run time have what follows
from the state (compile/functions.py).
"""

from collections.abc import Mapping

import casadi as ca

from lagrangia.algebra.scalars import symbol
from lagrangia.frames.evaluation import scalars_of
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.consequences import asks_for_forces
from lagrangia.language.events import level_of, name_of_contact
from lagrangia.language.tree import Flat


class Asking:
    """`kinematics` of a scene with its contact forces as symbols, while nobody knows yet which contacts there are."""

    def __init__(self, kinematics: Kinematics) -> None:
        model = kinematics.graph.model
        self.bindings, self.kinematics = {name: v.binding for name, v in model.variables.items()}, kinematics
        self.contacts = dict[int, ca.SX]()
        if any(self.asks(when.condition) for when in model.whens):
            self.contacts = {k: symbol(name_of_contact(k)) for k in range(len(model.whens))}
            self.kinematics = kinematics.knowing({name_of_contact(k): x for k, x in self.contacts.items()})

    def asks(self, condition: Flat) -> bool:
        """Whether a condition, or a part of one, does."""
        return asks_for_forces(condition, self.bindings)

    def forces_in(self, condition: Flat) -> ca.SX:
        """The symbols of all forces that have been asked for, as a column; nothing of a condition that asks for none."""
        if not self.asks(condition):
            return ca.SX(0, 1)
        scalars_of(self.kinematics.evaluator.value(level_of(condition)))
        wrenches = (x for wrench in self.kinematics.reactions.values() for x in wrench)
        return ca.vertcat(ca.SX(0, 1), *self.contacts.values(), *wrenches, *self.kinematics.forces.values())

    def told(self, levels: Mapping[int, ca.SX], pressing: Mapping[int, tuple[ca.SX, ca.SX]]) -> dict[int, ca.SX]:
        """Levels of events with the forces and impulses of contacts in the places of their symbols; of what holds nothing, 0."""
        values = [sum(pressing[k], ca.SX(0)) if k in pressing else ca.SX(0) for k in self.contacts]
        symbols = ca.vertcat(ca.SX(0, 1), *self.contacts.values())
        return {k: ca.substitute(g, symbols, ca.vertcat(ca.SX(0, 1), *values)) for k, g in levels.items()}
