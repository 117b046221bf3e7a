"""`lag simulate X.fmu`: options -> the motion of an FMU, as a table and a picture."""

import math
import re
import sys
from argparse import Namespace
from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise
from math import prod
from pathlib import Path
from typing import Any

from lagrangia.base.diagnostics import RunError, fail
from lagrangia.base.interruptions import INTERRUPTED
from lagrangia.base.result_files import Target, cells, quoted
from lagrangia.base.spelling import plain_text
from lagrangia.base.tables import read_input_table
from lagrangia.command.arguments import (
    asked,
    assignments,
    is_named,
    names_once,
    prepare_target,
    whole_tables,
)
from lagrangia.command.input_tables import named_tables, read_input, together
from lagrangia.fmu.description import Description, labels
from lagrangia.fmu.process import SPOKEN, Inputs
from lagrangia.fmu.run import FmuRun, open_fmu, simulate_fmu
from lagrangia.fmu.settable import settable, shape_of, with_whole_arrays
from lagrangia.language.units import ONE, Unit, parse_unit
from lagrangia.language.values import read_value
from lagrangia.view.curves import draw

# Options of `lag simulate` that only a model has a meaning for, and their usual values.
_ONLY_MODELS: dict[str, tuple[Any, str]] = {"model": (None, "the FMU is one model"),
                "reactions": (False, "what it reports is in its description: --outputs"),
                "least_squares": (None, "lag export --to fmu has it"),
                "solver": ("auto", "an FMU for Co-Simulation has its own, Model Exchange is integrated by CVode"),
                "engine": ("auto", "an FMU is compiled"), "max_step": (0.0, "--interval sets the communication step"),
                "max_steps": (0, ""), "dump": (None, "it has no phases"), "spectrum": (None, ""), "section": (None, ""),
                "overlay": ([], ""), "stream": (False, ""), "beside": ([], ""), "linear": (False, "its equations are not known")}


def simulate_fmu_command(options: Namespace) -> int:
    """`lag simulate X.fmu`: runs an FMU and writes its rows; returns the exit code. Raises LagError."""
    for name, (usual, hint) in _ONLY_MODELS.items():
        if getattr(options, name) != usual:
            fail("L0706", f"not supported for an FMU: --{name.replace('_', '-')}", None, *filter(None, [hint]))
    target = prepare_target(options)
    if options.start_from is not None:
        fail("L0706", "an FMU cannot be started from its equilibrium: it does not tell what holds it", None,
             "find the position with `lag equilibrium` of its scene, and give it with --initial")
    opened = open_fmu(options.file)
    description = opened.description
    shown = [label for name in names_once(options.plot_quantities, "--plot-quantities") for label in _labels(description, name)]
    values = {**_values(description, options.parameter, "-p"), **_values(description, options.initial, "--initial")}
    request = asked(options, values, {}, _inputs(description, options.input), names_once(options.outputs, "--outputs"))
    run = simulate_fmu(opened, replace(request, outputs=(*request.outputs, *shown)), options.kind)
    _write(run, target, None if request.at is None else request.at[0])
    if options.plot is not None and run.rows:
        curves = shown or [c.name for c in _usual_curves(run)]
        draw(opened.text or opened.name, run["time"], [(opened.column(name), run[name]) for name in curves], options.plot)
    if run.job.kind == "cs" and _has_ramps(run.job.inputs) and not _follows(description):
        print("note: the FMU cannot follow slopes of inputs: their means are held over each communication step, which --interval "
              "makes shorter; --kind me follows them where there is one", file=sys.stderr)
    if not options.quiet:
        _summarise(options, run, target)
    if run.outcome.interrupted:
        print(f"interrupted at t = {run.outcome.time:.6g}; the {run.rows} rows before are kept", file=sys.stderr)
        return INTERRUPTED
    if run.outcome.said and (run.outcome.is_asked_for or not run.outcome.message):
        print("\n".join(["the FMU says:", *(f"  {line}" for line in run.outcome.said)]), file=sys.stderr)
    if run.outcome.is_asked_for:
        print(f"{run.outcome.message} at t = {run.outcome.time:.6g}", file=sys.stderr)
    elif run.outcome.message:
        raise RunError(f"at t = {run.outcome.time:.9g}: {run.outcome.explanation}\n"
                       f"{run.rows} rows before it are kept in {target}")
    elif run.outcome.warns:
        step = "communication step" if run.job.kind == "cs" else "step"
        raise RunError(f"the FMU answered the last {step} with a warning; the rows are kept in {target}")
    return 0


def _has_ramps(inputs: Inputs) -> bool:
    rows = list(zip(inputs.times, inputs.rows, strict=True))
    return any(b > a and list(x) != list(y) for (a, x), (b, y) in pairwise(rows))


def _follows(description: Description) -> bool:
    return description.version == "2" and description.interfaces["cs"].get("canInterpolateInputs") in ("true", "1")


def _values(description: Description, given: Iterable[str], option: str) -> dict[str, Any]:
    """By name, of arrays by their elements."""
    found: dict[str, Any] = {}
    for name, text in assignments(given, option):
        causality = settable(description, name).quantity.causality
        is_parameter = causality in ("parameter", "structuralParameter")
        if option == "-p" and not is_parameter:
            fail("L0701", f"'{name}' is no parameter", None, "start values are given by --initial, inputs by -u")
        if option == "--initial" and (is_parameter or causality == "input"):
            fail("L0701", f"'{name}' is {'an input' if causality == 'input' else 'a parameter'}", None,
                 "give it by " + ("-u" if causality == "input" else "-p"))
        for element, value in _numbers(description, name, text).items():
            if element in found:
                fail("L0712", f"'{element}' is given twice")
            found[element] = value
    return found


def _numbers(description: Description, name: str, text: str) -> dict[str, Any]:
    """The values of a scalar, an element, or all elements of an array. Raises LagError L0706."""
    found = settable(description, name)
    kind, unit = found.quantity.kind, found.quantity.get("unit") or ""
    if found.names == (name,):
        return {name: _value(kind, text, unit, name)}
    inner = text.strip()[1:-1]
    if len(found.shape) == 2 and "{" in inner:
        rows = [row.split(",") for row in re.findall(r"\{([^{}]*)\}", inner)]
        parts = [part for row in rows for part in row] if [len(row) for row in rows] == [found.shape[1]] * found.shape[0] else []
    else:
        parts = inner.split(",")
    if not (text.strip().startswith("{") and text.strip().endswith("}")) or len(parts) != len(found.names):
        size = " by ".join(map(str, found.shape))
        fail("L0706", f"{name} = {text}: it is an array of {size} values", None,
             f"write them as {name}={{..., ...}}, row by row, or {found.names[0]}=... for one of them")
    return {element: _value(kind, part.strip(), unit, element) for element, part in zip(found.names, parts, strict=True)}


def _value(kind: str, text: str, unit: str, name: str) -> Any:
    """In the FMU's own unit. Raises LagError L0706."""
    if kind in ("String", "Boolean"):
        if kind == "Boolean" and text not in ("true", "false"):
            fail("L0706", f"{name} = {text}: it is true or false")
        return text if kind == "String" else text == "true"
    if kind in ("Binary", "Clock"):
        fail("L0901", f"not supported yet: values of the type {kind}")
    try:
        value = _in_unit(text, unit) if "[" in text else read_value(text, "")
    except ValueError as error:
        fail("L0706", f"{name} = {text}: {error}")
    if isinstance(value, list):
        fail("L0706", f"{name} = {text}: one number is needed")
    if kind not in ("Real", "Float32", "Float64") and value != int(value):
        fail("L0706", f"{name} = {text}: a whole number is needed")
    return float(value)


def _in_unit(text: str, unit: str) -> float | list[float]:
    """A value with a unit of its own, in that of the FMU. Raises ValueError; units of other tools may be none of ours."""
    own = parse_unit(unit) if unit else Unit(1.0, ONE)
    value = read_value(text, unit or "rad")
    return value if isinstance(value, list) else (value - own.offset) / own.factor


def _inputs(description: Description, given: list[str]) -> Inputs:
    named = named_tables(given)
    whole = whole_tables(given, named)
    inputs = [q.name for q in description.quantities if q.causality == "input"]
    known = f"the inputs are {', '.join(inputs)}" if inputs else "there are none"

    def unit_of(name: str, is_one: bool = True) -> str:
        found = settable(description, name)
        if found.quantity.causality != "input":
            fail("L0701", f"'{name}' is no input", None, known)
        if is_one and found.names != (name,):
            fail("L0703", f"'{name}' is an array: each of its elements needs a column", None, f"name it {found.names[0]}")
        return found.quantity.get("unit") or ""

    constants: list[tuple[str, float]] = []
    for name, text in assignments((item for item in given if item not in whole and not is_named(item, named)), "-u"):
        unit_of(name, is_one=False)
        constants += [(element, float(value)) for element, value in _numbers(description, name, text).items()]
    if len(whole) > 1:
        fail("L0703", "one table of inputs can be given", None, "put its columns into one file, or name each: -u NAME=FILE")
    tables = [read_input_table(Path(file)) for file in whole]
    tables += [_column(name, unit_of(name), file) for name, file in named.items()]
    times, columns = together(tables) if tables else ([0.0], {})
    for name in columns:
        if name not in description.by_name and description.element(name) is None:
            fail("L0701", f"the FMU has no input '{name}'", None, known)
        unit_of(name)
    count = Counter([*(name for name, _ in constants), *(name for _, found in tables for name in found)])
    if twice := next((name for name, times_given in count.items() if times_given > 1), None):
        fail("L0712", f"'{twice}' is given twice")
    if any(b < a for a, b in pairwise(times)) or not all(map(math.isfinite, times)):
        fail("L0703", "the times of the inputs must be finite and not fall")
    given_columns = {**columns, **{name: [value] * len(times) for name, value in constants}}
    table = with_whole_arrays(description, given_columns, len(times))
    return Inputs(list(table), list(times), [[column[row] for column in table.values()] for row in range(len(times))])


def _column(name: str, unit: str, file: str) -> Any:
    """-u NAME=FILE, in the FMU's own unit; those of other tools may be none of ours. Raises LagError L0706."""
    if file.endswith((":cubic", ":monotone")):
        fail("L0706", f"not supported for an FMU: '{name}' as a smooth table", None, "give rows close together, linear between")
    try:
        parse_unit(unit or "1")
    except ValueError:
        return read_input(name, None, file, is_moving=False)
    return read_input(name, unit, file, is_moving=False)


def _labels(description: Description, name: str) -> list[str]:
    """Of a variable's columns."""
    quantity = description.by_name.get(name)
    return [name] if quantity is None else labels(name, shape_of(description, quantity))


def _usual_curves(run: FmuRun) -> list[Any]:
    """Declared outputs; states where there are none."""
    description = run.opened.description
    outputs = {label for q in description.quantities if q.causality == "output" for label in _labels(description, q.name)}
    return [c for c in run.columns if c.name in outputs] or list(run.columns)


def _write(run: FmuRun, target: str, first: float | None) -> None:
    """A line of names and a line for each row; `first` leaves out the start when no row was asked for there."""
    names = ",".join(quoted(name) for name in ("time", *(column.name for column in run.columns)))
    rows = (row for row in run.lines() if first is None or row[0] >= first)
    lines = (cells(row) for row in rows)
    if target == "-":
        print(names, *lines, sep="\n")
        return
    with Target(Path(target)) as opened:
        opened.put(names + "\n")
        for line in lines:
            opened.put(line + "\n")


def _summarise(options: Namespace, run: FmuRun, target: str) -> None:
    out = sys.stdout if target != "-" else sys.stderr
    opened, job, outcome = run.opened, run.job, run.outcome
    title = f"{opened.name}: {opened.text}" if opened.text else opened.name
    description = opened.description
    states = sum(prod(description.shape(state) or ()) for state, _ in description.states())
    print(f"{plain_text(title)}\n  FMI {description.root.get('fmiVersion')}, {SPOKEN[job.kind]}; {states} "
          f"state{'s' if states != 1 else ''}, {job.times[0]:g} to {job.stop:g} s, tolerance {job.tolerance:g}", file=out)
    how = f"{outcome.steps} communication steps"
    if job.kind == "me":
        how = f"CVode: {outcome.steps} intervals, {outcome.evaluations} evaluations, {outcome.events} events"
    print(plain_text(f"  {run.rows} rows in {target}" + (f", picture in {options.plot}" if options.plot else "")), file=out)
    if options.stats:
        maker = opened.description.root.get("generationTool") or "a tool that does not tell"
        print(plain_text(f"  {how}; {outcome.seconds:.3g} s with FMPy and loading; made by {maker}"), file=out)
        print(plain_text(f"  binaries for {', '.join(opened.platforms)}"), file=out)
