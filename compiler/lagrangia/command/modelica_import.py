"""`lag import`: a Modelica file, or a robot in URDF -> a .lag file."""

import sys
from argparse import Namespace
from pathlib import Path

from lagrangia.base.diagnostics import Source, fail
from lagrangia.base.result_files import write_text
from lagrangia.compile.sources import read_source
from lagrangia.editor.formatting import formatted
from lagrangia.editor.modelica_import import Imported, imported
from lagrangia.language.syntax import parse


def import_command(options: Namespace) -> int:
    """Exit code 1 where something was left out, which is told. Raises LagError."""
    file = Path(options.file)
    if file.suffix not in (".mo", ".urdf"):
        fail("L0703", f"not supported yet: to import '{file.name}'", None,
             "Modelica files can be imported, which end in .mo, and robots in URDF, which end in .urdf")
    target = Path(options.output) if options.output else file.with_suffix(".lag")
    if target.exists() and not options.output:
        fail("L0004", f"'{target}' is there already", None, f"-o {target} writes over it; another name after -o keeps it")
    found = _robot(file) if file.suffix == ".urdf" else _modelica(file)
    write_text(target, formatted(Source(str(target), f"// From {file.name}.\n{found.text}")))
    print(f"written to {target}: lag check {target}")
    for statement in found.left_out:
        print(f"left out, as it has no counterpart: {statement}", file=sys.stderr)
    return 1 if found.left_out else 0


def _modelica(file: Path) -> Imported:
    source = read_source(file)
    parse(source)  # which tells what is wrong, or not of this language, where it stands
    return imported(source.text)


def _robot(file: Path) -> Imported:
    from lagrangia.editor.urdf_import import imported_robot

    return imported_robot(file.name, read_source(file).text.encode())
