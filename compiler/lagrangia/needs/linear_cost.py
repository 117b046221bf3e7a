"""What the matrix exponential costs, and what steps do: run/rules.py compares. Both ways are right; this is about time alone.

An explicit method takes some steps for each radian of the fastest motion, more for tighter tolerances; the exponential costs its
set-up, whatever the horizon, and each row, whatever lies between the rows. Measured with 501 rows on lattices of 36 and 100
coordinates, where series take 0.3 and 1 ms: set-up and rows take 3 and 40 ms, a share of the third and of the second power of
the states. Where a table bends, in time, both begin anew: exponentials of 4, 12 and 24 states take 1.4, 2.1 and 3.7 us a
piece, series that reach over it 0.6, 0.9 and 1.2 us.
"""

import casadi as ca
import numpy as np

from lagrangia.base.table_data import Beyond
from lagrangia.constraints.parameters import default_parameters
from lagrangia.dynamics.motion import Motion, mass_matrix
from lagrangia.frames.kinematics import Kinematics
from lagrangia.run.rules import MOST_LINEAR, Facts

_SET_UP, _ROW = 3.2e-3, 7.4e-4  # microseconds, times the third power of the number of states, and the second
_ACCOUNTS = 4  # times as much where energy is lost or fed in, whose integrals are forms of the state
_RADIAN, _RADIAN_OF_ONE = 1.2, 0.02  # microseconds, and for each coordinate
_PIECE, _PIECE_OF_STATES = 1.3, 4.2e-3  # microseconds a piece of a table, and times the second power of the number of states
_FEW = 6  # coordinates up to which series reach over pieces, so that it pays to leave exponentials
_ORDER, _USUAL_TOLERANCE = 8, 1e-8
_USUAL_ROWS = 500


def weigh_linear(kinematics: Kinematics, motion: Motion) -> Facts:
    """At the parameters as declared and over the experiment's horizon: radians of the fastest motion, more at tight tolerances;
    `own`, those that set-up and rows of exponentials cost as much as. Of many coordinates nothing is measured."""
    experiment = kinematics.graph.model.experiment
    if motion.q.numel() > MOST_LINEAR:
        return {"coordinates": motion.q.numel()}
    horizon, n = experiment.stop - experiment.start, motion.q.numel()
    radians = fastest_rate(kinematics, motion) * horizon
    more = (_USUAL_TOLERANCE / experiment.tolerance) ** (1 / _ORDER)
    rows = horizon / experiment.interval if experiment.interval else _USUAL_ROWS
    accounts = 1 if motion.dissipated_power.is_zero() and motion.source_power.is_zero() else _ACCOUNTS
    own = accounts * (_SET_UP * (2 * n) ** 3 + _ROW * (2 * n) ** 2 * rows)
    if n <= _FEW:
        own += pieces_of_tables(kinematics, experiment.start, experiment.stop) * (_PIECE + _PIECE_OF_STATES * (2 * n) ** 2)
    own /= _RADIAN + _RADIAN_OF_ONE * n
    return {"coordinates": n, "radians": radians * more, "own": own, "has_events": bool(kinematics.algebra.modes)}


def pieces_of_tables(kinematics: Kinematics, start: float, stop: float) -> float:
    """How many pieces of tables in time are passed from start to stop, at the parameters as declared."""
    uses = list({mode.use.number: mode.use for mode in kinematics.algebra.modes if mode.use is not None}.values())
    if not uses:
        return 0.0
    p, defaults = default_parameters(kinematics)
    function = ca.Function("arguments", [kinematics.algebra.time, p], [ca.vertcat(*[use.argument for use in uses])])
    ways = np.abs(np.array(function(stop, defaults)) - np.array(function(start, defaults))).ravel()
    tables = [use.table for use in uses]
    passed = [table.n * way / (table.knot(table.n - 1) - table.knot(0)) for table, way in zip(tables, ways, strict=True)]
    return float(sum(x if table.beyond is Beyond.PERIODIC else min(x, table.n) for x, table in zip(passed, tables, strict=True)))


def fastest_rate(kinematics: Kinematics, motion: Motion) -> float:
    """The largest |lambda| of the motion's equations, 1/s; 0 where they have no value."""
    p, defaults = default_parameters(kinematics)
    n = motion.q.numel()
    slopes = ca.densify(ca.jacobian(motion.h, ca.vertcat(motion.q, motion.v)))
    matrices = [ca.densify(mass_matrix(motion)), slopes]
    function = ca.Function("matrices", [motion.t, p], kinematics.algebra.with_modes(matrices))
    M, KC = (np.array(x) for x in function(kinematics.graph.model.experiment.start, defaults))
    try:
        A = np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), -np.linalg.solve(M, KC)])
        rates = np.abs(np.linalg.eigvals(A))
    except np.linalg.LinAlgError:
        return 0.0
    return float(rates.max()) if np.all(np.isfinite(rates)) else 0.0
