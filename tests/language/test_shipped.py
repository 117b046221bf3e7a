"""What is made when the package is built is found by what it was made of, and is what would be made now."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from lagrangia.language import component_library, shipped
from lagrangia.language.plain_tree import read_trees
from lagrangia.language.syntax import parse
from lagrangia.language.tree import Syntax


@pytest.fixture
def empty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An installation in which nothing was shipped, with an empty cache."""
    monkeypatch.setattr(shipped, "_FOLDER", tmp_path / "shipped")
    monkeypatch.setenv("LAGRANGIA_CACHE", str(tmp_path / "cache"))
    return tmp_path


def test_what_is_shipped_is_found_until_a_file_changes(empty: Path) -> None:
    file = empty / "text.lag"
    file.write_text("one")
    shipped.ship("thing", [file], b"made of one")
    never = pytest.fail
    assert shipped.made_of("thing", [file], lambda: never("it is there")) == b"made of one"
    file.write_text("two")
    assert shipped.made_of("thing", [file], lambda: b"made of two") == b"made of two"
    assert shipped.made_of("thing", [file], lambda: never("it was kept")) == b"made of two"
    file.write_text("one")
    assert shipped.made_of("thing", [file], lambda: never("it is there")) == b"made of one"


def test_two_may_ship_at_once(empty: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """They wrote to one file, and the second one's was gone."""
    file = empty / "text.lag"
    file.write_text("one")
    replace = Path.replace

    def later(self: Path, target: Path) -> Path:
        monkeypatch.undo()
        monkeypatch.setattr(shipped, "_FOLDER", empty / "shipped")
        shipped.ship("thing", [file], b"made")
        return replace(self, target)

    monkeypatch.setattr(Path, "replace", later)
    place = shipped.ship("thing", [file], b"made")
    assert place.read_bytes() == b"made" and [*place.parent.iterdir()] == [place]


@pytest.mark.parametrize("damage", [
    lambda whole: b"", lambda whole: whole[: len(whole) // 2], lambda whole: whole.replace(b"o", b"b", 1),
], ids=["empty", "cut", "a letter changed"])
def test_what_was_kept_and_is_damaged_is_made_anew(damage: Callable[[bytes], bytes], empty: Path) -> None:
    file = empty / "text.lag"
    file.write_text("one")
    assert shipped.made_of("thing", [file], lambda: b"made of one") == b"made of one"
    (kept,) = (empty / "cache" / "syntax").iterdir()
    kept.write_bytes(damage(kept.read_bytes()))
    assert shipped.made_of("thing", [file], lambda: b"made again") == b"made again"


def undrawn(syntax: Syntax) -> Syntax:
    return replace(syntax, classes=tuple(replace(c, sections=tuple(s for s in c.sections if s.kind != "drawing"))
                                         for c in syntax.classes))


def test_the_library_is_shipped_as_it_is_parsed(empty: Path) -> None:
    component_library.ship_all()
    (place,) = (empty / "shipped").glob("library-*")
    found = read_trees(place.read_bytes())
    assert [item.source.name for item in found] == [f"library/{file.name}" for file in component_library._files()]
    (drawn,) = (empty / "shipped").glob("drawn-*")
    whole = read_trees(drawn.read_bytes())
    assert whole == tuple(parse(item.source) for item in whole)
    assert found == tuple(undrawn(parse(item.source)) for item in found)
    assert len(list((empty / "shipped").glob("reader-*"))) == 1
