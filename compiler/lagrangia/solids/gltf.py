"""A stage -> binary glTF 2.0 (.glb), which Blender, three.js and viewers of systems read: meshes, lines and their motion.

Source: Khronos Group, glTF 2.0 specification (2021). Lengths are m, y is up there: what is up here is turned to it.
"""

import json
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lagrangia.solids.shapes import Solid, across, coil
from lagrangia.solids.stage import Body, Line, Stage, quaternions

Vector = NDArray[np.float64]
_FLOAT, _INDEX = 5126, 5125  # kinds of numbers
_LINE_STRIP = 3
_GREYS = {"white": 0.8, "grey": 0.5, "black": 0.05}


def write_gltf(stage: Stage) -> bytes:
    """The whole file."""
    return _Writer(stage).whole()


class _Writer:
    def __init__(self, stage: Stage) -> None:
        self.stage, self.data = stage, bytearray()
        self.views: list[dict[str, Any]] = []
        self.accessors: list[dict[str, Any]] = []
        self.meshes: list[dict[str, Any]] = []
        self.nodes: list[dict[str, Any]] = []
        self.samplers: list[dict[str, Any]] = []
        self.channels: list[dict[str, Any]] = []
        self.known: dict[tuple[int, str], int] = {}
        self.times = self._numbers(stage.t - stage.t[0], "SCALAR") if len(stage.t) > 1 else -1

    def whole(self) -> bytes:
        """Header, description, numbers."""
        for body in self.stage.bodies:
            self._body(body)
        for line in self.stage.lines:
            self._line(line)
        turn = quaternions(_upright(self.stage.up)[None])[0]
        root = {"name": "world", "rotation": _as_xyzw(turn[None])[0].tolist(), "children": list(range(len(self.nodes)))}
        if not self.nodes:
            del root["children"]
        shades = [{"name": name, "pbrMetallicRoughness": {"baseColorFactor": [grey, grey, grey, 1.0], "metallicFactor": 0.1,
                   "roughnessFactor": 0.7}, "doubleSided": True} for name, grey in _GREYS.items()]
        told: dict[str, Any] = {"asset": {"version": "2.0", "generator": "lagrangia"}, "scene": 0, "materials": shades,
                                "scenes": [{"nodes": [len(self.nodes)]}], "nodes": [*self.nodes, root]}
        for name, found in (("meshes", self.meshes), ("accessors", self.accessors), ("bufferViews", self.views)):
            told |= {name: found} if found else {}
        if self.channels:
            told["animations"] = [{"name": "motion", "channels": self.channels, "samplers": self.samplers}]
        if self.data:
            told["buffers"] = [{"byteLength": len(self.data)}]
        text = json.dumps(told, separators=(",", ":"), allow_nan=False).encode()
        chunks = [(b"JSON", text + b" " * (-len(text) % 4))] + ([(b"BIN\0", bytes(self.data))] if self.data else [])
        parts = b"".join(struct.pack("<I4s", len(chunk), kind) + chunk for kind, chunk in chunks)
        return struct.pack("<4sII", b"glTF", 2, 12 + len(parts)) + parts

    # ------------------------------------------------------------ what is seen

    def _body(self, body: Body) -> None:
        shade = [*_GREYS].index(body.shade)
        key = id(body.solid), body.shade
        if key not in self.known:
            points, normals, triangles = _triangles(body.solid)
            attributes = {"POSITION": self._numbers(points, "VEC3", True), "NORMAL": self._numbers(normals, "VEC3")}
            self.known[key] = self._mesh({"attributes": attributes, "indices": self._indices(triangles), "material": shade})
        self._node(body.name, self.known[key], body.poses[:, :3], _as_xyzw(body.poses[:, 3:]), None)

    def _line(self, line: Line) -> None:
        """Straight parts, and coils, are of length 1 along z: turned and stretched to where they are."""
        shape = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
        if line.turns:
            shape = coil(shape[0], shape[1], line.radius, line.turns)
        mesh = self._mesh({"attributes": {"POSITION": self._numbers(shape, "VEC3", True)}, "mode": _LINE_STRIP,
                           "material": [*_GREYS].index("black")})
        for k in range(line.points.shape[1] - 1):
            a, b = line.points[:, k], line.points[:, k + 1]
            length = np.linalg.norm(b - a, axis=1)
            ways = np.where(length[:, None] > 0, b - a, [0.0, 0.0, 1.0])
            turns = quaternions(np.array([across(way) for way in ways]))
            sizes = np.column_stack([np.ones((len(length), 2)), np.maximum(length, 1e-9)])
            self._node(line.name, mesh, a, _as_xyzw(turns), sizes)

    def _node(self, name: str, mesh: int, places: Vector, turns: Vector, sizes: Vector | None) -> None:
        tracks = {"translation": places, "rotation": turns} | ({"scale": sizes} if sizes is not None else {})
        tracks = {path: _kept_on(values, path) for path, values in tracks.items()}
        named = {"name": name} if name else {}
        self.nodes.append(named | {"mesh": mesh} | {path: values[0].tolist() for path, values in tracks.items()})
        for path, values in tracks.items():
            if self.times >= 0 and np.ptp(values, axis=0).max() > 0:
                output = self._numbers(values, "VEC4" if path == "rotation" else "VEC3")
                self.channels.append({"sampler": len(self.samplers), "target": {"node": len(self.nodes) - 1, "path": path}})
                self.samplers.append({"input": self.times, "output": output, "interpolation": "LINEAR"})

    # ------------------------------------------------------------ numbers

    def _mesh(self, primitive: dict[str, Any]) -> int:
        self.meshes.append({"primitives": [primitive]})
        return len(self.meshes) - 1

    def _numbers(self, values: Vector, kind: str, is_bounded: bool = False) -> int:
        rows = np.ascontiguousarray(values, dtype="<f4")
        found: dict[str, Any] = {"componentType": _FLOAT, "count": len(rows), "type": kind}
        if is_bounded or kind == "SCALAR":
            flat = rows.reshape(len(rows), -1)
            found |= {"min": flat.min(axis=0).tolist(), "max": flat.max(axis=0).tolist()}
        return self._accessor(rows.tobytes(), found)

    def _indices(self, values: Vector) -> int:
        return self._accessor(np.ascontiguousarray(values, dtype="<u4").tobytes(),
                              {"componentType": _INDEX, "count": values.size, "type": "SCALAR"})

    def _accessor(self, told: bytes, found: dict[str, Any]) -> int:
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(told)})
        self.data += told
        self.accessors.append({"bufferView": len(self.views) - 1, **found})
        return len(self.accessors) - 1


def _triangles(solid: Solid) -> tuple[Vector, Vector, Vector]:
    """Vertices of each face apart, with its normal, so that edges are sharp."""
    points: list[Vector] = []
    normals: list[Vector] = []
    triangles: list[list[int]] = []
    for k, face in enumerate(solid.faces):
        first = len(points)
        for vertex in face:
            points.append(solid.vertices[vertex])
            normals.append(solid.normals[k])
        triangles += [[first, first + j, first + j + 1] for j in range(1, len(face) - 1)]
    return np.array(points), np.array(normals), np.array(triangles)


def _kept_on(values: Vector, path: str) -> Vector:
    """Where there is nothing to be seen it stays where it was last: numbers are finite there."""
    usual = {"rotation": [0.0, 0.0, 0.0, 1.0], "scale": [1.0, 1.0, 1.0]}.get(path, [0.0, 0.0, 0.0])
    found, last = values.copy(), np.array(usual)
    for k, row in enumerate(values):
        last = row if np.isfinite(row).all() else last
        found[k] = last
    return found


def _as_xyzw(turns: Vector) -> Vector:
    """glTF has the real part last."""
    return np.roll(turns, -1, axis=1)


def _upright(up: Vector) -> Vector:
    """A matrix that turns what is up into y."""
    return np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]) @ across(up).T
