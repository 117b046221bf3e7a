"""`lag export`: options -> file."""

import sys
from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangia.base.diagnostics import LagError, fail
from lagrangia.base.result_files import keep_apart, write_text
from lagrangia.base.spelling import plain_text
from lagrangia.command.arguments import (
    assignments,
    keep_other,
    named_pairs,
    part_structural,
    tell,
    tell_warnings,
)
from lagrangia.command.scene_export import TARGETS

if TYPE_CHECKING:
    from lagrangia.model import Model

_WRITTEN = ("modelica", "sympy", "latex")  # with names on paper
_SIGNS = {"python": "Functions of t, q, v, u, p in SI units", "sympy": "Lagrange's equations: equations[k]",
          "modelica": ", fixed = true", "latex": "margin=22mm"}  # of what each writes
_MEANT = dict.fromkeys(("fmi", "kind", "platforms", "sources", "engine", "arrays", "outputs", "least_squares",
                         "info"), ("fmu",)) | {
    "names": _WRITTEN, "components": ("modelica",)}


def _refuse_idle(options: Namespace) -> None:
    """Raises LagError L0704 for an option that would change nothing."""
    for name, targets in _MEANT.items():
        if getattr(options, name) not in (None, []) and options.to not in targets and options.to in ("fmu", *TARGETS):
            fail("L0704", f"an export to {options.to} has no --{name.replace('_', '-')}", None, f"it is for {', '.join(targets)}")


def _export_components(options: Namespace) -> int:
    """A scene in the words of the Modelica Standard Library: a drive train as its file says, frames by joints and bodies."""
    from lagrangia.compile.pipeline import read_files
    from lagrangia.editor.modelica_export import drive_train, has_frames, used_of

    main, imported = read_files(options.file)
    used = used_of(main, imported)
    in_frames = has_frames(main, used)
    for name in ("names", "force") if in_frames else ("model", "names", "force", "parameter"):
        if getattr(options, name):
            fail("L0704", f"--{name} has no effect beside --components", None, "the file is written as it stands")
    text, read = _multibody(options) if in_frames else (drive_train(main, used), [])
    if not in_frames:
        _require_right(options.file)
    if options.output == "-":
        sys.stdout.write(text)
        return 0
    path = Path(options.output) if options.output else Path(f"{options.file.stem}.mo")
    keep_apart([path], read)
    if not options.output and path.exists():
        fail("L0004", f"'{path}' is there already", None, f"-o {path} writes over it; another name after -o keeps it")
    write_text(path, text)
    print(plain_text(f"{path}: {text.count(chr(10))} lines"))
    return 0


def _require_right(file: Path) -> None:
    """Raises LagError for what a file says wrong, but for a value that only who uses a component can give."""
    from lagrangia.compile.sources import read_source
    from lagrangia.editor.reading import read_text

    if wrong := [one for one in read_text(file, read_source).diagnostics if one.severity == "error" and one.code != "L0211"]:
        raise LagError(wrong)


def _multibody(options: Namespace) -> tuple[str, list[str]]:
    """The text, and the tables that the scene reads."""
    from lagrangia.command.multibody_export import multibody_text
    from lagrangia.command.scene_export import export_warnings

    model = _model(options)
    tell(options, model, [warning.render() for warning in export_warnings(model, options.to)])
    return multibody_text(model), model.scene.notes["files"]


def _model(options: Namespace) -> "Model":
    """The scene, with its warnings told."""
    from lagrangia.model import Model

    structural, others = part_structural(options, assignments(options.parameter, "-p"))
    if others:
        fail("L0702", f"'{next(iter(others))}' is no structural parameter", None,
             "other parameters stay open in what is exported")
    model = Model(options.file, options.model, structural)
    tell_warnings(options, model)
    return model


def export_command(options: Namespace) -> int:
    """`lag export`: writes a scene for another program. Raises LagError."""
    _refuse_idle(options)
    if options.to == "fmu":
        from lagrangia.command.fmu_export import export_fmu_command

        return export_fmu_command(options)
    if options.components:
        return _export_components(options)
    from lagrangia.command.scene_export import export, export_warnings, exported_text
    from lagrangia.fmu.export import identifier_of

    model = _model(options)
    tell(options, model, [warning.render() for warning in export_warnings(model, options.to)])
    names = named_pairs(options.names or "", "--names")
    if options.output == "-":
        sys.stdout.write(exported_text(model, options.to, names, options.force))
        return 0
    path = Path(options.output) if options.output else Path(identifier_of(model.name) + TARGETS.get(options.to, ""))
    keep_other(options, path, _SIGNS.get(options.to, ""))
    if path.suffix.lower() != TARGETS.get(options.to, path.suffix.lower()):
        print(f"'{path}' will hold an export to {options.to}, whose names end in {TARGETS[options.to]}", file=sys.stderr)
    print(export(model, options.to, path, names, options.force))
    return 0
