"""What several outputs of one scene have in common, made once: equations of pages in several forms, compilations."""

from collections.abc import Callable

import pytest

from lagrangia.paper import sheet
from lagrangia.paper.sheet import Request


def derive_once(patch: pytest.MonkeyPatch) -> None:
    """For tests that ask for many forms of one scene with the same parameters: those whose equations are the same share them."""
    patch.setattr(sheet, "_book", _kept(sheet._book, lambda kinematics, scene, request, has_kicks: _kind(request)))


def _kind(request: Request) -> tuple[object, ...]:
    """What equations depend on in a request, but for names and values."""
    return (request.form if request.form in ("linear", "worked") else "", request.has_source_potentials, request.has_quaternions,
            request.format == "sympy", request.level, request.sections)


def _kept(make: Callable[..., object], key: Callable[..., object]) -> Callable[..., object]:
    """What is found, or raised, first for a key."""
    known: dict[object, object] = {}

    def found(*given: object) -> object:
        at = key(*given)
        if at not in known:
            try:
                known[at] = make(*given)
            except Exception as error:
                known[at] = error
        if isinstance(known[at], Exception):
            raise known[at]
        return known[at]

    return found


def once(make: Callable[..., object]) -> Callable[..., object]:
    """Whatever it is given, what it makes first."""
    made: list[object] = []
    return lambda *given: made[0] if made else made.append(make(*given)) or made[0]
