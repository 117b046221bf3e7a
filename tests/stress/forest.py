"""What must hold of any tree of bodies, looked at for one random tree after the other, in processes beside each other."""

import multiprocessing
import os
import tempfile
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import casadi as ca
import numpy as np

import lagrangia as lag
from helpers.random_trees import random_tree
from lagrangia.dynamics.bodies import find_bodies
from lagrangia.dynamics.elimination import articulate
from lagrangia.dynamics.motion import mass_matrix, solve_dense
from lagrangia.run.solvers import applicable

STOP, ROWS, TOLERANCE, TIGHT = 1.0, 9, 1e-8, 1e-11
MOST_BODIES = 12
STATES = 3
NUDGE = 1e-8


@dataclass
class Tree:
    """What was measured of the tree grown from `seed`; each number is 0 where all is perfect, and some eps or tolerances."""

    seed: int
    bodies: int
    coordinates: int = 0
    asymmetry: float = 0.0  # of M, relative
    definiteness: float = 1.0  # smallest eigenvalue of M over the largest
    disagreement: float = 0.0  # of elimination and of a dense M, in units of eps times the condition of M
    departure: float = 0.0  # of the model's accelerations from these, in what a change of eps, and eps cond M, may do
    account: float = 0.0  # largest residual of the energy account, relative, over the tolerance
    errors: dict[str, float] = field(default_factory=dict)  # of each solver, relative, over the tolerance
    finite: bool = True
    warned: bool = False

    def faults(self) -> list[str]:
        """What is not as it must be; empty when all is well."""
        found = [] if self.finite else ["a row is not finite"]
        if self.asymmetry > 1e-14 or not self.definiteness > 0:
            found.append(f"M: asymmetry {self.asymmetry:.1e}, smallest eigenvalue {self.definiteness:.1e}")
        if not self.disagreement < 10:
            found.append(f"elimination and dense M: {self.disagreement:.1e} eps cond M")
        if not self.departure < 4:
            found.append(f"accelerations and elimination: apart by {self.departure:.1e}")
        if not self.account < 100:  # no step is made smaller for work that moves nothing: a spring between places given in time
            found.append(f"energy account: {self.account:.1e} tolerances")
        found += [f"{name}: {error:.1e} tolerances" for name, error in self.errors.items() if not error < 100]
        return [f"tree {self.seed} of {self.bodies} bodies, {text}" for text in found]


def look_at(seed: int) -> Tree:
    bodies = 1 + seed % MOST_BODIES
    tree = Tree(seed, bodies)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "tree.lag"
        path.write_text(random_tree(seed, bodies).text, encoding="utf-8")
        model = lag.Model(path)
        model.native = False  # no tree is worth a C compiler
        tree.coordinates = model.scene.n
        _look_at_equations(model, tree)
        _look_at_motion(model, tree)
    return tree


def look_at_all(seeds: Iterable[int]) -> list[Tree]:
    """On all cores."""
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(os.cpu_count(), mp_context=context) as pool:
        return list(pool.map(look_at, seeds, chunksize=8))


def _look_at_equations(model: lag.Model, tree: Tree) -> None:
    """M itself, and the accelerations by elimination, by M factored as a whole, and those the model took."""
    compilation = model.compilation
    motion, random = compilation.motion, np.random.default_rng(tree.seed)
    articulated = articulate(compilation.kinematics, find_bodies(compilation.kinematics, compilation.energies))
    assert articulated is not None
    along = articulated.solve(-motion.h)
    dense = solve_dense(motion.momentum, -motion.h, motion.v)
    function = ca.Function("all", [motion.t, motion.q, motion.v, motion.p],
                           [ca.densify(mass_matrix(motion)), along, dense, motion.acceleration])
    for _ in range(STATES):
        state = (random.uniform(0, 3), *random.uniform(-2, 2, (2, model.scene.n)))
        M, *ways = (np.array(x) for x in function(*state, model.parameter_values()))
        values = np.linalg.eigvalsh((M + M.T) / 2)
        tree.asymmetry = max(tree.asymmetry, np.abs(M - M.T).max() / np.abs(M).max())
        tree.definiteness = min(tree.definiteness, values[0] / values[-1])
        eps, size = np.finfo(float).eps, values[-1] / values[0] * np.abs(ways[0]).max()
        tree.disagreement = max(tree.disagreement, np.abs(ways[1] - ways[0]).max() / (eps * size))
        nudged = [x * (1 + NUDGE * random.choice([-1, 1], np.shape(x))) for x in (*state, model.parameter_values())]
        response = np.abs(np.array(function(*nudged)[-1]) - ways[2]).max() / NUDGE  # large where large forces nearly balance
        tree.departure = max(tree.departure, np.abs(ways[2] - ways[0]).max() / (eps * (size + response)))


def _look_at_motion(model: lag.Model, tree: Tree) -> None:
    at, states = np.linspace(0, STOP, ROWS), slice(1, 1 + 2 * model.scene.n)
    exact = model.simulate(at=at, tolerance=TIGHT, solver="erk").rows[:, states]
    size = np.maximum(np.abs(exact).max(axis=0), 0.1 * np.abs(exact).max())
    for solver in ("auto", *(name for name in applicable(model.scene) if name != "taylor")):  # that is C, written for the scene
        run = model.simulate(at=at, tolerance=TOLERANCE, solver=solver)
        tree.finite = tree.finite and bool(np.isfinite(run.rows).all())
        tree.warned = tree.warned or bool(run.warnings)
        tree.errors[solver] = (np.abs(run.rows[:, states] - exact) / size).max() / TOLERANCE
        statistics = run.statistics
        tree.account = max(tree.account, statistics.energy_residual / statistics.energy_scale / TOLERANCE)
