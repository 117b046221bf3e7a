"""A scene as lines to be drawn: bodies, springs and links between the places of their frames."""

from collections.abc import Callable, Mapping
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lagrangia.base.records import dataclass
from lagrangia.frames.graph import ComponentGraph
from lagrangia.frames.joints import component_of
from lagrangia.frames.planar import LENGTHS
from lagrangia.language.flat import FlatModel

Vector = NDArray[np.float64]
_THIN = 1e-9  # of the scene's size: what is shorter is a point


@dataclass(frozen=True)
class Mechanism:
    """`places`: q -> (frames, SIZE), see frames/planar.py. Lines join frames by number; discs have a frame and a radius."""

    places: Callable[[Vector], Vector]
    bodies: tuple[tuple[int, int], ...]
    springs: tuple[tuple[int, int], ...]
    discs: tuple[tuple[int, float], ...]
    points: tuple[int, ...]

    def size(self, q: Vector) -> float:
        """The extent of what is drawn, m."""
        used = sorted({k for line in (*self.bodies, *self.springs) for k in line} | {k for k, _ in self.discs} | set(self.points))
        spread = float(np.ptp(self.places(q)[used][:, LENGTHS], axis=0).max()) if used else 0.0
        return max(spread, 2 * max((radius for _, radius in self.discs), default=0.0))

    def is_drawable(self, q: Vector) -> bool:
        """Whether there is any body or spring with an extent."""
        places = self.places(q)
        size = self.size(q)
        lengths = [float(np.linalg.norm(places[a, LENGTHS] - places[b, LENGTHS])) for a, b in (*self.bodies, *self.springs)]
        return bool(np.isfinite(places).all()) and size > 0 and (bool(self.discs) or max(lengths, default=0.0) > _THIN * size)


def build_mechanism(graph: ComponentGraph, frames: tuple[str, ...], places: Callable[[Vector], Vector],
                    parameters: Mapping[str, float]) -> Mechanism:
    """`frames` in the order of the rows of `places`."""
    number = {name: k for k, name in enumerate(frames)}
    cluster = _clusters(graph, frames)
    owned: dict[str, list[str]] = {}
    for frame in frames:
        if component_of(frame):
            owned.setdefault(component_of(frame), []).append(frame)
    bodies, springs, discs, points = [], [], [], []
    elastic = {energy.component for energy in graph.model.energies if energy.kind != "kinetic"}
    massive = {energy.component for energy in graph.model.energies if energy.kind == "kinetic"}
    tied = {equation.component for equation in graph.model.constraints}
    for component, own in owned.items():
        ports = [number[f"{component}.{port}"] for port in ("a", "center", "b") if f"{component}.{port}" in number]
        own_numbers = [number[name] for name in own]
        is_rigid = len({cluster[name] for name in own}) == 1
        if component in massive:
            points += [number[name] for name in own if name.endswith(".center")]
            radius = parameters.get(f"{component}.r")
            if radius is not None and f"{component}.center" in number:
                discs.append((number[f"{component}.center"], float(radius)))
        if is_rigid and len(own) > 1:
            bodies += list(pairwise(ports if len(ports) == len(own) else own_numbers))
        elif len(ports) == 2 and component in elastic and component not in massive and not _is_axial(graph.model, component):
            springs.append((ports[0], ports[-1]))
        elif len(ports) == 2 and component in tied and _is_link(graph.model, component):
            bodies.append((ports[0], ports[-1]))
    return Mechanism(places, tuple(dict.fromkeys((*bodies, *_rigid_offsets(graph, number)))), tuple(springs), tuple(discs),
                     tuple(points))


def _rigid_offsets(graph: ComponentGraph, number: Mapping[str, int]) -> list[tuple[int, int]]:
    """A frame that sits at a fixed place in another one, beside the ground: an arm between them."""
    return [(number[edge.parent], number[edge.child]) for edge in graph.edges
            if edge.is_rigid and edge.parent != "world" and edge.parent in number and edge.child in number]


def _is_link(model: FlatModel, component: str) -> bool:
    """Whether the component holds two points at a distance, as a massless rod does."""
    return f"{component}.L" in model.variables


def _is_axial(model: FlatModel, component: str) -> bool:
    """Whether a spring feels one direction only: the line between its ends then says nothing."""
    return f"{component}.along" in model.variables


def _clusters(graph: ComponentGraph, frames: tuple[str, ...]) -> dict[str, str]:
    """Frames that sit rigidly to each other share a name."""
    above = {edge.child: edge.parent for edge in graph.edges if edge.is_rigid}
    found = {}
    for frame in frames:
        root = frame
        while root in above:
            root = above[root]
        found[frame] = root
    return found
