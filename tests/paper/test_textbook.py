"""The three scenes of a textbook's chapter on virtual work, formula by formula: (a) to (q), compared after parsing.

The formulas are those of the chapter in the names x, θ; that each stands on the page is tested, and that it is equal to it.
"""

from pathlib import Path

import pytest
import sympy as sp

from helpers.reading import Motion, NotRead, read
from helpers.symbolic_scenes import EXAMPLES
from lagrangia.paper.document import Display
from lagrangia.paper.layout import Grid
from lagrangia.paper.sheet import Request, page_of, write_equations
from lagrangia.paper.typeset import line

MOTION = Motion({"x": "x'", "θ": "θ'", "x'": "x''", "θ'": "θ''"}, {"x": "δx", "θ": "δθ"})
BAR = {"guide.s": "x", "tilt.phi": "theta"}
DISC = {"block.s": "x", "axle.phi": "theta"}

SPRINGS = [
    "V = ½ k₁ (x − ½ L sin θ)² + ½ k₂ (x + ½ L sin θ)² − P(t) (x + (a − ½ L) sin θ)",  # a
    "T = ½ m x'² + ½ I θ'²",  # b
    "∂T/∂x' = m x'", "d/dt ∂T/∂x' = m x''", "∂T/∂x = 0", "∂T/∂θ' = I θ'", "d/dt ∂T/∂θ' = I θ''", "∂T/∂θ = 0",
    "∂V/∂x = k₁ (x − ½ L sin θ) + k₂ (x + ½ L sin θ) − P(t)",
    "∂V/∂θ = − ½ k₁ L (x − ½ L sin θ) cos θ + ½ k₂ L (x + ½ L sin θ) cos θ − P(t) (a − ½ L) cos θ",
    "m x'' + (k₁ + k₂) x + ½ (k₂ − k₁) L sin θ = P(t)",  # c
    "I θ'' + ½ (k₂ − k₁) L x cos θ + ¼ (k₁ + k₂) L² sin θ cos θ = P(t) (a − ½ L) cos θ",  # d
    "m x'' + (k₁ + k₂) x + ½ (k₂ − k₁) L θ = P(t)",
    "I θ'' + ½ (k₂ − k₁) L x + ¼ (k₁ + k₂) L² θ = P(t) (a − ½ L)",
]
SPRINGS_MATRICES = {"M": "m, 0, 0, I", "K": "k₁ + k₂, ½ (k₂ − k₁) L, ½ (k₂ − k₁) L, ¼ (k₁ + k₂) L²",
                    "f": "P(t), P(t) (a − ½ L)"}  # e
DAMPERS = [
    "D = ½ c₁ (d/dt (x − ½ L sin θ))² + ½ c₂ (d/dt (x + ½ L sin θ))²",
    "D = ½ c₁ (x' − ½ L θ' cos θ)² + ½ c₂ (x' + ½ L θ' cos θ)²",
    "f_nc,x = − ∂D/∂x' = − (c₁ + c₂) x' − ½ (c₂ − c₁) L θ' cos θ",  # h
    "f_nc,θ = − ∂D/∂θ' = − ½ (c₂ − c₁) L x' cos θ − ¼ (c₁ + c₂) L² θ' cos² θ",  # i
    "δW_nc = − c₁ (x' − ½ L θ' cos θ) δ(x − ½ L sin θ) − c₂ (x' + ½ L θ' cos θ) δ(x + ½ L sin θ)",
    "δW_f = P(t) δ(x + (a − ½ L) sin θ) = P(t) δx + P(t) (a − ½ L) cos θ δθ",
    "f_f,x = P(t)", "f_f,θ = P(t) (a − ½ L) cos θ",  # m, n
    "V = ½ k₁ (x − ½ L sin θ)² + ½ k₂ (x + ½ L sin θ)² − P(t) (x + (a − ½ L) sin θ)",
    "m x'' + (c₁ + c₂) x' + ½ (c₂ − c₁) L θ' + (k₁ + k₂) x + ½ (k₂ − k₁) L θ = P(t)",  # j
    "I θ'' + ½ (c₂ − c₁) L x' + ¼ (c₁ + c₂) L² θ' + ½ (k₂ − k₁) L x + ¼ (k₁ + k₂) L² θ = P(t) (a − ½ L)",  # k
]
DAMPERS_MATRICES = SPRINGS_MATRICES | {"C": "c₁ + c₂, ½ (c₂ − c₁) L, ½ (c₂ − c₁) L, ¼ (c₁ + c₂) L²"}  # l
BLOCK = [
    "T = ½ m x'² + ½ I θ'²", "V = ½ k₁ x² + ½ k₂ (r θ − x)² − M(t) θ",
    "m x'' + k₁ x − k₂ (r θ − x) = 0", "m x'' + (k₁ + k₂) x − k₂ r θ = 0",  # o
    "I θ'' + k₂ r (r θ − x) − M(t) = 0", "I θ'' − k₂ r x + k₂ r² θ = M(t)",  # p
]
BLOCK_MATRICES = {"M": "m, 0, 0, I", "K": "k₁ + k₂, − k₂ r, − k₂ r, k₂ r²", "f": "0, M(t)"}  # q


@pytest.fixture
def undamped(tmp_path: Path) -> Path:
    text = (EXAMPLES / "suspended_bar.lag").read_text(encoding="utf-8")
    kept = [row for row in text.splitlines() if "AxialDamper" not in row and "Damping" not in row]
    (tmp_path / "springs.lag").write_text("\n".join(kept), encoding="utf-8")
    return tmp_path / "springs.lag"


def test_bar_on_springs(undamped: Path) -> None:
    stands(undamped, BAR, SPRINGS, SPRINGS_MATRICES)


def test_bar_with_dampers() -> None:
    stands(EXAMPLES / "suspended_bar.lag", BAR, DAMPERS, DAMPERS_MATRICES)


def test_block_and_disc() -> None:
    stands(EXAMPLES / "disc_and_block.lag", DISC, BLOCK, BLOCK_MATRICES)


def test_letters_are_given_in_order_and_may_go_on(undamped: Path) -> None:
    wanted = Request("worked", names=BAR, sections=("kinetic", "potential", "equations"), first_letter="f")
    said = write_equations(undamped, wanted)
    rows = [row for row in said.splitlines() if row.endswith(("(f)", "(g)", "(h)", "(i)"))]
    assert [row.split(" =")[0].strip() for row in rows[:2]] == ["T", "V"] and len(rows) == 4
    assert "Principle" not in said and max(map(len, said.splitlines())) <= 100


def stands(path: Path, names: dict[str, str], formulas: list[str], matrices: dict[str, str]) -> None:
    """Each formula is on the page: the same members between equal signs, each equal in value."""
    _, page = page_of(path, Request("worked", names=names))
    nodes = [x for block in page.blocks if isinstance(block, Display) for x in block.formulas]
    printed = [found for x in nodes for found in [members(line(x))] if found]
    for formula in formulas:
        wanted = members(formula)
        assert any(contained(wanted, found) for found in printed), formula
    bold = {"M": "𝐌", "C": "𝐂", "K": "𝐊", "f": "𝐟"}
    for name, entries in matrices.items():
        cells = [cell for row in grids_of(nodes, bold[name])[0].rows for cell in row]
        for cell, entry in zip(cells, entries.split(", "), strict=True):
            assert sp.expand(read(line(cell), MOTION) - read(entry, MOTION)) == 0, name


def grids_of(nodes, name: str) -> list[Grid]:
    return [x.right for x in nodes if isinstance(getattr(x, "right", None), Grid) and line(x.left) == name]


def members(formula: str) -> list[sp.Expr]:
    try:
        return [read(part, MOTION) for part in formula.split(" = ")]
    except NotRead:
        return []


def contained(wanted: list[sp.Expr], found: list[sp.Expr]) -> bool:
    return all(any(sp.expand(x - y) == 0 for y in found) for x in wanted)
