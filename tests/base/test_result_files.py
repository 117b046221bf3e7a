"""Files that take their names when all is well."""

import os
import sys
from pathlib import Path

import pytest

from lagrangia.base.result_files import Target


@pytest.mark.skipif(sys.platform == "win32", reason="needs links")
def test_a_copy_follows_no_link(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where what has no name cannot be linked to one."""
    kept, new = tmp_path / "kept", tmp_path / "new.csv"
    kept.write_text("mine")

    def put_in_the_way(_: str, place: Path, **options: object) -> None:
        place.symlink_to(kept)
        raise PermissionError

    monkeypatch.setattr(os, "link", put_in_the_way)
    with Target(new) as target:
        target.put("new")
    assert kept.read_text() == "mine" and new.read_text() == "new" and not new.is_symlink()
