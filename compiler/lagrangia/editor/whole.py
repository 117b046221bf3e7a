"""`python -m lagrangia.editor.whole FILE`: what all phases of the compiler say of a file, as JSON; a process of its own, so that
no editor waits for it."""

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lagrangia.base.diagnostics import Diagnostic, LagError, Source, Span
from lagrangia.compile.elsewhere import faults_of_motion


def main(arguments: list[str]) -> int:
    """Prints the diagnostics of the models of a file, first of the last one."""
    try:
        found: Sequence[Diagnostic] = faults_of_motion(Path(arguments[0]))
    except LagError as error:
        found = error.diagnostics
    print(json.dumps([_plain(diagnostic) for diagnostic in found]))
    return 0


def _plain(found: Diagnostic) -> dict[str, Any]:
    place = None if found.span is None else (found.span.source.name, found.span.start, found.span.end)
    return {"severity": found.severity, "code": found.code, "message": found.message, "label": found.label,
            "hints": list(found.hints), "place": place}


def read_back(text: str, source: Source) -> list[Diagnostic]:
    """What `main` printed of this file; what is told of other files has no place."""
    found = []
    for one in json.loads(text):
        place = one.pop("place")
        is_here = place is not None and place[0] == source.name
        span = Span(source, place[1], place[2]) if is_here else None
        found.append(Diagnostic(one["severity"], one["code"], one["message"], span, one["label"], tuple(one["hints"])))
    return found


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
