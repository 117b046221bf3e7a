"""Vectors that a scene in space has and that were given two components: forces, gravity, directions. Their z is 0, which is told.

Not told: what is 0 in any case; defaults of declarations, which are written for plane and space alike; shift(a, {x, y}) and other
places, as Weld(offset = {x, y}), which mean z = 0; and components of classes, as one that is written for the plane stands in
space as it is.
"""

from lagrangia.base.diagnostics import Report, Span
from lagrangia.language.classes import ClassTable
from lagrangia.language.flat import FlatModel
from lagrangia.language.folding import fold
from lagrangia.language.instances import Instance, Slot
from lagrangia.language.space_values import is_fitted
from lagrangia.language.tree import Array, Flat, Number
from lagrangia.language.unread import inside

_PLACE = "m"  # the unit of shifts


def find_short_vectors(model: FlatModel, root: Instance, table: ClassTable) -> Report:
    """A warning, L0306, for each that the scene's own class states."""
    report, told = Report(), set[Span]()
    if not model.found.space.is_spatial:
        return report
    texts = [c.span for c in table.lineage(root.definition) if c.name_span.source not in table.library_sources]
    for instance in (root, *inside(root)):
        for slot in instance.members.values():
            if not isinstance(slot, Slot) or slot.binding is None or not is_fitted(slot.declaration):
                continue
            variable, place = model.variables.get(slot.path), slot.binding.expression.span
            if variable is None or variable.unit == _PLACE or not _is_padded(variable.binding) or place in told:
                continue
            if _is_default(slot) or not any(
                    text.source is place.source and text.start <= place.start < text.end for text in texts):
                continue
            told.add(place)
            why = f": the scene is in space, as {model.found.why}" if model.found.why else ""
            report.warning("L0306", f"'{slot.path}' is given two components{why}; its z is taken as 0", place, _advice(place))
    return report


def _is_padded(value: Flat | None) -> bool:
    """Whether it was two components, not both 0 (frame_words.in_space)."""
    if not isinstance(value, Array) or len(value.items) != 3:
        return False
    x, y, z = value.items
    return isinstance(z, Number) and z.value == 0 and z.span == value.span and any(fold(part) != 0 for part in (x, y))


def _is_default(slot: Slot) -> bool:
    """Whether it stands in the declaration itself, and not where the component is."""
    default = slot.declaration.binding
    return default is not None and slot.binding is not None and slot.binding.expression.span == default.span


def _advice(place: Span) -> str:
    text = place.text
    inner = text[1:-1] if text.startswith("{") and text.endswith("}") else ""
    return f"write {{{inner}, 0}}, or the z that is meant" if inner else "give it three components"
