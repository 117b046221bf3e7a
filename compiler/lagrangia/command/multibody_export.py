"""`lag export --to modelica --components` of a scene with frames: what MultiBody needs to know besides what the scene states."""

from dataclasses import replace

import numpy as np

from lagrangia.base.diagnostics import fail
from lagrangia.command.scene_export import inputs, remarks, require_smooth, starts
from lagrangia.compile.pipeline import Compilation
from lagrangia.dynamics.freedom import Freedom, find_freedom
from lagrangia.frames.edges import Closure
from lagrangia.language.mentions import nodes
from lagrangia.language.tree import FrameRef
from lagrangia.model import Model
from lagrangia.paper.multibody import Starts, write_multibody
from lagrangia.paper.sheet import parameter_values
from lagrangia.run.request import USUAL


def multibody_text(model: Model) -> str:
    """The scene in components of Modelica.Mechanics.MultiBody. Raises LagError L0901, L0909."""
    require_smooth(model, "modelica")
    model = model.in_space
    c = model.compilation
    if name := next(iter(c.flat.states), None):
        fail("L0901", f"not supported yet: the first-order state '{name}' among components of Modelica.Mechanics.MultiBody",
             c.flat.states[name].span)
    freedom = find_freedom(c.kinematics, c.motion, c.constraints, c.initial, c.functions.table)
    numbers = parameter_values(c.kinematics)
    free = _free(model)
    guesses = _bodies_at_start(model) if any(part not in free for part in model.scene.turned) else {}
    begun = Starts(starts(model) | inputs(model) | numbers | guesses, free, _planar_loops(c, freedom))
    solved = ["starts are numbers, as the parameters' values here give them: they do not follow other values"]
    is_solved = bool(c.graph.closures or c.flat.initial_equations or model.scene.turned)
    return write_multibody(c.kinematics, begun, numbers, [*remarks(model, "modelica"), *(solved if is_solved else [])]) + "\n"


def _bodies_at_start(model: Model) -> dict[str, float]:
    """Where bodies are and how they move, for tools that look for attitudes that no joint tells."""
    flat = model.compilation.flat
    frames = {node.name for energy in flat.energies if energy.kind == "kinetic" for node in nodes(energy.value)
              if isinstance(node, FrameRef)}
    run = model.run(replace(USUAL, at=[model.scene.start]))
    return {f"{frame}.{name}[{k + 1}]": float(x) for frame in sorted(frames) for name in ("r", "v", "Q", "w")
            for k, x in enumerate(np.asarray(run[f"{frame}.{name}"])[0])}


def _free(model: Model) -> frozenset[str]:
    """Coordinates that may be chosen at the start: all others follow from them and the loops."""
    names = [c.name for c in model.scene.coordinates]
    table = model.functions()
    if "J" not in table:
        return frozenset(names)
    first = starts(model)
    q, v = ([first[c.name] for c in columns] for columns in (model.scene.told_positions, model.scene.rates))
    J = table["J"](model.scene.start, q, v, list(inputs(model).values()), model.parameter_values()).full()
    _, sizes, rows = np.linalg.svd(J)
    ways = rows[int((sizes > 1e-9 * sizes.max()).sum()):].T  # (n, freedom)
    is_turned = np.array([name in model.scene.turned for name in names])
    found: list[str] = []
    while len(found) < ways.shape[1]:
        worth = np.linalg.norm(ways, axis=1) * np.where(is_turned, 1e-3, 1)  # hinges and sliders first
        k = int(np.argmax(worth))
        found.append(names[k])
        along = ways[k] / np.linalg.norm(ways[k])
        ways = ways - np.outer(ways @ along, along)
    return frozenset(found)


def _planar_loops(c: Compilation, freedom: Freedom) -> tuple[Closure, ...]:
    """The loops of which three equations repeat others because they lie in a plane. Raises LagError L0901 for other loops whose
    equations repeat each other."""
    if not c.flat.space.is_spatial:
        return c.graph.closures
    rows = [*c.constraints.repeated, *(c.constraints.rows[k] for k in freedom.dependent)]
    loops = dict.fromkeys(row.loop for row in rows if row.loop is not None)
    for loop in loops:
        if sum(row.loop == loop for row in rows) != 3:
            fail("L0901", f"not supported yet: the loop {loop.around}, whose equations repeat each other, among components of "
                 "Modelica.Mechanics.MultiBody", loop.span, "its library closes planar loops alone, by one hinge in each",
                 "lag export --to modelica without --components writes the equations of motion")
    return tuple(loops)
