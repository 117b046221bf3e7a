"""`lag doc`: the library and people's own files as a site to be read."""

import re
from argparse import Namespace
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from lagrangia.base.diagnostics import LagError, RunError, Span, fail
from lagrangia.base.folders import data_folder
from lagrangia.base.result_files import write_text
from lagrangia.base.search_path import searching_in
from lagrangia.compile.packages import Packages
from lagrangia.compile.pipeline import read_files
from lagrangia.language.classes import build_class_table
from lagrangia.language.component_library import LIBRARY_PACKAGES, drawn_library, library_package
from lagrangia.language.tree import ClassDefinition
from lagrangia.model import Model
from lagrangia.site.pages import Package, library_title, site

_SHAPE = re.compile(r"<(?:path|line|polyline|polygon|circle|ellipse|rect)\b")
_FOLDER = "package.lag"  # of a package that is a folder
_MARK = "search.js"  # by which a folder is known as a site


def doc_command(options: Namespace) -> int:
    """Writes the pages into a folder, which is new, empty, or was made by this command. Raises LagError."""
    target = Path(options.output)
    if target.exists() and (not target.is_dir() or (any(target.iterdir()) and not (target / _MARK).exists())):
        fail("L0004", f"'{target}' holds something else", None, "choose another folder: -o site")
    own = [_package(Path(file)) for file in options.files]
    table = build_class_table(drawn_library(), [])
    library = [*drawn_library(), *filter(None, map(library_package, LIBRARY_PACKAGES))]
    for file in library[len(drawn_library()) :]:
        table.scopes.take(file)
    components = [Package(library_title(file.source), (file,), table, None) for file in library]
    examples = [_package(file) for file in sorted((data_folder("models") / "examples").glob("*.lag"))]
    target.mkdir(parents=True, exist_ok=True)
    write_text(target / _MARK, "")  # at once: what was ended half way is written anew
    with TemporaryDirectory() as folder, searching_in(list(filter(None, map(_around, options.files)))):
        drawings = _Drawings(Path(folder), {id(c): p.imported for p in own for c in p.classes if p.imported is not None})
        count = 0
        for name, text in site([*own, *components], examples, drawings.draw):
            write_text(target / name, text)
            count += name.endswith(".html")
    print(f"{count} pages written to {target}: open {target / 'index.html'}")
    return 0


def _package(place: Path) -> Package:
    """A file, or a folder with all files of the package that it is. Raises LagError."""
    file = place / _FOLDER if place.is_dir() else place
    syntax, imported = read_files(file)
    packages = Packages(syntax)
    table = build_class_table(drawn_library(), [syntax, *imported], packages.find)
    if file.name == _FOLDER:
        own = ".".join(filter(None, [syntax.within, syntax.classes[0].name]))
        for name in _inside(file.parent, own):
            table.lookup(name, Span(syntax.source, 0, 0))
    is_folder, folder = file.name == _FOLDER, file.resolve().parent
    inside = [read for read in packages.read if is_folder and Path(read.source.name).resolve().is_relative_to(folder)]
    return Package(folder.name if is_folder else file.stem, (syntax, *inside), table, None if is_folder else file.resolve())


def _around(place: str) -> str:
    """The folder in which a package that is a folder is found by its name; "" for a file."""
    file = Path(place, _FOLDER) if Path(place).is_dir() else Path(place)
    if file.name != _FOLDER:
        return ""
    within = read_files(file)[0].within
    return str(file.resolve().parents[1 + len(within.split(".")) if within else 1])


def _inside(folder: Path, package: str) -> Iterator[str]:
    """The full names of what the files and folders of a package are."""
    for place in sorted(folder.iterdir()):
        if place.suffix == ".lag" and place.name != _FOLDER:
            yield f"{package}.{place.stem}"
        elif (place / _FOLDER).is_file():
            yield f"{package}.{place.name}"
            yield from _inside(place, f"{package}.{place.name}")


class _Drawings:
    """Pictures of scenes, by way of a file in a folder of its own. `files` are those of people's own classes."""

    def __init__(self, folder: Path, files: dict[int, Path]) -> None:
        self.folder, self.files = folder, files

    def draw(self, definition: ClassDefinition, scenes: Sequence[str], runs: bool) -> str:
        """The first scene with a picture; "" where there is none."""
        if runs and (drawn := self._drawn(self.files[id(definition)], definition.name)):
            return drawn
        for scene in scenes:
            place = self.folder / "shown.lag"
            write_text(place, scene)
            if drawn := self._drawn(place, None):
                return drawn
        return ""

    @staticmethod
    def _drawn(place: Path, model: str | None) -> str:
        try:
            text = Model(place, model).draw()
        except (LagError, RunError):
            return ""
        return text if _SHAPE.search(text) else ""


