"""An FMU as an archive: opened with care, and the rules for what is in it (ZIP; FMI 2.0.5, 2.3; FMI 3.0.2, 2.5)."""

import stat
import struct
import zipfile
import zlib
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path, PurePosixPath

from lagrangia.base.diagnostics import Diagnostic, Severity, fail
from lagrangia.base.records import dataclass
from lagrangia.base.result_files import require_file
from lagrangia.fmu.xmltree import Element, read_xml

DESCRIPTION = "modelDescription.xml"
_LARGEST_TEXT = 256 << 20  # bytes
_LARGEST_WHOLE = 4 << 30
_SUSPICIOUS = 1000  # unpacked over packed, of archives that unpack to more than _LARGEST_TEXT
_NEWEST = 20  # version needed to extract: directories, deflate
_BROKEN = (zipfile.BadZipFile, NotImplementedError, RuntimeError, ValueError, EOFError, OverflowError, struct.error, zlib.error)


@dataclass(frozen=True, eq=False)
class Archive:
    """An open FMU, read member by member."""

    path: Path
    opened: zipfile.ZipFile

    @cached_property
    def entries(self) -> list[zipfile.ZipInfo]:
        """The directory of the archive."""
        return self.opened.infolist()

    @cached_property
    def names(self) -> frozenset[str]:
        """Of files, as they are written in the archive."""
        return frozenset(entry.orig_filename for entry in self.entries if not entry.orig_filename.endswith("/"))

    def read(self, name: str, most: int = _LARGEST_TEXT) -> bytes:
        """Raises LagError L0731 for what is damaged, encrypted or too large."""
        try:
            with self.opened.open(name) as stream:
                content = stream.read(most + 1)
        except (*_BROKEN, KeyError, OSError) as error:
            fail("L0731", f"'{name}' in {self.path} cannot be read: {error}")
        if len(content) > most:
            fail("L0731", f"'{name}' in {self.path} is larger than {most >> 20} MB")
        return content

    def read_xml(self, name: str) -> Element:
        """Raises LagError."""
        return read_xml(f"{self.path}/{name}", self.read(name))

    def extract(self, folder: Path) -> None:
        """All of it. Raises LagError L0731 for what cannot be unpacked, or should not be."""
        for diagnostic in _dangers(self):
            fail(diagnostic.code, diagnostic.message, None, *diagnostic.hints)
        try:
            self.opened.extractall(folder)
        except (*_BROKEN, OSError) as error:
            fail("L0731", f"{self.path} cannot be unpacked: {error}")


def open_archive(path: Path) -> Archive:
    """Raises LagError L0001 for a file that cannot be read, L0730 for one that is no FMU."""
    if path.is_dir():
        fail("L0730", f"'{path}' is a folder", None, "an FMU is a ZIP archive; pack what is in the folder")
    try:
        require_file(path)
        archive = Archive(path, zipfile.ZipFile(path))
        names = archive.names
    except OSError as error:
        fail("L0001", f"'{path}' cannot be read: {error.strerror}" if path.exists() else f"there is no file '{path}'")
    except _BROKEN as error:
        empty = path.stat().st_size == 0
        fail("L0730", f"'{path}' is no FMU: " + ("it is empty" if empty else f"it is no ZIP archive that can be read ({error})"))
    if DESCRIPTION not in names:
        inside = sorted(name for name in names if PurePosixPath(name.replace("\\", "/")).name == DESCRIPTION)
        fail("L0730", f"'{path}' is no FMU: there is no {DESCRIPTION} at its top", None,
             *([f"it has {inside[0]}: pack what is in that folder, not the folder"] if inside else []))
    return archive


def archive_rules(archive: Archive) -> Iterator[Diagnostic]:
    """What importers with ZIP readers of their own, on other systems, stumble over."""
    yield from _dangers(archive)
    for entry in archive.entries:
        yield from _entry_rules(entry)
    counts: dict[str, int] = {}
    for name in (entry.orig_filename for entry in archive.entries if not entry.orig_filename.endswith("/")):
        counts[name] = counts.get(name, 0) + 1
    yield from (_fault(f"the archive holds '{name}' {count} times") for name, count in counts.items() if count > 1)
    plain: dict[str, str] = {}
    for name in counts:
        other = plain.setdefault(name.lower(), name)
        if other != name:
            yield _fault(f"'{name}' and '{other}' are one file where capitals do not count", severity="warning")

def _fault(message: str, *hints: str, severity: Severity = "error") -> Diagnostic:
    return Diagnostic(severity, "L0731", message, None, "", hints)


def _dangers(archive: Archive) -> Iterator[Diagnostic]:
    """What may not be unpacked."""
    whole = sum(entry.file_size for entry in archive.entries)
    packed = sum(entry.compress_size for entry in archive.entries)
    if whole > _LARGEST_WHOLE or whole > max(_LARGEST_TEXT, _SUSPICIOUS * packed):
        yield _fault(f"the archive unpacks to {whole / 1e6:.0f} MB from {packed / 1e6:.1f} MB, which is not done")
    for entry in archive.entries:
        name = entry.orig_filename
        if not entry.filename or "\0" in name:
            yield _fault(f"'{name}' is no name of a file")
        if name.startswith(("/", "\\")) or ".." in name.replace("\\", "/").split("/") or name[1:2] == ":":
            yield _fault(f"'{name}' leads out of the archive")
        if stat.S_ISLNK(entry.external_attr >> 16):
            yield _fault(f"'{name}' is a link", "put the file itself into the archive")


def _entry_rules(entry: zipfile.ZipInfo) -> Iterator[Diagnostic]:
    name = entry.orig_filename
    if entry.flag_bits & 1:
        yield _fault(f"'{name}' is encrypted")
    if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
        way = zipfile.compressor_names.get(entry.compress_type, str(entry.compress_type))  # type: ignore[attr-defined]
        yield _fault(f"'{name}' is packed by {way}", "FMI allows deflate, or no compression")
    elif entry.extract_version > _NEWEST:
        yield _fault(f"'{name}' needs version {entry.extract_version / 10} of ZIP, and FMI allows 2.0", "write it without ZIP64")
    if "\\" in name:
        yield _fault(f"'{name}' has a backslash", "folders are parted by '/'")
    if name.startswith("./") or "//" in name:
        yield _fault(f"'{name}' is not found by its plain name", f"call it '{PurePosixPath(name)}'")
    if not name.isascii() and not entry.flag_bits & 0x800:
        yield _fault(f"'{name}' has characters whose encoding is not told", severity="warning")

