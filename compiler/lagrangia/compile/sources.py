"""Files -> sources."""

from pathlib import Path

from lagrangia.base.diagnostics import Source, fail
from lagrangia.base.result_files import require_file

_OTHERS = {
    ".fmu": ("an FMU", "lag simulate and lag fmu check take FMUs"), ".csv": ("a table", "of inputs: -u FILE.csv beside a scene"),
    **dict.fromkeys((".dat", ".parquet", ".pq", ".npz", ".mat", ".jsonl"), ("a table", "of inputs: -u FILE beside a scene")),
    ".mo": ("a model of Modelica", "lag import FILE.mo makes a scene of it"),
    ".urdf": ("a robot's description", "lag import FILE.urdf makes a scene of it"),
    ".xml": ("no scene", "lag import FILE.xml makes one of what MuJoCo reads"),
}


def refuse_others(path: Path) -> None:
    """Raises LagError L0001 for a file that is no scene by its name."""
    if path.is_file() and (found := _OTHERS.get(path.suffix.lower())):
        fail("L0001", f"'{path}' is {found[0]}, by its name: one of a scene ends in .lag", None, found[1])


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
