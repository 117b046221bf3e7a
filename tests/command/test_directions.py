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
    """As declared, by -p, and in one run of a sweep."""
    zero, one, rows = tmp_path / "zero.lag", tmp_path / "one.lag", ["-o", str(tmp_path / "x.csv")]
    zero.write_text(SCENE % (component % 0))
    one.write_text(SCENE % (component % 1))
    for command in (["check", str(zero)], ["simulate", str(zero), *rows], ["simulate", str(one), "-p", "floor.along[2]=0", *rows],
                    ["sweep", str(one), "-p", "floor.along[2]=1,0", *rows]):
        assert main(command) == 2
        told = capsys.readouterr()
        assert REFUSED in told.err + told.out and ".lag:3:" in told.err + told.out
    assert main(["simulate", str(one), "-p", "floor.along[2]=2", *rows]) == 0
