"""A scene at one moment -> the figure that a textbook has of it."""

from collections.abc import Mapping, Sequence

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.compile.functions import observer_of
from lagrangia.compile.pipeline import Compilation
from lagrangia.draw.joints import Tree
from lagrangia.draw.names import label_all
from lagrangia.draw.page import Page, Words, bounds_of, build_page, view_of, weight_of
from lagrangia.draw.scenery import Scenery, first_symbol
from lagrangia.draw.strokes import RODS, Shape, Stroke
from lagrangia.draw.values import Numbers, States, evaluate_figures
from lagrangia.frames.evaluation import scalars_of
from lagrangia.frames.joints import component_of
from lagrangia.language.flat import Figure
from lagrangia.language.tree import Flat

Vector = NDArray[np.float64]
_SYMBOL, MOST_SYMBOL = 4.2, 5.0  # mm, on the page
_ENOUGH = 2000  # figures that tell how large a scene is
_ROUNDS = 3  # of finding the size of symbols: loose parts stand so many symbols apart
_OTHER_TIMES = 12  # at which forces are looked at
MOST_LABELS = 60
SHORTEST_ARM = 0.02  # symbols
_MOST_ALIKE = 2  # labels with the same words


def draw_page(c: Compilation, figures: Sequence[Figure], states: States, names: Mapping[str, str], is_named: bool = True) -> Page:
    """The page of a scene at the first moment of `states`. Raises LagError."""
    at_other_times = _at_other_times(c, states)
    numbers = evaluate_figures(c, figures, at_other_times)
    scenery = fit_scenery(numbers, Tree(c.graph, constants_of(c, states)), [0], True)
    shapes = {k: scenery.shape(k, 0) for k in scenery.shown}
    labels = words_of(c, scenery, names) if is_named else {}
    arms = Shape(arms_of(scenery, 0))
    drawn = [(arms, None), *((shapes[k], labels.get(k)) for k in sorted(shapes, key=lambda k: not is_load(scenery, k)))]
    strokes = [stroke for shape, _ in drawn for stroke in shape.strokes]
    view = view_of(strokes, MOST_SYMBOL / scenery.symbol)
    return build_page(drawn, view, c.flat.description or c.flat.name, weight_of(view.scale * scenery.symbol))


def is_load(scenery: Scenery, k: int) -> bool:
    """Whether a figure is the arrow of a force or torque, whose name is placed before others: beside it stands nothing else."""
    return scenery.numbers.items[k].measure in ("force", "torque", "other")


def fit_scenery(numbers: Numbers, tree: Tree, moments: Sequence[int], is_still: bool) -> Scenery:
    """With symbols of the usual size on the page, unless bars leave less room."""
    symbol, most = first_symbol(numbers, moments)
    for _ in range(_ROUNDS):
        scenery = Scenery(numbers, tree, moments[0], symbol, is_still)
        some = scenery.shown[:: 1 + len(scenery.shown) // _ENOUGH]
        strokes = [stroke for k in some for moment in moments for stroke in scenery.shape(k, moment).strokes]
        low, high = bounds_of(strokes)
        if not strokes or not np.isfinite(high - low).all():
            return scenery
        scale = view_of(strokes, MOST_SYMBOL / symbol).scale
        symbol = min(_SYMBOL / scale, most, 4 * symbol)
    return Scenery(numbers, tree, moments[0], symbol, is_still)


def words_of(c: Compilation, scenery: Scenery, names: Mapping[str, str]) -> dict[int, Words]:
    """Of figures with labels, where they are not too many to be read."""
    items = scenery.numbers.items
    labelled = [k for k in scenery.shown if "label" in items[k].figure.options or items[k].word == "text"]
    found = label_all(c.flat, [_label(items[k].figure) for k in labelled], names)
    words = {k: word for k, word in zip(labelled, found, strict=True) if word is not None}
    told = [word.plain for word in words.values()]
    seen: dict[str, int] = {}
    kept = {}
    for k, word in words.items():
        seen[word.plain] = seen.get(word.plain, 0) + 1
        if seen[word.plain] <= (1 if told.count(word.plain) > _MOST_ALIKE else _MOST_ALIKE):
            kept[k] = word
    return kept if len(kept) <= MOST_LABELS else {}


def _label(figure: Figure) -> Flat | None:
    return figure.arguments[-1] if figure.word == "text" else figure.options.get("label")


def arms_of(scenery: Scenery, moment: int) -> list[Stroke]:
    """Frames that sit at a fixed place of another one, away from it, are held by a rod."""
    found = []
    for pair in arms_between(scenery):
        ends = np.array([scenery.numbers.place(frame)[:2, moment] + scenery.layout.offset(frame) for frame in pair])
        if np.isfinite(ends).all() and float(np.linalg.norm(ends[1] - ends[0])) > SHORTEST_ARM * scenery.symbol:
            found.append(Stroke(ends, RODS, "thick"))
    return found


def arms_between(scenery: Scenery) -> list[tuple[str, str]]:
    """The frames of these rods."""
    tree, numbers = scenery.tree, scenery.numbers
    drawn = {numbers.items[k].figure.component for k in scenery.shown}
    found = []
    for edge in tree.graph.edges:
        if not edge.is_rigid or edge.parent in tree.grounded:
            continue
        component = component_of(edge.parent)
        if component == component_of(edge.child) and component in drawn:
            continue
        if np.any(scenery.layout.offset(edge.parent) != scenery.layout.offset(edge.child)):
            continue  # drawn apart: what guides the child stands with it
        found.append((edge.parent, edge.child))
    return found


def _at_other_times(c: Compilation, states: States) -> States:
    """The first moment, and the same place at other times of the experiment: a load may begin with zero."""
    experiment = c.flat.experiment
    times = np.linspace(experiment.start, experiment.stop, _OTHER_TIMES + 2)[1:-1] + 1e-3 * (experiment.stop - experiment.start)
    first = states.picked([0] * (1 + _OTHER_TIMES))
    return States(np.concatenate([first.t[:, :1], times[None]], axis=1), first.q, first.v, first.u, first.p)


class constants_of:
    """Numbers for expressions that do not move."""

    def __init__(self, c: Compilation, states: States) -> None:
        self.c, self.states = c, states.picked([0])

    def __call__(self, node: Flat) -> Vector:
        c, s = self.c, self.states
        value = c.kinematics.evaluator.value(node)
        scalars = scalars_of(value)
        y = observer_of(c.kinematics, c.motion, c.constraints, ca.densify(ca.vertcat(*[ca.SX(x) for x in scalars])))
        found = np.array(y(s.t, s.q, s.v, s.u, s.p), dtype=float).ravel()
        return found if isinstance(value, tuple) else found[0]
