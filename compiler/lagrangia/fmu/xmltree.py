"""An XML file of an FMU -> its elements, each with its place in the text, so that faults can be pointed at."""

import codecs
import re
from collections.abc import Iterator, Mapping
from dataclasses import field
from xml.parsers import expat

from lagrangia.base.diagnostics import Diagnostic, Severity, Source, Span, fail
from lagrangia.base.records import dataclass

_START_TAG = re.compile(r"""<[^"'>]*(?:"[^"]*"[^"'>]*|'[^']*'[^"'>]*)*>?""")
_BYTE_ORDER_MARKS = ((codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))
_DEEPEST = 250
_DECLARED = re.compile(rb"""^<\?xml[^>]*encoding\s*=\s*["']([A-Za-z0-9._-]+)["']""")


@dataclass(frozen=True, eq=False)
class Element:
    """`start` is where its tag begins in the text."""

    tag: str
    attributes: Mapping[str, str]
    source: Source
    start: int
    children: list["Element"] = field(default_factory=list)

    def all(self, *path: str) -> Iterator["Element"]:
        """Those under a path of tags; "*" stands for any tag."""
        if not path:
            yield self
        else:
            for child in self.children:
                if path[0] in ("*", child.tag):
                    yield from child.all(*path[1:])

    def first(self, *path: str) -> "Element | None":
        """The first element below, by a path of names; None where there is none."""
        return next(self.all(*path), None)

    def get(self, name: str) -> str | None:
        """An attribute as it is written; None where it is not there."""
        return self.attributes.get(name)

    def span(self, attribute: str = "") -> Span:
        """Of the value of an attribute; of the tag's name where there is none of this name."""
        match = _START_TAG.match(self.source.text, self.start)
        end = match.end() if match else self.start + 1 + len(self.tag)
        if attribute:
            pattern = re.compile(rf"""\s{re.escape(attribute)}\s*=\s*("[^"]*"|'[^']*')""")
            if found := pattern.search(self.source.text, self.start, end):
                return Span(self.source, found.start(1), found.end(1))
        return Span(self.source, self.start, min(end, self.start + 1 + len(self.tag)))

    def fault(self, code: str, message: str, attribute: str = "", *hints: str, severity: Severity = "error") -> Diagnostic:
        """A diagnostic that points at the element, or at one of its attributes."""
        return Diagnostic(severity, code, message, self.span(attribute), "", hints)


def read_xml(name: str, content: bytes) -> Element:
    """The root. `name` is what people call the file. Raises LagError L0730 for what is no XML, or has a document type: entities
    that unfold to gigabytes come with one, and neither FMI nor URDF nor MJCF has any."""
    source = Source(name, _decoded(name, content))
    builder = _Builder(source)
    parser = expat.ParserCreate("utf-8")
    parser.buffer_text = True
    parser.StartElementHandler = builder.open
    parser.EndElementHandler = builder.close
    parser.StartDoctypeDeclHandler = builder.refuse
    builder.parser = parser
    try:
        parser.Parse(builder.content, True)
    except expat.ExpatError as error:
        if builder.root is None:  # any text: nothing of it is shown
            fail("L0730", f"'{name}' is no XML: {expat.ErrorString(error.code)} in line {error.lineno}")
        offset = _offset(source.text, error.lineno, error.offset)
        fail("L0730", f"this is no XML: {expat.ErrorString(error.code)}", Span(source, offset, offset + 1))
    assert builder.root is not None
    return builder.root


class _Builder:
    def __init__(self, source: Source) -> None:
        self.source = source
        self.content = source.text.encode()
        self.parser: expat.XMLParserType | None = None
        self.root: Element | None = None
        self.open_elements: list[Element] = []
        self.at = (0, 0)  # a byte and its character

    def open(self, tag: str, attributes: dict[str, str]) -> None:
        element = Element(tag, attributes, self.source, self._place())
        if len(self.open_elements) >= _DEEPEST:
            fail("L0730", f"not supported yet: elements more than {_DEEPEST} deep in each other", element.span())
        if self.open_elements:
            self.open_elements[-1].children.append(element)
        else:
            self.root = element
        self.open_elements.append(element)

    def close(self, tag: str) -> None:
        self.open_elements.pop()

    def refuse(self, *declaration: object) -> None:
        offset = self._place()
        fail("L0730", "document types and entities are not read", Span(self.source, offset, offset + 1))

    def _place(self) -> int:
        """The character at which the parser is; bytes are counted on from the last one."""
        assert self.parser is not None
        byte, character = self.at
        now = self.parser.CurrentByteIndex
        self.at = now, character + len(self.content[byte:now].decode(errors="replace"))
        return self.at[1]


def _decoded(name: str, content: bytes) -> str:
    encoding = next((known for mark, known in _BYTE_ORDER_MARKS if content.startswith(mark)), None)
    if encoding is None:
        declared = _DECLARED.match(content)
        encoding = declared[1].decode() if declared else "utf-8"
    try:
        return content.decode(encoding)
    except (LookupError, UnicodeError):
        fail("L0730", f"'{name}' is not the text in {encoding} that it says it is")


def _offset(text: str, line: int, column: int) -> int:
    """Of a one-based line and a zero-based column."""
    start = 0
    for _ in range(line - 1):
        start = text.find("\n", start) + 1
    return min(len(text), start + column)
