"""Scenes that cannot move: what is asked of them is the forces in their joints."""

from collections.abc import Iterable, Sequence

from lagrangia.language.frame_attributes import REACTIONS, WRENCH_HEADINGS
from lagrangia.run.scene import Scene
from lagrangia.view.rows import columns


def is_static(scene: Scene) -> bool:
    """No degree of freedom is left, and no motion is prescribed."""
    return bool(scene.notes["is_static"])


def tells_reactions(scene: Scene) -> bool:
    """Whether a scene that cannot move is asked for them: where something only just holds, nothing bounds the forces."""
    return is_static(scene) and not scene.notes["touching"]["told"]


def told_shares(repeated: Iterable[str], length: float | None = None) -> list[str]:
    """What leaves reactions one way of several, or those of least squares over a length (m): loops and equations that repeat
    others, as told."""
    way = "one way of several" if length is None else f"those of least squares, torques over {length:g} m"
    return [f"the reactions are {way}: {what}" for what in repeated]


def reaction_table(scene: Scene, row: Sequence[float]) -> list[str]:
    """The reactions in one row of results, a line for each joint or tie, with their units."""
    found: dict[str, list[float]] = {}
    for column, value in zip(columns(scene), row, strict=False):
        joint, _, what = column.name.rpartition(".")
        if what.partition("[")[0] in REACTIONS:
            found.setdefault(joint, []).append(value)
    whole = {joint: values for joint, values in found.items() if len(values) in WRENCH_HEADINGS}
    width = max((len(joint) for joint in whole), default=0)
    size = max(map(len, whole.values()), default=min(WRENCH_HEADINGS))
    lines = [f"{'':{width}}" + "".join(f"{heading:>14}" for heading in WRENCH_HEADINGS[size])]
    largest = max((abs(x) for values in whole.values() for x in values), default=0.0)
    for joint, values in whole.items():
        shown = (0.0 if abs(x) < 1e-12 * largest else x for x in values)  # rounding
        lines.append(f"{joint:{width}}" + "".join(f"{x:>14.6g}" for x in shown))
    return lines if whole else []
