"""`lag export`: options -> file."""

import sys
from argparse import Namespace
from pathlib import Path

from lagrangia.commands import assignment, structural_value
from lagrangia.diagnostics import fail


def export_command(options: Namespace) -> int:
    if options.to == "fmu":
        from lagrangia.fmu_command import export_fmu_command

        return export_fmu_command(options)
    from lagrangia.exports import TARGETS, export, exported_text
    from lagrangia.model import Model
    from lagrangia.pipeline import flatten_file

    structural = dict(assignment(text, "-p") for text in options.parameter)
    if structural:
        known = flatten_file(options.file, options.model)[1].structural
        others = [name for name in structural if name not in known]
        if others:
            fail("L0702", f"'{others[0]}' is no structural parameter", None, "other parameters stay open in what is exported")
    model = Model(options.file, options.model, {name: structural_value(text) for name, text in structural.items()})
    names = dict(assignment(text, "--names") for text in (options.names or "").split(",") if text.strip())
    if options.output == "-":
        sys.stdout.write(exported_text(model, options.to, names, options.force))
        return 0
    path = Path(options.output) if options.output else Path(model.name + TARGETS.get(options.to, ""))
    print(export(model, options.to, path, names, options.force))
    return 0
