"""Euler's equations of attitudes as they are printed: read back, they have the numbers of the compiled motion."""

import re
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import lagrangia as lag
from helpers.reading import Motion, read
from helpers.symbolic_scenes import EXAMPLES
from lagrangia.command.cli import main
from lagrangia.paper.book import Book
from lagrangia.paper.document import Display
from lagrangia.paper.equations import constants_of_motion
from lagrangia.paper.sheet import Request, page_of
from lagrangia.paper.typeset import line

PULLED = """
model Pulled "A body on a ball joint, which is damped, pulled, turned and hung on a spring, with a hinge on it"
  parameter Torque M[3] = {1, 2, 3};
  parameter Force F = 4;
  World world(gravity = {0, 0, -9.81});
  Spherical joint(a = shift(world, {0.1, 0.2, 0}));
  Body body(m = 2, I = {0.3, 0.4, 0.6}, center = shift(joint.b, {0.1, 0.2, 0.4}));
  Revolute hinge(a = shift(body.center, {0.3, 0, 0}), axis = {0, 1, 0});
  PointMass tip(m = 0.5, center = shift(hinge.b, {0, 0, 0.2}));
  Spring spring(a = world, b = body.center, k = 30, s_rel0 = 0.2);
energy
  work M on body.center.attitude;
  work {F, 0, 0} on tip.center.r;
  dissipation 0.3*dot(joint.w, joint.w);
end Pulled;
"""
TWO = """
model Two "A body that floats, with another one on a ball joint"
  World world(gravity = {0, 0, -9.81});
  Body hull(m = 2, I = {0.3, 0.4, 0.6});
  Spherical joint(a = hull.center);
  Body arm(m = 1, I = {0.1, 0.1, 0.1}, center = joint.b);
end Two;
"""


class Compiled:
    """Numbers by printed names, and M v' + h + J^T lambda of the compiled scene, at a state at random."""

    def __init__(self, path: Path, book: Book) -> None:
        model, e, random = lag.load(path), book.equations, np.random.default_rng(5)
        scene, names = e.scene, book.presentation.symbols.names
        functions = model.functions()
        n, turnings = e.n, scene.turnings
        v, a, multipliers = (random.uniform(-2, 2, k) for k in (n, n, len(e.multipliers)))
        q = dict(zip(scene.names, random.uniform(0.2, 1.2, n), strict=True))
        told: dict[str, float] = {}
        for turning in turnings:
            quaternion = random.normal(size=4)
            told |= zip((f"{turning.name}[{k}]" for k in (1, 2, 3, 4)), quaternion / np.linalg.norm(quaternion), strict=True)
        positions = [told[name] if name in told else q[name] for name in model.position_names]
        arguments = 0.3, positions, v, [], model.parameter_values()
        self.wanted = np.array(functions["M"](*arguments)) @ a + np.array(functions["h"](*arguments)).ravel()
        if len(multipliers):
            self.wanted += np.array(functions["J"](*arguments)).T @ multipliers
        self.size = 1 + np.abs(self.wanted).max()
        self.turning = dict(zip(model.position_names, np.array(functions["turning"](*arguments)).ravel(), strict=True))
        known = {p.symbol: book.values[p.name] for p in scene.parameters}
        for symbols, numbers in ((scene.q, q.values()), (scene.v, v), (scene.a, a), (e.multipliers, multipliers)):
            known |= dict(zip(symbols, numbers, strict=True))
        self.parts = {line(names[x]): f"{turning.name}[{k}]" for turning in turnings for k, x in enumerate(turning.parts, 1)}
        self.values = {line(names[x]): value for x, value in known.items() if x in names}
        self.values |= {label: told[name] for label, name in self.parts.items()}

    def number(self, text: str) -> float:
        x = read(text, Motion({}, {}))
        return float(x.evalf(30, subs={s: self.values[str(s)] for s in x.free_symbols}))


def printed(path: Path, form: str = "lagrange") -> tuple[Book, list[str]]:
    book, page = page_of(path, Request(form, is_forced=True))
    return book, [line(x) for block in page.blocks if isinstance(block, Display) for x in block.formulas]


def scene_file(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "scene.lag"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("text", [PULLED, TWO, "top", "satellite", "rolling_disc_space"],
                         ids=["pulled", "two", "top", "satellite", "disc"])
def test_printed_equations_have_the_numbers_of_the_motion(text: str, tmp_path: Path) -> None:
    path = scene_file(tmp_path, text) if "\n" in text else EXAMPLES / f"{text}.lag"
    book, lines = printed(path)
    known = Compiled(path, book)
    for name in map(line, book.presentation.symbols.lengths.values()):  # ell = sqrt(...), or ell^2 = ...
        left, _, right = next(x for x in lines if x.startswith((f"{name} = ", f"{name}² = "))).partition(" = ")
        known.values[name] = known.number(right) ** (0.5 if left.endswith("²") else 1)
    equations = [x for x in lines if "∂" not in x and not x.startswith(("Φ", "ℓ", "E ", "p_", *known.parts))]
    equations = [re.sub(r"(?<== )\W*(drive) .*", r"\1", x) for x in equations]  # before it stops
    assert len(equations) == book.equations.n
    for text_, wanted in zip(equations, known.wanted, strict=True):
        left, _, right = text_.partition(" = ")
        assert abs(known.number(left) - known.number(right) - wanted) < 1e-12 * known.size
    rates = [x.split(" = ") for x in lines if re.match(r"Q\S*' = ", x)]
    assert len(rates) == 4 * len(book.equations.scene.turnings)
    for part, rate in rates:
        assert known.number(rate) == pytest.approx(known.turning[known.parts[part.replace("'", "")]], abs=1e-14)


def test_first_order_has_the_accelerations(tmp_path: Path) -> None:
    path = EXAMPLES / "top.lag"
    book, lines = printed(path, "first-order")
    known = Compiled(path, book)
    rates = {name: known.number(text) for name, text in (x.split(" = ") for x in lines if x.startswith("w"))}
    M = np.array([[float(x.xreplace({p.symbol: book.values[p.name] for p in book.equations.scene.parameters})) for x in row]
                  for row in book.equations.M])
    a = np.array([known.values[f"{name}"] for name in rates])
    assert np.allclose(M @ (a - list(rates.values())), known.wanted, rtol=1e-12, atol=1e-12 * known.size)


def test_the_top_reads_as_in_books(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["equations", str(EXAMPLES / "top.lag"), "--names", "top.I[1]=A,top.I[3]=C"]) == 0
    told = capsys.readouterr().out
    for wanted in ("d/dt ∂T/∂w₁ + w₂ ∂T/∂w₃ − w₃ ∂T/∂w₂ + ∂V/∂θ₁ = 0", "C w₃' = 0", "Q₁' = − ½ Q₂ w₁ − ½ Q₃ w₂ − ½ Q₄ w₃",
                   "(A + m l²) w₁' + (C − A − m l²) w₂ w₃ − 2 m g l Q₁ Q₂ − 2 m g l Q₃ Q₄ = 0"):
        assert wanted in told


@pytest.mark.parametrize("form", ["worked", "linear", "total"])
def test_other_forms_are_refused_by_name(form: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["equations", str(EXAMPLES / "top.lag"), "--form", form]) == 2
    told = capsys.readouterr().err
    assert "tip.S" in told and "--angles zxz" in told and "Euler's equations" in told


@pytest.mark.parametrize(("form", "format_"), [("energies", "latex"), ("matrix", "html"), ("lagrange", "markdown")])
def test_pages_of_other_formats_and_languages(form: str, format_: str, capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--form", form, "--format", format_, "--language", "de"]
    code = main(["equations", str(EXAMPLES / "satellite.lag"), *options])
    told = capsys.readouterr()
    assert code == 0 and "Einheitsquaternion" in told.out, told.err


KEPT = """
model Kept "A body that floats, and beside it a symmetric top"
  World world(gravity = {0, 0, -9.81});
  Body hull(m = 2, I = {0.3, 0.4, 0.6}, center(omega(start = {1, 2, 3})));
  Spherical tip(a = world, S(start = angles("zxz", 0, 0.5, 0)), w(start = {0.3, 0, 20}));
  Body top(m = 1, I = {0.1, 0.1, 0.2}, center = shift(tip.b, {0, 0, 0.1}));
end Kept;
"""


def test_angular_momenta_that_are_named_stay(tmp_path: Path) -> None:
    """All three of what floats, in the world's axes; of a top that about the vertical, and that about its own axis."""
    path = tmp_path / "kept.lag"
    path.write_text(KEPT)
    book = page_of(path, Request("lagrange"), None, {})[0]
    e = book.equations
    found = [c for c in constants_of_motion(e) if c.name == "angular momentum"]
    turnings = {t.name: t for t in e.scene.turnings}
    hull, tip = turnings["hull.center.S"], turnings["tip.S"]
    vertical = tip.places[2]
    assert {(c.coordinate, c.why) for c in found} == {*((k, "outside") for k in hull.places), (vertical, "outside"),
                                                      (vertical, "own")}
    run = lag.load(path).simulate(stop=2, tolerance=1e-12, interval=0.1)
    known = {x.symbol: book.values[x.name] for x in e.scene.parameters}
    told = {part: run[f"{t.name}[{k}]"] for t in turnings.values() for k, part in enumerate(t.parts, 1)}
    told |= {e.scene.v[place]: run[f"der({t.name})[{k}]"] for t in turnings.values() for k, place in enumerate(t.places, 1)}
    for c in found:
        along = sp.lambdify([*told], c.value.subs(known), "numpy")(*told.values())
        assert np.ptp(along) < 1e-10
        assert np.abs(along).max() > 0.1
