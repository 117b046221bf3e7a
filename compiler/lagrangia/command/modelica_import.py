"""`lag import`: a Modelica file, a robot in URDF, or a scene in MJCF -> a .lag file."""

import re
import sys
from argparse import Namespace
from dataclasses import replace
from pathlib import Path

from lagrangia.base.diagnostics import LagError, Source, Span, fail
from lagrangia.base.result_files import keep_sources, write_text
from lagrangia.base.spelling import plain_text
from lagrangia.compile.sources import read_source
from lagrangia.editor.formatting import formatted
from lagrangia.editor.modelica_import import Imported, imported, without_leading_dots
from lagrangia.language.syntax import parse

_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)


def import_command(options: Namespace) -> int:
    """Exit code 1 where something was left out, which is told. Raises LagError."""
    file = Path(options.file)
    reader = _READERS.get(file.suffix)
    if file.suffix == ".xacro":
        fail("L0730", f"'{file.name}' is xacro, which writes URDF", None, f"run it first: xacro {file.name} > robot.urdf")
    if reader is None:
        fail("L0703", f"not supported yet: to import '{file.name}'", None,
             "Modelica files can be imported (.mo), robots in URDF (.urdf), and scenes in MJCF (.xml)")
    target = Path(options.output) if options.output else file.with_suffix(".lag")
    if target.exists() and not options.output:
        fail("L0004", f"'{target}' is there already", None, f"-o {target} writes over it; another name after -o keeps it")
    found = reader(file)
    keep_sources(target, [file, *found.read])
    write_text(target, formatted(Source(str(target), f"// From {file.name}.\n{found.text}")))
    print(plain_text(f"written to {target}: lag check {target}"))
    for statement in found.left_out:
        print(f"left out, as it has no counterpart: {plain_text(statement)}", file=sys.stderr)
    return 1 if found.left_out else 0


def _modelica(file: Path) -> Imported:
    source = read_source(file)
    text = without_leading_dots(source.text)
    try:
        classes = parse(Source(source.name, text)).classes  # which tells what is wrong, or not of this language, where it stands
    except LagError as error:
        if (place := error.diagnostics[0].span) is not None and not _COMMENT.sub("", text[: place.start]).strip():
            fail("L0703", f"'{file}' is no Modelica file: it begins with no class", None, "as in model Name ... end Name;")
        raise
    if not classes:
        fail("L0703", f"there is nothing to import in '{file}': it has no class", None,
             "a Modelica file has one: model Name ... end Name;")
    return imported(text)


def _robot(file: Path) -> Imported:
    from lagrangia.editor.urdf_import import imported_robot

    return imported_robot(file.name, read_source(file).text.encode())


def _scene(file: Path) -> Imported:
    from lagrangia.editor.mjcf_import import imported_scene
    from lagrangia.fmu.xmltree import Element, read_xml

    included = list[Path]()

    def read(name: str, span: Span) -> Element:
        """An included file, beside the first one, whose root is of any name: of what is no XML, no line is shown."""
        path = file.parent / name
        included.append(path)
        if not path.is_file():
            fail("L0730", f"there is no file '{name}' to include", span)
        try:
            return read_xml(name, read_source(path).text.encode())
        except LagError as error:
            (first, *_) = error.diagnostics
            fail("L0730", f"'{name}' cannot be included: {first.message}", span, *([f"at {first.span}"] if first.span else []))

    root = read_xml(file.name, read_source(file).text.encode())
    if root.tag == "robot":
        return _robot(file)
    if root.tag != "mujoco":
        fail("L0730", f"'{file}' is neither a scene in MJCF nor a robot but <{root.tag}>", None,
             "a scene in MJCF stands in <mujoco>, with bodies in <worldbody>")
    return replace(imported_scene(root, file.name, read), read=tuple(included))


_READERS = {".mo": _modelica, ".urdf": _robot, ".xml": _scene}
