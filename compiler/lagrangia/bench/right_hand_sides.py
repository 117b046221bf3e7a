"""The accelerations of a tree in space, as they are compiled, beside what peers take for those of the same tree at one state.

All are timed by the shortest of many calls. What is called from Python carries about 0.3 us of that; ours is called from C.
"""

import ctypes
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from lagrangia.algebra.duals import Scalar
from lagrangia.base.records import dataclass
from lagrangia.bench.clock import Clock, shortest, state
from lagrangia.bench.tree_peers import Tree, Unfit, in_numbers, peers_of
from lagrangia.compile.pipeline import Compilation
from lagrangia.constraints.parameters import default_parameters
from lagrangia.dynamics.forces import Forces
from lagrangia.dynamics.spatial_tree import SpatialBodies, articulate_in_space
from lagrangia.native.c_code import usual_rhs
from lagrangia.run.engines import load_engine

if TYPE_CHECKING:
    from numpy.typing import NDArray

_LARGEST_COMPILED = 100  # coordinates: the C compiler takes minutes for thousands


@dataclass(frozen=True)
class Side:
    """One right-hand side. `difference`: largest of an acceleration from ours, relative to the largest acceleration."""

    name: str
    how: str
    seconds: float
    difference: float


def measure_sides(made: Compilation) -> Iterator[Side | tuple[str, str]]:
    """Ours first, then the peers, which are given loads as numbers; a name and the reason of those that cannot take it. Raises
    Unfit."""
    tree = articulate_in_space(made.kinematics, made.motion.bodies) if made.kinematics.geometry.by_rates else None
    if tree is None or not made.scene.n:
        raise Unfit("only trees in space are measured so, of hinges, sliders and ball joints")
    own, how, seconds, inputs = _ours(made)
    yield Side("lagrangia", f"{how}, {made.scene.notes['acceleration_nodes']} operations", seconds, 0.0)
    given = _in_numbers(made, tree, inputs)
    told = "from Python, loads in numbers" if given.forces.any() else "from Python"
    for peer in peers_of(given):
        if isinstance(peer, tuple):
            yield peer
            continue
        found = peer.accelerations()
        yield Side(peer.name, told, shortest(peer.call), float(np.abs(found - own).max() / np.abs(own).max()))


def _ours(made: Compilation) -> "tuple[NDArray[np.float64], str, float, list[NDArray[np.float64]]]":
    scene = made.scene
    engine = load_engine(scene, native=scene.n <= _LARGEST_COMPILED)
    assert engine is not None  # there is a C compiler: the command asked
    tape, inputs = usual_rhs(scene.tapes), state(scene)
    function = getattr(engine.model.struct, "rhs" if tape is scene.tapes["rhs"] else "regular")
    outputs = [np.zeros(max(1, size)) for size in tape.out_sizes]
    interpreter = ctypes.cast(engine.runtime.library.lag_tape_run, ctypes.c_void_p)
    seconds = Clock().seconds(function, interpreter, inputs, outputs, tape.n_work)
    return outputs[0][: scene.n], engine.how, seconds, inputs


def _in_numbers(made: Compilation, tree: SpatialBodies, inputs: "list[NDArray[np.float64]]") -> Tree:
    p, values = default_parameters(made.kinematics)
    field, left = tree.field(made.energies)
    if left is None:
        raise Unfit("peers are given forces on bodies and on coordinates that joints have")

    def value(x: Any) -> float:
        return float(ca.evalf(ca.substitute(ca.SX(x), p, ca.SX(values)))) if isinstance(x, ca.SX) else float(x)

    n = made.scene.n
    joints = in_numbers(tree.joints, value)
    return Tree(joints, n, inputs[1][:n], inputs[2][:n], np.array([value(x) for x in field]), loads_of(made, left, inputs))


def loads_of(made: Compilation, forces: Forces, inputs: "list[NDArray[np.float64]]") -> "NDArray[np.float64]":
    """What springs, dampers and loads exert on the coordinates, (n,), at one state: t, q, v, u, d and c. Raises Unfit."""
    kinematics, motion = made.kinematics, made.motion
    twists, wrenches = list[Scalar](), list[Scalar]()
    for frame, wrench in forces.on_frames.items():
        twists += kinematics.pose(frame, 1).twist
        wrenches += wrench
    taken = ca.vertcat(*[forces.on_coordinates.get(c.name, 0.0) for c in kinematics.graph.coordinates])
    if twists:
        taken = taken + ca.jtimes(ca.vertcat(*twists), motion.v, ca.vertcat(*wrenches), True)
    p, values = default_parameters(kinematics)
    (taken,) = ca.substitute([ca.densify(ca.SX(taken))], [p, kinematics.symbols.tau], [ca.SX(values), ca.SX(1)])
    symbols = [motion.t, motion.q, motion.v, motion.u, kinematics.algebra.mode_symbols]
    if {x.__hash__() for x in ca.symvar(taken)} - {x.__hash__() for x in ca.symvar(ca.vertcat(*symbols))}:
        raise Unfit("forces that follow from others, as those of contacts, are not given to peers")
    found = ca.Function("loads", symbols, [-taken])(*[x[: s.numel()] for x, s in zip(inputs, symbols, strict=False)])
    return np.asarray(found.full().ravel())
