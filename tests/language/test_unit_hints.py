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
