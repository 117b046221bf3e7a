"""What pieces of syntax are made of."""

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any

from lagrangia.base.diagnostics import Source, Span


def parts_of(part: Any) -> Iterator[Any]:
    """The parts of a piece of syntax; none of anything else."""
    return iter(part) if isinstance(part, tuple) else (getattr(part, name) for name in fields_of(part.__class__))


@cache
def fields_of(kind: type) -> tuple[str, ...]:
    """Their names."""
    return tuple(field.name for field in fields(kind)) if is_dataclass(kind) and kind not in (Span, Source) else ()
