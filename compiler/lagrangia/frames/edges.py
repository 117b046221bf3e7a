"""Edges of the component graph, the spanning tree chosen from them, and the closures that the other edges are.

Edges enter the tree in the order rigid, sliders, hinges, of each those with start values first, then those nearer to the ground,
as long as they close no loop (Kruskal, 1956). So a loop is cut at a hinge where it has one, far from the ground. A cut hinge
leaves two equations, a cut slider its angle and its lateral offset, and the coordinate is read off the frames; anything else is
cut as a weld: its coordinates stay, and three equations close it. In space cut joints keep their coordinates, for an angle that
is read off would not tell full turns; ball joints, of which most is saved, are cut first.
"""

from collections import deque
from collections.abc import Iterable, Mapping, Set

from lagrangia.base.diagnostics import Span
from lagrangia.base.records import dataclass
from lagrangia.frames.planar_joints import WORTH_CUTTING, cut_as
from lagrangia.language.attitudes import parts_of
from lagrangia.language.frame_steps import Step
from lagrangia.language.mentions import nodes
from lagrangia.language.tree import Binary, Call, Flat, Ref


@dataclass(frozen=True, slots=True)
class Edge:
    """child = parent followed by the steps."""

    parent: str
    child: str
    steps: tuple[Step, ...]
    coordinates: tuple[str, ...]  # those the steps depend on
    moves_with_time: bool
    span: Span

    @property
    def is_rigid(self) -> bool:
        """Whether its two frames keep their places to each other for ever."""
        return not self.coordinates and not self.moves_with_time

    def inverse(self) -> "Edge":
        """The same edge, from the child to the parent."""
        steps = tuple([step.inverse() for step in reversed(self.steps)])
        return Edge(self.child, self.parent, steps, self.coordinates, self.moves_with_time, self.span)


@dataclass(frozen=True, slots=True)
class Closure:
    """The frame `a` followed by steps_a and the frame `b` followed by steps_b coincide, but for the freedom of a cut joint.

    Its kinds stand in planar_joints.py: up to a turn by `coordinate`; up to the shift `freedom`; wholly. Those in space, in
    spatial_joints.py, keep their coordinates: `base` is where both sides of the loop part.
    """

    kind: str
    a: str
    b: str
    steps_a: tuple[Step, ...]
    steps_b: tuple[Step, ...]
    coordinate: str
    freedom: Step | None
    around: str  # the components along the loop
    span: Span
    kept: str = ""  # in space: the coordinate of a hinge or slider, the attitude of a ball joint
    ahead: Step | None = None  # the first of the two steps of a cylinder or a cross, whose coordinate is `ahead_kept`
    ahead_kept: str = ""
    base: str = ""


def choose_tree(
    frames: Iterable[str], edges: tuple[Edge, ...], ground: Iterable[str], uses: Mapping[str, int], tied: Set[str],
    started: Set[str | None],
) -> frozenset[int]:
    """The places in `edges` of those that make the tree.

    `uses` counts the edges that each coordinate moves; `tied` are coordinates that equations speak of: they had better stay;
    `started` are coordinates with start values: of two joints of a kind the other one is cut.
    """
    frames = [*frames]
    whole = _joining(frames, edges, range(len(edges)))
    if len(whole) == len(edges):  # without loops nothing is to be chosen
        return whole
    depth = _depths(frames, edges, ground)
    nearest = [max(depth[edge.parent], depth[edge.child]) for edge in edges]
    return _joining(frames, edges, sorted(range(len(edges)), key=lambda k: (_rank(edges[k], uses, tied, started), nearest[k], k)))


def _joining(frames: Iterable[str], edges: tuple[Edge, ...], order: Iterable[int]) -> frozenset[int]:
    """Of the edges at these places, one after the other, those that join what the ones before have not."""
    leader = {name: name for name in frames}

    def find(name: str) -> str:
        while leader[name] != name:
            leader[name] = leader[leader[name]]
            name = leader[name]
        return name

    chosen = set()
    for k in order:
        a, b = find(edges[k].parent), find(edges[k].child)
        if a != b:
            leader[a] = b
            chosen.add(k)
    return frozenset(chosen)


def close(edge: Edge, uses: Mapping[str, int], around: str = "") -> Closure:
    """The closure that an edge outside the tree is."""
    step = _moving(edge, uses)
    kind = cut_as(step, edge.coordinates[0]) if step is not None and len(edge.coordinates) == 1 else "weld"
    if step is None or kind == "weld":
        return Closure("weld", edge.parent, edge.child, edge.steps, (), "", None, around, edge.span)
    return Closure(kind, edge.parent, edge.child, *_beside(edge, step), edge.coordinates[0], step, around, edge.span)


def close_in_space(edge: Edge, uses: Mapping[str, int], around: str, base: str) -> Closure:
    """The same of a scene in space, where a cut joint keeps its coordinates: each says what it is in an equation of its own."""
    pair = _pair(edge, uses)
    if pair is not None:
        kind, ahead, last, (first, kept) = pair
        before, behind = _beside(edge, ahead)[0], _beside(edge, last)[1]
        return Closure(kind, edge.parent, edge.child, before, behind, "", last, around, edge.span, kept, ahead, first, base)
    step = _moving(edge, uses)
    kind = "weld" if step is None or step.is_inverse else "ball" if _is_ball(edge, uses) else (
        cut_as(step, edge.coordinates[0]) if len(edge.coordinates) == 1 else "weld")
    if step is None or kind == "weld":
        return Closure("weld", edge.parent, edge.child, edge.steps, (), "", None, around, edge.span, base=base)
    kept = edge.coordinates[0].rpartition(".s[")[0] or edge.coordinates[0]
    return Closure(kind, edge.parent, edge.child, *_beside(edge, step), "", step, around, edge.span, kept, base=base)


def _moving(edge: Edge, uses: Mapping[str, int]) -> Step | None:
    """The only step that moves, by coordinates that move nothing else."""
    if not edge.coordinates or edge.moves_with_time or any(uses[name] != 1 for name in edge.coordinates):
        return None
    names = {name.rpartition(".s[")[0] or name for name in edge.coordinates}
    moving = [step for step in edge.steps if any(_mentions(step.amount, name) for name in names)]
    return moving[0] if len(moving) == 1 and len(names) == 1 else None


def _pair(edge: Edge, uses: Mapping[str, int]) -> tuple[str, Step, Step, list[str]] | None:
    """Of a cylinder, a shift along an axis and then a turn about the same one, and of a cross, two turns: its kind, these steps
    and their coordinates. None of other edges."""
    if len(edge.coordinates) != 2 or edge.moves_with_time or any(uses[name] != 1 for name in edge.coordinates):
        return None
    moved = [[name for name in edge.coordinates if _mentions(step.amount, name)] for step in edge.steps]
    places = [k for k, names in enumerate(moved) if names]
    if len(places) != 2 or places[1] != places[0] + 1 or any(len(moved[k]) != 1 for k in places):
        return None
    (first, second), names = (edge.steps[k] for k in places), [moved[k][0] for k in places]
    if first.is_inverse or second.is_inverse or second.kind != "turn" or not isinstance(second.amount, Ref):
        return None
    if first.kind == "turn":
        return ("cross", first, second, names) if isinstance(first.amount, Ref) else None
    return ("cylinder", first, second, names) if _is_along(first.amount, names[0], second.axis) else None


def _is_along(amount: Flat, coordinate: str, axis: Flat | None) -> bool:
    """Whether a shift is written as s*axis/norm(axis)."""
    if not isinstance(axis, Ref) or not isinstance(amount, Binary) or not isinstance(amount.left, Binary):
        return False
    (over, product), length = (amount.operator, amount.left), amount.right
    named = [x.name if isinstance(x, Ref) else "" for x in (product.left, product.right)]
    is_length = isinstance(length, Call) and length.function == "norm" and _is_named(length.arguments[0], axis.name)
    return over == "/" and product.operator == "*" and named == [coordinate, axis.name] and is_length


def _is_named(node: Flat, name: str) -> bool:
    return isinstance(node, Ref) and node.name == name


def _is_ball(edge: Edge, uses: Mapping[str, int]) -> bool:
    step = _moving(edge, uses)
    return step is not None and isinstance(step.amount, Ref) and edge.coordinates == parts_of(step.amount.name)


def _beside(edge: Edge, step: Step) -> tuple[tuple[Step, ...], tuple[Step, ...]]:
    """The steps before the one that moves, and the way back over those behind it."""
    at = next(k for k, own in enumerate(edge.steps) if own is step)
    return edge.steps[:at], tuple(own.inverse() for own in reversed(edge.steps[at + 1 :]))


def _rank(edge: Edge, uses: Mapping[str, int], tied: Set[str], started: Set[str | None]) -> int:
    """Small for what is dear to cut."""
    if edge.is_rigid or not tied.isdisjoint(edge.coordinates):
        return 0
    pair = _pair(edge, uses)
    worth = WORTH_CUTTING[pair[0] if pair is not None else "ball" if _is_ball(edge, uses) else close(edge, uses).kind]
    return worth + (worth > 0 and started.isdisjoint(name.rpartition(".s[")[0] or name for name in edge.coordinates))


def _mentions(amount: Flat, name: str) -> bool:
    return any(isinstance(node, Ref) and node.name == name for node in nodes(amount))


def _depths(frames: Iterable[str], edges: tuple[Edge, ...], ground: Iterable[str]) -> dict[str, int]:
    """The smallest number of joints between each frame and the ground; 0 for what is not joined to it."""
    neighbours: dict[str, list[tuple[str, int]]] = {name: [] for name in frames}
    for edge in edges:
        joints = 0 if edge.is_rigid else 1
        neighbours[edge.parent].append((edge.child, joints))
        neighbours[edge.child].append((edge.parent, joints))
    depth: dict[str, int] = {}
    queue = deque((name, 0) for name in ground)
    while queue:
        name, here = queue.popleft()
        if name in depth:
            continue
        depth[name] = here
        for other, joints in neighbours[name]:
            if joints:
                queue.append((other, here + 1))
            else:
                queue.appendleft((other, here))
    return {name: depth.get(name, 0) for name in neighbours}
