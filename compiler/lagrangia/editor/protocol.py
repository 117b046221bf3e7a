"""What this package knows, in the words of the language server protocol (LSP 3.17): places, diagnostics, proposals, tokens."""

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from lsprotocol import types
from pygls.uris import from_fs_path

from lagrangia.base.diagnostics import LIBRARY, Diagnostic, Source, Span
from lagrangia.base.folders import data_folder
from lagrangia.editor.changes import Change
from lagrangia.editor.completion import Proposal
from lagrangia.editor.outline import MODIFIERS, TOKENS, Token
from lagrangia.language.tree import ClassDefinition, Declaration

_HALVES = re.compile("[\ud800-\udfff]")
_SEVERITIES = {"error": types.DiagnosticSeverity.Error, "warning": types.DiagnosticSeverity.Warning,
               "note": types.DiagnosticSeverity.Information}
_SYMBOLS = {"function": types.SymbolKind.Function, "package": types.SymbolKind.Package, "record": types.SymbolKind.Struct,
            "enumeration": types.SymbolKind.Enum, "connector": types.SymbolKind.Interface}
_KINDS = {"class": types.CompletionItemKind.Class, "type": types.CompletionItemKind.Struct,
          "function": types.CompletionItemKind.Function, "variable": types.CompletionItemKind.Variable,
          "port": types.CompletionItemKind.Interface, "property": types.CompletionItemKind.Property,
          "keyword": types.CompletionItemKind.Keyword, "unit": types.CompletionItemKind.Unit}


class Places:
    """Characters of texts as an editor counts them: in units of UTF-16, unless it asked for others."""

    def __init__(self, encoding: str) -> None:
        self.bytes_a_unit = {"utf-8": 1, "utf-32": 4}.get(encoding, 2)
        self.codec = {"utf-8": "utf-8", "utf-32": "utf-32-le"}.get(encoding, "utf-16-le")

    def position(self, source: Source, offset: int) -> types.Position:
        """Of a character of a text."""
        line, column = source.line_and_column(offset)
        before = source.text[offset - column + 1 : offset]
        return types.Position(line - 1, len(self._encoded(before)) // self.bytes_a_unit)

    def offset(self, source: Source, position: types.Position) -> int:
        """Of the character at a position; the end of the line, or of the text, for what is beyond."""
        lines = source.text.split("\n")
        if position.line >= len(lines):
            return len(source.text)
        start = sum(len(line) + 1 for line in lines[: position.line])
        before = self._encoded(lines[position.line])[: position.character * self.bytes_a_unit]
        return start + len(before.decode(self.codec, errors="ignore"))

    def _encoded(self, text: str) -> bytes:
        """Halves of letters (surrogates without the other half) count as the sign that stands for what is none, U+FFFD."""
        return _HALVES.sub("\ufffd", text).encode(self.codec)

    def range(self, span: Span) -> types.Range:
        """Of a piece of a text."""
        return types.Range(self.position(span.source, span.start), self.position(span.source, span.end))

    def location(self, span: Span) -> types.Location:
        """Of a piece of a file, also of the library."""
        return types.Location(uri_of(span.source), self.range(span))

    def diagnostic(self, found: Diagnostic, source: Source) -> types.Diagnostic:
        """What is told of another file, or of none, stands at the begin of this one."""
        is_here = found.span is not None and found.span.source.name == source.name
        place = found.span if is_here and found.span is not None else Span(source, 0, 0)
        elsewhere = f"{found.span}: " if found.span is not None and not is_here else ""
        label = f" ({found.label})" if found.label else ""
        text = "\n".join([f"{elsewhere}{found.message}{label}", *found.hints])
        severity = _SEVERITIES[found.severity]
        return types.Diagnostic(self.range(place), text, severity=severity, code=found.code, source="lagrangia")

    def edits(self, changes: Iterable[Change]) -> types.WorkspaceEdit:
        """Of all files."""
        found: dict[str, list[types.TextEdit]] = {}
        for change in changes:
            found.setdefault(uri_of(change.span.source), []).append(types.TextEdit(self.range(change.span), change.text))
        return types.WorkspaceEdit(changes=found)

    def tokens(self, source: Source, found: Sequence[Token]) -> list[int]:
        """Five numbers each, places from one to the next."""
        data: list[int] = []
        line = column = 0
        for token in found:
            if token.span.source is not source:
                continue
            start, end = self.position(source, token.span.start), self.position(source, token.span.end)
            modifiers = sum(1 << MODIFIERS.index(modifier) for modifier in token.modifiers)
            data += [start.line - line, start.character - (column if start.line == line else 0), end.character - start.character,
                     TOKENS.index(token.kind), modifiers]
            line, column = start.line, start.character
        return data

    def symbol(self, node: ClassDefinition | Declaration) -> types.DocumentSymbol:
        """A class with what it declares, and the classes in it."""
        if isinstance(node, Declaration):
            is_fixed = {"parameter", "constant"} & node.prefixes
            kind = types.SymbolKind.Constant if is_fixed else types.SymbolKind.Variable
            return types.DocumentSymbol(node.name, kind, self.range(node.span), self.range(node.name_span), detail=node.type_name)
        kind = _SYMBOLS.get("enumeration" if node.literals else node.kind, types.SymbolKind.Class)
        inside = [self.symbol(element) for element in node.elements if isinstance(element, Declaration)]
        inside += [types.DocumentSymbol(literal.name, types.SymbolKind.EnumMember, place := self.range(literal.span), place,
                                        detail=literal.description) for literal in node.literals]
        inside += [self.symbol(definition) for definition in node.classes]
        return types.DocumentSymbol(node.name, kind, self.range(node.span), self.range(node.name_span), detail=node.description,
                                    children=inside)


def uri_of(source: Source) -> str:
    """Of a file by the name of its text; the library's are where it is installed."""
    is_shipped = source.name.startswith(LIBRARY)
    path = data_folder("models") / "library" / source.name[len(LIBRARY) :] if is_shipped else Path(source.name)
    return from_fs_path(str(path)) or ""


def completion_item(proposal: Proposal) -> types.CompletionItem:
    """With what it is about."""
    return types.CompletionItem(proposal.label, kind=_KINDS[proposal.kind], detail=proposal.detail or None,
                                documentation=proposal.about or None)
