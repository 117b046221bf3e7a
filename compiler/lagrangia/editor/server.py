"""The language server: what an editor asks, answered from the text that is being written (LSP 3.17)."""

import asyncio
import logging
import os
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from lsprotocol import types
from pygls.exceptions import JsonRpcException, JsonRpcInvalidParams
from pygls.lsp.server import LanguageServer
from pygls.uris import to_fs_path

from lagrangia.base.diagnostics import LIBRARY, Diagnostic, LagError, Source
from lagrangia.base.own_python import own_command, own_environment
from lagrangia.base.spelling import plain_text
from lagrangia.base.version import VERSION
from lagrangia.compile.sources import read_source
from lagrangia.editor.changes import fixes, renamed, same
from lagrangia.editor.completion import proposals
from lagrangia.editor.formatting import formatted
from lagrangia.editor.meanings import Index, Occurrence
from lagrangia.editor.outline import MODIFIERS, TOKENS, folds, tokens, units_of_numbers
from lagrangia.editor.protocol import Places, completion_item
from lagrangia.editor.reading import Known, Reading, read_text
from lagrangia.editor.signatures import signature
from lagrangia.editor.telling import told_of
from lagrangia.editor.whole import read_back

_PAUSE = 0.003  # s in which the changes come in that were written while a text was looked at; the last one is looked at
_REST = 0.3  # s without a change after which the next one is looked at at once
_MOST_FILES = 500  # of a folder that are looked through
_LONGEST_LINE = 300  # of what is told of messages that are none
_PATIENCE = 60.0  # s for all phases of a saved text


class Server(LanguageServer):
    """Texts are read when they are asked about, and again when they, or what they import, have changed."""

    def __init__(self) -> None:
        super().__init__("lagrangia", VERSION)
        self.readings: dict[str, Reading] = {}
        self.known = Known()
        self.changes = 0  # of any text
        self.changed_at = -_REST  # s
        self.read_at: dict[str, int] = {}

    @property
    def places(self) -> Places:
        """As the editor counts characters."""
        return Places(str(self.workspace.position_encoding or "utf-16"))

    def path(self, uri: str) -> Path:
        """The file; a text that is in none yet has a name of its own."""
        return Path(os.path.realpath((to_fs_path(uri) or uri.replace(":", "_")).replace("\0", "_")))

    def read(self, path: Path) -> Source:
        """The text that is open in the editor, or the file. Raises LagError."""
        name = os.path.realpath(path)
        for uri, document in self.workspace.text_documents.items():
            if str(self.path(uri)) == name:
                return Source(name, document.source)
        return read_source(Path(name))

    def reading(self, uri: str) -> Reading:
        """What is known of an open text now. Raises JsonRpcInvalidParams where it is none, and no file."""
        if self.read_at.get(uri) != self.changes:
            try:
                self.readings[uri] = read_text(self.path(uri), self.read, self.known)
            except LagError as error:
                raise JsonRpcInvalidParams(error.diagnostics[0].message) from None
            self.read_at[uri] = self.changes
        return self.readings[uri]

    def found(self, uri: str, position: types.Position) -> tuple[Reading, Occurrence | None]:
        """The name at a place."""
        reading = self.reading(uri)
        offset = self.places.offset(reading.source, position)
        return reading, reading.index.at(offset) if reading.index is not None else None

    def files(self, found: Occurrence, here: Reading) -> Iterator[Index]:
        """All texts of the folder that may name what was found: this one, and those in which its name stands."""
        own = here.source.name
        if here.index is not None:
            yield here.index
        folders = [Path(place) for folder in self.workspace.folders.values() if (place := to_fs_path(folder.uri))]
        others = [Path(os.path.realpath(file)) for folder in folders for file in sorted(folder.rglob("*.lag"))[:_MOST_FILES]]
        others += [self.path(uri) for uri in self.workspace.text_documents]
        for path in dict.fromkeys([*others, *map(Path, [found.meaning.place.source.name])]):
            if str(path) == own or str(path).startswith(LIBRARY):
                continue
            with suppress(LagError):
                if found.meaning.name in self.read(path).text and (index := read_text(path, self.read).index) is not None:
                    yield index

    def tell(self, uri: str, more: list[Diagnostic] | None = None) -> None:
        """Sends what is wrong with a text."""
        reading = self.reading(uri)
        wrong = [self.places.diagnostic(found, reading.source) for found in (*reading.diagnostics, *(more or ()))]
        self.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, wrong))


def _is_fault(record: logging.LogRecord) -> bool:
    """Whether it tells of an error of the server: requests that are refused are answered, and nothing is written of them."""
    return not (record.exc_info and isinstance(record.exc_info[1], JsonRpcException))


class _OneLine(logging.Formatter):
    """Of messages that are none, and of faults: LAGRANGIA_TRACEBACK=1 shows where they happened."""

    def format(self, record: logging.LogRecord) -> str:
        if os.environ.get("LAGRANGIA_TRACEBACK"):
            return super().format(record)
        error = record.exc_info[1] if record.exc_info else None
        what = record.getMessage().partition("\n")[0]
        return plain_text(f"{what}{f': {type(error).__name__}: {error}' if error else ''}".partition("\n")[0][:_LONGEST_LINE])


_handler = logging.StreamHandler()
_handler.setFormatter(_OneLine())
for name in ("pygls", "asyncio"):
    logging.getLogger(name).addHandler(_handler)
logging.getLogger("pygls.protocol.json_rpc").addFilter(_is_fault)
server = Server()
Asked = types.TextDocumentPositionParams


@server.feature(types.TEXT_DOCUMENT_DID_OPEN)
def opened(ls: Server, asked: types.DidOpenTextDocumentParams) -> None:
    """Looks at it."""
    ls.changes += 1
    ls.tell(asked.text_document.uri)


@server.feature(types.TEXT_DOCUMENT_DID_CHANGE)
async def changed(ls: Server, asked: types.DidChangeTextDocumentParams) -> None:
    """Looks at it unless it goes on changing."""
    ls.changes = now = ls.changes + 1
    before, ls.changed_at = ls.changed_at, time.monotonic()
    if ls.changed_at - before < _REST:
        await asyncio.sleep(_PAUSE)
    if ls.changes == now:
        ls.tell(asked.text_document.uri)


@server.feature(types.TEXT_DOCUMENT_DID_SAVE)
async def saved(ls: Server, asked: types.DidSaveTextDocumentParams) -> None:
    """Asks all phases of the compiler as well, in a process of their own."""
    uri, now = asked.text_document.uri, ls.changes
    reading = ls.reading(uri)
    if reading.is_part or any(found.severity == "error" for found in reading.diagnostics):
        return
    process = await asyncio.create_subprocess_exec(*own_command("lagrangia.editor.whole"), reading.source.name,
                                                   env=own_environment(), stdout=asyncio.subprocess.PIPE,
                                                   stderr=asyncio.subprocess.DEVNULL)
    try:
        printed, _ = await asyncio.wait_for(process.communicate(), _PATIENCE)
    except TimeoutError:
        process.kill()
        return
    if ls.changes == now and process.returncode == 0:
        ls.tell(uri, read_back(printed.decode(), reading.source))


@server.feature(types.TEXT_DOCUMENT_DID_CLOSE)
def closed(ls: Server, asked: types.DidCloseTextDocumentParams) -> None:
    """Forgets it."""
    ls.changes += 1
    ls.readings.pop(asked.text_document.uri, None)
    ls.known.forget(str(ls.path(asked.text_document.uri)))
    ls.text_document_publish_diagnostics(types.PublishDiagnosticsParams(asked.text_document.uri, []))


@server.feature(types.TEXT_DOCUMENT_COMPLETION, types.CompletionOptions(trigger_characters=[".", "(", "[", ","]))
def completion(ls: Server, asked: types.CompletionParams) -> list[types.CompletionItem]:
    """What may stand there."""
    reading = ls.reading(asked.text_document.uri)
    if reading.index is None:
        return []
    offset = ls.places.offset(reading.source, asked.position)
    return [completion_item(proposal) for proposal in proposals(reading.index, reading.source.text, offset)]


@server.feature(types.TEXT_DOCUMENT_HOVER)
def hover(ls: Server, asked: types.HoverParams) -> types.Hover | None:
    """What is known of a name."""
    reading, found = ls.found(asked.text_document.uri, asked.position)
    if found is None:
        return None
    return types.Hover(types.MarkupContent(types.MarkupKind.Markdown, told_of(reading, found)), ls.places.range(found.span))


@server.feature(types.TEXT_DOCUMENT_SIGNATURE_HELP, types.SignatureHelpOptions(trigger_characters=["(", ","]))
def signature_help(ls: Server, asked: types.SignatureHelpParams) -> types.SignatureHelp | None:
    """What goes into the open brackets."""
    reading = ls.reading(asked.text_document.uri)
    index, offset = reading.index, ls.places.offset(reading.source, asked.position)
    shown = signature(index, reading.source.text, offset) if index is not None else None
    if shown is None:
        return None
    parameters = [types.ParameterInformation(name, about) for name, about in shown.parameters]
    one = types.SignatureInformation(shown.label, shown.about, parameters, active_parameter=shown.active)
    return types.SignatureHelp([one], active_signature=0, active_parameter=shown.active)


@server.feature(types.TEXT_DOCUMENT_DEFINITION)
def definition(ls: Server, asked: types.DefinitionParams) -> types.Location | None:
    """Where it is declared, also in the library."""
    _, found = ls.found(asked.text_document.uri, asked.position)
    return ls.places.location(found.meaning.place) if found is not None else None


@server.feature(types.TEXT_DOCUMENT_REFERENCES)
def references(ls: Server, asked: types.ReferenceParams) -> list[types.Location]:
    """Where it is named, in all texts of the folder."""
    reading, found = ls.found(asked.text_document.uri, asked.position)
    if found is None:
        return []
    places = [one.span for index in ls.files(found, reading) for one in same(index, found.meaning.key)]
    own = found.meaning.place
    return [ls.places.location(span) for span in places
            if asked.context.include_declaration or (span.source.name, span.start) != (own.source.name, own.start)]


@server.feature(types.TEXT_DOCUMENT_PREPARE_RENAME)
def prepare_rename(ls: Server, asked: types.PrepareRenameParams) -> types.Range | None:
    """The name, where it is not the library's."""
    _, found = ls.found(asked.text_document.uri, asked.position)
    if found is None or found.meaning.place.source.name.startswith(LIBRARY):
        return None
    return ls.places.range(found.span)


@server.feature(types.TEXT_DOCUMENT_RENAME, types.RenameOptions(prepare_provider=True))
def rename(ls: Server, asked: types.RenameParams) -> types.WorkspaceEdit | None:
    """The same with another name, everywhere."""
    reading, found = ls.found(asked.text_document.uri, asked.position)
    if found is None:
        return None
    try:
        return ls.places.edits(renamed(found, asked.new_name, ls.files(found, reading)))
    except LagError as error:
        raise JsonRpcInvalidParams(error.diagnostics[0].message) from None


@server.feature(types.TEXT_DOCUMENT_DOCUMENT_SYMBOL)
def symbols(ls: Server, asked: types.DocumentSymbolParams) -> list[types.DocumentSymbol]:
    """Classes, and what they declare."""
    index = ls.reading(asked.text_document.uri).index
    return [ls.places.symbol(definition) for definition in index.syntax.classes] if index is not None else []


@server.feature(types.TEXT_DOCUMENT_CODE_ACTION, types.CodeActionOptions([types.CodeActionKind.QuickFix]))
def actions(ls: Server, asked: types.CodeActionParams) -> list[types.CodeAction]:
    """What the hints of diagnostics propose."""
    uri = asked.text_document.uri
    reading = ls.reading(uri)
    first, last = (ls.places.offset(reading.source, position) for position in (asked.range.start, asked.range.end))
    proposed = []
    for found in reading.diagnostics:
        place = found.span
        if place is None or place.source.name != reading.source.name or place.end < first or place.start > last:
            continue
        told = ls.places.diagnostic(found, reading.source)
        proposed += [types.CodeAction(title, types.CodeActionKind.QuickFix, [told], True, edit=ls.places.edits([change]))
                     for title, change in fixes(found)]
    return proposed


@server.feature(types.TEXT_DOCUMENT_INLAY_HINT)
def hints(ls: Server, asked: types.InlayHintParams) -> list[types.InlayHint]:
    """The units that bare numbers take."""
    reading = ls.reading(asked.text_document.uri)
    if reading.index is None:
        return []
    first, last = (ls.places.offset(reading.source, position) for position in (asked.range.start, asked.range.end))
    return [types.InlayHint(ls.places.position(reading.source, offset), unit, padding_left=True)
            for offset, unit in units_of_numbers(reading.index) if first <= offset <= last]


@server.feature(types.TEXT_DOCUMENT_FOLDING_RANGE)
def folding(ls: Server, asked: types.FoldingRangeParams) -> list[types.FoldingRange]:
    """Classes, sections, blocks, comments."""
    reading = ls.reading(asked.text_document.uri)
    if reading.index is None:
        return []
    ranges = [ls.places.range(span) for span in folds(reading.index)]
    return [types.FoldingRange(one.start.line, one.end.line) for one in ranges]


@server.feature(types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL, types.SemanticTokensLegend(list(TOKENS), list(MODIFIERS)))
def semantic_tokens(ls: Server, asked: types.SemanticTokensParams) -> types.SemanticTokens:
    """Names, by what they stand for."""
    index = ls.reading(asked.text_document.uri).index
    return types.SemanticTokens(ls.places.tokens(index.syntax.source, tokens(index)) if index is not None else [])


@server.feature(types.TEXT_DOCUMENT_FORMATTING)
def formatting(ls: Server, asked: types.DocumentFormattingParams) -> list[types.TextEdit]:
    """The one layout; nothing where the text is wrong."""
    source = ls.reading(asked.text_document.uri).source
    try:
        text = formatted(source)
    except LagError:
        return []
    end = ls.places.position(source, len(source.text))
    return [types.TextEdit(types.Range(types.Position(0, 0), end), text)] if text != source.text else []
