"""Equations that may be dependent, solved by orthogonal transformations."""

import numpy as np

from lagrangia.algebra.orthogonal import nearest


def test_dependent_equations_that_contradict_each_other_share_what_they_miss() -> None:
    """Three alike of three blocks, (9, 12), weighted: beside the least squares of a singular value decomposition."""
    block = np.array([[1.0, 2, 0, 1], [2, 4, 0, 2], [0, 1, -1, 0]])  # the second says the first once more
    A, b = np.kron(np.eye(3), block), np.array([1.0, 3, 2, 0, 1, 0, 1, 2, -1])
    wish, weight = np.linspace(-1, 1, 12), np.linspace(0.5, 2, 9)
    x, rank = nearest(A, b, wish, 1e-9, weight)
    step = np.linalg.lstsq(A * weight[:, None], (b - A @ wish) * weight, rcond=1e-9)[0]
    assert rank == 6
    np.testing.assert_allclose(x, wish + step, rtol=0, atol=1e-14)


def test_equations_that_say_nothing_leave_the_wish() -> None:
    wish = np.array([1.0, 2.0])
    x, rank = nearest(np.zeros((3, 2)), np.zeros(3), wish, 1e-9)
    assert rank == 0
    np.testing.assert_array_equal(x, wish)
