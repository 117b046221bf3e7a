"""`lag fmu check`: all that can be found wrong with an FMU, by reading it and by running it."""

import re
from collections.abc import Iterator
from dataclasses import field
from pathlib import Path

from lagrangia.base.diagnostics import Diagnostic, LagError
from lagrangia.base.records import dataclass
from lagrangia.fmu.archive import DESCRIPTION, archive_rules
from lagrangia.fmu.compare import Load, compare, experiment_of
from lagrangia.fmu.parts import part_rules
from lagrangia.fmu.process import SPOKEN, Job, Outcome, require_fmpy, run_job
from lagrangia.fmu.rules import unit_rules, variable_rules
from lagrangia.fmu.run import Opened, has_binary, open_fmu, unpacked
from lagrangia.fmu.schemas import schema_rules
from lagrangia.fmu.structure import structure_rules

FMPY = "L0739"
PATIENCE = 20.0  # seconds for each run, as long as nothing else is asked for


@dataclass
class Checked:
    """`faults` of what was read; `told`: what running it showed, and whether that is a fault."""

    opened: Opened
    faults: list[Diagnostic]
    told: list[tuple[str, bool]] = field(default_factory=list)

    @property
    def is_wrong(self) -> bool:
        """Whether something written in it is."""
        return any(d.severity == "error" for d in self.faults)

    @property
    def has_failed(self) -> bool:
        """Whether a run of it did."""
        return any(is_fault for _, is_fault in self.told)


def check_fmu(path: Path, load: Load | None = None, seconds: float = PATIENCE) -> Checked:
    """With `load`, which opens a source inside, its binary for this machine is loaded and simulated: that is to trust it. Each
    run of it is given up after `seconds`; one that does not even begin in that time has failed.

    Raises LagError for what is no FMU.
    """
    require_fmpy()
    opened = open_fmu(path)
    found = list(read_faults(opened))
    checked = Checked(opened, found + list(_fmpy_rules(path, found)))
    if load is not None:
        _run(opened, checked, load, seconds)
    return checked


def read_faults(opened: Opened) -> Iterator[Diagnostic]:
    """What our own rules find in the archive and its texts."""
    description = opened.description
    yield from archive_rules(opened.archive)
    yield from unit_rules(description)
    yield from variable_rules(description)
    yield from structure_rules(description)
    yield from part_rules(opened.archive, description)
    yield from schema_rules(opened.archive)


def _fmpy_rules(path: Path, found: list[Diagnostic]) -> Iterator[Diagnostic]:
    """What FMPy's validation says, but for lines of the description in which a fault is told already."""
    from fmpy.validation import validate_fmu

    lines = {d.span.source.line_and_column(d.span.start)[0] for d in found
             if d.span is not None and d.severity == "error" and d.span.source.name.endswith(DESCRIPTION)}
    told = lines | {line - 1 for line in lines}  # numbers of FMI 2 stand in an element below that of their variable
    try:
        messages = validate_fmu(str(path))
    except Exception as error:  # FMPy reads on where there is nothing to read
        messages = [f"{type(error).__name__}: {error}"]
    for message in messages:
        if told.isdisjoint(map(int, re.findall(r"line (\d+)[),]", message))):
            yield Diagnostic("error", FMPY, f"FMPy: {message}")


def _run(opened: Opened, checked: Checked, load: Load, seconds: float) -> None:
    if opened.description.bad_identifier is not None:
        checked.told.append(("it was not run: its model identifier is none, and names no library in it", False))
        return
    if not has_binary(opened):
        checked.told.append(("it was not run: it has no binary for this machine", False))
        return
    try:
        with unpacked(opened) as folder:
            begun = []
            for kind in opened.offers:
                outcome = _probe(opened, folder, kind, seconds)
                told = filter(None, (outcome.explanation, *outcome.faults))
                checked.told += [(f"{SPOKEN[kind]}: {text}", True) for text in told]
                begun += [] if outcome.is_given_up else [kind]
            checked.told += [(found.message, found.is_wrong) for found in compare(opened, folder, begun, load, seconds)]
    except LagError as error:
        checked.told += [(d.message, True) for d in error.diagnostics]


def _probe(opened: Opened, folder: str, kind: str, seconds: float) -> Outcome:
    """A look at a running instance."""
    start, stop, tolerance = experiment_of(opened)
    flags = opened.description.interfaces[kind]
    derivatives = any(flags.get(f"providesDirectionalDerivative{end}") in ("true", "1") for end in ("", "s"))
    return run_job(Job(folder, kind, [start], stop, tolerance, probe=True, derivatives=derivatives), seconds)
