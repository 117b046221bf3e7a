"""Equilibria and modes as tables with their units, for notebooks."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from lagrangia.base.html_table import headed, html_notes, html_table
from lagrangia.language.frame_attributes import WRENCH_HEADINGS
from lagrangia.study.text import reactions_of, unrounded, way_of

if TYPE_CHECKING:
    from lagrangia.study.equilibria import Equilibria
    from lagrangia.study.modes import Modes

_MOST_COLUMNS = 20
_MOST_ROWS = 60


def equilibria_html(found: "Equilibria") -> str:
    """A row for each position of rest, and the reactions of each."""
    if not found.found:
        return html_notes([f"{found.name}: no equilibrium was found", *found.notes])
    names = [*found.found[0].position]
    shown = names[:_MOST_COLUMNS]
    heads = ["", "stability", *(headed(name, found.units.get(name, "")) for name in shown), "V [J]"]
    rows = [(k, item.stability, *(unrounded(item.position[name]) for name in shown), unrounded(item.potential))
            for k, item in enumerate(found.found, 1)]
    parts = [html_table(heads, rows, f"{found.name}: {len(rows)} at rest, t = {found.time:g} s")]
    for k, item in enumerate(found.found, 1):
        if item.reactions:
            held = reactions_of(item.reactions, found.ports, item.residual)
            parts.append(html_table(["", *WRENCH_HEADINGS], [(joint, *values) for joint, values in held], f"reactions of {k} on"))
    return "".join([*parts, html_notes([*_missing(names, "coordinates"), *found.notes])])


def modes_html(modes: "Modes") -> str:
    """Frequencies, damping and shapes."""
    if not len(modes):
        return html_notes([f"{modes.name}: no modes, nothing can move", *modes.notes])
    way = ["way of moving"] * (len(modes.ways) > 1)
    rows: list[tuple[Any, ...]] = []
    for k, mode in enumerate(modes.modes[:_MOST_ROWS]):
        period = 1 / mode.frequency if mode.kind == "oscillation" else None
        growth = mode.growth if mode.kind == "divergence" else None
        rows.append((k + 1, *([mode.way] if way else []), mode.kind, mode.frequency, mode.omega, period, growth))
    heads = ["mode", *way, "kind", "f [Hz]", "omega [rad/s]", "period [s]", "growth [1/s]"]
    parts = [html_table(heads, rows, f"{modes.name}: modes")]
    if modes.has_damping or modes.is_gyroscopic:
        parts.append(html_table([*way, "motion", "f [Hz]", "omega [rad/s]", "|s| [rad/s]", "zeta", "rate [1/s]"], _damped(modes),
                                "with damping" if modes.has_damping else "gyroscopic"))
    scaled = "mass-normalised" if modes.scaling == "mass" else "the largest entry of each is 1"
    shown = range(min(len(modes), _MOST_COLUMNS))
    coordinates = modes.coordinates[:_MOST_ROWS]
    shapes = [(name, *(modes[k].shape[name] for k in shown)) for name in coordinates]
    parts.append(html_table(["", *(f"mode {k + 1}" for k in shown)], shapes, f"shapes ({scaled})"))
    return "".join([*parts, html_notes([*_missing(modes.modes, "modes"), *modes.notes])])


def _damped(modes: "Modes") -> Iterator[tuple[Any, ...]]:
    has_ways = len(modes.ways) > 1
    for item in modes.damped[:_MOST_ROWS]:
        s = item.eigenvalue
        told = (item.frequency, item.damped_omega, item.omega, item.damping_ratio) if s.imag > 0 else (None, None, abs(s), None)
        yield (*([item.way] if has_ways else []), way_of(item), *told, s.real)


def _missing(all_of: Sequence[object], what: str) -> list[str]:
    """In tables of so many columns."""
    return [f"{_MOST_COLUMNS} of {len(all_of)} {what} are shown"] if len(all_of) > _MOST_COLUMNS else []
