"""Where modes lie that the run time fills in or keeps: of tables, moving inputs, held values, attitudes; and their functions."""

import casadi as ca

from lagrangia.algebra.modes import Mode
from lagrangia.dynamics.motion import Motion
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.attitudes import parts_of


def find_samplers(modes: list[Mode]) -> dict[str, tuple[int, ...]]:
    """LagModel.samplers: of each the event of its instants; LagModel.held: the modes that they change, each with its sampler and
    its rank. Nothing where there are none."""
    places: dict[int, int] = {}
    event = 0
    for mode in {id(mode.arguments): mode for mode in modes}.values():
        if mode.of_sampler is not None:
            places[mode.of_sampler[0]] = event
        event += len(mode.arguments)
    held = tuple(x for k, mode in enumerate(modes) if mode.of_sampler is not None for x in (k, *mode.of_sampler))
    return {"samplers": tuple(places[k] for k in sorted(places)), "held": held} if held else {}


def find_attitudes(kinematics: Kinematics, modes: list[Mode]) -> dict[str, tuple[int, ...]]:
    """LagModel.attitudes: of each its first coordinate and the first mode of its reference. Nothing where there are none."""
    places = {name: k for k, name in enumerate(kinematics.symbols.positions)}
    firsts = {mode.of_attitude: k for k, mode in reversed([*enumerate(modes)]) if mode.of_attitude}
    found = tuple(x for name in kinematics.symbols.attitudes for x in (places[parts_of(name)[0]], firsts[name]))
    return {"attitudes": found} if found else {}


def find_pieces(modes: list[Mode]) -> tuple[int, ...]:
    """LagModel.pieces: of each input that is a polynomial of time its place among them, those of its rates, its first mode."""
    firsts = [(mode, k) for k, mode in enumerate(modes) if mode.of_input is not None and mode.column == 0]
    return tuple(x for mode, k in firsts for x in (*(mode.of_input or ()), k))


def find_lookups(modes: list[Mode]) -> tuple[int, ...]:
    """LagModel.lookups: of each table in time its event and its first mode."""
    shared = {id(mode.arguments): mode for mode in modes}
    starts, event = {}, 0
    for key, mode in shared.items():
        starts[key] = event
        event += len(mode.arguments)
    firsts = {id(mode.arguments): k for k, mode in reversed([*enumerate(modes)]) if mode.use}
    return tuple(x for key in shared if key in firsts for x in (starts[key], firsts[key]))


def events_of(modes: list[Mode]) -> list[tuple[ca.SX, int]]:
    """The arguments of the modes with their kinds; what modes of one table share stands there once."""
    shared = {id(mode.arguments): mode for mode in modes}
    return [event for mode in shared.values() for event in mode.events]


def mode_functions(motion: Motion, modes: list[Mode]) -> dict[str, ca.Function]:
    """Modes at a time, and the arguments a + b t whose crossings are events; `d`: pieces of inputs, which both may follow."""
    if not modes:
        return {}
    t, p, d = motion.t, motion.p, ca.vertcat(*[mode.symbol for mode in modes])
    arguments = ca.vertcat(ca.SX(0, 1), *[argument for argument, _ in events_of(modes)])
    slopes, offsets = ca.densify(ca.jtimes(arguments, t, ca.SX(1))), ca.substitute(arguments, t, ca.SX(0))
    values = ca.vertcat(*[ca.SX(0) if mode.is_filled_in else mode.in_time for mode in modes])
    return {
        "events": ca.Function("events", [p, d], [offsets, slopes], ["p", "d"], ["a", "b"]),
        "modes": ca.Function("modes", [t, p, d], [values], ["t", "p", "pieces"], ["d"])
    }
