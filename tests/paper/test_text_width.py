"""No line of text is longer than 100 columns, whatever the scene and the form."""

from pathlib import Path

import pytest

from helpers.symbolic_scenes import EXAMPLES
from lagrangia.base.diagnostics import LagError
from lagrangia.paper.sheet import ALL_FORMS, Request, write_equations

SLOW = ("scissor_lift", "andrews_squeezer", "pantograph", "n_four_bars", "parallelogram")


@pytest.mark.parametrize("path", [pytest.param(path, id=path.stem, marks=pytest.mark.slow if path.stem in SLOW else ())
                                  for path in sorted(EXAMPLES.glob("*.lag"))])
def test_lines_fit(path: Path) -> None:
    structural = {"n": 3} if path.stem == "chain" else None
    for form in ALL_FORMS:
        try:
            said = write_equations(path, Request(form), structural=structural)
        except LagError as error:
            assert form == "linear" and "L0713" in str(error)
            continue
        assert [row for row in said.splitlines() if len(row) > 100] == []
