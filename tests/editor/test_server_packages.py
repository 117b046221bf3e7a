"""`lag server` in packages, enumerations, records, imports, redeclarations: each name leads to what it means."""

from collections.abc import Iterator

import pytest

from helpers.language_client import Client

pytest.importorskip("pygls")
PACKAGE = """package Shop "parts of ours"
end Shop;
"""
WHEEL = """within Shop;
model Wheel "on its own"
  parameter Length r = 0.3;
  Disc rim(m = 1, r = r);
end Wheel;
"""
SCENE = """package Parts "own parts"
  constant Length L0 = 0.5 "a length";
  type Side = enumeration(left "port side", right);
  record Data "data of a wheel"
    parameter Length r = 0.3 "radius";
  end Data;
  partial model Base
    replaceable model Load = PointMass constrainedby Body;
    Load load(m = 1);
  end Base;
end Parts;
model Top
  import Parts.{Data, Base};
  import R = Rotational;
  extends Base(redeclare model Load = Disc(r = 2));
  parameter Data d(r = 0.4);
  parameter Parts.Side side = Parts.Side.left;
  parameter Length q = Parts.L0;
  R.Inertia J(J = 2);
  Shop.Wheel wheel(r = d.r);
end Top;
"""
PLACES = {  # a mark, how far behind its start the name is: the file, its line, and a word of what is told
    ("left;", 0): ("scene.lag", 3, "port side"), ("L0;", 0): ("scene.lag", 2, "a length"),
    ("Side side", 0): ("scene.lag", 3, "`left`: port side"), ("Parts.Side side", 0): ("scene.lag", 1, "own parts"),
    ("Data, Base", 0): ("scene.lag", 4, "data of a wheel"), ("{Data, Base", 7): ("scene.lag", 7, "partial model"),
    ("Rotational;", 0): ("rotational.lag", 4, "Drive trains"), ("R.Inertia", 0): ("rotational.lag", 4, "Drive trains"),
    ("Inertia J", 0): ("rotational.lag", 54, "T = J w^2/2"), ("model Load = Disc", 6): ("scene.lag", 8, "model Load"),
    ("Disc(r", 0): ("bodies.lag", 32, "uniform disc"), ("Disc(r = 2", 5): ("bodies.lag", 33, "radius"),
    ("PointMass constr", 0): ("bodies.lag", 12, "without extent"), ("Body;", 0): ("bodies.lag", 1, "Rigid body"),
    ("Wheel wheel", 0): ("Wheel.lag", 2, "on its own"), ("Shop.Wheel", 0): ("package.lag", 1, "parts of ours"),
    ("wheel(r = d", 6): ("Wheel.lag", 3, "default 0.3"), ("d.r);", 2): ("scene.lag", 5, "radius"),
}


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Client]:
    folder = tmp_path_factory.mktemp("project")
    (folder / "Shop").mkdir()
    (folder / "Shop" / "package.lag").write_text(PACKAGE)
    (folder / "Shop" / "Wheel.lag").write_text(WHEEL)
    client = Client(folder)
    yield client
    assert client.close() == 0


@pytest.fixture(scope="module")
def scene(client: Client) -> str:
    uri, wrong = client.open("scene.lag", SCENE)
    assert [found for found in wrong if found["severity"] == 1] == []
    return uri


def test_each_name_leads_to_what_it_means(client: Client, scene: str) -> None:
    for (mark, shift), (file, line, word) in PLACES.items():
        place = client.at("definition", scene, SCENE, mark, shift)
        assert place is not None, mark
        assert place["uri"].rpartition("/")[2] == file, mark
        if file == "scene.lag":
            assert place["range"]["start"]["line"] + 1 == line, mark
        assert word in client.at("hover", scene, SCENE, mark, shift)["contents"]["value"], mark


def test_a_value_of_an_enumeration_and_a_class_get_another_name_everywhere(client: Client, scene: str) -> None:
    for mark, name, count in (("left;", "port", 2), ("Data, Base", "Facts", 4), ("L0;", "length", 2)):
        (edits,) = client.at("rename", scene, SCENE, mark, newName=name)["changes"].values()
        assert len(edits) == count, mark


def test_what_stands_behind_the_dot_of_a_package(client: Client, scene: str) -> None:
    def labels(mark: str, shift: int) -> set[str]:
        return {item["label"] for item in client.at("completion", scene, SCENE, mark, shift)}

    assert {"Inertia", "Spring", "Clutch"} <= labels("R.Inertia", 2)
    assert labels("Side.left", 5) == {"left", "right"}
    assert {"Side", "Data", "Base", "L0"} <= labels("Parts.L0", 6)
    assert "r" in labels("d.r);", 2)


def test_the_outline_has_classes_in_classes(client: Client, scene: str) -> None:
    package, _ = client.ask("textDocument/documentSymbol", textDocument={"uri": scene})
    inside = {symbol["name"]: symbol for symbol in package["children"]}
    assert set(inside) == {"L0", "Side", "Data", "Base"}
    assert [symbol["name"] for symbol in inside["Side"]["children"]] == ["left", "right"]
    assert [symbol["name"] for symbol in inside["Base"]["children"]] == ["load", "Load"]
