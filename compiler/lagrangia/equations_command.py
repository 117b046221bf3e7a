"""`lag equations`: options -> Request -> page."""

from argparse import Namespace
from pathlib import Path
from typing import Any

from lagrangia.arguments import assignment, keep_inputs, structural_value
from lagrangia.diagnostics import fail
from lagrangia.pipeline import flatten_file
from lagrangia.targets import write_text


def equations_command(options: Namespace) -> int:
    from lagrangia.equation_sheet import Request, write_equations

    keep_inputs(options, options.output)
    structural, parameters = _parameters(options)
    about = None if options.about is None else _pairs(options.about, "--about")
    names = _pairs(options.names or "", "--names")
    request = Request(options.form, options.format, names, parameters, options.numbers, options.force, about)
    text = write_equations(options.file, request, options.model, structural)
    if options.output in (None, "-"):
        print(text)
    else:
        write_text(Path(options.output), text + "\n")
        print(f"written to {options.output}")
    return 0


def _parameters(options: Namespace) -> tuple[dict[str, Any], dict[str, str]]:
    """Those that are structural, and the others."""
    given = dict(assignment(text, "-p") for text in options.parameter)
    if not given:
        return {}, {}
    known = flatten_file(options.file, options.model)[1].structural
    return ({name: structural_value(text) for name, text in given.items() if name in known},
            {name: text for name, text in given.items() if name not in known})


def _pairs(text: str, option: str) -> dict[str, str]:
    pairs = [assignment(item, option) for item in text.split(",") if item.strip()]
    names = [name for name, _ in pairs]
    if len(set(names)) < len(names):
        fail("L0706", f"{option}: '{next(n for n in names if names.count(n) > 1)}' is given twice")
    return dict(pairs)
