"""Expressions that are evaluated together, by columns, are those that come out one by one."""

from pathlib import Path

import casadi as ca
import pytest

import lagrangia as lag
from lagrangia.algebra.scalars import as_expression
from lagrangia.compile.pipeline import flatten_file
from lagrangia.frames import alike, rigid_poses
from lagrangia.frames.evaluation import scalars_of
from lagrangia.frames.graph import build_graph
from lagrangia.frames.kinematics import Kinematics, build_kinematics

MANY = """model Own "energies of its own"
  parameter Mass m = 2; parameter Length L = 1; parameter Real many = 3;
  Frame a; coordinate Length s; Length twice = 2*s; parameter Boolean plain = false;
  Real other = if time > 1 then 1 else s/L;
energy
  kinetic m*dot(a.v, a.v)/2 + m*der(s)^2/2;
  potential -m*dot(world.gravity, a.r) - m*world.gravity[2]*{2, 3}*a.r;
  potential m*s^2 + m*twice^2/many;
  potential if plain then m*a.y else m*a.y*L*other;
end Own;
model Many
  Planar place[12](each a = world); Own own[12](m = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12});
  Bar bar[3](each m = 1, each L = 2); Spring tie[12](each a = world, each k = 3);
equation
  for i in 1:12 loop connect(place[i].b, own[i].a); connect(tie[i].b, own[i].a); end for;
  for i in 1:3 loop connect(place[i].b, bar[i].a); end for;
end Many;"""


def kinematics_of(text: str, folder: Path) -> Kinematics:
    file = folder / "many.lag"
    file.write_text(text)
    return build_kinematics(build_graph(flatten_file(file)[1]))


def test_columns_are_what_comes_out_one_by_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kinematics = kinematics_of(MANY, tmp_path)
    expressions = [energy.value for energy in kinematics.graph.model.energies]
    one_by_one = [kinematics.evaluator.value(node) for node in expressions]
    taken = []
    together = alike._together
    monkeypatch.setattr(alike, "_together", lambda *given: taken.append(found := together(*given)) or found)
    found = alike.evaluate_all(expressions, [kinematics.evaluator] * len(expressions))
    assert [len(rows) for rows in taken if rows] == [12], "potentials of weights"
    assert len(taken) == 4, "those that read a variable with a binding are tried, and taken one by one"
    for a, b in zip(one_by_one, found, strict=True):
        for x, y in zip(scalars_of(a), scalars_of(b), strict=True):
            assert ca.is_equal(as_expression(x), as_expression(y), 20)


@pytest.mark.parametrize(("wrong", "told"), [
    ("k = 2*s", "L0604: the parameter 'own[1].k' cannot depend on the coordinate 'own[1].s'"),
    ("k = 3*a.x", "L0604: the parameter 'own[1].k' cannot depend on the frame 'own[1].a'"),
    ("k = 2*c, c = k/m", "L0212: parameter 'own[1].k' depends on itself"),
])
def test_what_is_wrong_with_parameters_is_told_of_the_first(wrong: str, told: str, tmp_path: Path) -> None:
    text = f"""model Own
  parameter Mass m = 2; parameter Real {wrong};
  Frame a; coordinate Length s;
energy
  kinetic m*der(s)^2/2;
end Own;
model Many
  Own own[9](each a = world);
end Many;"""
    file = tmp_path / "many.lag"
    file.write_text(text)
    with pytest.raises(lag.LagError) as raised:
        lag.load(file)
    code, _, message = told.partition(": ")
    (first, *_) = raised.value.diagnostics
    assert (first.code, first.message) == (code, message)


def test_a_name_that_only_some_read_twice_keeps_expressions_apart(tmp_path: Path) -> None:
    joined = "".join(f"  potential 3*h[{k}].phi*h[{max(k, 2)}].phi;\n" for k in range(1, 13))
    loop = "  for i in 1:12 loop potential 2*h[i].phi*h[if i < 2 then 1 else i - 1].phi; end for;\n"
    text = f"""model Twice
  Revolute h[12](each a = world); Bar bar[12](each m = 1, each L = 1);
equation
  for i in 1:12 loop connect(h[i].b, bar[i].a); end for;
energy
{loop}{joined}end Twice;"""
    kinematics = kinematics_of(text, tmp_path)
    expressions = [energy.value for energy in kinematics.graph.model.energies]
    found = alike.evaluate_all(expressions, [kinematics.evaluator] * len(expressions))
    for node, value in zip(expressions, found, strict=True):
        assert ca.is_equal(as_expression(kinematics.evaluator.value(node)), as_expression(value), 20)


RIGID = """model Rigid
  parameter Integer n = 30;
  Planar place[n](each a = world); Bar bar[n](each m = 1, each L = 2), plain[3](each m = 2, each L = 1); Frame far[n];
equation
  for i in 1:n loop
    connect(place[i].b, bar[i].a); far[i] = shift(turn(bar[i].b, if i > 20 then 0.2 else 0), {0, bar[i].L/i});
  end for;
  for i in 1:3 loop connect(bar[i].b, plain[i].b); end for;
end Rigid;"""


@pytest.mark.parametrize("fewest", [2, 24])
def test_poses_within_bodies_are_what_comes_out_one_by_one(fewest: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kinematics = kinematics_of(RIGID, tmp_path)
    rigid = [edge for edge in kinematics.graph.edges if edge.is_rigid]
    begins = {edge.parent for edge in rigid} - {edge.child for edge in rigid}
    found, expected = ({frame: kinematics.seen_from_itself(frame) for frame in begins} for _ in range(2))
    monkeypatch.setattr(rigid_poses, "_FEWEST", fewest)
    rigid_poses.follow_rigid(kinematics, rigid, found)
    for edge in rigid:
        expected[edge.child] = kinematics.follow(edge, expected[edge.parent], 0)
    assert len(found) == len(expected) > 120
    for frame, pose in expected.items():
        numbers = ((*p.place, p.cos, p.sin) for p in (pose, found[frame]))
        for x, y in zip(*numbers, strict=True):
            assert isinstance(x, float) == isinstance(y, float) and ca.is_equal(as_expression(x), as_expression(y), 20)
