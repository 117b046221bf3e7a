"""Scenes in which one component stands alone, so that it can be drawn: what it lacks is given, its ports are put somewhere."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path

from lagrangia.language.tree import ClassDefinition, Declaration

# What holds or moves the ports, and is not drawn: an empty drawing section draws nothing.
_UNSEEN = """\
model UnseenBody
  extends Body(m = 1, I = 1);
drawing
end UnseenBody;
model UnseenHinge
  extends Revolute(a = world);
  UnseenBody load(center = b);
drawing
end UnseenHinge;
"""
FLANGES = {"Rotational.Flange": ("Angle", "kg.m2", ".phi"), "Translational.Flange": ("Length", "kg", ".s")}
_MOVING = "  coordinate Length unseen;\n"  # so that something can move, where the component does not
_ENERGY = "energy\n  kinetic 0.5[kg]*der(unseen)^2;\n"


def scenes_of(definition: ClassDefinition, members: Mapping[str, Declaration], quantities: Collection[str],
              flanges: Mapping[str, str], imported: Path | None) -> Iterator[str]:
    """Texts to be tried, the likeliest first: parts of drive trains between their flanges, a body floats, a spring reaches from
    the ground, a joint moves a body, gears stand between hinges, a stop before a body that floats. `quantities` are the names of
    types of numbers; `flanges` those of ports that turn or slide, with their classes."""
    ports = [name for name, d in members.items() if d.type_name == "Frame" and d.binding is None and not d.dimensions]
    given = [f"{name} = {value}" for name, d in members.items() if d.type_name in quantities and (value := _value(d))]
    head = _UNSEEN if imported is None else f'import "{imported}";\n{_UNSEEN}'
    name = definition.name.rpartition(".")[2]  # which the picture of a drive train tells
    if flanges and not ports:
        yield f"{head}model Shown\n  {definition.name} {name}({', '.join(given)});\n{_turning(flanges, name)}end Shown;\n"
    for bound, beside in _surroundings(ports):
        arguments = ", ".join([*given, *bound])
        shown = f"  {definition.name} shown{f'({arguments})' if arguments else ''};\n"
        yield f"{head}model Shown\n{shown}{beside}end Shown;\n"


def _surroundings(ports: Sequence[str]) -> Iterator[tuple[list[str], str]]:
    """How the ports are bound, and what stands beside the component."""
    moving = f"{_MOVING}{_ENERGY}"
    yield [], ""
    yield [], moving
    if not ports:
        return
    first, rest = f"{ports[0]} = world", ports[1:]
    yield [first], ""
    yield [first], moving
    yield [first, *(f"{port} = shift(world, {{{k}, 0}})" for k, port in enumerate(rest, 1))], moving
    yield [first], f"  UnseenBody load(center = shown.{ports[-1]});\n"
    if {"a", "b", "carrier"} == {*ports}:
        hinges = "  UnseenHinge left;\n  UnseenHinge right(a = shift(world, {2, 0}));\n"
        yield ["a = left.b", "b = right.b", "carrier = world"], hinges
    bodies = "".join(f"  UnseenBody load{k}(center(x(start = {k}), y(start = 0.5)));\n" for k in range(1, len(rest) + 1))
    yield [first, *(f"{port} = load{k}.center" for k, port in enumerate(rest, 1))], bodies


def _turning(flanges: Mapping[str, str], name: str) -> str:
    """Flanges of the scene by the same names, each with an inertia or a mass of its own, which is not drawn."""
    lines, energies, equations = [], [], []
    for k, (port, kind) in enumerate(flanges.items(), 1):
        quantity, unit, position = FLANGES[kind]
        lines.append(f"  {kind} {port};\n  coordinate {quantity} unseen{k};\n")
        energies.append(f"  kinetic 0.5[{unit}]*der(unseen{k})^2;\n")
        equations.append(f"  {port}{position} = unseen{k};\n  connect({port}, {name}.{port});\n")
    return f"{''.join(lines)}energy\n{''.join(energies)}equation\n{''.join(equations)}"


def _value(declaration: Declaration) -> str:
    """For what has none: 1, or a vector along x."""
    is_open = declaration.binding is None and not {"coordinate", "output", "protected"} & declaration.prefixes
    has_start = any(argument.name == "start" for argument in declaration.arguments)
    if not is_open or has_start or declaration.condition is not None:
        return ""
    return "{1, 0}" if declaration.dimensions else "1"
