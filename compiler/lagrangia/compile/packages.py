"""Packages in folders: NAME.lag, or NAME/package.lag with a file or folder for each class in it (Modelica 3.6, section 13.4)."""

import os
from collections.abc import Iterator
from pathlib import Path

from lagrangia.base.diagnostics import Report, Span, fail
from lagrangia.base.search_path import search_path
from lagrangia.compile.sources import read_source
from lagrangia.language.syntax import parse
from lagrangia.language.tree import Syntax


class Packages:
    """Finds the files of packages for one file and keeps what was read."""

    def __init__(self, main: Syntax) -> None:
        self.main, self.read = main, list[Syntax]()
        self._folders: dict[str, Path | None] = {}  # of packages that are folders
        file, names = Path(main.source.name).absolute(), main.within.split(".") if main.within else []
        folder = file.parent
        if file.name == "package.lag" and main.classes:
            names = [*names, main.classes[0].name]
        for k in range(len(names), 0, -1):
            self._folders[".".join(names[:k])] = folder
            folder = folder.parent
        self._roots = [folder, *search_path()]

    def find(self, name: str) -> Syntax | None:
        """The file of a class by its full name; None where there is none, also of a name that no file can have. Raises LagError
        for one that is wrong."""
        owner, _, last = name.rpartition(".")
        if not last.isidentifier():
            return None
        inside = self._folders.get(owner) if owner else None
        for folder in (([inside] if inside else []) if owner else self._roots):
            for place in (folder / last / "package.lag", folder / f"{last}.lag"):
                if os.path.isfile(place) and place.resolve() != Path(self.main.source.name).resolve():
                    return self._taken(name, place)
        return None

    def _taken(self, name: str, place: Path) -> Syntax | None:
        owner, _, last = name.rpartition(".")
        syntax = parse(read_source(place))
        found = next((c for c in syntax.classes if c.name == last), None)
        if found is None or (not owner and found.kind != "package"):
            if not owner:
                return None  # a scene of this name, no package
            fail("L0002", f"'{place}' has no class '{last}'", Span(syntax.source, 0, 1), f"{name} was looked for there")
        _check(syntax, owner, place)
        self._folders[name] = place.parent if place.name == "package.lag" else None
        self.read.append(syntax)
        return syntax


def _check(syntax: Syntax, owner: str, place: Path) -> None:
    report = Report()
    if (syntax.within or "") != owner:
        said = f"within {syntax.within};" if syntax.within else "nothing of a package around it"
        report.error("L0002", f"'{place}' says {said}", Span(syntax.source, 0, 1),
                     f"it lies in the folder of its package: its first line is `within {owner};`" if owner else
                     "a package that lies in no other one begins without `within`")
    for item in syntax.imports:
        report.error("L0002", "a file of a package imports no file by its path", item.span,
                     "import what it has by name: import P.Q;")
    report.raise_errors()


def enclosing(main: Syntax) -> Iterator[Syntax]:
    """The package.lag files around a file that says within which package it lies. Raises LagError L0002."""
    names = main.within.split(".") if main.within else []
    folder = Path(main.source.name).absolute().parent
    if Path(main.source.name).name == "package.lag":
        folder = folder.parent
    for k in range(len(names), 0, -1):
        place = folder / "package.lag"
        if not place.is_file():
            fail("L0002", f"there is no package '{'.'.join(names[:k])}' around this file", Span(main.source, 0, 1),
                 f"looked for {os.path.relpath(place)}")
        yield parse(read_source(place))
        folder = folder.parent
