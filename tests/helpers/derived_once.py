"""What several outputs of one scene have in common, made once: equations of pages in several forms, compilations."""

from collections.abc import Callable, Mapping

import pytest
import sympy as sp

from lagrangia.paper import sheet
from lagrangia.paper.equations import Equations
from lagrangia.paper.sheet import Request


def derive_once(patch: pytest.MonkeyPatch) -> None:
    """For tests that ask for many forms of one scene with the same parameters: those whose equations are the same share them."""
    patch.setattr(sheet, "_book", _kept(sheet._book, lambda kinematics, scene, request, has_kicks: _kind(request)))
    patch.setattr(sheet, "linearize", _kept(sheet.linearize, _linearized))


def _kind(request: Request) -> tuple[object, ...]:
    """What equations depend on in a request, but for names and values."""
    return (request.form if request.form in ("linear", "worked") else "", request.has_source_potentials, request.has_quaternions,
            request.format == "sympy", request.level, request.sections)


def _linearized(e: Equations, numbers: Mapping[sp.Expr, float], begin: object, given: Mapping[str, float] | None = None
                ) -> tuple[object, ...]:
    """Small motions are the same where equations, parameters and the place are."""
    return (*(tuple(map(tuple, x)) for x in (e.M, e.J)), *map(tuple, (e.h, e.f, e.rows)), *numbers.items(), repr(given))


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
