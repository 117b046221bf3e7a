"""Modes -> the lists of LagModel that say which of them belong to samplers, inputs and tables."""

from lagrangia.algebra.with_casadi import Mode


def find_samplers(modes: list[Mode]) -> dict[str, tuple[int, ...]]:
    """LagModel.samplers: of each the event of its instants; LagModel.held: the modes that they change. Nothing where there are
    none."""
    places: dict[int, int] = {}
    event = 0
    for mode in {id(mode.arguments): mode for mode in modes}.values():
        if mode.of_sampler is not None:
            places[mode.of_sampler] = event
        event += len(mode.arguments)
    held = tuple(k for k, mode in enumerate(modes) if mode.of_sampler is not None)
    return {"samplers": tuple(places[k] for k in sorted(places)), "held": held} if held else {}


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
