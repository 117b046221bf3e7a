"""`lag check`: whether files compile, and what freedom their scenes have."""

import sys
from argparse import Namespace
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lagrangia.base.diagnostics import Diagnostic, LagError, Report, render_all
from lagrangia.base.spelling import plain_text
from lagrangia.command.arguments import tell_warnings
from lagrangia.command.summary import singular_start
from lagrangia.model import Model
from lagrangia.run.interpret import evaluate
from lagrangia.run.request import check_parameters, check_values

if TYPE_CHECKING:
    from lagrangia.compile.elsewhere import Beside

_NOTHING_RUNS = "L0003"
_MOST_NAMED = 12


def check_command(options: Namespace) -> int:
    """Compiles every file; the exit code is 2 when one is wrong. Raises LagError L0706, L0710, of all of them."""
    wrong, strict = 0, Report()
    for file in options.files:
        models, parts, found = _compiled(file)
        problems = [model.freedom["problem"] for model in models if model.freedom["problem"]]
        if found or problems:
            wrong += 1
            print("\n".join([*([render_all(found, sys.stderr.isatty())] if found else []), *problems]), file=sys.stderr)
            continue
        if not models:
            names = ", ".join(parts[:_MOST_NAMED]) + (", ..." if len(parts) > _MOST_NAMED else "")
            print(f"{plain_text(str(file))}: {len(parts)} model{'s' if len(parts) != 1 else ''} for others to use: {names}")
        for model in models:
            print(f"{plain_text(str(file))}: {_describe(model.scene, model.freedom)}")
            try:
                tell_warnings(options, model)
            except LagError as error:
                strict.add(error.diagnostics)
    strict.raise_errors()
    return 2 if wrong else 0


def _compiled(file: Path) -> tuple[list[Model], list[str], list[Diagnostic]]:
    """The models of a file that can be run, the one that is run last; those for others to use; and what is wrong with any."""
    report = Report()
    last = _checked(file, None, report)
    codes = [diagnostic.code for diagnostic in report.diagnostics]
    is_package = codes == [_NOTHING_RUNS]
    if any(code.startswith(("L00", "L01", "L0202")) for code in codes) and not is_package:
        return last, [], report.diagnostics
    beside = _beside(file)
    if is_package and not beside:
        return last, [], report.diagnostics
    if is_package:
        report = Report()  # it is for others, and its models are run by name
    known = {diagnostic.render() for diagnostic in report.diagnostics}  # what is wrong with the whole file is told already
    report.add(diagnostic for diagnostic in _of_others(file) if diagnostic.render() not in known)
    scenes, parts = [], [other.name for other in beside if not other.is_whole]
    for other in (x for x in beside if x.is_whole):
        own = Report()
        made = _checked(file, other.name, own)
        report.add(d for d in own.diagnostics if other.is_fault(d) and d.render() not in known)
        if made and other.is_scene:
            scenes += made
        else:
            parts.append(other.name)
    return [*scenes, *last], parts, report.diagnostics


def _checked(file: Path, name: str | None, report: Report) -> list[Model]:
    """A model through all phases, with its freedom; none where that reports what is wrong."""
    try:
        model = Model(file, name)
        _check_limits(model)
        return [model] if model.freedom else []
    except LagError as error:
        report.add(error.diagnostics)
    return []


def _beside(file: Path) -> "list[Beside]":
    """The other models of the file."""
    from lagrangia.compile.elsewhere import models_beside

    try:
        return models_beside(file)
    except LagError:
        return []  # told already


def _of_others(file: Path) -> list[Diagnostic]:
    """What is wrong with what the last model does not use."""
    from lagrangia.compile.elsewhere import faults_elsewhere

    try:
        return faults_elsewhere(file)
    except LagError:
        return []  # told already


def _check_limits(model: Model) -> None:
    """Parameters as declared must lie within the limits of their types, as they must in a run."""
    values = check_values(model.scene)
    (parameters,) = evaluate(model.scene.tapes["parameters"], values.parameters, values.mask)
    try:
        check_parameters(model.scene, parameters)
    except LagError:
        from lagrangia.constraints.parameters import require_possible

        require_possible(model.compilation.kinematics)  # which knows the lines
        raise


def _describe(scene: Any, freedom: Mapping[str, Any]) -> str:
    """Degrees of freedom, coordinates, loops and redundant constraints."""
    notes = scene.notes
    names = scene.told
    shown = ", ".join(names[:6]) + (f", ... ({len(names)})" if len(names) > 6 else "")
    degrees = freedom["degrees_of_freedom"] - len(scene.signals)
    still = "" if degrees else ": its motion is prescribed" if notes["is_driven"] else ", so it stands still: statics"
    lines = [f"{scene.name}: {degrees} degree{'s' if degrees != 1 else ''} of freedom{still}"]
    held = scene.sizes["n_multipliers"]
    closed = f", {notes['loops']} closed loop{'s' if notes['loops'] != 1 else ''}" if notes["loops"] else ""
    if names:
        lines.append(f"  coordinates {shown}" + (f"; {held} constraint{'s' if held != 1 else ''}{closed}" if held else ""))
    if scene.flowing:
        lines.append(f"  first-order states {', '.join(scene.flowing.values())}")
    if scene.kept:
        lines.append(f"  discrete variables {', '.join(scene.discrete)}")
    if notes["dependent"]:
        lines.append(f"  given by others: {', '.join(notes['dependent'][:8])}")
    lines += [f"  {text}" for text in filter(None, [singular_start(scene, freedom)])]
    lines += [f"  {text} only just holds: it is kept with its slopes or its parts" for text in notes["touching"]["told"]]
    lines += [f"  {text}" for text in (*freedom["repeated"], *freedom["assemblies"])]
    return "\n".join(lines)
