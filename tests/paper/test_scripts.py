"""SymPy scripts: what they build, what they derive once more, and that they notice what is wrong."""

import re
from pathlib import Path
from typing import Any

import pytest
import sympy as sp

from helpers.symbolic_scenes import derived
from lagrangia.command.cli import main
from paper.test_equation_pages import ALL, LARGE, equations


@pytest.mark.parametrize("path", [path for path in ALL if path.stem not in LARGE], ids=lambda path: path.stem)
def test_scripts_build_the_same_equations(path: Path, capsys) -> None:
    """Executed, and compared by symbolic equality, symbol by symbol."""
    space: dict[str, object] = {}
    script = equations(capsys, path.stem, "--format", "sympy")
    exec(script, space)
    e = derived(path).equations
    mine = sp.Matrix([e.left[k] + e.reactions[k] - e.f[k] for k in range(e.n)])
    theirs = space["equations"]
    assert isinstance(theirs, sp.MatrixBase)
    renamed: dict[object, sp.Expr] = {}
    for theirs_name, ours in (("q", e.scene.q), ("v", e.scene.v), ("a", e.scene.a), ("multipliers", e.multipliers)):
        renamed |= dict(zip(space.get(theirs_name, ()), ours, strict=True))  # type: ignore[call-overload]
    commented = re.findall(r"^(\w+) = sp\.Symbol\(.*?\)  # ([^\s,]+)", script, re.MULTILINE)
    known = {p.name: p.symbol for p in e.scene.parameters} | {str(x): x for g in e.scene.given for x in g.moving}
    renamed |= {space[name]: known[source] for name, source in commented if source in known}
    for x, y in zip(theirs, mine, strict=True):
        assert e.ring.is_zero(x.subs(renamed) - y)


@pytest.mark.parametrize("form", ["lagrange", "5.16", "5.21", "5.23", "5.27", "dissipation"])
def test_scripts_derive_their_equations_again(form: str, capsys) -> None:
    """Run, they end without a word; with another T, they do not."""
    script = equations(capsys, "suspended_bar", "--format", "sympy", "--form", form)
    exec(script, {"__name__": "__main__"})
    wrong = re.sub(r"^(T = .*)$", r"\1 + m*s_d**2*s", script, flags=re.MULTILINE)
    with pytest.raises(AssertionError):
        exec(wrong, {"__name__": "__main__"})
    capsys.readouterr()


def test_letters_that_stand_nowhere_are_told(capsys) -> None:
    bar = str(ALL[0].with_name("suspended_bar.lag"))
    assert main(["equations", bar, "--names", "W=tau,D=sigma"]) == 0
    told = capsys.readouterr()
    assert "warning[L0224]: --names W=tau has no effect: 'W' stands nowhere" in told.err and "D=sigma" not in told.err
    assert main(["equations", bar, "--names", "W=tau,D=sigma", "--form", "worked"]) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(("name", "form", "wrong"), [
    ("double_pendulum", "first-order", ("M = sp", "rates_of_v = M.LUsolve(r) + r  #")),
    ("suspended_bar", "linear", ("K_0 = sp", "")), ("rolling_disc", "matrix", ("h = sp", "")),
    ("pendulum", "energies", ("V = ", "")), ("disc_and_block_damped", "worked", ("D = ", "")),
    ("spring_pendulum", "linear", ("M_0 = sp", "")), ("cart_pole", "linear", ("C_0 = sp", ""))])
def test_scripts_of_the_other_forms_assert_them(name: str, form: str, wrong: tuple[str, str], capsys) -> None:
    """Run, they end without a word; with one line doubled, they do not."""
    script = equations(capsys, name, "--format", "sympy", "--form", form)
    exec(script, {"__name__": "__main__"})
    begin, instead = wrong
    changed = (re.sub(r"rates_of_v = M.LUsolve\(r\)  #", instead, script) if instead
               else re.sub(rf"^({re.escape(begin)}.*?)(?=^\S)", lambda m: f"{m[1]}{m[1].split()[0]} *= 2\n", script, count=1,
                           flags=re.MULTILINE | re.DOTALL))
    assert changed != script
    with pytest.raises(AssertionError):
        exec(changed, {"__name__": "__main__"})
    capsys.readouterr()


def test_programs_have_the_signs_of_lengths_that_start_positive(tmp_path: Path, capsys) -> None:
    """A mass falls through the anchor of its spring: V = k (|s| - L)^2/2, which people read for s > 0. At s = -0.3 the spring
    pulls with k (0.3 - L); a script and a Modelica model that go on there had k (-0.3 - L)."""
    file = tmp_path / "m.lag"
    file.write_text("""model M Prismatic p(a = world, along = {0, 1}, s(start = 0.2)); PointMass q(m = 1, center = p.b);
      Spring spring(a = world, b = p.b, k = 3, s_rel0 = 0.1); end M;""")
    assert main(["equations", str(file)]) == 0 and "s > 0" in capsys.readouterr().out
    space: dict[str, Any] = {}
    assert main(["equations", str(file), "--format", "sympy"]) == 0
    exec(capsys.readouterr().out, space)
    pull = space["h"].xreplace(space["values"])[0].subs(space["s"], -0.3)
    assert float(pull) == pytest.approx(9.81 - 3*(0.3 - 0.1))
    assert main(["export", str(file), "--to", "modelica", "-o", "-"]) == 0 and "sign(s)" in capsys.readouterr().out


def test_what_turns_over_at_no_length_has_no_pole_and_no_slope_there(tmp_path: Path, capsys) -> None:
    """|s|' = s s'/|s|, whose rate is 0 beside s = 0: s'^2/|s| - s'^2 sgn s/s was written, no number at s = 0."""
    file = tmp_path / "m.lag"
    file.write_text("""model M Prismatic p(a = world, along = {0, 1}, s(start = 0.2)); PointMass q(m = 1, center = p.b);
      coordinate Length z(start = 0.1);
      energy kinetic 0.5[kg]*(der(z) + der(distance(world, p.b)))^2; potential 3[N/m]*distance(world, p.b)*z; end M;""")
    assert main(["export", str(file), "--to", "modelica", "-o", "-"]) == 0
    assert "z_dd + sign(s)*s_dd + 3*abs(s) = 0;" in capsys.readouterr().out
    assert main(["equations", str(file), "--format", "sympy", "--form", "linear"]) == 2  # it rests at s = 0
    assert "no slope at the point" in capsys.readouterr().err
    assert main(["equations", str(file), "--format", "sympy", "--form", "linear", "--about", "p.s=0.2,z=0"]) == 0
    exec(capsys.readouterr().out, {"__name__": "__main__"})


def test_a_linear_form_without_parameters(tmp_path: Path, capsys) -> None:
    """Its script asserted by values that it had not."""
    file = tmp_path / "m.lag"
    file.write_text("""model M coordinate Real x(start = 1), y, z;
      energy kinetic 0.5*(der(x)^2 + 2*der(y)^2 + der(z)^2); potential x^2/2 + y^2 + x*z; equation x + y + z = 1; end M;""")
    assert main(["equations", str(file), "--format", "sympy", "--form", "linear"]) == 0
    script = capsys.readouterr().out
    exec(script, {"__name__": "__main__"})
    with pytest.raises(AssertionError):
        exec(re.sub(r"^K_0 = .*$", "K_0 = sp.eye(2)", script, flags=re.MULTILINE), {"__name__": "__main__"})
