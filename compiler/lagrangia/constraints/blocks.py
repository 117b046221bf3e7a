"""Equations of start values solved one block after another: as runtime/start/blocks.c, which states what it does and why."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from lagrangia.algebra.orthogonal import Vector
from lagrangia.base.records import dataclass
from lagrangia.constraints.metric import Way
from lagrangia.constraints.newton import Equations, General, Newton


@dataclass(frozen=True)
class Block:
    """Some of the equations, by number, and the values (2 n,) that are moved to solve them."""

    equations: NDArray[np.int_]
    moving: NDArray[np.bool_]


def blocks(general: General, active: NDArray[np.int_], scale: Vector) -> list[Block]:
    """Those of the active equations, in their order: each speaks of its own values and of those of blocks before it alone."""
    return list(_blocks((general.jacobian[active] != 0) & (scale > 0), active))


def _blocks(speaks: NDArray[np.bool_], active: NDArray[np.int_]) -> Iterator[Block]:
    is_open, unowned = np.ones(active.size, bool), np.ones(speaks.shape[1], bool)
    mine, own = np.zeros(active.size, bool), np.zeros(speaks.shape[1], bool)
    while is_open.any():
        counts = np.where(is_open, (speaks & unowned).sum(axis=1), speaks.shape[1] + 1)
        own |= speaks[counts.argmin()] & unowned
        unowned &= ~own
        taken = is_open & ~(speaks & unowned).any(axis=1)
        mine |= taken
        is_open &= ~taken
        if (speaks[mine].any(axis=1)).sum() <= own.sum() or not is_open.any():
            yield Block(active[mine], own)
            mine, own = np.zeros_like(mine), np.zeros_like(own)


def solve_blocks(
    found: list[Block], equations: Equations, general: General, scale: Vector, fixed: NDArray[np.int_], x: Vector, way: Way,
    most_iterations: int, most_pushes: int,
) -> tuple[Vector, int]:
    """Each by its own values, at last all together; the place reached, and an equation of the first that fails, or -1."""
    failed = -1
    for block in found:
        newton = Newton(equations, general, block.equations, np.where(block.moving, scale, 0.0), fixed, x, way)
        x, worst = newton.solve(x, most_iterations, most_pushes)
        failed = worst if failed < 0 else failed
    if failed >= 0:
        return x, failed
    active = np.sort(np.concatenate([block.equations for block in found]))
    return Newton(equations, general, active, scale, fixed, x, way).solve(x, most_iterations, 0)
