"""What only a running FMU shows: which numbers its states really are, derivatives against differences, reset, saved states.

Each function returns faults as texts.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any

from lagrangia.fmu.importer import Importer

_STEPS = (1e-7, 1e-5, 1e-3)  # of a state, for differences: some FMUs have rounding, others wide surroundings to be kept off
_WRONG = 1e-2  # of the largest in a column: a derivative that is another one
_MOST = 20  # states whose derivatives are looked at

Start = Callable[[], None]


def probe_states(importer: Importer) -> list[str]:
    """The continuous states must be the variables that the description says, in its order, and so their derivatives."""
    derivatives = [unknown.variable for unknown in importer.description.derivatives]
    if any(d.derivative is None for d in derivatives):
        return []
    states = importer.columns([d.derivative.name for d in derivatives])
    before = importer.states()
    if len(states) != len(before):
        return [f"there are {len(before)} states, and {len(states)} variables whose derivatives are listed"]
    apart = [x + 1e-3 * (k + 1) * max(1.0, abs(x)) for k, x in enumerate(before)]  # no two alike
    importer.set_states(apart)
    faults = _compared("the state", states, importer.get(states), importer.states())
    importer.set_states(before)
    if not faults:
        names = importer.columns([d.name for d in derivatives])
        faults = _compared("the derivative", names, importer.get(names), importer.slopes())
    return faults


def _compared(what: str, names: Sequence[str], by_name: Sequence[float], by_place: Sequence[float]) -> list[str]:
    for k, (name, value, true) in enumerate(zip(names, by_name, by_place, strict=True), 1):
        if not math.isclose(value, true, rel_tol=1e-9, abs_tol=1e-12):
            return [f"{what} {k} is {true:.9g} in the vector, and '{name}', which the description names there, is {value:.9g}"]
    return []


def probe_derivatives(importer: Importer) -> list[str]:
    """Directional derivatives along each state against central differences."""
    rows = [u.variable for u in (*importer.description.derivatives, *importer.description.outputs)
            if u.variable.type in ("Real", "Float64")]
    states = [u.variable.derivative for u in importer.description.derivatives]
    if not rows or not states or any(s is None for s in states):
        return []
    faults: list[str] = []
    names, x, nominals = importer.columns([row.name for row in rows]), importer.states(), importer.nominals()
    of_rows, elements = [row.valueReference for row in rows], importer.columns([state.name for state in states])
    for k, (name, nominal) in enumerate(zip(elements[:_MOST], nominals, strict=False)):
        state, place, _ = importer.find(name)
        seed = [float(i == place) for i in range(len(importer.columns([state.name])))]
        exact = importer.along(of_rows, [state.valueReference], seed, len(names))
        tries = [_differing(importer, names, x, k, step * max(abs(x[k]), nominal), exact) for step in _STEPS]
        if all(tries):
            row, found, true = tries[1]
            faults.append(f"the directional derivative of '{row}' along '{name}' is {found:.6g}, and by differences {true:.6g}")
    return faults


def _differing(importer: Importer, names: Sequence[str], x: Sequence[float], k: int, h: float, exact: Sequence[float]) -> Any:
    """The first whose derivative along state k is not that by central differences: name, derivative, difference; or nothing."""
    ends = []
    for sign in (1, -1):
        importer.set_states([value + sign * h * (i == k) for i, value in enumerate(x)])
        ends.append(importer.get(names))
    importer.set_states(x)
    numeric = [(a - b) / (2 * h) for a, b in zip(*ends, strict=True)]
    largest = max(map(abs, (*x, *importer.nominals(), *ends[0], *ends[1])))  # what is held is a difference of terms unseen
    noise = [max(1e-12 * max(abs(a), abs(b)), 1e-15 * largest) / h for a, b in zip(*ends, strict=True)]
    size = max(map(abs, (*exact, *numeric)))
    for name, found, true, error in zip(names, exact, numeric, noise, strict=True):
        if not abs(found - true) <= _WRONG * size + error:
            return name, found, true
    return ()


def probe_reset(importer: Importer, first: Sequence[float], start: Start, read: Callable[[], list[float]],
                go_on: Callable[[], Any]) -> list[str]:
    """After reset all is as it was at `first`: when it was just initialised, before anybody looked at other states."""
    go_on()
    importer.reset()
    start()
    again = read()
    same = all(a == b or (math.isnan(a) and math.isnan(b)) for a, b in zip(first, again, strict=True))
    return [] if same else ["after reset, and initialised again, it does not start where it did first"]


def probe_saved(importer: Importer, read: Callable[[], list[float]], go_on: Callable[[], Any]) -> list[str]:
    """A state that was saved, and serialised when the FMU says it can be, is gone on from as the first time."""
    fmu, interface = importer.fmu, importer.interface
    if not interface.canGetAndSetFMUstate:
        return []
    state = fmu.getFMUState()
    go_on()
    first = read()
    restored = state
    if interface.canSerializeFMUstate:
        written = fmu.serializeFMUState(state)
        restored = (fmu.deSerializeFMUstate if importer.is_fmi2 else fmu.deserializeFMUState)(written)
    fmu.setFMUState(restored)
    go_on()
    same = all(a == b or (math.isnan(a) and math.isnan(b)) for a, b in zip(first, read(), strict=True))
    fmu.setFMUState(state)
    return [] if same else ["from a state that was saved and restored it goes on in another way"]
