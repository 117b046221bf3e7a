"""`lag server`: the language server, for editors."""

import os
import sys
from argparse import Namespace
from contextlib import redirect_stdout
from typing import BinaryIO, cast

from lagrangia.base.diagnostics import fail

_LONGEST_LINE, _LARGEST = 1 << 12, 1 << 28  # bytes: of a line before a message, and of a message


def server_command(options: Namespace) -> int:
    """Speaks the language server protocol over standard input and output until the editor ends it. Raises LagError L0715."""
    try:
        import pygls
    except ImportError:
        fail("L0715", "the language server needs pygls, which is not installed", None,
             "pip install 'lagrangia[editor]', or pygls")
    del pygls
    from lagrangia.editor.server import server

    with os.fdopen(os.dup(0), "rb") as asked, os.fdopen(os.dup(1), "wb") as answers, redirect_stdout(sys.stderr):
        server.start_io(cast("BinaryIO", _Bounded(asked)), answers)  # which nothing else may write to
    return 0


class _Bounded:
    """A stream of messages none of which is larger than a text may be."""

    def __init__(self, stream: BinaryIO) -> None:
        self.stream = stream

    def readline(self) -> bytes:
        """A line of what stands before a message."""
        return self.stream.readline(_LONGEST_LINE)

    def read(self, size: int) -> bytes:
        """A message. Raises LagError L0715."""
        if size > _LARGEST:
            fail("L0715", f"the editor announces a message of {size} bytes", None, f"at most {_LARGEST} are read")
        return self.stream.read(size)
