"""The checks at the end of a derivation: computed, and silent or outspoken where they do not hold."""

import random
from pathlib import Path

import pytest
import sympy as sp

from helpers.symbolic_scenes import EXAMPLES
from lagrangia.paper.check_steps import _Unlike, checks, dimension_of, dimensions_of
from lagrangia.paper.document import Display
from lagrangia.paper.layout import Relation
from lagrangia.paper.sheet import Request, page_of
from lagrangia.paper.typeset import line


def book_of(path: Path):
    return page_of(path, Request("worked"))[0]


def told(path: Path) -> str:
    said = page_of(path, Request("worked", sections=("checks",)))[1]
    words = [p if isinstance(p, str) else line(p) for b in said.blocks for p in getattr(b, "parts", getattr(b, "formulas", ()))]
    return "".join(words)


def test_terms_have_dimensions() -> None:
    known = dimensions_of(book_of(EXAMPLES / "suspended_bar.lag"))
    x, L = (next(s for s in known if str(s) == name) for name in ("guide.s", "L"))
    assert dimension_of(x**2 * sp.sin(x / L) + sp.Abs(L) * sp.sqrt(x * L), known) == dimension_of(L**2, known)
    for wrong in (x + x**2, sp.sin(x), x + 1, sp.Symbol("unknown") * x):
        with pytest.raises(_Unlike):
            dimension_of(wrong, known)


def test_numbers_with_units_leave_nothing_to_check(tmp_path: Path) -> None:
    text = "model Scene\n  Block b(m = 2, base = world); Spring s(k = 3, stretch = b.s - 0.1[m]);\nend Scene;\n"
    (tmp_path / "scene.lag").write_text(text, encoding="utf-8")
    assert "one unit" not in told(tmp_path / "scene.lag")
    (tmp_path / "scene.lag").write_text(text.replace(" - 0.1[m]", ""), encoding="utf-8")
    assert "one unit, s: N" in told(tmp_path / "scene.lag")


def test_a_mass_matrix_that_is_not_positive_is_said(tmp_path: Path) -> None:
    text = ("model Scene\n  coordinate Length x(start = 3), y; parameter Mass m = 1; parameter Stiffness k = 2;\n"
            "  energy kinetic m*(1 - x^2/1[m2])*der(x)^2/2 + m*der(y)^2/2; potential k*(x^2 + y^2);\nend Scene;\n")
    (tmp_path / "scene.lag").write_text(text, encoding="utf-8")
    assert "not positive" in told(tmp_path / "scene.lag")


@pytest.mark.parametrize("name", ["suspended_bar", "cart_pole", "stick_slip"])
def test_the_energy_theorem_holds_along_the_motion(name: str) -> None:
    """dT/dt + dV/dt by the accelerations that the equations give, beside the power that is printed."""
    book = book_of(EXAMPLES / f"{name}.lag")
    e, p = book.equations, book.parts
    formula = next(f for b in checks(book) if isinstance(b, Display) for f in b.formulas if line(f).startswith("d/dt"))
    assert isinstance(formula, Relation)
    V = p.V_elastic + p.V_field - sp.Add(*(x for _, x in p.sources))
    chance = random.Random(2)
    free = {x for y in (e.T, V, *e.left, *e.f) for x in y.free_symbols} - set(e.scene.a)
    symbols = sorted(free | {*e.scene.q, *e.scene.v}, key=str)
    at = {x: chance.uniform(0.3, 1.4) for x in symbols}
    push = sp.Matrix([f - h for f, h in zip(e.f, e.h, strict=True)]).subs(at)
    a = sp.Matrix(e.n, e.n, [x for row in e.M for x in row]).subs(at).LUsolve(push)
    rate = sum(((e.T + V).diff(q).subs(at) * at[v] for q, v in zip(e.scene.q, e.scene.v, strict=True)), sp.S.Zero)
    rate += sum((e.T.diff(v).subs(at) * x for v, x in zip(e.scene.v, a, strict=True)), sp.S.Zero)
    printed = power_of(book).subs(at)
    assert abs(float(rate - printed)) < 1e-12 * (1 + abs(float(printed)))
    assert book.sum(power_of(book)) == formula.right


def power_of(book) -> sp.Expr:
    """All generalised forces but those of T and V without sources, by the rates."""
    e, p = book.equations, book.parts
    V = p.V_elastic + p.V_field - sp.Add(*(x for _, x in p.sources))
    shares = [(f - left + momentum - slope + V.diff(q)) * v for f, left, momentum, slope, q, v in zip(
        e.f, e.left, e.momentum_rates, e.dT_dq, e.scene.q, e.scene.v, strict=True)]
    return e.ring.tidy(sp.Add(*shares))
