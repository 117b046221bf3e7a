"""In which formulas a scene is compiled, and which of them hold for the values of its parameters.

Numbers that are compiled in hold for themselves alone; what moves no mass follows from other equations than what does; formulas
for masses that are uneven, or 0 in a loop, are longer; and what only just holds does so for the values that are declared.
"""

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import replace
from typing import Any

from lagrangia.base.records import dataclass
from lagrangia.run.request import check_values
from lagrangia.run.scene import Parameter, Scene

# Instructions of an evaluation: one of four_bar (254; 348 for any masses) costs the same by both, and a call of some 25 us 3 to 9
# more with the question; spatial_four_bar (646; 1432) takes 125 us for 145, hexapod (8610; 16826) 1.34 ms for 7.1.
_SHORT = 600
MASSES = ("kg", "kg.m2")  # units
Sets = Callable[[], Iterable[tuple[Sequence[Any], Sequence[float]]]]  # of parameters: values (or arrays of many) and their mask
Compute = Callable[..., list[list[Any]]]  # interpret.evaluate, or evaluate_each for arrays


@dataclass(frozen=True)
class Formulas:
    """`for_any_mass`: they hold whatever the masses; `is_general`: no number is compiled in that can be set; `is_as_written`:
    with what only just holds as it is written; `massless`: the masses compiled in as 0, None for those declared so; `in_space`:
    not by the equations of a plane in which a scene in space may lie; `least_squares`: reactions that repeated constraints share
    are those of least squares, torques over this length (m)."""

    for_any_mass: bool = False
    is_general: bool = False
    is_as_written: bool = False
    massless: tuple[str, ...] | None = None
    in_space: bool = False
    least_squares: float | None = None


AS_DECLARED = Formulas()


def by_numbers(scene: Scene, formulas: Formulas, sets: Sets, compute: Compute) -> Formulas:
    """These, or a step towards those whose numbers are these parameters'. Masses of 0 in some sets alone stay open."""
    known = [(k, p.compiled) for k, p in enumerate(scene.parameters) if p.compiled is not None and not _is_massless(p)]
    if known and any(mask[k] and _any(given[k] != number) for given, mask in sets() for k, number in known):
        return replace(formulas, is_general=True, massless=massless_of(scene))
    massless = _massless(scene, sets, compute)
    return formulas if massless == massless_of(scene) else replace(formulas, massless=massless)


def by_masses(scene: Scene, formulas: Formulas, sets: Sets, compute: Compute) -> Formulas:
    """The same for masses that are uneven, and for what only just holds."""
    if _lets_go(scene, sets, compute):
        return replace(formulas, is_as_written=True)
    if scene.unevenness is None:
        return formulas
    is_even = not any(_any(compute(scene.unevenness, _all(scene, *one, compute))[0][0] != 0) for one in sets())
    return formulas if is_even else replace(formulas, for_any_mass=True)


def by_varied(scene: Scene, formulas: Formulas, varied: Collection[str]) -> Formulas:
    """The same for whatever values of these parameters, where asking which hold costs more than formulas that always do."""
    is_short = len(scene.tapes["rhs"].code) < 4 * _SHORT
    return replace(formulas, for_any_mass=True) if is_short and feel_masses(scene, varied) else formulas


def feel_masses(scene: Scene, varied: Collection[str]) -> bool:
    """Whether values of these parameters decide whether the formulas hold, by the masses that they make."""
    if scene.unevenness is None:
        return False
    given = {(0, k) for k, parameter in enumerate(scene.parameters) if parameter.name in varied}
    return bool(scene.unevenness.reached({(0, k) for _, k in scene.tapes["parameters"].reached(given)}))


def massless_of(scene: Scene) -> tuple[str, ...]:
    """The masses that are compiled in as 0."""
    return tuple(p.name for p in scene.parameters if _is_massless(p))


def zero_masses(scene: Scene, parameters: Sequence[float]) -> list[str]:
    """Those that are 0 among the values of all parameters, and not known to be."""
    return [p.name for p, value in zip(scene.parameters, parameters, strict=True)
            if p.unit in MASSES and value == 0 and not _is_massless(p)]


def zero_directions(scene: Scene, parameters: Sequence[float]) -> list[str]:
    """Vectors without unit, as axes are, that are 0 among the values of all parameters and were not declared so."""
    vectors: dict[str, list[tuple[Parameter, float]]] = {}
    for p, value in zip(scene.parameters, parameters, strict=True):
        stem, _, place = p.name.rpartition("[")
        if p.unit in ("", "1") and place in ("1]", "2]", "3]"):
            vectors.setdefault(stem, []).append((p, value))
    return [stem for stem, parts in vectors.items()
            if len(parts) > 1 and all(value == 0 for _, value in parts) and any(p.value != 0 for p, _ in parts)]


def _is_massless(parameter: Parameter) -> bool:
    return parameter.unit in MASSES and parameter.compiled == 0


def _massless(scene: Scene, sets: Sets, compute: Compute) -> tuple[str, ...]:
    """The masses that are 0 in all sets."""
    found = [_none(scene, given, mask, compute) for given, mask in sets()]
    return tuple(name for name in found[0] if all(name in names for names in found[1:])) if found else massless_of(scene)


def _none(scene: Scene, given: Sequence[Any], mask: Sequence[float], compute: Compute) -> tuple[str, ...]:
    """The same of one portion; computed only where it may be otherwise than declared."""
    masses = [(k, p) for k, p in enumerate(scene.parameters) if p.unit in MASSES]
    if all(mask[k] and not _any(given[k] != p.value) for k, p in masses):
        return tuple(p.name for _, p in masses if p.value == 0)
    values = _all(scene, given, mask, compute)
    return tuple(p.name for k, p in masses if not _any(values[k] != 0))


def _lets_go(scene: Scene, sets: Sets, compute: Compute) -> bool:
    """Whether parameters differ by which constraints only just hold."""
    places = scene.notes["touching"]["parameters"]
    if not places:
        return False
    declared = check_values(scene)
    usual = _all(scene, declared.parameters, declared.mask, compute)
    return any(_any(values[k] != usual[k]) for values in (_all(scene, *one, compute) for one in sets()) for k in places)


def _all(scene: Scene, given: Sequence[Any], mask: Sequence[float], compute: Compute) -> list[Any]:
    return compute(scene.tapes["parameters"], given, mask)[0]


def _any(found: Any) -> bool:
    """Of numbers, or of arrays."""
    return bool(found.any()) if hasattr(found, "any") else bool(found)
