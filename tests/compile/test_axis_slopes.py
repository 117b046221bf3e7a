"""Derivatives of accelerations by axes of hinges, where these lie along others: none were known there, and NaN told so."""

from collections.abc import Callable
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


def test_of_one_coordinate_alone(scene: Callable[[str], Model]) -> None:
    """A point mass m at a distance 2 from a horizontal axis along {1, w, 0}/norm: it swings by the axis' direction in gravity."""
    model = scene("""model M parameter Real w = 0; Revolute hinge(a = world, axis = {1, w, 0}, phi(start = 0.4));
      PointMass p(m = 3, center = shift(hinge.b, {0, 0, -2})); end M;""")
    values, functions = model.parameter_values(), model.derivatives() | model.functions()
    k, h = model.parameter_names.index("w"), 1e-4
    for w in (0.0, 0.5):
        values[k] = w
        ends = [float(functions["rhs"](0, 0.4, 1, [], values + move * np.eye(len(values))[k])) for move in (-h, h)]
        slope = float(functions["jacobian_p"](0, 0.4, 1, [], values)[k])
        assert slope == pytest.approx((ends[1] - ends[0]) / (2*h), abs=1e-6) and np.isfinite(slope)
