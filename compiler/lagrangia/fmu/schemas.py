"""Rules for the XML files beside the model description: the schemas of the standard, which FMPy brings, and the manifests of
layered standards (FMI 3.0.2, 2.5 and 2.6). FMI 2 has taken these files over from FMI 3, with its schemas."""

import re
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path, PurePosixPath

from lagrangia.base.diagnostics import Diagnostic, LagError, Span
from lagrangia.fmu.archive import Archive
from lagrangia.fmu.xmltree import Element

SCHEMA = "L0728"
_SCHEMAS = {"sources/buildDescription.xml": "fmi3BuildDescription.xsd",
            "terminalsAndIcons/terminalsAndIcons.xml": "fmi3TerminalsAndIcons.xsd"}
_MANIFEST = "fmi-ls-manifest.xml"
_MANIFESTS = "http://fmi-standard.org/fmi-ls-manifest"  # their namespace
_STATED = ("fmi-ls-name", "fmi-ls-version", "fmi-ls-description")
_MOST = 20  # faults of one file


def schema_rules(archive: Archive) -> Iterator[Diagnostic]:
    """Files that are no XML are told of where they are read."""
    for name, schema in _SCHEMAS.items():
        if name in archive.names and (root := _read(archive, name)) is not None:
            yield from _invalid(root, schema)
    for name in sorted(archive.names):
        if name.startswith("extra/") and PurePosixPath(name).name == _MANIFEST:
            yield from _manifest_rules(archive, name)


def _read(archive: Archive, name: str) -> Element | None:
    try:
        return archive.read_xml(name)
    except LagError:
        return None


def _invalid(root: Element, schema: str) -> Iterator[Diagnostic]:
    """What the schema says, each at its line."""
    from lxml import etree

    spec = find_spec("fmpy")
    if spec is None or not spec.submodule_search_locations:
        return
    file = Path(spec.submodule_search_locations[0]) / "schema" / "fmi3" / schema
    if not file.is_file():  # other versions of FMPy
        return
    parser = etree.XMLParser(resolve_entities=False, no_network=True)
    document = etree.fromstring(_without_declaration(root.source.text).encode(), parser)
    checker = etree.XMLSchema(etree.parse(str(file)))
    if not checker.validate(document):
        for entry in list(checker.error_log)[:_MOST]:
            yield Diagnostic("error", SCHEMA, entry.message, _line(root, entry.line), "",
                             (f"{schema} of FMI 3.0 says so, for FMUs of version 2 too",))


def _without_declaration(text: str) -> str:
    """Blank in its place: the text is decoded already, whatever it says of its encoding."""
    return re.sub(r"\A\ufeff?<\?xml.*?\?>", lambda found: " " * len(found[0]), text, flags=re.DOTALL)


def _line(root: Element, line: int) -> Span:
    text, start = root.source.text, 0
    for _ in range(line - 1):
        start = text.find("\n", start) + 1
    end = text.find("\n", start)
    whole = text[start : end if end >= 0 else len(text)]
    return Span(root.source, start + len(whole) - len(whole.lstrip()), start + len(whole.rstrip()))


def _manifest_rules(archive: Archive, name: str) -> Iterator[Diagnostic]:
    try:
        root = archive.read_xml(name)
    except LagError as error:
        yield from error.diagnostics
        return
    parted = {key.partition(":")[::2]: value for key, value in root.attributes.items()}
    prefixes = {name for (prefix, name), value in parted.items() if prefix == "xmlns" and value == _MANIFESTS}
    stated = {name: value for (prefix, name), value in parted.items() if prefix in prefixes}
    for attribute in _STATED:
        if attribute not in stated:
            yield root.fault(SCHEMA, f"the manifest has no {attribute}", "",
                             f"it is an attribute of the root, in the namespace {_MANIFESTS}")
    folder = PurePosixPath(name).parent.relative_to("extra").as_posix()
    if stated.get("fmi-ls-name", folder) != folder:
        yield root.fault(SCHEMA, f"the manifest of '{stated['fmi-ls-name']}' lies in the folder of '{folder}'",
                         severity="warning")
