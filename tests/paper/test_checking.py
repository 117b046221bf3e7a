"""`lag equations --check`: a right equation in many dresses, a wrong one with the term that is wrong, and what cannot be read."""

import pytest

from helpers.symbolic_scenes import CLASSROOM, EXAMPLES
from lagrangia.command.cli import main

BAR = ["equations", str(EXAMPLES / "suspended_bar.lag"), "--names", "guide.s=x,tilt.phi=theta", "--check"]
FIRST = "m*x'' + (c1 + c2)*x' + (c2 - c1)*L/2*theta'*cos(theta) + (k1 + k2)*x + L/2*(k2 - k1)*sin(theta)"
SECOND = ("bar.I*theta'' + (c2 - c1)*L/2*x'*cos(theta) + L^2/4*(c1 + c2)*theta'*cos(theta)^2 + L/2*(k2 - k1)*x*cos(theta)"
          " + L^2/4*(k1 + k2)*sin(theta)*cos(theta) - P(t)*(a - L/2)*cos(theta)")


@pytest.mark.parametrize("equation", [
    f"{FIRST} = P(t)", f"P - ({FIRST}) = 0", f"({FIRST})/m = P/m", f"{SECOND} = 0", f"({FIRST} - P)*L + 3*({SECOND}) = 0",
    f"({FIRST} - P)*cos(theta) = 0", FIRST.replace("theta", "θ").replace("k1", "k₁").replace("x'", "guide.s'") + " = P(t)",
])
def test_right(equation: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*BAR, equation]) == 0
    assert "is an equation of the scene" in capsys.readouterr().out


@pytest.mark.parametrize(("equation", "told"), [
    (f"{FIRST.replace('k1 + k2', 'k1 - k2')} = P(t)", "− 2 k₂ x"), (f"{FIRST} = 2*P(t)", "− P(t)"),
    (f"{FIRST} = P(t) + 2*m*theta''", "Its accelerations are not"), ("k1*x = P(t)", "No acceleration"),
    (f"{SECOND.replace('cos(theta)^2', 'cos(theta)')} = 0", "(c₁ + c₂) L² θ' cos θ"),
])
def test_wrong(equation: str, told: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*BAR, equation]) == 1
    said = capsys.readouterr().out
    assert told in said and "is an equation of the scene" not in said


@pytest.mark.parametrize("equation", ["m*x''", "m*x'' = = 0", "m*x'' + q*x = 0", "m x'' = 0", "m*x''^(9^9^9) = 0",
                                      "__import__('os') = 0", "m*x''/0 = 0", "a[0] = 0", "x''*sqrt(-5-x^2) = 0"])
def test_unreadable(equation: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*BAR, equation]) == 2
    assert "error[L0706]" in capsys.readouterr().err


# -------------------------------------------------------------------- scenes with constraints

ROLLING = ["equations", str(CLASSROOM / "rolling_with_multiplier.lag"), "--check"]
CRANK = ["equations", str(EXAMPLES / "slider_crank.lag"), "--check"]


@pytest.mark.parametrize(("scene", "equation"), [
    (ROLLING, "m*(R - r)^2*phi'' + m*g*(R - r)*sin(phi) + (R - r)*lambda = 0"), (ROLLING, "I*theta'' + r*λ = 0"),
    (ROLLING, "(m + I/r^2)*(R - r)^2*phi'' + m*g*(R - r)*sin(phi) = 0"),  # without its multiplier
    (ROLLING, "m*(R - r)^2*phi'' + m*g*(R - r)*sin(phi) - (R - r)/r*I*theta'' = 0"),
    (CRANK, "piston.m*guide.s'' = -λ_1"),
])
def test_right_under_constraints(scene: list[str], equation: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*scene, equation]) == 0
    assert "is an equation of the scene" in capsys.readouterr().out


@pytest.mark.parametrize(("scene", "equation", "told"), [
    (ROLLING, "(m - I/r^2)*(R - r)^2*phi'' + m*g*(R - r)*sin(phi) = 0", "no equation of the scene"),
    (ROLLING, "m*(R - r)^2*phi'' + m*g*(R - r)*sin(phi) + R*lambda = 0", "r λ"),
    (ROLLING, "(R - r)*phi'' + r*theta'' = 0", "from the constraints alone"),
    (CRANK, "piston.m*guide.s'' = λ_1", "− 2 λ₁"),
])
def test_wrong_under_constraints(scene: list[str], equation: str, told: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*scene, equation]) == 1
    assert told in capsys.readouterr().out
