"""The equations as CasADi Functions of t, q, v, u, p, for people and exports."""

from collections.abc import Collection, Mapping

import casadi as ca

from lagrangia.compile.axis_slopes import slopes_by_parameters
from lagrangia.compile.functions import state_space
from lagrangia.compile.told_positions import ToldPositions, told_positions
from lagrangia.constraints.parameters import parameters_of
from lagrangia.constraints.rows import Constraints
from lagrangia.dynamics.motion import Motion, mass_matrix
from lagrangia.dynamics.negative_inertia import refuse_negative_inertia, without_negative_inertia
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.delays import refuse_delays
from lagrangia.language.samplers import refuse_held


def people_functions(
    kinematics: Kinematics, motion: Motion, constraints: Constraints, outputs: tuple[str, ...], given: Collection[str] = ()
) -> dict[str, ca.Function]:
    """M, h, rhs, energies, outputs and jacobian as functions of t, q, v, u, p, in SI units.

    M(q, p) (n, n): M dv/dt + h = 0;  rhs: dv/dt (n,);  energies: T, V, D;  jacobian: d(dv/dt)/d(q, v) (n, 2 n).
    p has an entry for every parameter. One that is bound to others (m of Bar bar(m = m)) follows them: its entry is not read, and
    derivatives go through its binding; in `given` are names of such that are read from p instead.
    Where attitudes are coordinates q has their unit quaternions (model.position_names), whose length says nothing, jacobian as
    many columns more, and turning is dq/dt; v stays as it is.
    A constrained scene has four more, for its m constraints: M dv/dt + h + J^T lambda = 0, J dv/dt + bias = 0.
    Phi(t, q) = 0, the holonomic ones (m or fewer rows);  J (m, n);  bias (m,): the rates of the constraints at dv/dt = 0,
    differentiated once more;  lambda (m,): the multipliers. At states off the constraints rhs and lambda keep d2 Phi/dt2 = 0.
    rhs is NaN where kinetic energies of the scene's own are negative for some motion.
    """
    refuse_held(kinematics.graph.model, "M, h and accelerations as functions")
    refuse_delays(kinematics.graph.model, "M, h and accelerations as functions")
    motion, told = without_negative_inertia(kinematics, motion), told_positions(kinematics)
    expressions = _equations(told, motion, constraints, outputs, {"jacobian": [_by_state(told, motion)]})
    return _following(told, motion, expressions, parameters_of(kinematics, motion.p, given))


def flat_function(kinematics: Kinematics, motion: Motion, constraints: Constraints, outputs: tuple[str, ...]) -> ca.Function:
    """All that a flat model consists of, of t, q, v, u, p and s, (n,), what of positions v is in those: outputs and turning, and
    rhs of a tree, or M, h, Phi, J, bias and rate, (m,): J v + dPhi/dt.

    Raises LagError L0506 where a kinetic energy is negative for some motion with the declared parameters.
    """
    refuse_negative_inertia(kinematics)
    told, held = told_positions(kinematics), motion.constrained
    found = _equations(told, motion, constraints, outputs, {"rate": [held.rows.rate]} if held else {})
    found = {name: found[name] for name in ("outputs", *(("M", "h", "Phi", "J", "bias", "rate") if held else ("rhs",)))}
    s = ca.SX.sym("s", motion.v.numel())
    table = _following(told, motion, found | {"turning": [told.pace(told.of(motion.q), motion.v)]},
                       parameters_of(kinematics, motion.p))
    t, q, v, u, p = (ca.SX.sym(name, table["turning"].numel_in(name)) for name in "tqvup")
    results = [table[name](t, q, s if name == "turning" else v, u, p) for name in table]
    return ca.Function("flat", [t, q, v, u, p, s], ca.cse(results), [*"tqvups"], [*table])


def _equations(told: ToldPositions, motion: Motion, constraints: Constraints, outputs: tuple[str, ...],
               others: Mapping[str, list[ca.SX]]) -> dict[str, list[ca.SX]]:
    """By their names, `others` among them."""
    (_a, y, *_) = state_space(told.kinematics, motion, constraints, outputs)[1]
    found = {"M": [mass_matrix(motion)], "h": [motion.h], "rhs": [motion.acceleration],
             "energies": [motion.T, motion.V, motion.D], "outputs": [y], **others}
    if told.quaternions:
        found["turning"] = [told.pace(told.of(motion.q), motion.v)]
    held = motion.constrained
    if held:
        found |= {"Phi": [held.rows.phi], "J": [held.J], "bias": [held.rows.bias], "lambda": [held.multipliers]}
    return found


def people_derivatives(
    kinematics: Kinematics, motion: Motion, given: Collection[str] = (), has_repeated: bool = False
) -> dict[str, ca.Function]:
    """jacobian_u: d(dv/dt)/du (n, n_u) and jacobian_p: d(dv/dt)/dp (n, n_p), as functions of t, q, v, u, p;
    parameters: p -> all values with which these and `people_functions` reckon, (n_p,)."""
    refuse_held(kinematics.graph.model, "derivatives of accelerations")
    refuse_delays(kinematics.graph.model, "derivatives of accelerations")
    (a,), p = kinematics.algebra.by_inputs([motion.acceleration]), motion.p
    parameters = parameters_of(kinematics, p, given)
    by_parameters = slopes_by_parameters(kinematics, motion, has_repeated) @ ca.jacobian(parameters, p)
    slopes = {"jacobian_u": [ca.jacobian(a, motion.u)], "jacobian_p": [by_parameters]}
    return {**_following(told_positions(kinematics), motion, slopes, parameters),
            "parameters": ca.Function("parameters", [p], [parameters], ["p"], ["parameters"])}


def _by_state(told: ToldPositions, motion: Motion) -> ca.SX:
    """Accelerations by told positions and rates."""
    if not told.quaternions:
        return ca.jacobian(motion.acceleration, ca.vertcat(motion.q, motion.v))
    put = told.put([motion.acceleration])[0]
    return ca.jacobian(put, ca.vertcat(told.q, motion.v))


def _following(told: ToldPositions, motion: Motion, expressions: Mapping[str, list[ca.SX]],
               parameters: ca.SX) -> dict[str, ca.Function]:
    """Functions of t, q, v, u, p, with the modes as they are at t and `parameters`, which are functions of p, in place of p."""
    labels = {"energies": ["T", "V", "D"], "outputs": ["y"], "rhs": ["a"]}
    arguments = [motion.t, told.q, motion.v, motion.u, motion.p]
    modes = [mode for mode in told.kinematics.algebra.modes if not mode.of_attitude]
    symbols, values = [mode.symbol for mode in modes], [mode.value for mode in modes]
    table = {}
    for name, results in expressions.items():
        found = told.put(ca.substitute(results, symbols, values) if modes else results)
        found = ca.substitute(found, [motion.p], [parameters])
        table[name] = ca.Function(name, arguments, found, ["t", "q", "v", "u", "p"], labels.get(name, [name]))
    return table
