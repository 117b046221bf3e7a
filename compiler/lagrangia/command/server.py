"""`lag server`: the language server, for editors."""

import os
import sys
from argparse import Namespace
from contextlib import redirect_stdout

from lagrangia.base.diagnostics import fail


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
        server.start_io(asked, answers)  # which nothing else may write to
    return 0
