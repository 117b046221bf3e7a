"""`lag format`: texts in the one layout of the language."""

import os
import sys
from argparse import Namespace
from collections.abc import Iterator, Sequence
from pathlib import Path

from lagrangia.base.diagnostics import LagError, Report, Source, fail, render_all
from lagrangia.base.result_files import write_text
from lagrangia.base.spelling import plain_text
from lagrangia.compile.sources import read_source
from lagrangia.editor.formatting import formatted


def format_command(options: Namespace) -> int:
    """Writes what differs; a file that is wrong stays as it is, and the exit code is 2. With --check it is 1 where
    one differs."""
    report = Report()
    changed = 0
    for file in _files(options.files, report):
        try:
            source = Source("standard input", sys.stdin.read()) if file is None else read_source(file)
            text = formatted(source)
            differs = text != source.text
            changed += differs
            if options.diff and differs:
                sys.stdout.writelines(_difference(source, text))
            elif options.check and differs:
                print(f"{source.name} would change")
            if not options.check and not options.diff:
                _write(file, text, differs)
        except LagError as error:
            report.add(error.diagnostics)
    if report.diagnostics:
        print(render_all(report.diagnostics, sys.stderr.isatty()), file=sys.stderr)
        return 2
    return 1 if options.check and changed else 0


def _files(names: Sequence[str], report: Report) -> Iterator[Path | None]:
    """In folders those that end in .lag; None is standard input."""
    for name in names:
        path = Path(name)
        found = sorted(file for file in path.rglob("*.lag") if file.is_file()) if path.is_dir() else [path]
        if not found:
            report.error("L0001", f"there is no .lag file in '{path}'")
        yield from [None] if name == "-" else found


def _write(file: Path | None, text: str, differs: bool) -> None:
    if file is None:
        sys.stdout.write(text)
    elif differs:
        if not os.access(file, os.W_OK):
            fail("L0004", f"'{file}' cannot be written: it is write-protected")
        write_text(file, text)
        print(plain_text(f"{file} formatted"))


def _difference(source: Source, text: str) -> Iterator[str]:
    from difflib import unified_diff

    before, after = (lines.splitlines(keepends=True) for lines in (source.text, text))
    for line in unified_diff(before, after, source.name, f"{source.name} formatted"):
        yield line if line.endswith("\n") else f"{line}\n\\ No newline at end of file\n"
