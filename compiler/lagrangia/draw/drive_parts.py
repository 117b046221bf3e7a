"""A flat model -> the parts of its drive train, and the shafts between them: sets of flanges that are connected."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from lagrangia.language.flat import FlatModel
from lagrangia.language.tree import Ref

PORT = "port"  # the kind of a flange of the scene itself
_LEFT, _RIGHT = ("flange_a", "sun", "flangeR"), ("flange_b", "carrier", "flangeT", "ring")
_HOUSING = "support"
_POSITIONS = (".phi", ".s")


@dataclass(frozen=True)
class Part:
    """A component: its class in the library ('' for others), and the shafts, by their numbers, on its left, on its right (None
    where it has one flange, on either side), of further flanges, and of its housing; `of`: the joint that it belongs to."""

    name: str
    kind: str
    left: int
    right: int | None = None
    further: tuple[int, ...] = ()
    housing: int | None = None
    of: str = ""

    @property
    def ends(self) -> list[int]:
        """The shafts that it lies on, without its housing's."""
        return [self.left, *([self.right] if self.right is not None else []), *self.further]

    @property
    def shafts(self) -> list[int]:
        """All of them."""
        return [*self.ends, *([self.housing] if self.housing is not None else [])]


def parts_of(flat: FlatModel) -> list[Part]:
    """The components of a flat model that have flanges, as they stand in it; its own flanges where it has parts or is one."""
    shafts = _shafts(flat)
    ports: dict[str, list[tuple[str, int, str]]] = {}
    for variable, shaft in shafts.items():
        component, port = _part(variable), variable.split(".")[-2]
        ports.setdefault(component, []).append((port, shaft, flat.flanges[variable]))
    own = ports.pop("", [])
    within = {name[:k] for name in ports for k in range(len(name)) if name[k] == "."}
    parts = [_part_of(name, found, flat) for name, found in ports.items() if name not in within or _is_more(name, found, ports)]
    if own and not ports:
        parts.append(_part_of(flat.name, own, flat))
    return [*parts, *(Part(port, PORT, shaft) for port, shaft, _ in own)]


def _is_more(name: str, found: Sequence[tuple[str, int, str]], ports: dict[str, list[tuple[str, int, str]]]) -> bool:
    """Whether a component has flanges that are not simply those of what is in it."""
    inner = {shaft for other, ends in ports.items() if other.startswith(name + ".") for _, shaft, _ in ends}
    return any(shaft not in inner for _, shaft, _ in found)


def _part_of(name: str, found: Sequence[tuple[str, int, str]], flat: FlatModel) -> Part:
    ends = [(port, shaft) for port, shaft, _ in found if port != _HOUSING]
    housing = next((shaft for port, shaft, _ in found if port == _HOUSING), None)
    if not ends:
        ends, housing = [(port, shaft) for port, shaft, _ in found], None
    ends.sort(key=lambda end: (end[0] not in _LEFT, _RIGHT.index(end[0]) if end[0] in _RIGHT else len(_RIGHT)))
    (_, left), *others = ends
    others.sort(key=lambda end: end[0] in _LEFT)  # several left ones: all but the first are on the right
    given = flat.variables.get(f"{name}.of")
    joint = given.binding.name.rpartition(".")[0] if given is not None and isinstance(given.binding, Ref) else ""
    right = others[0][1] if others else None
    return Part(name, found[0][2], left, right, tuple(shaft for _, shaft in others[1:]), housing, joint)


def _shafts(flat: FlatModel) -> dict[str, int]:
    """Flanges, by their variables: those that are connected, or equal to each other in two components, have one number."""
    parent = {name: name for name in flat.flanges if name.endswith(_POSITIONS)}

    def root(name: str) -> str:
        while parent[name] != name:
            parent[name] = name = parent[parent[name]]
        return name

    for name, other in (*flat.connections, *_equal(flat, list(parent))):
        if name in parent and other in parent:
            parent[root(other)] = root(name)
    numbers: dict[str, int] = {}
    return {name: numbers.setdefault(root(name), len(numbers)) for name in parent}


def _equal(flat: FlatModel, names: Sequence[str]) -> Iterator[tuple[str, str]]:
    pairs = [(name, flat.variables[name].binding) for name in names]
    pairs += [(e.left.name, e.right) for e in flat.constraints if isinstance(e.left, Ref)]
    for name, other in pairs:
        if isinstance(other, Ref) and _part(name) != _part(other.name):
            yield name, other.name


def _part(name: str) -> str:
    """The component of a flange's variable; '' for a flange of the scene itself."""
    return name.rsplit(".", 2)[0] if name.count(".") > 1 else ""
