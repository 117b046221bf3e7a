"""Where the data folders are: in a wheel beside the modules, in a checkout two levels above them."""

from pathlib import Path

_HERE = Path(__file__).resolve().parent


def data_folder(name: str) -> Path:
    """The folder `name` ("grammar", "runtime" or "models").

    `importlib.resources` is not used: with an editable install it would find a stale copy.
    Raises FileNotFoundError when the installation is broken.
    """
    for base in (_HERE, _HERE.parent.parent):
        folder = base / name
        if folder.is_dir():
            return folder
    raise FileNotFoundError(f"the installation of lagrangia lacks its folder {name!r}")
