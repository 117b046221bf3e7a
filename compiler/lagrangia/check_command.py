"""`lag check`: whether files compile, and what freedom their scenes have."""

import sys
from argparse import Namespace
from collections.abc import Mapping
from typing import Any

from lagrangia.arguments import tell_warnings
from lagrangia.diagnostics import LagError, render_all
from lagrangia.model import Model


def check_command(options: Namespace) -> int:
    """Compiles every file; the exit code is 2 when one is wrong."""
    wrong = 0
    for file in options.files:
        try:
            model = Model(file)
            freedom = model.freedom
        except LagError as error:
            wrong += 1
            print(render_all(error.diagnostics, sys.stderr.isatty()), file=sys.stderr)
            continue
        if freedom["problem"]:
            wrong += 1
            print(freedom["problem"], file=sys.stderr)
            continue
        print(f"{file}: {_describe(model.scene, freedom)}")
        tell_warnings(model)
    return 2 if wrong else 0


def _describe(scene: Any, freedom: Mapping[str, Any]) -> str:
    """Degrees of freedom, coordinates, loops and redundant constraints."""
    notes = scene.notes
    names = [c.name for c in scene.coordinates]
    shown = ", ".join(names[:6]) + (f", ... ({len(names)})" if len(names) > 6 else "")
    degrees = freedom["degrees_of_freedom"]
    still = "" if degrees else ": its motion is prescribed" if notes["is_driven"] else ", so it stands still: statics"
    lines = [f"{scene.name}: {degrees} degree{'s' if degrees != 1 else ''} of freedom{still}"]
    held = scene.sizes["n_multipliers"]
    closed = f", {notes['loops']} closed loop{'s' if notes['loops'] != 1 else ''}" if notes["loops"] else ""
    if names:
        lines.append(f"  coordinates {shown}" + (f"; {held} constraint{'s' if held != 1 else ''}{closed}" if held else ""))
    if notes["dependent"]:
        lines.append(f"  given by others: {', '.join(notes['dependent'][:8])}")
    if freedom["is_rigid_at_start"]:
        lines.append("  the start is a singular position: nothing moves there, and parts a little longer let it go")
    elif freedom["ways_at_start"]:
        ways = freedom["ways_at_start"]
        lines.append(f"  the start is a singular position, where {len(ways)} ways of moving meet: {'; or '.join(ways)}")
    elif freedom["degrees_at_start"] > degrees:
        lines.append(f"  the start is a singular position: {freedom['degrees_at_start']} degrees of freedom there")
    lines += [f"  {text}" for text in (*freedom["repeated"], *freedom["assemblies"])]
    return "\n".join(lines)
