"""Files -> sources."""

from pathlib import Path

from lagrangia.base.diagnostics import Source, fail
from lagrangia.base.result_files import require_file


def read_source(path: Path) -> Source:
    """Raises LagError L000x for what cannot be read as text."""
    try:
        require_file(path)
        return Source(str(path), path.read_bytes().decode("utf-8"))
    except FileNotFoundError:
        fail("L0001", f"there is no file '{path}'")
    except IsADirectoryError:
        fail("L0001", f"'{path}' is a folder")
    except OSError as error:
        fail("L0001", f"'{path}' cannot be read: {error.strerror}")
    except UnicodeDecodeError as error:
        fail("L0101", f"'{path}' is not a text file in UTF-8: byte {error.object[error.start]:#04x} at offset {error.start}")
