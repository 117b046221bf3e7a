"""Motion -> M a = F (q, v, w), dw/dt = G w: a linear scene with its loads as further states, for the matrix exponential.

The powers of the energy account are x' Q x with x = (q, v, w). runtime/methods/linear_system.h states how the numbers lie.
"""

import casadi as ca

from lagrangia.base.records import dataclass
from lagrangia.dynamics.motion import Motion, mass_matrix
from lagrangia.frames.kinematics import Kinematics
from lagrangia.needs.linearity import Degree, NotLinear, Rewritten, rewrite
from lagrangia.needs.loads import LoadStates
from lagrangia.needs.waves import NotAWave

# Beyond so many states only products with sparse matrices are formed, and of a mass matrix with more entries a row no factors.
_MOST_DENSE, _DENSEST_ROW = 200, 24
_UNEVEN = "its mass matrix is not constant"
_POWERS = "not supported yet: the powers of its energy account, as they are written,"


@dataclass(frozen=True)
class LinearForm:
    """`values`: p, modes -> the nonzeros;  `waves`: t, p, modes -> w (zero where inputs stand);  `pattern`: where they lie."""

    values: ca.Function
    waves: ca.Function
    pattern: tuple[int, ...]


def find_linear_form(kinematics: Kinematics, motion: Motion) -> LinearForm | str:
    """The form, or the reason why the scene is not linear."""
    if not motion.q.numel():
        return "nothing in it moves"
    if motion.constrained is not None:
        return "it is held by constraints that are not substituted away"
    n = motion.q.numel()
    is_quadratic = not (kinematics.is_timed or motion.bodies.rest)  # T, in the rates
    if n > _MOST_DENSE and is_quadratic and not motion.inertial.is_known and ca.depends_on(motion.T, motion.q):
        return _UNEVEN  # before h is made, which nobody else asked for
    modes = kinematics.algebra.mode_symbols
    powers = ca.vertcat(motion.dissipated_power, motion.source_power)
    has_forms = 2 * motion.q.numel() <= _MOST_DENSE and not powers.is_zero()
    moving = ca.vertcat(motion.q, motion.v, motion.u)
    try:
        arguments = (moving, motion.t, modes, motion.p)
        equations = rewrite(motion.h, *arguments)
        _check(kinematics, motion, equations, modes)
        return _Builder(motion, modes, moving, equations, _rewrite_powers(powers if has_forms else ca.SX(0, 1), arguments)).form()
    except (NotLinear, NotAWave) as reason:
        return str(reason)


def _rewrite_powers(powers: ca.SX, arguments: tuple[ca.SX, ca.SX, ca.SX, ca.SX]) -> Rewritten:
    """Loads that change at events go into the state if they can, so that the matrices stay."""
    try:
        return rewrite(powers, *arguments, factors_are_loads=True)
    except NotLinear:
        return rewrite(powers, *arguments, what=_POWERS)


def _check(kinematics: Kinematics, motion: Motion, rewritten: Rewritten, modes: ca.SX) -> None:
    for degree, coordinate in zip(rewritten.degrees, kinematics.graph.coordinates, strict=False):
        if degree == Degree.QUADRATIC:
            raise NotLinear(f"the equation of '{coordinate.name}' multiplies two quantities that change in time")
    if ca.jacobian_sparsity(motion.momentum, motion.v).nnz() > max(_MOST_DENSE**2 // 4, _DENSEST_ROW * motion.q.numel()):
        raise NotLinear("not supported yet: so large a mass matrix that is full")
    if ca.depends_on(mass_matrix(motion), ca.vertcat(motion.q, motion.v, motion.u, motion.t, modes)):
        raise NotLinear(_UNEVEN)


class _Builder:
    """Expressions that are linear (h) and quadratic (powers) in q, v, u and loads, as matrices on (q, v, w)."""

    def __init__(self, motion: Motion, modes: ca.SX, moving: ca.SX, equations: Rewritten, powers: Rewritten) -> None:
        self.motion, self.modes, self.moving = motion, modes, moving
        self.symbols = ca.vertcat(equations.symbols, powers.symbols)
        self.n = motion.q.numel()
        self.h, self.powers = equations.expressions, powers.expressions
        both = ca.vertcat(self.h, self.powers)
        self.all = ca.vertcat(moving, self.symbols)
        self.rest = self._at_rest(both)
        self.slopes = self._at_rest(ca.jacobian(self.powers, self.all))
        n_inputs = motion.u.numel() if motion.u.numel() and ca.depends_on(both, motion.u) else 0
        needs_one = not (self.rest.is_zero() and self.slopes.is_zero())
        self.loads = LoadStates(motion.t, modes, motion.p, ca.vertcat(equations.loads, powers.loads), n_inputs, needs_one)
        self.size = 2 * self.n + self.loads.n_w
        self.Z = self._selection(n_inputs)

    def _at_rest(self, expressions: ca.SX) -> ca.SX:
        return ca.densify(ca.substitute(expressions, self.all, ca.SX.zeros(self.all.numel())))

    def _selection(self, n_inputs: int) -> ca.SX:
        """(q, v, u, loads) = Z (q, v, w)."""
        Z, n = ca.SX(self.all.numel(), self.size), 2 * self.n
        Z[:n, :n] = ca.SX.eye(n)
        for k in range(n_inputs):
            Z[n + k, n + k] = 1
        if self.symbols.numel():
            Z[self.moving.numel() :, n:] = self.loads.factors
        return ca.sparsify(Z)

    def _force_rows(self) -> ca.SX:
        F = -ca.mtimes(ca.jacobian(self.h, self.all), self.Z)
        if self.loads.one >= 0:
            F[:, 2 * self.n + self.loads.one] -= self.rest[: self.n]
        return ca.sparsify(F)

    def _quadratic_form(self, k: int) -> ca.SX:
        hessian, _ = ca.hessian(self.powers[k], self.all)
        Q = ca.mtimes([self.Z.T, hessian, self.Z]) / 2
        if self.loads.one >= 0:
            one, half = 2 * self.n + self.loads.one, ca.mtimes(self.slopes[k, :], self.Z) / 2
            Q[one, :] += half
            Q[:, one] += half.T
            Q[one, one] += self.rest[self.n + k]
        return ca.sparsify(Q)

    def form(self) -> LinearForm:
        M = mass_matrix(self.motion)
        pattern, order = M.sparsity().ldl(True) if M.sparsity().nnz() > self.n else (ca.Sparsity(self.n, self.n), range(self.n))
        permuted = M[list(order), list(order)]
        forms = [self._quadratic_form(k) for k in range(self.powers.numel())]
        rows = [_rows(matrix) for matrix in (self._force_rows(), self.loads.generator(), *forms)]
        numbers = [ca.densify(ca.diag(permuted)), *ca.project(permuted, pattern).nonzeros()]
        numbers += [x for _, found in rows for x in found]
        values = ca.vertcat(*numbers)
        changes = bool(self.modes.numel()) and ca.depends_on(values, self.modes)
        integers = [self.loads.n_w, self.loads.n_inputs, int(changes), len(forms), *order, *pattern.colind(), *pattern.row()]
        for places, _ in rows:
            integers += places
        t, p, d = self.motion.t, self.motion.p, self.modes
        return LinearForm(ca.Function("linear", [p, d], [ca.densify(values)], ["p", "d"], ["values"]),
                          ca.Function("waves", [t, p, d], [self.loads.values()], ["t", "p", "d"], ["w"]),
                          tuple(int(i) for i in integers))


def _rows(matrix: ca.SX) -> tuple[list[int], list[ca.SX]]:
    """A sparse matrix row by row: where rows begin and the columns, and the numbers."""
    across = matrix.T
    return [*across.sparsity().colind(), *across.sparsity().row()], across.nonzeros()
