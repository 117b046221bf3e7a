"""`lag lint`: what `lag check` warns of, and what could be written better."""

import sys
from argparse import Namespace
from contextlib import suppress
from pathlib import Path

from lagrangia.base.diagnostics import Diagnostic, LagError, render_all
from lagrangia.command.arguments import allowed_codes
from lagrangia.compile.elsewhere import models_beside
from lagrangia.compile.sources import read_source
from lagrangia.editor.reading import Reading, read_text
from lagrangia.editor.style import look_at_style
from lagrangia.model import Model

_LACKS_A_VALUE = "L0211"  # which only who uses a component can give


def lint_command(options: Namespace) -> int:
    """The exit code is 1 where something is found, 2 where a file is wrong, or with --strict. Raises LagError L0706."""
    allowed = allowed_codes(options)
    found, wrong = 0, False
    for file in options.files:
        reading = read_text(file, read_source)
        errors = [one for one in reading.diagnostics if one.severity == "error" and one.code != _LACKS_A_VALUE]
        wrong |= bool(errors)
        texts = [_shown(one) for one in errors] or _warnings(file, reading)
        if reading.index is not None and not errors:
            texts += [_shown(one) for one in look_at_style(reading.index)]
        told = [text for text in texts if text.removeprefix("warning[")[:5] not in allowed]
        found += len(told)
        if told:
            print("\n\n".join(told), file=sys.stderr)
    return 2 if wrong or (found and options.strict) else 1 if found else 0


def _warnings(file: Path, reading: Reading) -> list[str]:
    """Of all phases, of each scene of a file, also of those in packages; of a file of components, which do not run by themselves,
    what its text says."""
    found, runs = list[str](), False
    names: list[str | None] = [None]
    with suppress(LagError):
        names += [other.name for other in models_beside(file) if other.is_whole and other.is_scene]
    for name in names:
        with suppress(LagError):
            found += Model(file, name).warnings
            runs = True
    if runs:
        return [*dict.fromkeys(found)]
    return [_shown(one) for one in reading.diagnostics if one.severity != "error"]


def _shown(diagnostic: Diagnostic) -> str:
    return render_all([diagnostic], sys.stderr.isatty())
