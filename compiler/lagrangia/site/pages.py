"""Classes of files -> pages: text, schematic, parameters with units and defaults, ports, energies and equations, uses, source."""

import html
import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from textwrap import dedent

from lagrangia.base.diagnostics import LIBRARY, Source
from lagrangia.base.records import dataclass
from lagrangia.base.spelling import plain_text
from lagrangia.editor.meanings import Index, class_named
from lagrangia.editor.telling import unit_of
from lagrangia.editor.words import COMMENT, pieces_of
from lagrangia.language.classes import ClassTable
from lagrangia.language.scoping import lifted
from lagrangia.language.tree import ClassDefinition, Declaration, Syntax
from lagrangia.site.formulas import formula
from lagrangia.site.showing import FLANGES, scenes_of

Draw = Callable[[ClassDefinition, Sequence[str], bool], str]  # of the first of these scenes that can be drawn, or itself
_HERE = Path(__file__).parent
_NO_NAME, _LONGEST = re.compile(r"[^\w.]+"), 150
_LIBRARY_TITLE = "library"
_ROLES = ("parameter", "constant", "input", "output", "coordinate")


@dataclass(frozen=True)
class Package:
    """Files with their classes and what is known of others; `imported` is the place of a single
    file, None where its classes are found by their names."""

    title: str
    files: tuple[Syntax, ...]
    table: ClassTable
    imported: Path | None

    def page(self, definition: ClassDefinition) -> str:
        """The file of one of its classes; names in quotes, which may say anything, lead nowhere else."""
        name = _NO_NAME.sub("_", definition.name)[:_LONGEST]
        unlike = "" if name == definition.name else f"_{sha256(definition.name.encode()).hexdigest()[:8]}"
        return f"{self.title.replace('/', '.')}.{name}{unlike}.html"

    @cached_property
    def classes(self) -> tuple[ClassDefinition, ...]:
        """Those that stand in others, too, by their full names."""
        return tuple(definition for syntax in self.files for definition in lifted(syntax))


def site(packages: Sequence[Package], users: Sequence[Package], draw: Draw) -> Iterator[tuple[str, str]]:
    """Names of files with what they hold. `users` have no pages, but use what has; `draw` draws a scene."""
    writer = _Writer(packages, users, draw)
    for package in packages:
        for definition in package.classes:
            yield package.page(definition), writer.page(package, definition)
    yield "index.html", writer.index()
    entries = [{"name": d.name, "about": d.description, "page": p.page(d)} for p in packages for d in p.classes]
    search = (_HERE / "search.js").read_text(encoding="utf-8")
    yield "search.js", f"const ENTRIES = {json.dumps(entries, ensure_ascii=False)};\n{search}"
    yield "site.css", (_HERE / "site.css").read_text(encoding="utf-8")


class _Writer:
    def __init__(self, packages: Sequence[Package], users: Sequence[Package], draw: Draw) -> None:
        self.packages, self.draw = packages, draw
        self.users = _users([*packages, *users])
        self.pages = {_key(d): package.page(d) for package in packages for d in package.classes}

    def index(self) -> str:
        parts = ["<h1>Lagrangia <small>components</small></h1>"]
        for package in self.packages:
            rows = "".join(f"<tr><td>{self._link(d, d.name)}</td><td>{escape(d.kind)}</td><td>{escape(d.description)}</td></tr>"
                           for d in package.classes)
            parts.append(f"<h2>{escape(package.title)}</h2><div class=wide><table>{rows}</table></div>")
        return _page("Lagrangia", "\n".join(parts))

    def page(self, package: Package, definition: ClassDefinition) -> str:
        """Of one class."""
        index = Index(Syntax(definition.name_span.source, (), ()), package.table)
        members = index.members(definition)
        kind = f"{'partial ' if definition.is_partial else ''}{definition.kind}"
        parts = [f"<h1>{escape(definition.name)} <small>{kind}, in {escape(package.title)}</small></h1>",
                 f"<p>{escape(definition.description)}</p>", self._figure(package, definition, members)]
        parts += [self._table(package, title, rows) for title, rows in _grouped(package.table, members) if rows]
        parts += self._formulas(package, definition)
        parts.append(self._inside(definition))
        parts.append(self._uses(definition))
        parts.append(f"<h2>Source</h2>{self._source(package, definition)}")
        return _page(definition.name, "\n".join(filter(None, parts)))

    def _figure(self, package: Package, definition: ClassDefinition, members: Mapping[str, Declaration]) -> str:
        if definition.kind != "model" or definition.is_partial:
            return ""
        runs = definition is package.classes[-1] and package.imported is not None
        types = {name for name, kind in {**package.table.library, **package.table.user}.items() if kind.kind == "type"}
        flanges = {name: kind for name, d in members.items() if (kind := self._flange(package, d))}
        scenes = list(scenes_of(definition, members, {*types, "Real", "Integer"}, flanges, package.imported))
        drawn = self.draw(definition, scenes, runs)
        return f"<figure>{drawn}</figure>" if drawn else ""

    @staticmethod
    def _flange(package: Package, port: Declaration) -> str:
        """Its class, if it always is a flange; "" for anything else."""
        kind = class_named(package.table, port.type_name, port.type_span)
        is_flange = kind is not None and kind.name in FLANGES and port.condition is None and not port.dimensions
        return kind.name if kind is not None and is_flange else ""

    def _table(self, package: Package, title: str, rows: Sequence[Declaration]) -> str:
        is_ports = title == "Ports"
        head = "".join(f"<th>{word}</th>" for word in (("", "", "") if is_ports else ("name", "type", "unit", "default", "")))
        lines = []
        for row in rows:
            value = "" if row.binding is None else f"<code>{escape(' '.join(row.binding.span.text.split()))}</code>"
            sizes = f"[{', '.join(d.span.text for d in row.dimensions)}]" if row.dimensions else ""
            cells = [f"<code>{escape(row.name)}{escape(sizes)}</code>"]
            cells.append(self._type(package, row))
            if not is_ports:
                cells += [escape(unit_of(package.table, row)), value]
            cells.append(escape(row.description))
            lines.append("<tr>" + "".join(f"<td>{cell}</td>" for cell in cells) + "</tr>")
        return f"<h2>{title}</h2><div class=wide><table><tr>{head}</tr>{''.join(lines)}</table></div>"

    def _type(self, package: Package, row: Declaration) -> str:
        kind = class_named(package.table, row.type_name, row.type_span)
        return self._link(kind, row.type_name) if kind is not None else escape(row.type_name)

    def _formulas(self, package: Package, definition: ClassDefinition) -> Iterator[str]:
        """Of the class and all that it extends."""
        lineage = package.table.lineage(definition)
        for title, kind in (("Energies", "energy"), ("Equations", "equation")):
            found = [text for one in lineage for section in one.sections if section.kind == kind
                     for clause in section.clauses if (text := formula(clause))]
            if found:
                yield f"<h2>{title}</h2><div class=wide>{''.join(found)}</div>"

    def _inside(self, definition: ClassDefinition) -> str:
        rows = "".join(f"<tr><td>{self._link(c, c.name)}</td><td>{escape(c.kind)}</td><td>{escape(c.description)}</td></tr>"
                       for c in definition.classes)
        return f"<h2>Classes</h2><div class=wide><table>{rows}</table></div>" if rows else ""

    def _uses(self, definition: ClassDefinition) -> str:
        links = [self._link(other, other.name) for other in self.users.get(_key(definition), ())]
        return f"<h2>Used by</h2><p>{', '.join(dict.fromkeys(links))}</p>" if links else ""

    def _link(self, definition: ClassDefinition, name: str) -> str:
        page = self.pages.get(_key(definition))
        return f'<a href="{escape(page)}">{escape(name)}</a>' if page is not None else escape(name)

    def _source(self, package: Package, definition: ClassDefinition) -> str:
        """Its text, coloured, with links to the classes that it names."""
        span = definition.span
        before = span.source.text[: span.start].rpartition("\n")[2]
        text = dedent(before + span.text) if before.isspace() else span.text
        written, at, name = [], 0, ""
        for piece in pieces_of(Source(package.title, text)):
            name = f"{name}{piece.text}" if piece.text == "." or name.endswith(".") else piece.text  # dotted, as far as it goes
            written.append(escape(text[at : piece.start]))
            at = piece.start + len(piece.text)
            shown = escape(piece.text)
            kind = class_named(package.table, name, definition.name_span) if piece.kind == "NAME" else None
            if kind is not None and _key(kind) != _key(definition) and _key(kind) in self.pages:
                shown = self._link(kind, piece.text)
            elif mark := "c" if piece.kind == COMMENT else "s" if piece.kind == "STRING" else \
                    "w" if piece.kind != "NAME" and piece.text.isalpha() else "":
                shown = f"<span class={mark}>{shown}</span>"
            written.append(shown)
        return f"<pre>{''.join(written)}{escape(text[at:])}</pre>"


def escape(text: str) -> str:
    """A model's text as HTML, with signs that command a terminal by their codes: HTML may not hold them."""
    return html.escape(plain_text(text))


def _key(definition: ClassDefinition) -> tuple[str, int]:
    """Where it is defined: the same for the same class, in whichever reading of its file."""
    return definition.name_span.source.name, definition.name_span.start


def _users(packages: Sequence[Package]) -> Mapping[tuple[str, int], list[ClassDefinition]]:
    """By the classes, those that have a component of them, or extend them."""
    found: dict[tuple[str, int], list[ClassDefinition]] = {}
    for package in packages:
        for definition in package.classes:
            for element in definition.elements:
                used = class_named(package.table, element.type_name, element.span)
                if used is not None and _key(used) != _key(definition):
                    found.setdefault(_key(used), []).append(definition)
    return found


def _grouped(table: ClassTable, members: Mapping[str, Declaration]) -> Iterator[tuple[str, list[Declaration]]]:
    """By what they are, those that only the class itself may name left out."""
    seen = [d for d in members.values() if "protected" not in d.prefixes]
    ports = [d for d in seen if _is_port(table, d)]
    yield "Parameters", [d for d in seen if {"parameter", "constant"} & d.prefixes]
    yield "Ports", ports
    yield "Inputs and outputs", [d for d in seen if {"input", "output"} & d.prefixes]
    yield "Coordinates", [d for d in seen if "coordinate" in d.prefixes]
    yield "Variables and components", [d for d in seen if not {*_ROLES} & d.prefixes and d not in ports]


def _is_port(table: ClassTable, declaration: Declaration) -> bool:
    """A frame that is given, or an end of a shaft."""
    kind = class_named(table, declaration.type_name, declaration.type_span)
    return declaration.binding is None and (declaration.type_name == "Frame" or (kind is not None and kind.kind == "connector"))


def _page(title: str, body: str) -> str:
    return (f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            f'<meta name="viewport" content="width=device-width, initial-scale=1">\n<title>{escape(title)}</title>\n'
            f'<link rel="stylesheet" href="site.css">\n</head>\n<body>\n<nav><a href="index.html">all components</a>'
            f'<input id="search" type="search" placeholder="search" aria-label="search" autocomplete="off">'
            f'<div id="found"></div></nav>\n'
            f'{body}\n<script src="search.js"></script>\n</body>\n</html>\n')


def library_title(source: Source) -> str:
    """Of a file of the library: library/springs."""
    return f"{_LIBRARY_TITLE}/{source.name.removeprefix(LIBRARY).removesuffix('.lag')}"
