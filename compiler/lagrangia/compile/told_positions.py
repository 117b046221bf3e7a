"""Positions as who integrates by himself has them: a quaternion in the place of the three coordinates of an attitude, whose
reference no step of his moves on. FMUs for Model Exchange, exported functions."""

from collections.abc import Callable, Sequence

import casadi as ca

from lagrangia.base.records import dataclass
from lagrangia.frames.attitudes import present
from lagrangia.frames.kinematics import Kinematics
from lagrangia.frames.quaternions import quaternion_product
from lagrangia.language.attitudes import parts_of


@dataclass(frozen=True)
class ToldPositions:
    """`q`: their symbols (n + n_attitudes, 1); where there are no attitudes those of the coordinates, and all below changes
    nothing. A quaternion of another length than 1 stands for the unit one along it."""

    kinematics: Kinematics
    q: ca.SX
    quaternions: dict[str, ca.SX]

    def put(self, expressions: Sequence[ca.SX]) -> list[ca.SX]:
        """Expressions in coordinates and references, in terms of `q`."""
        symbols = self.kinematics.symbols
        if not self.quaternions:
            return list(expressions)
        parts = [symbols.positions[part] for name in self.quaternions for part in parts_of(name)]
        references = [x for name in self.quaternions for x in symbols.attitudes[name]]
        units = [x for quaternion in self.quaternions.values() for x in ca.vertsplit(quaternion / ca.norm_2(quaternion))]
        found: list[ca.SX] = ca.substitute(list(expressions), [*parts, *references], [*[ca.SX(0)] * len(parts), *units])
        return found

    def of(self, q: ca.SX) -> ca.SX:
        """Told positions of the coordinates, (n, 1), in terms of references."""
        return self._each(q, lambda name, s: present(self.kinematics.symbols.attitudes[name], s))

    def pace(self, told: ca.SX, v: ca.SX) -> ca.SX:
        """Rates of told positions, which are unit quaternions, at rates (n, 1)."""
        places = self._places()
        return self._each(v, lambda name, w: quaternion_product(ca.vertsplit(told[places[name] : places[name] + 4]),
                                                                (0.0, *(x / 2 for x in w))))

    def _each(self, values: ca.SX, turned: Callable[[str, list[ca.SX]], Sequence[ca.SX]]) -> ca.SX:
        if not self.quaternions:
            return values
        found: list[ca.SX] = []
        ends = {parts_of(name)[0]: name for name in self.quaternions}
        names = list(self.kinematics.symbols.positions)
        k = 0
        while k < len(names):
            attitude = ends.get(names[k])
            found += turned(attitude, [values[k + i] for i in range(3)]) if attitude else [values[k]]
            k += 3 if attitude else 1
        return ca.vertcat(*found)

    def _places(self) -> dict[str, int]:
        positions = list(self.kinematics.symbols.positions)
        return {name: positions.index(parts_of(name)[0]) + k for k, name in enumerate(self.quaternions)}


def told_positions(kinematics: Kinematics) -> ToldPositions:
    """Of a scene."""
    quaternions = {name: ca.SX.sym(name, 4) for name in _in_order(kinematics)}
    made = ToldPositions(kinematics, ca.vertcat(ca.SX(0, 1), *kinematics.symbols.positions.values()), quaternions)
    if not quaternions:
        return made
    return ToldPositions(kinematics, made._each(made.q, lambda name, _: ca.vertsplit(quaternions[name])), quaternions)


def _in_order(kinematics: Kinematics) -> list[str]:
    """Attitudes as their coordinates lie."""
    places = {name: k for k, name in enumerate(kinematics.symbols.positions)}
    return sorted(kinematics.symbols.attitudes, key=lambda name: places[parts_of(name)[0]])
