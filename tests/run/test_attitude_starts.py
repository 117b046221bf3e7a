"""Attitudes that begin where they are given: by angles, an axis or a quaternion, in runs, sweeps, prepared runs and rollouts."""

import math
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.base.attitude_values import read_attitude, turn_of
from lagrangia.command.cli import main

SCENE = """
model Top
  parameter Angle tilt = 0.5;
  World     world(gravity = {0, 0, -9.81});
  Spherical tip(a = world, S(start = angles("zxz", 0.3, tilt, 0)), w(start = {0, 0, 20}));
  Body      top(m = 0.5, I = {0.0008, 0.0008, 0.001}, center = shift(tip.b, {0, 0, 0.1}));
  output Length height = top.center.z;
  annotation(experiment(StopTime = 0.4, Tolerance = 1e-11));
end Top;
"""
Q = [f"tip.S[{k}]" for k in range(1, 5)]


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("starts") / "top.lag"
    path.write_text(SCENE)
    return path


@pytest.fixture(scope="module")
def top(file: Path) -> lag.Model:
    return lag.load(file)


@pytest.mark.parametrize(("text", "quaternion"), [
    ('angles("zxz", 0, 60[deg], 0)', [math.cos(math.pi / 6), 0.5, 0, 0]),
    ("angles(zyx, 90[deg], 0, 0)", [math.sqrt(0.5), 0, 0, math.sqrt(0.5)]),
    ("axis_angle({0, 3, 4}, 1)", [math.cos(0.5), 0, 0.6 * math.sin(0.5), 0.8 * math.sin(0.5)]),
    ("quaternion(-2, 0, 0, 0)", [1, 0, 0, 0]), ("quaternion({0, 0, 0, -5})", [0, 0, 0, -1]), ([3, 0, 4, 0], [0.6, 0, 0.8, 0]),
])
def test_what_is_written_is_the_attitude(text: object, quaternion: list[float], top: lag.Model) -> None:
    assert read_attitude(text) == pytest.approx(quaternion, abs=3e-16)
    found = top.simulate(initial={"tip.S": text}, at=[0.0], stop=0.1)
    assert [found[name][0] for name in Q] == pytest.approx(quaternion, abs=3e-16)


@pytest.mark.parametrize(("text", "message"), [
    ('angles("zzx", 1, 2, 3)', "three axes of which neighbours differ"), ("angles(zxz, 1)", "angles takes three axes"),
    ("quaternion(0, 0, 0, 0)", "a length"), ("quaternion(1, 2)", "four parts"), ("0.3", "is no attitude"),
    ("axis_angle({0, 0, 0}, 1)", "axis of the length 0"), ("axis_angle({1, 0}, 1)", "an axis and an angle"),
    ('angles("zxz", 0, 5[m], 0)', "is no angle"), ([1, 2, 3], "four parts"), (3.0, "an attitude is needed"),
    ([1, 2, 3, math.inf], "finite length"), ('angles("zxz", 0, (1, 0)', "parenthesis"),
])
def test_what_is_none_is_said(text: object, message: str, top: lag.Model) -> None:
    with pytest.raises(lag.LagError, match="length" if message == "a length" else message):
        top.simulate(initial={"tip.S": text})


def test_rows_go_on_where_they_ended_and_parts_alone_are_no_start(top: lag.Model) -> None:
    whole = top.simulate(at=[0, 0.2, 0.4], tolerance=1e-13)
    row = {name: whole[name][1] for name in (*Q, "tip.w[1]", "tip.w[2]", "tip.w[3]")}
    rest = top.simulate(start=0.2, at=[0.2, 0.4], initial=row, tolerance=1e-13)
    side = math.copysign(1, whole["tip.S[1]"][1])
    assert [side * rest[name][1] for name in Q] == pytest.approx([whole[name][2] for name in Q], abs=1e-11)
    for wrong in ({"tip.S[1]": 0.5}, {"tip.S.s[2]": 0.5}):
        with pytest.raises(lag.LagError, match="begins as a whole"):
            top.simulate(initial=wrong)
    with pytest.raises(lag.LagError, match="given twice"):
        top.simulate(initial={"tip.S": [1, 0, 0, 0], "tip.S.s[2]": 0.5})


def test_a_sweep_tells_quaternions(top: lag.Model) -> None:
    found = top.simulate_many(parameters={"tilt": [0.1, 0.2]}, stop=0.1)
    assert found.ok.all() and found["final(tip.S[1])"][0] != found["final(tip.S[1])"][1]


def test_sweeps_prepared_runs_and_rollouts_are_single_runs(top: lag.Model, file: Path,
                                                            capsys: pytest.CaptureFixture[str]) -> None:
    texts = ['angles("zxz", 0, 20[deg], 0)', "axis_angle({1, 1, 0}, 2)"]
    single = [top.simulate(initial={"tip.S": text}, at=[0.0, 0.4]) for text in texts]
    heights = [run["height"][-1] for run in single]
    found = top.simulate_many(outputs="final(height)", initial={"tip.S": texts}, parameters={"tilt": [0.5, 0.9]})
    assert found["final(height)"] == pytest.approx([heights[0], heights[1]] * 2, abs=1e-12)
    start = {"tip.S": read_attitude(texts[1])}
    alone = top.simulate_many(outputs="final(height)", initial=start, parameters={"tilt": [0.5, 0.9]})
    assert alone["final(height)"] == pytest.approx(heights[1:] * 2, abs=1e-12)
    starts = [turn_of(read_attitude(text)) for text in texts]
    prepared = top.prepare(initial={f"tip.S.s[{k}]": 0.0 for k in (1, 2, 3)}, at=[0.0, 0.4])
    column = prepared.columns.index("height")
    assert [prepared(start)[-1, column] for start in starts] == pytest.approx(heights, abs=1e-12)
    assert np.isnan(prepared(starts[0])[-1, 1:4]).all()
    rolled = top.rollout(np.array(starts), times=[0.0, 0.4])
    assert rolled["height"][:, -1] == pytest.approx(heights, abs=1e-10)
    assert np.isnan(rolled.q).all() and rolled["tip.S[1]"][:, 0] == pytest.approx([x["tip.S[1]"][0] for x in single], abs=1e-15)
    stepped = top.start(initial={"tip.S": texts[0]})
    stepped.step(0.4)
    assert stepped["height"] == pytest.approx(heights[0], abs=1e-10) and np.isnan(stepped.state[:3]).all()
    assert main(["sweep", str(file), "--initial", f"tip.S={','.join(texts)}", "--outputs", "final(height)", "-o", "-"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [float(line.split(",")[4]) for line in lines[1:3]] == pytest.approx(heights, abs=1e-12)
    for wrong in ("normal(0, 1)", "0.5"):
        assert main(["sweep", str(file), "--initial", f"tip.S={wrong}", "--samples", "3", "-o", "-"]) == 2
        assert "is no attitude" in capsys.readouterr().err
