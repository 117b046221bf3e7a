"""Variables that are otherwise in space than in the plane: parameters that only space asks for, vectors and inertias.

annotation(Space = true): not there in the plane, which knows its value as a constant; "vector": three components in space, a
number in the plane; "axial": a number about a hinge, or three components in space, a number in the plane; "tensor": a number,
three components, or a matrix of three by three in space, a number in the plane.
"""

from lagrangia.base.diagnostics import fail
from lagrangia.language.elements import Size, element, length
from lagrangia.language.folding import fold
from lagrangia.language.frame_attributes import Space
from lagrangia.language.frame_words import in_space
from lagrangia.language.functions import DIMENSIONS
from lagrangia.language.instances import Bound, Slot, StructuralValues
from lagrangia.language.matrices import shape_of
from lagrangia.language.spaces import ANNOTATION, leave_plane
from lagrangia.language.tree import Boolean, Declaration, Flat, Reference, String

_VECTOR, _AXIAL, _TENSOR, _ADDED = "vector", "axial", "tensor", "added"
_ABOUT_Z = (_VECTOR, _AXIAL, _TENSOR)  # numbers in the plane
_SHAPES: tuple[tuple[int, ...], ...] = ((), (3,), (3, 3))  # of an inertia


def form_of(declaration: Declaration) -> str:
    """"vector", "axial", "tensor" or "added", "" for what is the same in both. Raises LagError L0208."""
    for argument in declaration.annotation:
        if argument.name == ANNOTATION:
            match argument.value:
                case Boolean(True):
                    return _ADDED
                case String("vector" | "axial" | "tensor" as form):
                    return form
            fail("L0208", f'\'{ANNOTATION}\' is true, "vector", "axial" or "tensor"', declaration.name_span)
    return ""


def prefixes_of(form: str, space: Space) -> frozenset[str]:
    """What a declaration of this form is besides: what only space asks for is a constant in the plane."""
    return frozenset({"constant"}) if form == _ADDED and not space.is_spatial else frozenset()


def dimensions_of(form: str, values: StructuralValues, binding: Bound | None) -> tuple[int, ...]:
    """The sizes of a variable of a form that is not declared with sizes. Raises LagError L0303."""
    if not values.space.is_spatial or form not in _ABOUT_Z:
        return ()
    if form == _VECTOR or (form == _AXIAL and (binding is None or values.shape(binding) != ())):
        return (3,)
    shape = values.shape(binding) if binding is not None and form == _TENSOR else ()
    if shape not in _SHAPES:
        assert binding is not None
        fail("L0303", "an inertia is a number about z, three about the axes, or a matrix of three by three",
             binding.expression.span, "write {Ixx, Iyy, Izz}, or {{Ixx, Ixy, Ixz}, {Ixy, Iyy, Iyz}, {Ixz, Iyz, Izz}}")
    return shape


def is_fitted(declaration: Declaration) -> bool:
    """Whether what it is bound to may be otherwise in space."""
    is_sized = len(declaration.dimensions) == 1 and _is_of_space(declaration)
    return is_sized or bool(declaration.annotation and form_of(declaration))


def fitted(value: Flat, slot: Slot, space: Space, size: Size) -> Flat:
    """What a variable is bound to, as the space has it; leaves the plane where that says more."""
    declaration = slot.declaration
    if len(declaration.dimensions) == 1 and _is_of_space(declaration):
        return in_space(value, space, size, f"'{declaration.name}'")
    if not declaration.annotation or not (form := form_of(declaration)) or space.is_spatial:
        return value
    return _about_z(value, size, form) if form in _ABOUT_Z else value


def is_inertia(slot: Slot) -> bool:
    """Whether it is one of a body about three axes."""
    return bool(slot.dimensions) and form_of(slot.declaration) == _TENSOR


def least_of(slot: Slot, least: float | None) -> float | None:
    """The least value of its elements: products of inertia may be negative."""
    return None if len(slot.dimensions) == 2 and form_of(slot.declaration) == _TENSOR else least


def _is_of_space(declaration: Declaration) -> bool:
    size = declaration.dimensions[0]
    return isinstance(size, Reference) and str(size) == DIMENSIONS


def _about_z(value: Flat, size: Size, form: str) -> Flat:
    """The part about z of what is given for all axes."""
    count = length(value, size)
    if count != 3:
        return value
    third = element(value, 3, size)
    if form == _TENSOR:
        return element(third, 3, size) if shape_of(third, size) == (3,) else third
    if any(fold(element(value, k, size)) != 0 for k in (1, 2)):
        leave_plane(value.span, "it has components across z")
    return third
