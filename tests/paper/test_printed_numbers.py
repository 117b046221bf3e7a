"""Every formula of every form, read back from its text, has at 20 random points the numbers of CasADi, to 1e-12 of its terms."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from helpers.casadi_numbers import POINTS, Reference, reference
from helpers.derived_once import derive_once
from helpers.evaluated import evaluated
from helpers.reading import Motion, NotRead, read
from helpers.symbolic_scenes import WRITTEN
from lagrangia.algebra.normal_form import TooLarge
from lagrangia.base.diagnostics import LagError
from lagrangia.paper.document import Display, Document, Heading
from lagrangia.paper.layout import Grid, Name, Relation
from lagrangia.paper.numbered import NUMBERED
from lagrangia.paper.sheet import Request, page_of
from lagrangia.paper.typeset import line

QUICK = ("suspended_bar", "disc_and_block_damped", "slider_crank", "cart_pole")
ELSEWHERE = ("Small motion", "Checks")  # compared with lag linearize, and in test_checks.py
BESIDE, ROUNDED = 1e-12, 1e-5  # of formulas with a decimal that is printed to six digits


@pytest.mark.parametrize("path", [pytest.param(path, id=path.stem, marks=() if path.stem in QUICK else pytest.mark.slow)
                                  for path in WRITTEN])
def test_every_printed_formula_has_its_value(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    derive_once(monkeypatch)
    structural = (("n", 3),) if path.stem == "chain" else ()
    for form in ("worked", "lagrange", "energies", *NUMBERED):
        try:
            book, page = page_of(path, Request(form, level="lecture"), None, dict(structural))
        except TooLarge:
            continue
        except LagError as error:
            assert form == "conservative" and "not conservative" in str(error)
            continue
        known = reference(path, book, structural)
        _of_form(form, known, book)
        checker = Checker(known)
        for formula in formulas(page):
            checker.check(formula)
        assert checker.wrong == []
        assert checker.compared, checker.skipped


def _of_form(form: str, known: Reference, book) -> None:
    """What f_nc and f_f mean in a form."""
    if form not in NUMBERED:
        return
    has_D, is_whole = any(kind == "D" for _, kind in NUMBERED[form].left), not any(k == "f_f" for _, k in NUMBERED[form].right)
    for key in [key for key in known.values if key.startswith("f_nc,")]:
        q = key.removeprefix("f_nc,")
        D, a, d = (known.values[f"{kind},{q}"] for kind in ("f_nc", "f_a", "f_d"))
        V_f = known.values[f"f_c,{q}"] - known.values[f"f_e,{q}"]
        known.values[key] = (0 if has_D else D) + d + (a if is_whole else 0)
        known.values[f"f_f,{q}"] = V_f + a
        known.values[f"f_{q}"] = known.values[f"f_c,{q}"] + known.values[key]


def formulas(page: Document) -> Iterator[str]:
    heading = ""
    for block in page.blocks:
        if isinstance(block, Heading):
            heading = block.text
        if isinstance(block, Display) and heading not in ELSEWHERE:
            yield from (line(formula) for formula in block.formulas)


class Checker:
    """Members of a row of equal signs agree; what stands alone on the left is known, or is known from there on."""

    def __init__(self, known: Reference) -> None:
        self.known, self.wrong, self.skipped, self.compared = known, [], [], 0
        self.motion = Motion(known.rates, known.virtual)

    def check(self, formula: str) -> None:
        if re.search("[⎡⎢⎣\\[{⎰⎧]|Σ|q_k|𝐪|for |otherwise|>", formula):
            self.skipped.append(formula)
            return
        parts = [part.strip() for part in re.split(r" = ", formula)]
        if formula.startswith(("Φ", "f_in,")) and parts[-1] == "0":
            parts.pop()  # what the random states do not keep
        try:
            read_ = [read(part, self.motion) for part in parts]
            sides = [self.numbers(x) for x in read_]
        except (NotRead, KeyError) as error:
            self.skipped.append(f"{formula}: {error!r}")
            self.define(parts)
            return
        is_equation = not read_[0].is_Symbol
        if is_equation:
            self.equation(formula, sides)
            return
        for x, size in sides[1:]:
            self.same(formula, sides[0], (x, size))

    def define(self, parts: list[str]) -> None:
        """A name that is not known yet: T_bar, V, L, E."""
        try:
            name = read(parts[0], self.motion)
            if name.is_Symbol and str(name) not in self.known.values:
                sides = [self.numbers(read(part, self.motion)) for part in parts[1:]]
                self.known.values[str(name)] = sides[-1][0]
                self.compared += 1
                for side in sides[:-1]:
                    self.same(" = ".join(parts), sides[-1], side)
        except (NotRead, KeyError):
            pass

    def equation(self, formula: str, sides) -> None:
        (left, a), (right, b) = sides[0], sides[-1]
        gap, near = left - right, _near(formula)
        ok = any(np.all(np.abs(gap - sign * r) <= near * (a + b + np.abs(r))) for r in self.known.residuals for sign in (1, -1))
        is_inertial = "∂" in formula or formula.startswith("f_in,")
        zero = np.all(np.abs(gap) <= near * (a + b))
        self.compared += 1
        if not (ok or (zero and is_inertial)):
            self.wrong.append(f"{formula}: {gap[:3]}")

    def same(self, formula: str, one, other) -> None:
        self.compared += 1
        if not np.all(np.abs(one[0] - other[0]) <= _near(formula) * (one[1] + other[1])):
            self.wrong.append(f"{formula}: {one[0][:3]} and {other[0][:3]}")

    def numbers(self, x: sp.Expr) -> tuple[np.ndarray, np.ndarray]:
        """Values, and the sum of the sizes of terms."""
        whole, size, known = np.zeros(POINTS), np.zeros(POINTS), dict[sp.Expr, np.ndarray]()
        for term in sp.Add.make_args(x):
            value = evaluated(term, self.known.values, known)
            whole = whole + value
            size = size + np.abs(value)
        has_slope = any("∂" in s.name for s in x.free_symbols)  # of whose terms CasADi tells nothing
        of_slope = np.abs(self.known.values["T"]) if has_slope else 0.0
        return whole, size + of_slope + 1e-300


def _near(formula: str) -> float:
    return ROUNDED if re.search(r"\d\.\d{3}|·10", formula) else BESIDE


# ---------------------------------------------------------------- matrices


def entries(page: Document, taken: set[tuple[str, str]]) -> dict[tuple[str, int, int], str]:
    """Of the matrices on a page, whole or entry by entry, and of what stands for itself (row -1): by letter, row and column."""
    found: dict[tuple[str, int, int], str] = {}
    for formula in (formula for block in page.blocks if isinstance(block, Display) for formula in block.formulas):
        name, right = formula, formula
        while isinstance(name, Relation):  # M12 = M21 = ...
            name, right = name.left, name.right if name is formula else right
        is_whole = isinstance(right, Grid)
        is_other = isinstance(name, Name) and (((name.base, name.sub) in taken and not is_whole) or name.argument == "t")
        if not isinstance(name, Name) or right is name or is_other:
            continue
        if isinstance(right, Grid):
            for i, row in enumerate(right.rows):
                found |= {(name.base, i, j): line(cell) for j, cell in enumerate(row) if not name.marks}
        elif name.base in "MhfJrbwA" and not name.marks and re.fullmatch(r"\d+( \d+)?|", name.sub):
            while isinstance(right, Relation):  # M12 = M21 = ..., Delta = squares = ...
                right = right.right
            indices = [int(k) - 1 for k in (name.sub.split() if " " in name.sub else name.sub)] or [0]
            i, j = indices if len(indices) == 2 else (indices[0], 0)
            found[name.base, i, j] = line(right)
            if name.base in "MA" and name.sub:
                found[name.base, j, i] = found[name.base, i, j]
        elif name.marks == 1 and name.base == "v":
            found[name.sub, -1, 0] = line(right)
    return found


Number = tuple[np.ndarray, np.ndarray]  # values, and the sum of the sizes of their terms
ZERO = (np.zeros(POINTS), np.zeros(POINTS))


class Pages:
    """The pages of matrices and of first order, as numbers."""

    def __init__(self, path: Path) -> None:
        structural = (("n", 3),) if path.stem == "chain" else ()
        book, self.page = page_of(path, Request("matrix"), None, dict(structural))
        _, self.first = page_of(path, Request("first-order"), None, dict(structural))
        self.known, self.e, self.names = reference(path, book, structural), book.equations, book.presentation.symbols.names
        self.checker = Checker(self.known)
        self.taken = {(x.base, x.sub) for x in self.names.values()}
        self.subs = [" ".join(filter(None, (q.base, q.sub))) for q in book.q]
        for sub, v in zip(self.subs, self.e.scene.v, strict=True):
            self.known.values[line(Name("v", sub))] = self.known.values[line(self.names[v])]
        self.near = _near(str(entries(self.page, self.taken)) + str(entries(self.first, self.taken)))

    def number(self, text: str) -> Number:
        return self.checker.numbers(read(text, self.checker.motion))

    def of_matrices(self) -> dict[tuple[str, int, int], Number]:
        return {key: self.number(text) for key, text in entries(self.page, self.taken).items() if key[1] >= 0}

    def of_first_order(self, M: np.ndarray) -> dict[tuple[str, int, int], Number]:
        """What is named on the page is known from there on."""
        texts, n = entries(self.first, self.taken), self.e.n
        for (base, i, j), text in texts.items():
            if i >= 0:
                label = "" if n == 1 else f"{i + 1}{j + 1}" if base in "MA" else str(i + 1)
                self.known.values[line(Name(base, label))] = self.number(text)[0]
        if n == 2:
            self.known.values["Δ"] = M[0, 0] * M[1, 1] - M[0, 1] ** 2
        return {key: self.number(text) for key, text in texts.items()}

    def values(self, symbols) -> list[np.ndarray]:
        return [self.known.values[line(self.names[x])] for x in symbols]


@pytest.mark.parametrize("path", [pytest.param(path, id=path.stem, marks=() if path.stem in QUICK else pytest.mark.slow)
                                  for path in WRITTEN])
def test_every_printed_matrix_has_its_numbers(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """M q'' + h + J^T lambda - f of the matrices as printed is what CasADi has; v' of the first-order form is its solution."""
    derive_once(monkeypatch)
    try:
        pages = Pages(path)
    except TooLarge:
        pytest.skip("its equations are too large to be read")
    n, whole = pages.e.n, pages.of_matrices()
    a, multipliers = pages.values(pages.e.scene.a), pages.values(pages.e.multipliers)
    forces: list[Number] = []  # f - h - J^T lambda
    for k in range(n):
        left = [(whole.get(("M", k, j), ZERO), a[j]) for j in range(n)]
        right = [(whole.get(("f", k, 0), ZERO), 1.0), (whole.get(("h", k, 0), ZERO), -1.0),
                 *((whole.get(("J", i, k), ZERO), -x) for i, x in enumerate(multipliers))]
        force, size = sum(x * y for (x, _), y in right), sum(np.abs(s * y) for (_, s), y in (*left, *right)) + 1e-300
        value = sum(x * y for (x, _), y in left) - force
        assert np.all(np.abs(value - pages.known.residuals[k]) <= 10 * pages.near * size), (k, value, pages.known.residuals[k])
        forces.append((force, size))
    M = np.array([[whole.get(("M", i, j), ZERO)[0] for j in range(n)] for i in range(n)])
    solved = pages.of_first_order(M)
    rates = [solved[sub, -1, 0][0] for sub in pages.subs if (sub, -1, 0) in solved]
    for k, (force, size) in enumerate(forces):
        if len(rates) == n:
            parts = [M[k, j] * rates[j] for j in range(n)]
            assert np.all(np.abs(sum(parts) - force) <= 10 * pages.near * (size + sum(map(np.abs, parts))))
        else:  # M v' = r
            assert np.all(np.abs(solved["r", k, 0][0] - force) <= 10 * pages.near * size)
