"""What is said of frames, in the words of the space that a scene is in: attributes, shift and turn, vectors in other axes."""

from lagrangia.base.diagnostics import Span, fail
from lagrangia.language.elements import Size, element, length
from lagrangia.language.frame_attributes import SPACE, Space
from lagrangia.language.loops import Work
from lagrangia.language.matrices import ARRAY_FUNCTIONS, cross_of_three, product, shape_of
from lagrangia.language.spaces import FUNCTIONS, leave_plane, name_of_space, turn_of_plane, vector_of_plane
from lagrangia.language.tree import Array, Binary, Call, Flat, FrameRef, Number, Part

FRAME_WORDS = frozenset({"shift", "turn", *FUNCTIONS})


def attribute_of(space: Space, frame: str, part: Part, index: tuple[int, ...], span: Span) -> FrameRef:
    """frame.r, frame.v[1]. Raises LagError L0214, L0216."""
    name_of_space(space, part.name, span)
    if part.name not in space.attributes:
        fail("L0216", f"a frame has no '{part.name}'", part.span, space.missing.get(part.name, space.words))
    if not space.attributes[part.name].has_element(index):
        if not space.is_spatial and SPACE.attributes[part.name].has_element(index):
            leave_plane(span, f"it speaks of {span.text}")
        fail("L0214", f"'{part.name}' of a frame has no element {list(index)}", part.span, space.words_of_elements)
    return FrameRef(frame, part.name, index, span, space.is_spatial)


def frame_call(call: Call[Flat], space: Space, size: Size, work: Work) -> Flat:
    """shift and turn as the space has them; to_world, to_frame and velocity_at written out. Raises LagError L0209, L0221,
    L0303."""
    if call.function == "shift":
        return _shift(call, space, size)
    if call.function == "turn":
        return _turn(call, space, size)
    name_of_space(space, call.function, call.span)
    frame, vector = call.arguments
    if not isinstance(frame, FrameRef) or frame.attribute:
        fail("L0221", f"{call.function} needs a frame, as bar.a", frame.span)
    _need_three(vector, size, "a vector")
    if call.function == "velocity_at":
        ahead = Binary("-", vector, _of(frame, "r"), call.span)
        around = cross_of_three(Call("cross", (_of(frame, "w"), ahead), (), call.span), size)
        return Binary("+", _of(frame, "v"), around, call.span)
    axes: Flat = _of(frame, "R")
    if call.function == "to_frame":
        axes = ARRAY_FUNCTIONS["transpose"][1](Call("transpose", (axes,), (), call.span), size)
    return product(axes, vector, size, call.span, work)


def _of(frame: FrameRef, attribute: str) -> FrameRef:
    return FrameRef(frame.name, attribute, (), frame.span, True)


def _shift(call: Call[Flat], space: Space, size: Size) -> Flat:
    base, vector = call.arguments
    if len(shape_of(vector, size)) > 1:
        fail("L0303", "a shift is a vector, this is an array of arrays", vector.span, "write {x, y}, or {x, y, z}")
    fitted = in_space(vector, space, size, "a shift")
    return call if fitted is vector else Call("shift", (base, fitted), (), call.span)


def _turn(call: Call[Flat], space: Space, size: Size) -> Flat:
    if len(call.arguments) < 3:
        if not space.is_spatial and length(call.arguments[1], size) == 3:
            leave_plane(call.span, f"it turns by the attitude {call.arguments[1].span.text}")
        return call
    _need_three(call.arguments[2], size, "an axis")
    return call if space.is_spatial else turn_of_plane(call)


def _need_three(vector: Flat, size: Size, what: str) -> None:
    if length(vector, size) != 3:
        fail("L0303", f"{what} of three components is needed here", vector.span, "write {x, y, z}")


def _is_other(vector: Flat, space: Space, size: Size) -> bool:
    return length(vector, size) == (2 if space.is_spatial else 3)


def in_space(vector: Flat, space: Space, size: Size, what: str) -> Flat:
    """A vector as the space has it: of two components z is 0, of three it must be plainly 0 in the plane."""
    if not _is_other(vector, space, size):
        return vector
    x, y = (element(vector, k, size) for k in (1, 2))
    if space.is_spatial:
        return Array((x, y, Number(0.0, None, vector.span)), vector.span)
    vector_of_plane(vector, element(vector, 3, size), what)
    return Array((x, y), vector.span)
