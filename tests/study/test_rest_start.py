"""lag simulate --from equilibrium: runs that begin at rest stay there."""

from pathlib import Path

import pytest

from lagrangia.command.cli import main

SCENES = {
    "loop": ("""model Loop "Four-bar under gravity"
      Revolute O(a = world, phi(start = -1)), C(a = shift(world, {1, 0}), phi(start = -1)), A, B;
      Bar crank(m = 1, L = 0.4, a = O.b), rocker(m = 1, L = 0.8, a = C.b), coupler(m = 1, L = 1);
    equation
      connect(crank.b, A.a); connect(A.b, coupler.a); connect(coupler.b, B.a); connect(B.b, rocker.b);
    end Loop;""", {}),
    "controlled": ("""model Hang "On a spring, with a force that lags behind"
      Prismatic g(a = world, along = {0, 1}, v(start = 3)); PointMass m(m = 2, center = g.b);
      AxialSpring s(a = world, b = m.center, k = 100, along = {0, 1});
      AxialDamper d(a = world, b = m.center, c = 1, along = {0, 1});
      FirstOrder f(T = 0.1, u = g.s/1[m]);
      AppliedForce c(at = m.center, force = {0, -20[N]*f.y + 3*(1 + step(time - 9))});
    end Hang;""", {"g.s": -16.62 / 120, "f.y": -16.62 / 120}),
}


def table(path: Path) -> list[dict[str, float]]:
    names, *rows = path.read_text().splitlines()
    return [dict(zip(names.split(","), map(float, row.split(",")), strict=True)) for row in rows]


@pytest.mark.parametrize("name", SCENES)
def test_what_begins_at_rest_stays(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene, known = SCENES[name]
    (tmp_path / "scene.lag").write_text(scene)
    command = ["simulate", str(tmp_path / "scene.lag"), "--from", "equilibrium", "--stop", "2", "-o", str(tmp_path / "rows.csv")]
    assert main(command) == 0
    assert "starts at rest, " in capsys.readouterr().err
    first, *_, last = table(tmp_path / "rows.csv")
    assert last.pop("time") > first.pop("time")
    assert last == pytest.approx(first, abs=1e-9)
    assert {key: first[key] for key in known} == pytest.approx(known, abs=1e-12)


@pytest.mark.parametrize(("given", "code", "what"), [
    ("--from steady", 2, "rates of coordinates, and none is given"), ("--from equilibrum", 2, "did you mean 'equilibrium'?"),
    ("--from equilibrium -p k=0", 1, "no position of rest was found"),
])
def test_what_cannot_be(given: str, code: int, what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "scene.lag").write_text("""model Falls
      parameter Stiffness k = 10;
      Prismatic g(a = world, along = {0, 1}); PointMass m(m = 2, center = g.b);
      AxialSpring s(a = world, b = m.center, k = k, along = {0, 1});
    end Falls;""")
    assert main(["simulate", str(tmp_path / "scene.lag"), "-o", str(tmp_path / "rows.csv"), *given.split()]) == code
    assert what in capsys.readouterr().err
