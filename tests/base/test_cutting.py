"""Lists of a command line."""

import pytest

from lagrangia.base.cutting import cut_list


@pytest.mark.parametrize("items", [["x''", "y''"], ["x'", "y'"], ["x[1]'", "'u, v'"], ["'a, b'", "'c''", "d(1, 2)"]])
def test_commas_between_primes_part_a_list(items: list[str]) -> None:
    assert cut_list(", ".join(items)) == items
