"""Written equations of hinges in space: forms agree with each other and with known ones; points and angular velocities."""

from pathlib import Path

import pytest
import sympy as sp

from helpers.symbolic_scenes import Derived, derived, vanishes
from lagrangia.command.cli import main
from lagrangia.paper.numbered import NUMBERED
from paper.test_equations import the_two_derivations_agree

GIMBALS = """
model Gimbals "A gyroscope in massive gimbals (E.J. Routh)"
  parameter Inertia A = 0.004, C = 0.006, A1 = 0.003, B1 = 0.0035, C1 = 0.005, C2 = 0.01;
  World world(gravity = {0, 0, -9.81});
  Revolute outer(a = world, phi(start = 0));
  Body ring(m = 1, I = {A1, A1, C2}, center = outer.b);
  Revolute inner(a = outer.b, axis = {1, 0, 0}, phi(start = 1));
  Body frame(m = 1, I = {A1, B1, C1}, center = inner.b);
  Revolute spin(a = inner.b, phi(start = 0), w(start = 100));
  Body rotor(m = 1, I = {A, A, C}, center = spin.b);
end Gimbals;
"""


@pytest.fixture(scope="module")
def gimbals(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Derived]:
    path = tmp_path_factory.mktemp("gimbals") / "gimbals.lag"
    path.write_text(GIMBALS, encoding="utf-8")
    return path, derived(path)


def test_gimbals_have_their_known_equations(gimbals: tuple[Path, Derived]) -> None:
    _, d = gimbals
    A, C, A1, B1, C1, C2 = (d[name] for name in ("A", "C", "A1", "B1", "C1", "C2"))
    theta, u, v, w = (d[name] for name in ("inner.phi", "der(outer.phi)", "der(inner.phi)", "der(spin.phi)"))
    s, c = sp.sin(theta), sp.cos(theta)
    assert vanishes(d.equations.T - (C2 * u**2 + (A1 + A) * v**2 + (B1 + A) * u**2 * s**2 + C1 * u**2 * c**2
                                     + C * (w + u * c) ** 2) / 2)
    assert vanishes(d.equations.momenta[2] - C * (w + u * c))
    assert vanishes(d.motion(1) - ((A1 + A) * d["der(der(inner.phi))"] + (C1 - B1 - A) * u**2 * s * c + C * (w + u * c) * u * s))


@pytest.mark.parametrize("form", ["worked", "lagrange", "matrix", "linear", *NUMBERED])
def test_every_form_is_there(form: str, gimbals: tuple[Path, Derived], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["equations", str(gimbals[0]), "--form", form, "--names", "inner.phi=theta,outer.phi=phi,spin.phi=psi"]) == 0
    told = capsys.readouterr()
    assert "θ" in told.out and "bug" not in told.err


def test_the_derivation_speaks_of_angular_velocities(gimbals: tuple[Path, Derived], capsys: pytest.CaptureFixture[str]) -> None:
    main(["equations", str(gimbals[0]), "--form", "worked", "--names", "inner.phi=theta,outer.phi=phi,spin.phi=psi"])
    told = capsys.readouterr().out
    assert "ω_rotor,3 = φ' cos θ + ψ'" in told and "T_rotor = ½ A ω_rotor,1² + ½ A ω_rotor,2² + ½ C ω_rotor,3²" in told
    assert "p_ψ = ∂T/∂ψ' = C φ' cos θ + C ψ'" in told
    assert "Assumed: gravity does no work here; joints" in told  # it pulls, but at what does not move


def test_places_have_three_components(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "swing.lag"
    path.write_text("""
        model Swing
          parameter Length L = 1;
          World world(gravity = {0, 0, -9.81});
          Revolute hinge(a = world, axis = {0, 1, 0}, phi(start = 1));
          PointMass bob(m = 2, center = shift(hinge.b, {0, 0, -L}));
        end Swing;""", encoding="utf-8")
    assert main(["equations", str(path), "--form", "worked"]) == 0
    told = capsys.readouterr().out
    assert "r_bob = (− L sin φ, 0, − L cos φ)" in told and "m L² φ'' + m g L sin φ = 0" in told


LONG_ROOT = """
model Drawn "a spring between slanted points"
  parameter Length a = 0.5, b = 0.4, h = 0.3;
  World world(gravity = {0, 0, -9.81});
  Revolute p(a = world), q(a = shift(p.b, {a, 0, 0}), axis = {0, 1, 0}), r(a = shift(q.b, {b, 0, 0}), axis = {0, 1, 0});
  PointMass end_mass(m = 1, center = shift(r.b, {h, 0, 0}));
  Spring s(k = 50, s_rel0 = 0.2, a = shift(world, {0.1, 0.2, 0.9}), b = end_mass.center);
end Drawn;
"""


def test_long_roots_are_broken(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By their squares, which reach over lines."""
    path = tmp_path / "drawn.lag"
    path.write_text(LONG_ROOT, encoding="utf-8")
    assert main(["equations", str(path), "--form", "energies"]) == 0
    told = capsys.readouterr().out
    assert "ℓ² = 2 a b cos φ_q" in told and "ℓ ≥ 0" in told and "√" not in told
    assert max(map(len, told.splitlines())) <= 100
    assert main(["equations", str(path), "--form", "energies", "--format", "latex"]) == 0
    told = capsys.readouterr().out
    assert r"\sqrt" not in told and r"{\ell}^{2}" in told


def test_torques_on_attitudes(tmp_path: Path) -> None:
    """M . dw/dv, as CasADi has it; no torque of three components has a potential."""
    path = tmp_path / "torque.lag"
    path.write_text("""
        model Pushed
          parameter Torque M[3] = {1, 2, 3};
          World world(gravity = {0, 0, -9.81});
          Universal joint(a = world, phi_a(start = 1));
          Body body(m = 2, I = {1, 1.5, 2}, center = shift(joint.b, {0, 0, 1}));
        energy
          work M on body.center.attitude;
        end Pushed;""", encoding="utf-8")
    d = derived(path)
    the_two_derivations_agree(path, d)
    theta = d["joint.phi_a"]
    assert vanishes(d.equations.f[0] - 1)
    assert vanishes(d.equations.f[1] - (d["M[2]"] * sp.cos(theta) + d["M[3]"] * sp.sin(theta)))
    assert main(["equations", str(path), "--form", "worked"]) == 0


def test_what_takes_too_many_products_says_so(gimbals: tuple[Path, Derived], capsys: pytest.CaptureFixture[str],
                                              monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("lagrangia.paper.sheet.MOST_FORCED_PRODUCTS", 10)
    assert main(["equations", str(gimbals[0]), "--force", "--format", "sympy"]) == 2
    assert "too large even when forced: they take more than 10 products" in capsys.readouterr().err
