"""What a component graph holds that can have a reaction: joints of the tree, joints that close loops, ties."""

from lagrangia.frames.edges import Closure, Edge
from lagrangia.frames.graph import ComponentGraph
from lagrangia.language.consequences import is_constraint_force
from lagrangia.language.frame_attributes import REACTIONS
from lagrangia.language.instances import held_port


def all_reactions(graph: ComponentGraph) -> list[str]:
    """The force and torque of every joint and of every equation between the ports of one component; of a Motion what it takes."""
    forces = [name for name, v in graph.model.variables.items() if v.binding is not None and is_constraint_force(v.binding)]
    return [f"{path}.{what}" for path in reaction_ports(graph) for what in REACTIONS] + forces


def reaction_ports(graph: ComponentGraph) -> dict[str, str]:
    """Of every joint and tie, by its name, the port that its reaction acts on."""
    held = {*joints_of(graph), *cuts_of(graph)}
    stating = {equation.component for equation in graph.model.constraints} | {when.component for when in graph.model.whens}
    frames: dict[str, list[str]] = {}
    for frame in graph.model.frames:
        if frame not in graph.unused_frames and not frame.endswith("]"):
            frames.setdefault(component_of(frame), []).append(frame.rpartition(".")[2])
    ports = {path: held_port(names) for path, names in frames.items() if path}
    return {path: port for path, port in sorted(ports.items()) if port and (f"{path}.{port}" in held or path in stating)}


def component_of(frame: str) -> str:
    """The component that a port's full name belongs to."""
    return frame.rpartition(".")[0]


def joints_of(graph: ComponentGraph) -> dict[str, tuple[Edge, float]]:
    """The edges of the tree that are joints, by the frames on their two sides, and the side: 1 where the edge leads to."""
    joints = [edge for edge in graph.edges if _joins(edge.parent, edge.child, edge.is_rigid)]
    return {edge.child: (edge, 1.0) for edge in joints} | {edge.parent: (edge, -1.0) for edge in joints}


def cuts_of(graph: ComponentGraph) -> dict[str, tuple[Closure, float]]:
    """The same of the joints that close loops."""
    cuts = [cut for cut in graph.closures if _joins(cut.a, cut.b, cut.kind == "weld")]
    return {cut.b: (cut, 1.0) for cut in cuts} | {cut.a: (cut, -1.0) for cut in cuts}


def _joins(a: str, b: str, is_rigid: bool) -> bool:
    """Whether two frames are the two sides of a joint: frames of one component, its ports a and b when nothing moves."""
    path = component_of(a)
    return {a, b} == {f"{path}.a", f"{path}.b"} or (not is_rigid and path == component_of(b) != "")
