"""FMUs with faults put into them: files of an archive changed, left out or written in ways that FMI does not allow."""

import re
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path

DESCRIPTION = "modelDescription.xml"
Change = Callable[[str], str] | bytes | None


def replaced(pattern: str, by: str, count: int = 1) -> Callable[[str], str]:
    """The first matches; there must be one."""

    def change(text: str) -> str:
        changed, n = re.subn(pattern, by, text, count=count)
        assert n, pattern
        return changed

    return change


def broken(path: Path, target: Path, changes: Mapping[str, Change], **written: int) -> Path:
    """The FMU with files changed: new text, new bytes, or None to leave one out. `written` are attributes of each new entry."""
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in dict.fromkeys([*source.namelist(), *changes]):
            change = changes.get(name, b"")
            if change is None:
                continue
            content = source.read(name) if name in source.namelist() else b""
            entry = zipfile.ZipInfo(name)  # stored: to deflate a binary takes longer than all that is done with it
            if name in changes:
                entry.compress_type = zipfile.ZIP_DEFLATED
                content = change if isinstance(change, bytes) else change(content.decode()).encode()
                for attribute, value in written.items():
                    setattr(entry, attribute, value)
            archive.writestr(entry, content)
    return target


def described(path: Path, target: Path, pattern: str, by: str, count: int = 1) -> Path:
    """With another text in its model description."""
    return broken(path, target, {DESCRIPTION: replaced(pattern, by, count)})
