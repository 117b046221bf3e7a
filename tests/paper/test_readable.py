"""Formulas as a person writes them: order, common factors, brackets, signs. Each scene is the sample of a kind."""

from pathlib import Path

import pytest

from lagrangia.paper.sheet import Request, write_equations

SCENES = {
    "atwood": ("parameter Mass m1 = 3, m2 = 2; parameter Length R = 0.1; parameter Inertia I = 0.02; Revolute axle(a = world);"
               "Body pulley(m = 4, I = I, center = axle.b); Block left(m = m1, base = world, along = {0, -1}),"
               "right(m = m2, base = world, along = {0, -1}); Rack l(r = R, s = left.s, phi = axle.phi),"
               "r(r = -R, s = right.s, phi = axle.phi);", {
                   "lagrange": ["(I + (m₁ + m₂) R²) φ'' = (m₁ − m₂) g R"]}),
    "a cylinder in a cylinder": (
        "parameter Mass m = 2; parameter Length R = 1, r = 0.2; parameter Inertia I = 0.1;"
        "Revolute arm(a = turn(world, -90[deg])); Revolute spin(a = shift(arm.b, {R - r, 0}));"
        "Body cylinder(m = m, I = I, center = spin.b); equation r*spin.phi = -R*arm.phi;", {
            "lagrange": ["(m + I/r²) (R − r)² φ_arm'' + m g (R − r) sin φ_arm = 0"],
            "energies": ["V = − m g (R − r) cos φ_arm"]}),
    "a spring pendulum": (
        "parameter Mass m = 1; parameter Length L0 = 1; parameter Stiffness k = 30; Revolute hinge(a = turn(world, -90[deg]));"
        "Prismatic arm(a = hinge.b, s(start = 1.2)); PointMass bob(m = m, center = arm.b);"
        "Spring spring(k = k, s_rel0 = L0, a = world, b = bob.center);", {
            "lagrange": ["m s'' − m s φ'² − m g cos φ + k (s − L₀) = 0", "All that follows is for s > 0."],
            "first-order": ["v_φ' = − 2 v_φ v_s/s − g sin φ/s"],
            "linear": ["⎡ m (L₀ + m g/k)²  0 ⎤", "⎡ m g (L₀ + m g/k)  0 ⎤"]}),
    "a bead on a hoop": (
        "parameter Mass m = 1; parameter Length R = 0.5; parameter AngularVelocity W = 8; parameter Acceleration g = 9.81;"
        "coordinate Angle phi; energy kinetic m*R^2*der(phi)^2/2 + m*(W*R*sin(phi))^2/2; potential -m*g*R*cos(phi);", {
            "first-order": ["v_φ' = W² sin φ cos φ − g sin φ/R"]}),
    "a cart with a pendulum": (
        "parameter Mass M = 2, m = 1; parameter Length l = 1; Block cart(m = M, base = world);"
        "Revolute hinge(a = turn(cart.center, -90[deg])); PointMass bob(m = m, center = shift(hinge.b, {l, 0}));", {
            "first-order": ["Δ = M₁₁ M₂₂ − M₁₂² = m l² (M + m sin² φ)"]}),
    "a quadratic damper": (
        "parameter Real c(unit = \"N.s2/m2\") = 2; Block b(m = 1, base = world); QuadraticDamper d(c = c, rate = b.v);", {
            "lagrange": ["m s'' + c |s'| s' = 0"], "energies": ["D = ⅓ c |s'|³"]}),
    "a source with a potential": (
        "parameter Length L = 2, a = 1.5; coordinate Length x; coordinate Angle theta; parameter Mass m = 1;"
        "parameter Inertia I = 1; Force P = 50*sin(3*time);"
        "energy kinetic m*der(x)^2/2 + I*der(theta)^2/2; potential -P*(x + (a - L/2)*sin(theta));", {
            "lagrange": ["m x'' = P(t)", "I θ'' = P(t) (a − ½ L) cos θ"]}),
    "dry friction along a distance": (
        "parameter Force R = 2; Block b(m = 1, base = world, s(start = 1)); DryFriction f(F = R, a = world, b = b.center);", {
            "lagrange": ["R sgn(s')"]}),  # not sgn(s' sgn s)/sgn s, which is 0/0 at 0
    "its numbers without a name": (
        "parameter Length L = 2, a = 1.5; coordinate Angle theta; parameter Inertia I = 1;"
        "energy kinetic I*der(theta)^2/2; potential -50[N]*sin(3*time)*(a - L/2)*sin(theta);", {
            "lagrange": ["50 (½ L − a) sin(3 t) cos θ"]}),
    "decimals with letters below them and without": (
        "parameter Length l = 0.5; parameter Stiffness k = 10; World world(gravity = {0, 0});"
        "Planar p(a = world, x(start = 1), y(start = 0), phi(start = 0)); Body b(m = 2, I = 1, center = p.b);"
        "energy potential k*(0.12*p.x^3/l + 0.1275*p.x^2 + p.y^3*5/21/l + p.y^2/8 + p.y^4/16/l^2);", {
            "lagrange": ["0.36 k x²/l + 0.255 k x", "5 k y²/(7 l)", "k y³/(4 l²)"]}),
}


@pytest.mark.parametrize("what", SCENES)
def test_formulas_are_written_as_a_person_writes_them(what: str, tmp_path: Path) -> None:
    text, wanted = SCENES[what]
    (tmp_path / "scene.lag").write_text(f"model Scene\n  {text}\nend Scene;\n", encoding="utf-8")
    for form, lines in wanted.items():
        said = write_equations(tmp_path / "scene.lag", Request(form))
        for line in lines:
            assert line in said, said
        assert "− −" not in said and "+ −" not in said
