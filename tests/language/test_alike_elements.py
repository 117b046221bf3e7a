"""Elements of arrays that are copies of the first, and what they bring stamped out, are what they would be one by one."""

import cProfile
from pathlib import Path

import pytest

from lagrangia.base.diagnostics import LagError, Source
from lagrangia.compile.pipeline import flatten_files
from lagrangia.language import instantiation
from lagrangia.language.dimensions import check_dimensions
from lagrangia.language.flat import FlatModel
from lagrangia.language.syntax import parse

PARTS = """model Pair "Two links, the second with a spring of its own"
  parameter Length L = 0.3;
  parameter Mass m[2] = {1, 2};
  parameter Integer kind = 1;
  Real c = 0;
  Frame a, b;
  Revolute hinge[2](phi(start = {0.1, 0.2}));
  Bar bar[2](m = m, each L = L);
  Spring spring(a = bar[1].b, b = world, k = 10) if kind == 2;
  Real free = c*hinge[1].phi;
equation
  connect(a, hinge[1].a);
  for i in 1:2 loop connect(hinge[i].b, bar[i].a); end for;
  connect(bar[1].b, hinge[2].a);
  b = shift(bar[2].b, {0.01*kind, 0});
end Pair;
"""
ARRAYS = {
    "a chain": """Revolute hinge[9]; Bar link[9](each m = 1, each L = 0.5);
        equation connect(world, hinge[1].a);
        for i in 1:9 loop connect(hinge[i].b, link[i].a); end for;
        for i in 1:8 loop connect(link[i].b, hinge[i + 1].a); end for;""",
    "dealt out": """parameter Mass m[8] = {1 + 0.1*i for i in 1:8};
        Block block[8](m = m, each base = world, s(start = {0.1*i for i in 1:8}, each fixed = true));
        Spring spring[7](each k = 100, stretch = {block[i + 1].s - block[i].s for i in 1:7});""",
    "components in components": "Pair pair[9](each a = world, L = {0.1*i for i in 1:9}, each c = 3);",
    "arrays of arrays": "Pair pair[8](each a = world, m = {{i, 2*i} for i in 1:8});",
    "what stands before it": "Pair one(a = world); Pair pair[9](each a = one.b, each L = one.L);",
    "the first itself": """PointMass p[9](each m = 1);
        Spring s[8](each a = p[1].center, b = {p[i + 1].center for i in 1:8}, each k = 1);
        Spring first(a = world, b = p[1].center, k = 1);""",
    "of different structure": "Pair pair[9](each a = world, kind = {1, 2, 1, 1, 2, 1, 2, 1, 1});",
    "a lattice": """PointMass p[3, 4](m = {{i + j for j in 1:4} for i in 1:3}); Spring h[3, 3](each k = 1), v[2, 4](each k = 1);
        Spring pin(a = world, b = p[1, 1].center, k = 1);
        equation
        for i in 1:3, j in 1:3 loop connect(p[i, j].center, h[i, j].a); connect(p[i, j + 1].center, h[i, j].b); end for;
        for i in 1:2, j in 1:4 loop connect(p[i, j].center, v[i, j].a); connect(p[i + 1, j].center, v[i, j].b); end for;
        """,
    "drive trains": """Rotational.Inertia wheel[9](each J = 1);
        Rotational.SpringDamper spring[8](each c = 1, d = {i for i in 1:8});
        equation for i in 1:8 loop
        connect(wheel[i].flange_b, spring[i].flange_a); connect(spring[i].flange_b, wheel[i + 1].flange_a); end for;""",
}
WRONG = {
    "a port of one that is none": ("Spring s[9](each k = 1, each a = world, b = {if i == 5 then 3 else world for i in 1:9});",
                                    "L0221"),
    "a count": ("Spring s[9](k = {1, 2, 3}, each a = world, each b = world);", "L0213"),
    "a unit of one": ("Spring s[9](k = {if i == 5 then 3[m] else 3[N/m] for i in 1:9}, each a = world);", "L0304"),
    "a unit behind a name without one": ("Pair pair[9](each a = world, c = {if i == 7 then 1[m] else 1 for i in 1:9});\n"
                                         "Mass x = pair[6].free + pair[7].free;", "L0304"),
    "a unit within": ("Pair pair[9](each a = world, each L = 3[s]);", "L0304"),
    "what is not there": ("Bar b[9](each m = 1, each L = 1);\nequation for i in 1:9 loop connect(b[i + 1].a, world); end for;",
                          "L0214"),
    "nothing given": ("Bar b[9](each m = 1);", "L0211"),
}


def flat(text: str, folder: Path) -> FlatModel:
    """Of parts and one model that has them."""
    source = Source(str(folder / "scene.lag"), f"{PARTS}model Scene\n{text}\nend Scene;\n")
    return check_dimensions(flatten_files(parse(source), []))


def one_by_one(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(instantiation, "FEWEST", 1000)


@pytest.mark.parametrize("name", ARRAYS)
def test_elements_that_are_stamped_out_are_what_they_are_one_by_one(name: str, tmp_path: Path,
                                                                    monkeypatch: pytest.MonkeyPatch) -> None:
    stamped = flat(ARRAYS[name], tmp_path)
    one_by_one(monkeypatch)
    assert bool(stamped.repeats) == (name != "of different structure")
    assert spelled(stamped) == spelled(flat(ARRAYS[name], tmp_path))


def spelled(model: FlatModel) -> str:
    """All of it, with the text."""
    return repr(model)


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_told_as_one_by_one(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text, code = WRONG[name]
    with pytest.raises(LagError) as stamped:
        flat(text, tmp_path)
    one_by_one(monkeypatch)
    with pytest.raises(LagError) as plain:
        flat(text, tmp_path)
    assert str(stamped.value) == str(plain.value)
    assert code in str(plain.value)


def test_what_is_stamped_out_is_not_looked_at(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each more link asks for a third of the calls at most."""
    def calls(count: int) -> int:
        text = ARRAYS["a chain"].replace("9", str(count)).replace("8", str(count - 1))
        profile = cProfile.Profile()
        profile.enable()
        flat(text, tmp_path)
        profile.disable()
        return sum(entry.callcount for entry in profile.getstats())

    stamped = calls(300) - calls(100)
    one_by_one(monkeypatch)
    assert stamped < 0.33*(calls(300) - calls(100))
