"""`lag doc`: the library and people's own files as a site to be read."""

import re
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from lagrangia.base.diagnostics import LagError, RunError, fail
from lagrangia.base.folders import data_folder
from lagrangia.base.result_files import write_text
from lagrangia.compile.pipeline import read_files
from lagrangia.language.classes import build_class_table
from lagrangia.language.component_library import drawn_library
from lagrangia.language.tree import ClassDefinition
from lagrangia.model import Model
from lagrangia.site.pages import Package, library_title, site

_SHAPE = re.compile(r"<(?:path|line|polyline|polygon|circle|ellipse|rect)\b")
_MARK = "search.js"  # by which a folder is known as a site


def doc_command(options: Namespace) -> int:
    """Writes the pages into a folder, which is new, empty, or was made by this command. Raises LagError L0004."""
    target = Path(options.output)
    if target.exists() and (not target.is_dir() or (any(target.iterdir()) and not (target / _MARK).exists())):
        fail("L0004", f"'{target}' holds something else", None, "choose another folder: -o site")
    own = [_package(Path(file)) for file in options.files]
    table = build_class_table(drawn_library(), [])
    packages = [*own, *(Package(library_title(file.source), file, table, None) for file in drawn_library())]
    examples = [read_files(file)[0] for file in sorted((data_folder("models") / "examples").glob("*.lag"))]
    users = [*(package.syntax for package in packages), *examples]
    target.mkdir(parents=True, exist_ok=True)
    with TemporaryDirectory() as folder:
        drawings = _Drawings(Path(folder), {id(c): p.imported for p in own for c in p.syntax.classes if p.imported is not None})
        count = 0
        for name, text in site(packages, users, drawings.draw):
            write_text(target / name, text)
            count += name.endswith(".html")
    print(f"{count} pages written to {target}: open {target / 'index.html'}")
    return 0


def _package(file: Path) -> Package:
    syntax, imported = read_files(file)
    return Package(file.stem, syntax, build_class_table(drawn_library(), [syntax, *imported]), file.resolve())


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


