"""Attitudes in written equations by Euler's angles, and what cyclic coordinates leave to move."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import lagrangia as lag
from lagrangia.command.cli import main
from lagrangia.compile.pipeline import compile_energies
from lagrangia.paper.equations import sum_of
from lagrangia.paper.numbered import NUMBERED
from lagrangia.paper.sheet import parameter_values
from lagrangia.paper.symbolic import build_symbolic

TOP = """
model Top "A symmetric top on its tip (J.-L. Lagrange)"
  parameter Mass m = 0.5;
  parameter Length l = 0.1;
  parameter Inertia A = 0.0058 "about the tip", C = 0.001;
  World world(gravity = {0, 0, -9.81});
  Spherical tip(a = world);
  Body top(m = m, I = {A - m*l^2, A - m*l^2, C}, center = shift(tip.b, {0, 0, l}));
end Top;
"""
TWO = """
model Two "A body that floats, with another one on a ball joint"
  World world(gravity = {0, 0, -9.81});
  Body hull(m = 2, I = {0.3, 0.4, 0.6}, center(Q(start = angles("SEQ", 0.3, 0.7, -0.4)), omega(start = {W})));
  Spherical joint(a = shift(hull.center, {0.1, 0.2, 0.3}), S(start = angles("SEQ", -0.5, 0.6, 0.2)), w(start = {V}));
  Body arm(m = 1, I = {0.1, 0.2, 0.25}, center = shift(joint.b, {0, 0, 0.4}));
end Two;
"""


def equations(tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, *options: str) -> str:
    path = tmp_path / "scene.lag"
    path.write_text(text, encoding="utf-8")
    assert main(["equations", str(path), *options]) == 0
    return capsys.readouterr().out


def test_the_top_of_lagrange(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told = equations(tmp_path, capsys, TOP, "--angles", "zxz", "--form", "worked")
    for line in ("ω_top,3 = φ' cos θ + ψ'", "A θ'' − (A − C) φ'² sin θ cos θ + C φ' ψ' sin θ − m g l sin θ = 0",
                 "p_φ = ∂T/∂φ' = C φ' cos² θ + A φ' sin² θ + C ψ' cos θ", "p_ψ = ∂T/∂ψ' = C φ' cos θ + C ψ'",
                 "φ' = (p_φ − p_ψ cos θ)/(A sin² θ)", "ψ' = p_ψ/C − φ' cos θ",
                 "V_eff = m g l cos θ + (p_φ − p_ψ cos θ)²/(2 A sin² θ) + p_ψ²/(2 C)", "E = ½ A θ'² + V_eff"):
        assert line in told


@pytest.mark.parametrize(("sequence", "wave"), [("zxz", "sin"), ("zyx", "cos")])
def test_where_the_angles_are_singular(sequence: str, wave: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """sin theta = 0, also at the point of small motion, or cos theta = 0, where it hangs: no word of a point."""
    told = " ".join(equations(tmp_path, capsys, TOP, "--angles", sequence, "--form", "linear").split())
    assert f"These coordinates are singular where {wave} θ = 0: there det 𝐌 = 0, and the equations give no" in told
    assert ("At this point det 𝐌 = 0: the coordinates are singular there" in told) == (sequence == "zxz")


def test_hinges_that_are_angles(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Gimbals without mass: the axes of two hinges agree where the third is at 0 or half a turn; with mass nowhere."""
    gimbals = """
model Gimbals
  World world(gravity = {0, 0, -9.81});
  Revolute outer(a = world, axis = {0, 0, 1}), inner(a = outer.b, axis = {1, 0, 0}), axle(a = inner.b, axis = {0, 0, 1});
  Body rotor(m = 2, I = {0.1, 0.1, 0.15}, center = shift(axle.b, {0, 0, 0.1}));
  FRAME
end Gimbals;
"""
    assert "singular where sin φ_inner = 0" in equations(tmp_path, capsys, gimbals.replace("FRAME", ""))
    ring = "Body ring(m = 1, I = {0.1, 0.1, 0.15}, center = outer.b);"
    assert "singular" not in equations(tmp_path, capsys, gimbals.replace("FRAME", ring))


def test_numbers_of_the_effective_potential(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Multiplied out: not 2 0.001."""
    told = equations(tmp_path, capsys, TOP, "--angles", "zxz", "--numbers")
    assert "V_eff = 0.4905 cos θ + (p_φ − p_ψ cos θ)²/(0.0116 sin² θ) + p_ψ²/0.002\n  E = 0.0029 θ'² + V_eff" in told


@pytest.mark.parametrize("form", ["lagrange", "energies", "matrix", "first-order", *NUMBERED])
def test_every_form_of_the_top(form: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "θ" in equations(tmp_path, capsys, TOP, "--angles", "zxz", "--form", form)


def test_small_motion_in_angles(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    hanging = TOP.replace("{0, 0, -9.81}", "{0, -9.81, 0}").replace("{0, 0, l}", "{0, -l, 0}")
    point = "tip.phi=0,tip.theta=0,tip.psi=0"
    told = equations(tmp_path, capsys, hanging, "--angles", "zxy", "--form", "linear", "--about", point)
    assert "φ = θ = ψ = 0" in told and "C + m l²" in told


@pytest.mark.parametrize("sequence", ["zyx", "zxz", "xyz"])
def test_energies_are_those_of_the_motion(sequence: str, tmp_path: Path) -> None:
    """Of angles and their rates as SciPy turns them, and their differences."""
    angles, rates = np.array([[0.3, 0.7, -0.4], [-0.5, 0.6, 0.2]]), np.array([[0.5, -0.2, 0.9], [1.1, 0.3, -0.8]])

    def turned(k: int, t: float) -> Rotation:
        return Rotation.from_euler(sequence.upper(), angles[k] + t * rates[k])

    h = 1e-5
    omegas = [(turned(k, -h).inv() * turned(k, h)).as_rotvec() / (2 * h) for k in (0, 1)]
    text = TWO.replace("SEQ", sequence)
    for letter, w in zip("WV", omegas, strict=True):
        text = text.replace("{" + letter + "}", "{" + ", ".join(repr(float(x)) for x in w) + "}")
    path = tmp_path / "scene.lag"
    path.write_text(text, encoding="utf-8")
    kinematics, constraints = compile_energies(path, has_angles=True)
    scene, numbers = build_symbolic(kinematics, constraints, angles=sequence), parameter_values(kinematics)
    owners = ("hull.center", "joint")
    values = {f"{owner}.{letter}": (angles[k][j], rates[k][j]) for k, owner in enumerate(owners)
              for j, letter in enumerate(("phi", "theta", "psi"))}
    known = {x: values.get(name, (0, 0))[k] for k, symbols in enumerate((scene.q, scene.v))
             for x, name in zip(symbols, scene.names, strict=True)} | {p.symbol: numbers[p.name] for p in scene.parameters}
    start = lag.loads(text).simulate(stop=1e-3, interval=1e-3).energy
    for terms, wanted in ((scene.energies.kinetic, start.kinetic), (scene.energies.potential, start.potential)):
        assert float(sum_of(terms).xreplace(known).evalf()) == pytest.approx(wanted[0], rel=1e-8)


def test_what_is_wrong_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "scene.lag"
    path.write_text(TOP, encoding="utf-8")
    for options, told in ((["--form", "worked"], "--angles zxz"), (["--angles", "zzx"], "L0704")):
        assert main(["equations", str(path), *options]) == 2
        assert told in capsys.readouterr().err
    hinges = TOP.replace("Spherical", "Universal")
    path.write_text(hinges, encoding="utf-8")
    assert main(["equations", str(path), "--angles", "zxz"]) == 2
    assert "no attitude is a coordinate" in capsys.readouterr().err


def test_a_planet_has_an_effective_potential(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told = equations(tmp_path, capsys, """
        model Orbit
          parameter Real k(unit = "N.m2") = 2;
          World world(gravity = {0, 0});
          Revolute turn(a = world);
          Prismatic out(a = turn.b, s(start = 1));
          PointMass body(m = 3, center = out.b);
        energy
          potential -k/out.s;
        end Orbit;""")
    assert "φ' = p_φ/(m s²)" in told and "p_φ²/(2 m s²)" in told and "E = ½ m s'² + V_eff" in told


def test_a_gyroscope_in_gimbals_has_an_effective_potential(capsys: pytest.CaptureFixture[str]) -> None:
    """Its lines are too wide with the inertia about the vertical written out, which has a name of its own there."""
    assert main(["equations", str(Path(__file__).parents[2] / "models" / "examples" / "gyroscope.lag")]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert ("V_eff = 0.02 m g cos φ_inner + (p_φ,outer − p_φ,spinning cos φ_inner)²/(2 J_φ,outer) + p_φ,spinning²/(2 I_rotor,3)"
            in told)
    assert "J_φ,outer = I_inner_gimbal,3 cos² φ_inner + (I₂ + 0.0004 m + I_rotor,1) sin² φ_inner + I_outer_gimbal,3" in told
