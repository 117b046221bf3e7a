"""The syntax of the component library: parsed once, when the package is built."""

from dataclasses import replace
from functools import cache
from pathlib import Path

from lagrangia.base.diagnostics import LIBRARY, Source
from lagrangia.base.folders import data_folder
from lagrangia.language.plain_tree import PlainClasses, read_trees, write_trees
from lagrangia.language.shipped import made_of, ship
from lagrangia.language.syntax import grammar_file, parse, reader_tables
from lagrangia.language.tree import ClassDefinition, Syntax

LIBRARY_PACKAGES = {"Rotational": "rotational.lag", "Translational": "translational.lag", "Blocks": "blocks.lag",
                    "Modelica": "modelica.lag"}


@cache
def library() -> tuple[Syntax, ...]:
    """The files of the library, in the order of their names, without their drawing sections; read once in a process."""
    return read_trees(made_of("library", _files(), _parsed))


@cache
def library_classes() -> PlainClasses:
    """The same by their names: most scenes need few of them."""
    return PlainClasses(made_of("library", _files(), _parsed))


@cache
def drawn_library() -> tuple[Syntax, ...]:
    """The files of the library as a whole: a picture alone asks for it."""
    return read_trees(made_of("drawn", _files(), _parsed_whole))


def library_package(name: str) -> Syntax | None:
    """A package of the library, which is read when it is named; None for any other name."""
    file = LIBRARY_PACKAGES.get(name)
    return _package(name, file) if file is not None else None


def packages_with(name: str) -> list[str]:
    """The packages of the library that have a class of this name, without that of Modelica's own names."""
    return [package for package, file in LIBRARY_PACKAGES.items() if package != "Modelica"
            and any(c.name == name for c in _package(package, file).classes[0].classes)]


@cache
def _package(name: str, file: str) -> Syntax:
    place = _folder() / file
    (syntax,) = read_trees(made_of(f"package-{name}", [place], lambda: write_trees(_trees([place]))))
    return syntax


def ship_all() -> list[Path]:
    """What `library` and the parser would make at first use, put beside the modules: the files. Raises OSError."""
    packages = {name: _folder() / file for name, file in LIBRARY_PACKAGES.items()}
    return [ship("reader", [grammar_file()], reader_tables()),
            ship("library", _files(), _parsed()),
            ship("drawn", _files(), _parsed_whole()),
            *(ship(f"package-{name}", [file], write_trees(_trees([file]))) for name, file in packages.items())]


def _folder() -> Path:
    return data_folder("models") / "library"


def _files() -> list[Path]:
    return sorted(file for file in _folder().glob("*.lag") if file.name not in LIBRARY_PACKAGES.values())


def _parsed_whole() -> bytes:
    return write_trees(_trees(_files()))


def _parsed() -> bytes:
    return write_trees(tuple(replace(tree, classes=tuple(map(_undrawn, tree.classes))) for tree in _trees(_files())))


def _trees(files: list[Path]) -> tuple[Syntax, ...]:
    return tuple(parse(Source(f"{LIBRARY}{file.name}", file.read_text(encoding="utf-8"))) for file in files)


def _undrawn(definition: ClassDefinition) -> ClassDefinition:
    return replace(definition, sections=tuple(section for section in definition.sections if section.kind != "drawing"))
