"""Directions of no length are refused at their place: what is divided by their length is not a number, and does nothing."""

from pathlib import Path

import pytest

from lagrangia.command.cli import main

STOP = "Stop floor(a = world, b = p.center, along = {0, %s}, e = 0);"
ROUGH = "RoughStop floor(a = world, b = p.center, along = {0, %s}, mu = 0.3);"
SCENE = """model S
  PointMass p(m = 1, center(x(start = 0), y(start = 0.5)));
  %s
  annotation(experiment(StopTime = 1));
end S;
"""
REFUSED = "the direction 'floor.along' has no length"


@pytest.mark.parametrize("component", [STOP, ROUGH])
def test_directions_of_no_length_are_refused(component: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As declared, by -p, and in one run of a sweep, whose others are made."""
    zero, one, rows = tmp_path / "zero.lag", tmp_path / "one.lag", ["-o", str(tmp_path / "x.csv")]
    zero.write_text(SCENE % (component % 0))
    one.write_text(SCENE % (component % 1))
    for command in (["check", str(zero)], ["simulate", str(zero), *rows],
                    ["simulate", str(one), "-p", "floor.along[2]=0", *rows]):
        assert main(command) == 2
        told = capsys.readouterr()
        assert REFUSED in told.err + told.out and ".lag:3:" in told.err + told.out
    assert main(["simulate", str(one), "-p", "floor.along[2]=2", *rows]) == 0
    assert main(["sweep", str(one), "-p", "floor.along[2]=1,0", *rows]) == 0
    assert f"1 failed: {REFUSED}" in capsys.readouterr().out
    assert main(["sweep", str(one), "-p", "floor.along[2]=0,0", *rows]) == 1


def test_directions_are_found_in_arrays_and_where_they_follow(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """In one run of a sweep: of an element of components, and of a vector that follows from what is varied."""
    file, rows = tmp_path / "s.lag", ["-o", str(tmp_path / "x.csv")]
    file.write_text(SCENE % "parameter Real h = 1;"
                    "Stop floor[2](each a = world, each b = p.center, along = {{0, 1}, {0, h}}, each e = 0);")
    for given in ("floor[2].along[2]", "h", "floor[1].along[2]"):
        assert main(["sweep", str(file), "-p", f"{given}=1,0,2", *rows]) == 0
        named = "floor[1].along" if given.startswith("floor[1]") else "floor[2].along"
        assert f"1 failed: the direction '{named}' has no length" in capsys.readouterr().out
    assert main(["simulate", str(file), "-p", "h=0", *rows]) == 2
    assert main(["sweep", str(file), "-p", "h=1,-1", *rows]) == 0


@pytest.mark.parametrize("force", ["if d[1]*d[1] + d[2]*d[2] > 0 then 3*d[1]/norm(d) else 0", "u"])
def test_vectors_that_may_be_none_are_not_refused(force: str, tmp_path: Path) -> None:
    """A vector of 0 that is divided by its length only where it has one."""
    file = tmp_path / "g.lag"
    file.write_text(f"""model G
  parameter Real d[2] = {{0, 0}}, u = if norm(d) > 0 then 3*d[1]/norm(d) else 0;
  Block b(m = 1 + u, base = world); AppliedForce f(at = b.center, force = {{1 + ({force}), 0}});
end G;""")
    assert main(["simulate", str(file), "--stop", "1", "-o", str(tmp_path / "x.csv")]) == 0


def test_parallel_axes_of_a_cardan_joint_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As declared, and by -p."""
    text = """model U
      World world(gravity = {0, 0, -9.81});
      Universal u(a = world, axis_b = {%s, 1, 0}); Body b(m = 1, I = {0.1, 0.1, 0.1}, center = shift(u.b, {0, 0.1, -0.4}));
    end U;"""
    file, rows = tmp_path / "u.lag", ["--stop", "0.1", "-o", str(tmp_path / "x.csv")]
    file.write_text(text.replace("%s, 1", "2, 0"))
    assert main(["simulate", str(file), *rows]) == 2
    assert "axes that are parallel: u.axis_a and u.axis_b" in capsys.readouterr().err
    file.write_text(text % 0)
    assert main(["simulate", str(file), "-p", "u.axis_b={2,0,0}", *rows]) != 0
    assert "axis_a and axis_b are parallel" in capsys.readouterr().err
    assert main(["simulate", str(file), *rows]) == 0


def test_a_multiple_of_a_rotation_is_no_angle(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "t.lag").write_text("""model T World world(gravity = {0, 0, -9.81}); coordinate Rotation S;
      Frame f = turn(world, 2*S); Body b(m = 1, I = {0.1, 0.1, 0.1}, center = f); end T;""")
    assert main(["check", str(tmp_path / "t.lag")]) == 2
    assert "takes one angle; a coordinate Rotation S turns as a whole" in capsys.readouterr().err
