"""A file's equations in SymPy, with its symbols found by the names of the model."""

from dataclasses import dataclass
from pathlib import Path

import sympy as sp

from lagrangia.compile.pipeline import compile_energies
from lagrangia.paper.equations import Equations, derive
from lagrangia.paper.symbolic import build_symbolic

EXAMPLES = Path(__file__).parents[2] / "models" / "examples"
# Not written: sampled values, states, a long table, a bicycle, 42 coordinates.
UNWRITTEN = {"crane": "L0901", "dc_motor_stick_slip": "L0901", "rough_road": "L0712", "bicycle": "L0712",
             "hexapod": "L0712"}
TURNED = ("satellite", "top", "rolling_disc_space")  # whose attitudes have Euler's equations: test_euler_equations.py
TOO_LONG = ("robot_arm", "bricard", "cardan_shaft", "spatial_four_bar")  # of which its structure is told
WRITTEN = [path for path in sorted(EXAMPLES.glob("*.lag")) if path.stem not in (*UNWRITTEN, *TURNED, *TOO_LONG)]
CLASSROOM = Path(__file__).parents[1] / "cases" / "classroom"


@dataclass(frozen=True)
class Derived:
    equations: Equations

    def __getitem__(self, name: str) -> sp.Expr:
        """A coordinate, a parameter or a given function by its name in the model; with der(...) around it a rate."""
        scene = self.equations.scene
        known = {str(x): x for x in (*scene.q, *scene.v, *scene.a)} | {"t": scene.t}
        known |= {f"lambda_{k}": x for k, x in enumerate(self.equations.multipliers, 1)}
        known |= {p.name: p.symbol for p in scene.parameters} | {str(x): x for g in scene.given for x in g.moving}
        return known[name]

    def motion(self, k: int) -> sp.Expr:
        """What vanishes in the k-th equation: M a + h + J^T lambda - f."""
        e = self.equations
        return e.left[k] + e.reactions[k] - e.f[k]


def derived(path: Path, most_products: int = 10**6, has_named_supports: bool = False) -> Derived:
    return Derived(derive(build_symbolic(*compile_energies(path), has_named_supports), most_products))


def vanishes(expression: sp.Expr) -> bool:
    return bool(sp.simplify(sp.expand_trig(sp.expand(expression))) == 0)
