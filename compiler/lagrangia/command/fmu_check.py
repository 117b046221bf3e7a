"""`lag fmu check`: files -> a report."""

import math
import sys
from argparse import Namespace
from math import prod
from pathlib import Path

from lagrangia.base.diagnostics import LagError, fail, render_all
from lagrangia.base.spelling import plain_text
from lagrangia.fmu.check import Checked, check_fmu
from lagrangia.fmu.process import SPOKEN
from lagrangia.fmu.run import Opened
from lagrangia.model import Model


def check_fmu_command(options: Namespace) -> int:
    """The exit code is 2 when something written in an FMU is wrong, 1 when only its runs are. Raises LagError L0706 for a
    time that is none."""
    if not 0 < options.seconds < math.inf:
        fail("L0706", f"--seconds: {options.seconds:g} is no time for a run", None, "it is a positive number")
    codes = [_check(file, options.run, options.seconds) for file in options.files]
    return 2 if 2 in codes else max(codes)


def _check(file: Path, run: bool, seconds: float) -> int:
    color = sys.stderr.isatty()
    try:
        checked = check_fmu(file, Model if run else None, seconds)
    except LagError as error:
        print(render_all(error.diagnostics, color), file=sys.stderr)
        return 2
    if checked.faults:
        print(render_all(checked.faults, color), file=sys.stderr)
    print(plain_text(f"{file}: {_describe(checked.opened)}"))
    print(f"  {_count(checked)}")
    for text, is_fault in checked.told:
        print(f"  {'wrong: ' if is_fault else ''}{text}", file=sys.stderr if is_fault else sys.stdout)
    return 2 if checked.is_wrong else 1 if checked.has_failed else 0


def _describe(opened: Opened) -> str:
    description = opened.description
    kinds = " and ".join(SPOKEN.get(kind, "Scheduled Execution") for kind in description.interfaces) or "no interface"
    groups = {"state": [state for state, _ in description.states()],
              **{what: [q for q in description.quantities if q.causality == what] for what in ("input", "output", "parameter")}}
    numbers = {what: sum(prod(description.shape(q) or ()) for q in found) for what, found in groups.items()}
    counts = [f"{count} {what}{'s' if count != 1 else ''}" for what, count in numbers.items()]
    parts = [*opened.platforms, *(["sources"] if opened.has_sources else [])]
    return (f"{opened.name}, FMI {description.root.get('fmiVersion')}, {kinds}; {', '.join(counts)}; "
            f"{', '.join(parts) or 'no binaries'}")


def _count(checked: Checked) -> str:
    errors = sum(d.severity == "error" for d in checked.faults)
    warnings = len(checked.faults) - errors
    if not checked.faults:
        return "no fault is found in what is written in it"
    return " and ".join(f"{n} {what}{'s' if n != 1 else ''}" for n, what in ((errors, "fault"), (warnings, "warning")) if n)
