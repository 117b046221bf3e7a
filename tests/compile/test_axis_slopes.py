"""Derivatives of accelerations by axes of hinges, where these lie along others: none were known there, and NaN told so."""

from pathlib import Path

import numpy as np
import pytest

from lagrangia.model import Model

EXAMPLES = Path(__file__).parents[2] / "models" / "examples"


@pytest.mark.parametrize("name", ["furuta", "spatial_four_bar", "cardan_shaft"])
def test_they_are_those_of_differences(name: str) -> None:
    model = Model(EXAMPLES / f"{name}.lag")
    run = model.simulate(at=[0, 0.1], tolerance=1e-12)
    q, v = ([run[column][-1] for column in names] for names in (model.position_names, [x.name for x in model.scene.rates]))
    p, rhs = np.array(model.parameter_values()), model.functions()["rhs"]
    found = np.array(model.derivatives()["jacobian_p"](0.1, q, v, [], p))
    moves = 1e-6 * np.eye(len(p))
    wanted = np.hstack([np.array(rhs(0.1, q, v, [], p + move) - rhs(0.1, q, v, [], p - move)) / 2e-6 for move in moves])
    np.testing.assert_allclose(found, wanted, rtol=1e-6, atol=1e-6 * np.abs(wanted).max())
