"""Where things stand that the scene leaves open: ends of springs that are bound to a coordinate, walls, and bodies in one place.

A scene of numbers alone (Block, Spring(stretch = block.s)) says how things move and not where they are. The picture sets loose
parts beside each other, along the way they move: what a spring, a rope, a gear or a shaft joins. What geometry holds stays.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lagrangia.draw.joints import Joint, Tree
from lagrangia.draw.values import Item, Numbers
from lagrangia.frames.joints import component_of
from lagrangia.language.mentions import leaves
from lagrangia.language.tree import Flat, FrameRef

Vector = NDArray[np.float64]
_SHORT = 0.5  # of the usual length of a spring: what is nearer is set apart
SPRING = 3.2  # symbols
_TIGHT = 0.4  # of that: as near as what moves comes
_UPRIGHT = 0.7
_WHERE = ("", "r", "x", "y")  # attributes that say where a frame is
_SPRINGS = ("zigzag", "dashpot")


@dataclass(frozen=True)
class End:
    """A place that was found: a frame's, so far from it, m; `is_wall`: the ground is drawn there; `is_rim`: on a wheel."""

    frame: str
    shift: Vector
    is_wall: bool = False
    is_rim: bool = False
    way: Vector = field(default_factory=lambda: np.zeros(2))


@dataclass
class Layout:
    """`offsets`: how far frames are drawn from where they are, m. `ends`: of items (by their numbers) without places of their own
    along `along`. `lanes`: how far an item is set aside from others between the same ends, in symbols."""

    offsets: dict[str, Vector] = field(default_factory=dict)
    ends: dict[int, tuple[End, End]] = field(default_factory=dict)
    lanes: dict[int, float] = field(default_factory=dict)

    def offset(self, frame: str) -> Vector:
        """Of a frame, m."""
        return self.offsets.get(frame, np.zeros(2))


@dataclass
class _Placing:
    numbers: Numbers
    tree: Tree
    moment: int
    symbol: float  # m
    extents: Mapping[str, float]  # of what is drawn at frames, m
    layout: Layout = field(default_factory=Layout)
    pinned: set[str] = field(default_factory=set)
    walled: list[tuple[int, Joint, float]] = field(default_factory=list)  # items between a part and a wall, which come last
    taken: set[tuple[str, tuple[float, ...]]] = field(default_factory=set)  # sides of parts, to which others are tied

    def run(self) -> Layout:
        items = self.numbers.items
        for k, item in enumerate(items):
            if "of" in item.figure.options and not item.places:
                self._find_ends(k, item)
            elif item.word in _SPRINGS and "along" in item.options:
                self._stand_along(k, item)
            elif item.word in ("gears", "belt"):
                self._set_apart(item.frames, self._reach(item), np.array([1.0, 0.0]), is_exact=item.word == "gears")
            elif item.word in _SPRINGS and len(item.frames) == 2 and self._are_neighbours(item):
                reach = sum(self.extents.get(frame, 0.0) for frame in item.frames) + SPRING * self.symbol
                self._set_apart(item.frames, reach, np.array([1.0, 0.0]))
        for k, joint, x in self.walled:
            way: Vector = np.sign(x) * _unit(self._way(joint))
            if self._side(joint.child, -way) in self.taken and self._side(joint.child, way) not in self.taken:
                way = -way  # a spring is the same on either side, but the wall would stand in another part
            self.layout.ends[k] = self._wall(joint.child, way), End(joint.child, np.zeros(2))
        for k, item in enumerate(items):
            if item.word in _SPRINGS and len(item.frames) == 2 and k not in self.layout.ends:
                self._stand_on_ground(k, *item.frames)
        self._choose_lanes()
        return self.layout

    # ------------------------------------------------------------ ends

    def _place(self, frame: str) -> Vector:
        return self.numbers.place(frame)[:2, self.moment] + self.layout.offset(frame)

    def _way(self, joint: Joint) -> Vector:
        """How the child moves in the world, m per unit of the coordinate."""
        c, s = (f(self.numbers.place(joint.parent)[2, self.moment]) for f in (np.cos, np.sin))
        way: Vector = np.array([[c, -s], [s, c]]) @ joint.way
        return way

    def _find_ends(self, k: int, item: Item) -> None:
        form = self.tree.form(item.figure.options["of"])
        moved = [(self.tree.joints[name], float(x)) for name, x in (form or {}).items() if name in self.tree.joints and x != 0]
        if not form or len(moved) != len([x for x in form.values() if np.any(x != 0)]):
            return
        shifts = [(joint, x) for joint, x in moved if joint.kind == "shift"]
        turns = [(joint, x) for joint, x in moved if joint.kind == "turn"]
        if len(shifts) == 1 and not turns:
            self._tie_to_base(k, *shifts[0])
        elif len(shifts) == 2 and not turns:
            (one, first), (other, _) = shifts
            b, a = (one, other) if first > 0 else (other, one)
            self._tie(k, End(a.child, np.zeros(2)), End(b.child, np.zeros(2)), _unit(self._way(b)))
        elif len(shifts) == 1 and len(turns) == 1:
            (block, x), (disc, radius) = shifts[0], turns[0]
            way: Vector = -np.sign(x) * _unit(self._way(block))
            radius /= abs(x) * float(np.linalg.norm(self._way(block)))
            rim = End(disc.child, radius * np.array([way[1], -way[0]]), is_rim=True, way=way)
            self._tie(k, End(block.child, np.zeros(2)), rim, way)

    def _tie_to_base(self, k: int, joint: Joint, x: float) -> None:
        if joint.parent in self.tree.grounded:
            self.walled.append((k, joint, x))
        else:
            way: Vector = np.sign(x) * _unit(self._way(joint))
            self._tie(k, End(self.tree.holder(joint.parent), np.zeros(2)), End(joint.child, np.zeros(2)), way)

    def _wall(self, child: str, way: Vector) -> End:
        extent = self.extents.get(child, 0.0)
        ground = next(root.frame for root in self.tree.graph.roots if root.is_ground)
        reach = max(SPRING * self.symbol, _TIGHT * SPRING * self.symbol + self._nearing(ground, child, way)) + extent
        at = self.numbers.place(child)[:2, self.moment] - self.numbers.place(ground)[:2, self.moment] - reach * way
        return End(ground, at + self.layout.offset(child), True, way=way)

    def _nearing(self, a: str, b: str, way: Vector) -> float:
        """How much less far b is ahead of a, along the way, than at the moment of the layout."""
        gaps = way @ (self.numbers.place(b)[:2] - self.numbers.place(a)[:2])
        gaps = gaps[np.isfinite(gaps)]
        here = way @ (self.numbers.place(b)[:2, self.moment] - self.numbers.place(a)[:2, self.moment])
        return float(here - gaps.min()) if gaps.size and np.isfinite(here) else 0.0

    def _tie(self, k: int, a: End, b: End, way: Vector) -> None:
        rim = float(np.linalg.norm(b.shift)) if b.is_rim else 0.0  # what stands below a wheel stands free of it
        spring = max(SPRING * self.symbol, _TIGHT * SPRING * self.symbol + self._nearing(a.frame, b.frame, way))
        reach = spring + rim + sum(self.extents.get(e.frame, 0.0) for e in (a, b) if not e.shift.any())
        gap = self._place(b.frame) + b.shift - self._place(a.frame) - a.shift
        aside = gap - (gap @ way) * way if b.is_rim else np.zeros(2)  # a rope leaves a rim along its tangent
        ahead = reach - gap @ way if gap @ way < _SHORT * reach else 0.0
        if ahead or float(np.linalg.norm(aside)) > 1e-6 * self.symbol:
            self._move(b.frame, a.frame, ahead * way - aside)
        self.layout.ends[k] = a, b
        self.taken |= {self._side(a.frame, way), self._side(b.frame, -way)}

    @staticmethod
    def _side(frame: str, way: Vector) -> tuple[str, tuple[float, ...]]:
        return frame, tuple((np.round(way, 6) + 0.0).tolist())

    def _stand_along(self, k: int, item: Item) -> None:
        """A spring that feels one direction: its ends face each other along it."""
        if len(item.frames) != 2:
            return
        along = _unit(np.array([self.numbers.values[row, self.moment] for row in item.options["along"]]))
        a, b = item.frames
        at_a, at_b = (self.numbers.values[row : row + 2, self.moment] for row in item.places)
        shifts = at_a - self.numbers.place(a)[:2, self.moment], at_b - self.numbers.place(b)[:2, self.moment]
        if self.tree.bodies[a] in {root.frame for root in self.tree.graph.roots if root.is_ground}:
            length = float((at_b - at_a) @ along)
            if abs(length) < _SHORT * SPRING * self.symbol and along[1] > _UPRIGHT:
                along, length = -along, -length  # of no length, and held by the ground: it hangs from a ceiling
            spring = max(SPRING * self.symbol, _TIGHT * SPRING * self.symbol + self._nearing(a, b, along))
            reach = max(length, spring + self.extents.get(b, 0.0))
            self.layout.ends[k] = End(a, at_b + self.layout.offset(b) - reach * along - self.numbers.place(a)[:2, self.moment],
                                      True, way=along), End(b, shifts[1])
            return
        self._tie(k, End(a, shifts[0]), End(b, shifts[1]), along)

    def _stand_on_ground(self, k: int, a: str, b: str) -> None:
        """What joins a part to the ground in its own place, as a brake does, goes with it where it is set apart."""
        grounds = [frame in self.tree.grounded for frame in (a, b)]
        part = b if grounds == [True, False] else a if grounds == [False, True] else ""
        gap = self.numbers.place(a)[:2, self.moment] - self.numbers.place(b)[:2, self.moment] if part else np.ones(2)
        if self.layout.offset(part).any() and float(np.linalg.norm(gap)) < 1e-9 * max(self.symbol, 1e-300):
            shift = self.layout.offset(part)
            first, second = (End(frame, np.zeros(2) if frame == part else shift) for frame in (a, b))
            self.layout.ends[k] = first, second

    # ------------------------------------------------------------ what lies in one place

    def _reach(self, item: Item) -> float:
        radii = [abs(float(self.numbers.values[rows[0], self.moment])) for rows in item.numbers]
        return sum(radii) * (1.0 if item.word == "gears" else 1.6)

    def _are_neighbours(self, item: Item) -> bool:
        """Whether two frames in one place hang on joints of their own, so that their twist is no hinge's."""
        a, b = item.frames
        ways = [[edge for edge in self.tree.path(frame) if edge.coordinates] for frame in (a, b)]
        return bool(ways[0]) and bool(ways[1]) and not {edge.child for edge in ways[0]} & {edge.child for edge in ways[1]} \
            and float(np.linalg.norm(self._place(a) - self._place(b))) < 1e-9 * max(self.symbol, 1e-300)

    def _set_apart(self, frames: tuple[str, ...], reach: float, way: Vector, is_exact: bool = False) -> None:
        a, b = frames
        gap = self.numbers.place(b)[:2, self.moment] - self.numbers.place(a)[:2, self.moment]
        if float(np.linalg.norm(gap)) < (1e-9 if is_exact else _SHORT) * reach:
            self._move(b, a, reach * way - (self._place(b) - self._place(a)))

    def _move(self, frame: str, other: str, by: Vector) -> None:
        """The loose part with the frame, or, where it was set already, the other one the other way."""
        for one, apart, ahead in ((frame, other, by), (other, frame, -by)):
            top = self._loose_top(one, apart)
            if top is not None and top not in self.pinned:
                for name in [*self.tree.subtree(top), *self._foot(top)]:
                    self.layout.offsets[name] = self.layout.offset(name) + ahead
                break
        self.pinned |= {top for pair in ((frame, other), (other, frame)) if (top := self._loose_top(*pair)) is not None}

    def _foot(self, top: str) -> list[str]:
        """The other port of the joint that moves a part, and what leads there from the ground."""
        edge = self.tree.above[top]
        return [edge.parent] if component_of(edge.parent) == component_of(top) != "" else []

    def _loose_top(self, frame: str, apart: str) -> str | None:
        """The first frame on the way to one that does not carry the other, and that geometry ties to nothing else."""
        shared = {edge.child for edge in self.tree.path(apart)} | {apart}
        tops = [edge for edge in self.tree.path(frame) if edge.child not in shared]
        moving = [edge for edge in tops if not edge.is_rigid]
        if not moving:
            return None
        top = moving[-1].child
        inside = set(self.tree.subtree(top))
        return None if any(bool(pair & inside) and bool(pair - inside) for pair in self._held) else top

    @property
    def _held(self) -> list[set[str]]:
        if not hasattr(self, "_pairs"):
            self._pairs = list(_held_pairs(self.tree, self.numbers.items))
        return self._pairs

    def _spot(self, frame: str) -> tuple[object, ...]:
        """The same for frames of one body in one place."""
        place = self.numbers.place(frame)[:2, self.moment] / self.symbol
        return self.tree.bodies[frame], *np.round(np.where(np.isfinite(place), place, 0.0), 3)

    def _choose_lanes(self) -> None:
        """Springs and dampers between the same ends stand side by side."""
        groups: dict[tuple[object, ...], list[int]] = {}
        for k, item in enumerate(self.numbers.items):
            if item.word not in _SPRINGS or (not item.places and k not in self.layout.ends):
                continue
            ends = self.layout.ends.get(k)
            key: tuple[object, ...] = tuple(map(self._spot, item.frames)) if ends is None else tuple(
                ("wall", *np.round(e.way, 6)) if e.is_wall else (self._spot(e.frame), *np.round(e.shift / self.symbol, 3))
                for e in ends)
            groups.setdefault((*key, item.options.get("offset") is not None and item.figure.component), []).append(k)
        for members in groups.values():
            if "offset" not in self.numbers.items[members[0]].options:
                outside = self._outside(members[0])
                for place, k in enumerate(members):
                    self.layout.lanes[k] = outside * place * 1.3 if outside else (len(members) - 1) / 2 - place

    def _outside(self, k: int) -> float:
        """On which side of a line a wheel leaves room, where it ends on the rim of one; else 0."""
        for end in self.layout.ends.get(k, ()):
            if end.is_rim:
                return -float(np.sign(end.shift @ np.array([end.way[1], -end.way[0]])))
        return 0.0


def place_parts(numbers: Numbers, tree: Tree, moment: int, symbol: float, extents: Mapping[str, float]) -> Layout:
    """The layout of a scene as it is at a moment; `symbol` is the size of symbols, m."""
    return _Placing(numbers, tree, moment, symbol, extents).run()


def _held_pairs(tree: Tree, items: Iterable[Item]) -> Iterable[set[str]]:
    """Frames whose places are measured against each other: closed loops, and what reads the places of several."""
    for closure in tree.graph.closures:
        yield {closure.a, closure.b}
    bindings = {name: v.binding for name, v in tree.model.variables.items()}
    one_way = {i.figure.component for i in items if i.word in ("gears", "belt") or (i.word in _SPRINGS and "along" in i.options)}
    stated: list[tuple[str, list[Flat]]] = [(e.component, [e.value]) for e in tree.model.energies if e.kind != "kinetic"]
    stated += [(e.component, [e.left, e.right]) for e in tree.model.constraints]
    stated += [(w.component, [w.position]) for w in tree.model.works]
    for component, roots in stated:
        read = {leaf.name for leaf in leaves(roots, bindings) if isinstance(leaf, FrameRef) and leaf.attribute in _WHERE}
        if len(read) > 1 and component not in one_way:
            yield read


def _unit(vector: Vector) -> Vector:
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0 else np.array([1.0, 0.0])
