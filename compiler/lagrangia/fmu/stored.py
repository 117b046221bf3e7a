"""FmuModel -> the file from which the library that comes with the package has the scene: runtime/fmi/stored.c, which reads it.

Structures and vectors as C has them, each at a multiple of eight bytes; in the place of a pointer stands the distance of what it
points to from the beginning of the file, and all such places are listed at its end. It holds for this machine's kind of processor
and this version of the run time: library and file go into an FMU together. A page has the same with pointers of four bytes, as
WebAssembly has them, and one function more.
"""

import ctypes as c
import struct
import sys
from array import array
from collections.abc import Mapping, Sequence
from typing import Any, cast
from zlib import adler32

from lagrangia.base.folders import data_folder
from lagrangia.base.table_data import TableData
from lagrangia.fmu.elements import provides_elements
from lagrangia.fmu.tables import constants, guards_of, integers, requirements_of, sizes_of, vectors
from lagrangia.fmu.variables import FmuModel
from lagrangia.native.prebuilt import digest
from lagrangia.native.tapes import Tape
from lagrangia.run.runtime import MIRRORS

NAME = "scene.tape"  # among the resources
_HEAD = struct.Struct("=8s64s7Q")
_MAGIC = b"LAGFMU\0\1"
_TAPE, _FUNCTION, _MODEL, _TABLE = (cast("type[c.Structure]", MIRRORS[name])
                                    for name in ("LagTape", "LagFunction", "LagModel", "LagTable"))
_WORD = 8  # what is put begins at a multiple of it
_PAGE_TOKEN = "page"  # LAG_PLAY_TOKEN of play.h
_VECTORS = ("reals", "integers", "booleans", "strings", "names", "guards", "requirements", "state_start", "state_settable",
            "nominal", "input_start", "parameter_start", "minimum", "maximum", "parameter_settable")
_LISTS = ("kept", "extents", "known_first", "knowns", "known_kinds", "start_first", "starts", "start_kinds")


class _Fmu(c.Structure):
    """LagFmu of fmu.h."""

    _fields_ = (
        ("model", c.c_void_p),
        ("token", c.c_void_p),
        *((name, c.c_double) for name in ("start", "tolerance", "stabilisation")),
        *((name, c.c_int) for name in ("n_reals", "n_integers", "n_booleans", "n_strings", "n_kept_reals", "n_kept_integers",
                                      "n_kept_booleans")),
        *((name, c.c_void_p) for name in _VECTORS),
        ("has_knowns", c.c_int),
        *((name, c.c_void_p) for name in _LISTS),
        ("forward", _FUNCTION),
        ("adjoint", _FUNCTION),
    )


class _Played(_Fmu):
    """LagPlayed of play.c."""

    _fields_ = (("drawing", _FUNCTION),)


def write_stored(model: FmuModel, token: str) -> bytes:
    """The whole file. Equal input gives equal bytes."""
    image = _Image(_Layout(c.sizeof(c.c_void_p)))
    fmu = _filled(_Fmu, model, token, sizes_of(model), image)
    fmu.function("forward", model.forward, image)
    fmu.function("adjoint", model.adjoint, image)
    return image.whole(image.structure(fmu))


def write_played(model: FmuModel, solver: int, drawing: Tape) -> bytes:
    """The same for the run time in WebAssembly, with the numbers of the drawing; without derivatives, for which no page asks.
    `solver` is what the scene is run with."""
    image = _Image(_Layout(4))
    played = _filled(_Played, model, _PAGE_TOKEN, {**sizes_of(model), "solver": solver}, image)
    played.function("drawing", drawing, image)
    return image.whole(image.structure(played))


def _filled(kind: type[c.Structure], model: FmuModel, token: str, sizes: Mapping[str, int], image: "_Image") -> "_Struct":
    """A LagFmu without its derivatives."""
    scene = model.scene
    fmu = _Struct(kind, image.layout)
    own = _Struct(_MODEL, image.layout)
    for name, size in sizes.items():
        own.set(name, size)
    lists = {"coordinate_kind": scene.coordinate_kind, "fixed": scene.fixed, "event_kind": scene.event_kind, **scene.patterns}
    for name, places in lists.items():
        own.point(name, image.ints(places))
    for name, tape in scene.tapes.items():
        own.function(name, tape, image)
    if scene.tables:
        own.point("tables", image.row([_table(table, image) for table in scene.tables]))
    fmu.point("model", image.structure(own))
    fmu.point("token", image.text(token))
    for name in ("start", "tolerance"):
        fmu.set(name, getattr(scene, name))
    fmu.set("stabilisation", model.stabilisation)
    for group, values in constants(model).items():
        fmu.set(f"n_{group}s", len(values))
    for name, numbers in vectors(model).items():
        fmu.point(name, image.doubles(numbers))
    fmu.set("has_knowns", provides_elements(model))
    for name, whole in integers(model).items():
        fmu.point(name, image.ints(whole))
    fmu.point("names", image.texts([variable.name for variable in model.variables]))
    fmu.point("guards", image.texts(guards_of(model)))
    fmu.point("requirements", image.texts(requirements_of(model)))
    fmu.point("strings", image.texts([str(x) for x in constants(model)["string"]]))
    return fmu


def _table(table: TableData, image: "_Image") -> "_Struct":
    plain = _Struct(_TABLE, image.layout)
    for name in ("n", "degree", "beyond", "start", "pitch"):
        plain.set(name, getattr(table, name))
    for name in ("x", "y", "slopes"):
        if len(getattr(table, name)):
            plain.point(name, image.put(bytes(memoryview(getattr(table, name)).cast("B"))))
    return plain


class _Layout:
    """Structures as a processor has them whose pointers have `pointer` bytes: mirrors are those of this machine."""

    def __init__(self, pointer: int) -> None:
        self.pointer = pointer
        self._word = {4: c.c_uint32, 8: c.c_uint64}[pointer]
        self._known: dict[type[Any], type[Any]] = {}

    def of(self, mirror: type[Any]) -> type[Any]:
        """The same members in the same order, pointers and sizes as numbers of their bytes."""
        if mirror not in self._known:
            self._known[mirror] = self._made(mirror)
        return self._known[mirror]

    def _made(self, mirror: type[Any]) -> type[Any]:
        if issubclass(mirror, c.Structure):
            begins = c.Structure if mirror.__base__ is c.Structure else self.of(cast("type[Any]", mirror.__base__))
            members = [(name, self.of(kind)) for name, kind, *_ in vars(mirror)["_fields_"]]
            return type(mirror.__name__, (begins,), {"_fields_": members})
        is_address = mirror in (c.c_void_p, c.c_size_t) or hasattr(mirror, "contents")
        return self._word if is_address else mirror


class _Struct:
    """A structure of C, and where its pointers lead: distances by their places in it."""

    def __init__(self, mirror: type[Any], layout: _Layout) -> None:
        self.values = layout.of(mirror)()
        self.pointers: dict[int, int] = {}

    def set(self, name: str, value: float) -> None:
        setattr(self.values, name, value)

    def point(self, name: str, distance: int) -> None:
        self.pointers[getattr(type(self.values), name).offset] = distance

    def function(self, name: str, tape: Tape, image: "_Image") -> None:
        code, numbers = bytes(memoryview(tape.code).cast("B")), bytes(memoryview(tape.constants).cast("B"))
        plain = _Struct(_TAPE, image.layout)
        plain.set("n_instructions", len(code) // 16)
        plain.set("n_constants", len(numbers) // 8)
        plain.point("code", image.put(code))
        plain.point("constants", image.put(numbers))
        own = getattr(self.values, name)
        own.n_in, own.n_out, own.n_work = len(tape.in_sizes), len(tape.out_sizes), tape.n_work
        first = getattr(type(self.values), name).offset
        for member, distance in (("in_size", image.ints(tape.in_sizes)), ("out_size", image.ints(tape.out_sizes)),
                                 ("tape", image.structure(plain))):
            self.pointers[first + getattr(type(own), member).offset] = distance


class _Image:
    """The file as it grows behind its head."""

    def __init__(self, layout: _Layout) -> None:
        self.layout = layout
        self._content = bytearray(_HEAD.size)
        self._places: list[int] = []

    def put(self, content: bytes) -> int:
        """Its distance from the beginning. What is empty has a place, too: no pointer is NULL for it."""
        distance = len(self._content)
        self._content += content.ljust(max(1, -(-len(content) // _WORD)) * _WORD, b"\0")
        return distance

    def ints(self, values: Sequence[int]) -> int:
        return self.put(array("i", values).tobytes())

    def doubles(self, values: Sequence[float]) -> int:
        return self.put(array("d", values).tobytes())

    def text(self, text: str) -> int:
        return self.put(text.encode() + b"\0")

    def texts(self, texts: Sequence[str]) -> int:
        """An array of pointers to them."""
        return self._pointers([self.text(text) for text in texts])

    def _pointers(self, distances: Sequence[int]) -> int:
        size = self.layout.pointer
        first = self.put(b"".join(distance.to_bytes(size, sys.byteorder) for distance in distances))
        self._places += [first + size * k for k in range(len(distances))]
        return first

    def row(self, made: Sequence[_Struct]) -> int:
        """An array of structures."""
        first, *_ = [self.structure(one) for one in made]
        return first

    def structure(self, made: _Struct) -> int:
        first = self.put(bytes(made.values))
        for place, distance in made.pointers.items():
            at, size = first + place, self.layout.pointer
            self._content[at : at + size] = distance.to_bytes(size, sys.byteorder)
            self._places.append(first + place)
        return first

    def whole(self, root: int) -> bytes:
        """With its head, where `root` is the distance of the LagFmu."""
        places = self._places
        listed = self.put(array("Q", places).tobytes())
        head = (_MAGIC, digest(data_folder("runtime")).encode(), len(self._content), adler32(self._content[_HEAD.size :]),
                c.sizeof(self.layout.of(_Fmu)), c.sizeof(self.layout.of(_MODEL)), root, len(places), listed)
        return _HEAD.pack(*head) + self._content[_HEAD.size :]


FMU_MIRRORS: Mapping[str, type[c.Structure]] = {"LagFmu": _Fmu}
