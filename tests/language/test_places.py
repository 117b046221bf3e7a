"""What people give to a component of the library and is wrong there is told at their declaration, with the line that reads it."""

from collections.abc import Callable

import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]


@pytest.mark.parametrize(("text", "code", "said"), [
    ("Rope r(n = 0, L = 2, a = world, b = b.center);", "L0214", "it is read at library/constraints.lag"),
    ("Rope r(n = -1, L = 2, a = world, b = b.center);", "L0209", "negative size"),
    ("Rope r(n = 100000000, L = 2, a = world, b = b.center);", "L0209", "elements"),
    ("Rope r(n = 1000000, L = 2, a = world, b = b.center);", "L0209", "elements"),
    ("Stop s(a = world, b = shift(world, {1, 0}), along = {1, 0});", "L0225", "true or false for good"),
])
def test_errors_stand_where_people_wrote(text: str, code: str, said: str, scene: Write) -> None:
    with pytest.raises(lag.LagError) as found:
        scene(f"model A PointMass b(m = 1);\n  {text}\nend A;").simulate(at=[1.0])
    (first, *_) = found.value.diagnostics
    assert first.code == code and first.span is not None and str(first.span).partition("scene.lag:")[2].startswith("2:")
    assert said in str(found.value) and "--> library" not in str(found.value)
