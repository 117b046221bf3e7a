"""Units as people write them elsewhere are told as they are written here."""

from collections.abc import Callable

import pytest

import lagrangia as lag

MEANT = {"Nm": "N.m", "N m": "N.m", "m²": "m2", "kg*m²": "kg*m2", "sec": "s", "kgm2": "kg.m2", "Nms": "N.m.s",
         "Kg": "kg", "hz": "Hz"}


@pytest.mark.parametrize("unit", MEANT)
def test_a_hint_names_what_was_meant(scene: Callable[[str], lag.Model], unit: str) -> None:
    with pytest.raises(lag.LagError) as error:
        scene(f"model M output Real y = 3[{unit}]; Block b(m = 1, base = world); end M;")
    assert f"did you mean '{MEANT[unit]}'?" in str(error.value)


@pytest.mark.parametrize(("declared", "message"), [
    ('Real d(unit = "mm") = 3', 'unit = "m", displayUnit = "mm"'), ('Angle d(unit = "deg") = 90', 'unit = "rad"'),
    ('Real d(unit = "degC") = 20', 'unit = "K"'), ('Real d(unit = "foo") = 3', "'foo' is not a unit"),
])
def test_numbers_of_constants_are_in_si_units_as_those_of_parameters(
        scene: Callable[[str], lag.Model], declared: str, message: str) -> None:
    with pytest.raises(lag.LagError, match="L0301") as error:
        scene(f"model M constant {declared}; output Real y = 0*d; Block b(m = 1, base = world); end M;")
    assert message in str(error.value)
