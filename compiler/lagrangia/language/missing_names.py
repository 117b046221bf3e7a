"""Names that mean nothing where they stand: what they are likely to be."""

from typing import NoReturn

from lagrangia.base.diagnostics import Span, fail, suggest
from lagrangia.language.classes import ClassTable
from lagrangia.language.foreign_words import name_meant
from lagrangia.language.frame_attributes import REACTIONS
from lagrangia.language.instances import FrameSlot, Instance, Scope, Slot
from lagrangia.language.suggestions import explain
from lagrangia.language.tree import Declaration, Reference


def refuse_name(node: Reference, scope: Scope) -> NoReturn:
    """Raises LagError L0204."""
    first = node.parts[0]
    if first.name == "break":
        fail("L0901", "not of this language: a value that is taken away by `break`", first.span,
             "give another value; what is inherited as a whole is left out in extends: extends A(break part)")
    known = {*scope.instance.members, *scope.iterators, "time", "world"}
    hints = [name_meant(first.name, known) or suggest(first.name, known)]
    if first.name in scope.instance.absent:
        hints = ["its condition is false, or `break` left it out, so it is not there"]
    elif any(isinstance(e, Declaration) and e.name == first.name for e in scope.instance.definition.elements):
        hints = [f"'{first.name}' is a component, made when sizes and Integer parameters are known, in the order of "
                 "declaration: let a parameter say how many there are, parameter Integer n = 3"]
    elif scope.instance.parent is not None and first.name in scope.instance.parent.members:
        hints.append(f"'{first.name}' belongs to {scope.instance.parent.definition.name}: pass it in a modification")
    elif first.name.startswith("'"):
        hints = [f'a text stands in double quotes: "{first.name[1:-1]}"']
    elif first.name == "Modelica":
        hints = ["of the Modelica Standard Library Constants, Units.SI, functions of Math, Mechanics and Blocks are here, and "
                 "lag import FILE.mo makes a .lag file of a Modelica one"]
    where = scope.instance.definition.name
    fail("L0204", f"'{first.name}' is not known in {where}", first.span, *filter(None, hints))


def refuse_member(table: ClassTable, instance: Instance, name: str, span: Span) -> NoReturn:
    """Raises LagError L0204, L0216."""
    if name in instance.absent:
        fail("L0204", f"'{name}' is not there: its condition is false", span)
    what = f"{instance.definition.name} '{instance.path}'"
    if name in REACTIONS:
        joints = [str(slot.binding.expression).rpartition(".")[0] for slot in instance.members.values()
                  if isinstance(slot, Slot) and slot.binding is not None and isinstance(slot.binding.expression, Reference)]
        driven = next((f": {joint}.reaction, {joint}.reaction_torque" for joint in joints if joint), "")
        own = [f"what it takes is {instance.path}.reaction, a force along what it moves, or a torque"]
        fail("L0216", f"{what} has no {name}", span, "components with two ports have one; what acts on the coordinate of a "
             f"joint is in the reaction of the joint{driven}",
             *(own if "reaction" in instance.members else ()))
    fail("L0216", f"{what} has no member '{name}'", span, *explain(table, instance.definition, name))


def ports_of(instance: Instance) -> str:
    """What of a component can be named in its place."""
    frames = [name for name, member in instance.members.items() if isinstance(member, FrameSlot)]
    return f"its ports are {', '.join(frames)}" if frames else "name one of its variables"
