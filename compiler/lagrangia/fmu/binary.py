"""What a shared library says of itself: its processors, the libraries it needs, the newest glibc it asks for.

ELF: System V ABI, 4 and 5; PE: Microsoft, PE Format; Mach-O: Apple, loader.h. Only what is needed is read, and a file that is cut
short is said to be none.
"""

import re
import struct
from collections.abc import Callable, Iterator

from lagrangia.base.records import dataclass

_ELF_MACHINES = {3: "x86", 0x3E: "x86_64", 0x28: "aarch32", 0xB7: "aarch64", 0xF3: "riscv64"}
_PE_MACHINES = {0x14C: "x86", 0x8664: "x86_64", 0xAA64: "aarch64", 0x1C4: "aarch32"}
_MACH_MACHINES = {7: "x86", 0x01000007: "x86_64", 0x0100000C: "aarch64", 12: "aarch32"}
_NEEDED, _STRINGS, _SONAME_LIMIT = 1, 5, 4096
_LOAD_DYLIB = (0xC, 0x80000018, 0x8000001F)
_GLIBC = re.compile(rb"GLIBC_2\.(\d+)")
_MOST = 100_000  # entries of a table in a file that may be hostile


@dataclass(frozen=True)
class Library:
    """`system`: linux, windows or darwin; `processors`: more than one in a universal file; `glibc`: 17 for 2.17, None without."""

    system: str
    processors: tuple[str, ...]
    needs: tuple[str, ...]
    glibc: int | None


def read_library(content: bytes) -> Library | None:
    """None for what is no library, or is cut short."""
    try:
        if content[:4] == b"\x7fELF":
            return _read_elf(content)
        if content[:2] == b"MZ":
            return _read_pe(content)
        return _read_mach(content)
    except (struct.error, IndexError, ValueError, UnicodeDecodeError):
        return None


def _text(content: bytes, at: int) -> str:
    end = content.index(b"\0", at, at + _SONAME_LIMIT)
    return content[at:end].decode()


# -------------------------------------------------------------------- ELF


def _read_elf(content: bytes) -> Library:
    is_wide, order = content[4] == 2, "<" if content[5] == 1 else ">"
    (machine,) = struct.unpack_from(order + "H", content, 18)
    (table,) = struct.unpack_from(order + ("Q" if is_wide else "I"), content, 32 if is_wide else 28)
    size, count = struct.unpack_from(order + "HH", content, 54 if is_wide else 42)
    segments = [_elf_segment(content, table + k * size, is_wide, order) for k in range(count)]
    needs: list[str] = []
    for kind, offset, _address, length in segments:
        if kind == 2:  # PT_DYNAMIC
            needs = list(_elf_needs(content, offset, length, segments, is_wide, order))
    versions = [int(found[1]) for found in _GLIBC.finditer(content)]
    return Library("linux", (_ELF_MACHINES.get(machine, f"machine {machine}"),), tuple(needs), max(versions, default=None))


def _elf_segment(content: bytes, at: int, is_wide: bool, order: str) -> tuple[int, int, int, int]:
    """Type, offset, address, size in the file."""
    if is_wide:
        kind, _flags, offset, address, _physical, length = struct.unpack_from(order + "IIQQQQ", content, at)
    else:
        kind, offset, address, _physical, length = struct.unpack_from(order + "IIIII", content, at)
    return kind, offset, address, length


def _elf_needs(content: bytes, offset: int, length: int, segments: list[tuple[int, int, int, int]], is_wide: bool,
               order: str) -> Iterator[str]:
    pair = struct.Struct(order + ("qQ" if is_wide else "iI"))
    entries = [pair.unpack_from(content, offset + k * pair.size) for k in range(min(length // pair.size, _MOST))]
    strings = next((value for tag, value in entries if tag == _STRINGS), 0)
    place = next((strings - address + start for kind, start, address, size in segments
                  if kind == 1 and address <= strings < address + size), strings)
    yield from (_text(content, place + value) for tag, value in entries if tag == _NEEDED)


# -------------------------------------------------------------------- PE


def _read_pe(content: bytes) -> Library:
    (head,) = struct.unpack_from("<I", content, 60)
    if content[head : head + 4] != b"PE\0\0":
        raise ValueError
    machine, sections = struct.unpack_from("<HH", content, head + 4)
    (optional,) = struct.unpack_from("<H", content, head + 20)
    start = head + 24
    (magic,) = struct.unpack_from("<H", content, start)
    (imports,) = struct.unpack_from("<I", content, start + (120 if magic == 0x20B else 104))
    table = [struct.unpack_from("<IIII", content, start + optional + 40 * k + 8) for k in range(sections)]

    def place(address: int) -> int:
        for size, begin, raw, offset in table:
            if begin <= address < begin + max(size, raw):
                return int(address - begin + offset)
        raise ValueError

    return Library("windows", (_PE_MACHINES.get(machine, f"machine {machine:#x}"),),
                   tuple(_pe_needs(content, place(imports), place)) if imports else (), None)


def _pe_needs(content: bytes, at: int, place: Callable[[int], int]) -> Iterator[str]:
    for k in range(_MOST):
        (name,) = struct.unpack_from("<I", content, at + 20 * k + 12)
        if name == 0:
            return
        yield _text(content, place(name))


# -------------------------------------------------------------------- Mach-O


def _read_mach(content: bytes) -> Library | None:
    (magic,) = struct.unpack_from(">I", content, 0)
    if magic == 0xCAFEBABE:
        (count,) = struct.unpack_from(">I", content, 4)
        slices = [struct.unpack_from(">IIII", content, 8 + 20 * k) for k in range(min(count, 20))]
        parts = [_read_mach(content[offset : offset + size]) for _cpu, _subtype, offset, size in slices]
        found = [part for part in parts if part is not None]
        if not found or len(found) < len(parts):
            return None
        return Library("darwin", tuple(p for part in found for p in part.processors),
                       tuple(dict.fromkeys(name for part in found for name in part.needs)), None)
    if magic not in (0xCFFAEDFE, 0xCEFAEDFE):
        return None
    machine, _subtype, _kind, count = struct.unpack_from("<IIII", content, 4)
    at = 32 if magic == 0xCFFAEDFE else 28
    needs = []
    for _ in range(min(count, _MOST)):
        command, size = struct.unpack_from("<II", content, at)
        if command in _LOAD_DYLIB:
            needs.append(_text(content, at + struct.unpack_from("<I", content, at + 8)[0]))
        at += max(size, 8)
    return Library("darwin", (_MACH_MACHINES.get(machine, f"machine {machine:#x}"),), tuple(needs), None)
