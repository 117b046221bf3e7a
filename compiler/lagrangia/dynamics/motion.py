"""Energies -> Lagrange's equations: M(q, p) dv/dt + h(q, v, t, p, u) = 0, solved for the accelerations.

    d/dt(dT/dv) - dT/dq + dV/dq + dD/dv = f,   f_k = sum_i F_i . dr_i/dq_k

h is made by algorithmic differentiation: the gradient of T, V and D, and one forward sweep along v for the time derivative of
dT/dv. The accelerations come from the dense M, or by elimination along the tree of bodies, or from M and h of few coordinates
in which everything is collected that cancels; what counts fewer nodes is taken.
"""

from collections.abc import Sequence
from dataclasses import field, replace
from functools import cached_property

import casadi as ca

from lagrangia.algebra.duals import Scalar
from lagrangia.algebra.scalars import as_expression, column, symbols_in
from lagrangia.algebra.with_casadi import operations_in
from lagrangia.base.diagnostics import Span, fail
from lagrangia.base.later import Later
from lagrangia.base.records import dataclass
from lagrangia.constraints.held_points import HeldPoints
from lagrangia.constraints.partition import Partition
from lagrangia.constraints.rows import Constraints
from lagrangia.dynamics.along_tree import Tree, articulate
from lagrangia.dynamics.bodies import Bodies, find_bodies
from lagrangia.dynamics.collected_inertia import MOST_COORDINATES, Collected, blocks_of, collect, split_weights
from lagrangia.dynamics.constrained_motion import ConstrainedMotion, FreeMotion, bring_down, constrain, constraint_rows
from lagrangia.dynamics.dissipation import gradient_by_rates
from lagrangia.dynamics.energies import Energies, generalised_force, rate_of_potential
from lagrangia.dynamics.forces import forces_of_loops
from lagrangia.dynamics.impacts import Impacts
from lagrangia.dynamics.loops_in_tree import Ball, Granted
from lagrangia.dynamics.massless_directions import refuse_loose
from lagrangia.dynamics.regularity import is_even
from lagrangia.dynamics.schur import FreeTree, prefers
from lagrangia.frames.evaluation import scalars_of
from lagrangia.frames.geometry import Inertia, inertial_reaction
from lagrangia.frames.joints import all_reactions
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.attitudes import parts_of

# A mass matrix with more entries a coordinate than this is not formed when elimination along the tree is possible.
_DENSEST = 24
# Collected accelerations of few coordinates may be so much longer than the shortest where M and h, of which implicit steps are
# made, are shorter.
_NEARLY = 1.1
# Coordinates, in blocks that act on each other, that are collected: where nothing holds them, and in closed loops.
_MOST_FREE, _MOST_HELD = 60, 250
# Below this ratio fewer operations are worth differences of what the tree would do and what constraints take back.
_CLEARLY = 0.9
SMOOTH = frozenset({"sin", "cos", "sinh", "cosh", "tanh", "exp", "ratio"})  # with their derivatives
Held = tuple[ca.SX, ca.SX, ConstrainedMotion]  # what `constrain` finds


@dataclass(frozen=True)
class Felt:
    """Forces that feel reactions x: affine in `amounts`, of which each is a function of x, while x is affine in them."""

    reactions: ca.SX  # (k,): the symbols x
    amounts: ca.SX  # (m,): the symbols in the forces
    laws: ca.SX  # (m,): what each is, of x
    values: ca.SX  # (k,): x as functions of t, q, v, a, lambda, u, d, p and the amounts


@dataclass(frozen=True)
class Solution:
    """Amounts and reactions of a state."""

    felt: Felt
    amounts: ca.SX  # (m,)
    reactions: ca.SX  # (k,)

    def put(self, expressions: Sequence[ca.SX]) -> list[ca.SX]:
        """The expressions with these in place of their symbols: what is affine in them is not made twice."""
        found = ca.substitute(list(expressions), [self.felt.reactions], [self.reactions])
        return [self._put(x) if ca.depends_on(x, self.felt.amounts) else x for x in found]

    def _put(self, x: ca.SX) -> ca.SX:
        own = self.felt.amounts
        slopes = ca.jacobian(x.nz[:], own)
        if ca.depends_on(slopes, own):
            return ca.substitute(x, own, self.amounts)
        (without,) = ca.substitute([x], [own], [ca.SX.zeros(own.numel())])
        return without + ca.SX(x.sparsity(), slopes @ self.amounts)


@dataclass(frozen=True)
class Motion:
    """All in CasADi SX; n coordinates. M is None where it was not formed."""

    q: ca.SX  # (n,)
    v: ca.SX
    a: ca.SX  # symbols of the accelerations, for outputs
    t: ca.SX
    u: ca.SX
    p: ca.SX
    T: ca.SX
    V: ca.SX
    D: ca.SX
    H: ca.SX  # v . dT/dv - T + V: T + V, but for supports that move with time, and T of one's own that is not quadratic in v
    momenta: Later[ca.SX]
    inertial: Later[ca.SX]
    acceleration: ca.SX
    bodies: Bodies
    constrained: ConstrainedMotion | None
    dissipated_power: ca.SX  # taken out by dampers
    source_power: ca.SX  # put in by loads and moving supports
    way: str  # "dense", "tree", "collected", "constrained", "constrained along the tree" or "independent coordinates"
    counted: dict[str, int]  # nodes of each way, where there was a choice
    collected: Collected | None = None  # where that is the way
    impacts: Impacts = field(default_factory=Impacts)  # whose forces are among those in h
    lengths: tuple[ca.SX, ...] = ()  # x of |x| that are lengths
    turning: ca.SX | None = None  # dq/dt, (n,), where attitudes are among the coordinates
    asked: frozenset[str] = frozenset({"choice"})  # of the algebra, while the scene was put down
    felt: Felt | None = None  # where forces feel reactions
    stepped: ca.SX = field(default_factory=lambda: ca.SX(0, 1))  # of v, discrete variables: they change at events alone
    pieces: ca.SX = field(default_factory=lambda: ca.SX(0, 1))  # modes, which change at known instants alone
    unsolved: "Motion | None" = None  # the same with the amounts of `felt` for symbols, of those that are solved for
    solution: Solution | None = None  # of these, with conditions as they are

    @property
    def pace(self) -> ca.SX:
        """dq/dt, (n,)."""
        return self.v if self.turning is None else self.turning

    @property
    def momentum(self) -> ca.SX:
        """dT/dv, (n,). A large smooth tree without constraints is run without it as well."""
        return self.momenta.value

    @property
    def h(self) -> ca.SX:
        """(n,). A smooth tree without constraints is run without it: forces are kept on the bodies that they act on."""
        return self.inertial.value

    @cached_property
    def operations(self) -> frozenset[int]:
        """CasADi's, of which h is made; not looked for where nothing was asked of the algebra that bends or has roots."""
        return operations_in(self.h) if self.asked - SMOOTH else frozenset()

    @cached_property
    def nodes(self) -> dict[str, int]:
        """Nodes of each way that was tried. Counting takes as long as a good part of the compilation: only when asked."""
        return self.counted or {self.way: count_nodes([self.acceleration], [self.q, self.v, self.a, self.u])}


def build_motion(kinematics: Kinematics, energies: Energies, constraints: Constraints, for_any_mass: bool = False,
                 partition: Partition | None = None, impacts: Impacts | None = None) -> Motion:
    """`for_any_mass`: formulas that hold where parameters make M singular or uneven, too; they cost half as much again.
    `partition`: of the coordinates of closed loops, used where it saves operations. `impacts`: whose forces act as well.

    Raises LagError L0504 for a coordinate that moves no mass, L0505 for a scene without coordinates and joints.
    """
    symbols, impacts = kinematics.symbols, impacts or Impacts()
    q, v, a = (column(*s.values()) for s in (symbols.positions, symbols.rates, symbols.accelerations))
    t, tau = symbols.time, symbols.tau
    _require_coordinates(kinematics)
    energies = replace(energies, loads=energies.loads + impacts.loads) if impacts.loads else energies
    bodies = find_bodies(kinematics, energies)
    T, V, D = map(energies.total, (energies.kinetic, energies.potential, energies.dissipation))
    (momentum, dL_dt), mechanism = _slopes(kinematics, T - V, v), energies.of_mechanism()
    T, force, damping = energies.total(mechanism.kinetic), generalised_force(mechanism.loads, q, v), gradient_by_rates(D, v)
    inertial = Later(lambda: _on_time([inertial_force(kinematics, energies, bodies, q, v) + damping], kinematics)[0])
    moved = tau * ca.gradient(D, tau)  # what supports that move do to dampers
    dissipated, source = ca.dot(v, damping) + moved, ca.dot(force, v) - tau * dL_dt + moved
    is_sum = not _knows(kinematics, T) and is_quadratic(mechanism, v)
    H = T + V if is_sum else ca.dot(kept_rates(kinematics, v), momentum.value) - T + V
    short = _collected(kinematics, energies, bodies, momentum, damping, bool(constraints.rows))
    T, V, D, H, dissipated, source = _on_time([T, V, D, H, dissipated, source], kinematics)
    constrained = None
    if constraints.rows:
        if short is not None and short.is_shorter(kinematics, momentum.value, inertial.value):
            momentum, inertial = short.momentum, Later(short.whole)
        free = FreeMotion(q, v, momentum.value, inertial.value, source, pace=kinematics.turning)
        found, counted = _hold(kinematics, bodies, energies, constraints, free, for_any_mass, partition)
        acceleration, source, constrained, way = *found, found[2].way
    else:
        _require_mass(kinematics, energies.moving if not bodies.rest else frozenset(), momentum, v)
        acceleration, way, counted = _solve(kinematics, energies, bodies, momentum, inertial, v, short)
        if short is not None and way == "collected":
            momentum, inertial = short.momentum, Later(short.whole)
    p, u = _stack(kinematics, "parameter"), _stack(kinematics, "input", "delayed")
    inertia, index = short.inertia if short and way == "collected" else None, kinematics.algebra.index
    return Motion(q, v, a, t, u, p, T, V, D, H, momentum, inertial, acceleration, bodies, constrained, dissipated, source, way,
                  counted, inertia, impacts, (*index.lengths.values(),), kinematics.turning, frozenset(index.asked),
                  stepped=_stepped(kinematics), pieces=_pieces(kinematics))


def _pieces(kinematics: Kinematics) -> ca.SX:
    """All modes but the references of attitudes, which steps move along, as a column."""
    return ca.vertcat(ca.SX(0, 1), *(mode.symbol for mode in kinematics.algebra.modes if not mode.of_attitude))


def _stepped(kinematics: Kinematics) -> ca.SX:
    """The rates that are discrete variables, as a column."""
    kept = [state.coordinate for state in kinematics.graph.model.states.values() if state.is_kept]
    return ca.vertcat(ca.SX(0, 1), *(kinematics.symbols.rates[name] for name in kept))


def kept_rates(kinematics: Kinematics, v: ca.SX) -> ca.SX:
    """The rates whose energies count, (n,): 0 in the places of first-order states."""
    rates, states = kinematics.symbols.rates, kinematics.graph.model.states.values()
    signals = {rates[state.coordinate].__hash__() for state in states}
    return ca.vertcat(ca.SX(0, 1), *[0.0 if x.__hash__() in signals else x for x in v.elements()])


def _require_coordinates(kinematics: Kinematics) -> None:
    """But for models that only compute outputs: without energies and forces."""
    graph, model = kinematics.graph, kinematics.graph.model
    only_computes = any(v.is_output for v in model.variables.values()) and not model.energies and not model.works
    if not (kinematics.symbols.positions or all_reactions(graph) or only_computes):
        fail("L0505", "nothing can move: the scene has no coordinate", model.span,
             "joints (Revolute, Prismatic, ...) and bodies joined to nothing have coordinates")


def mass_matrix(motion: Motion) -> ca.SX:
    """M = d(dT/dv)/dv, n by n, kg or kg.m or kg.m2 by the coordinates."""
    return ca.jacobian(motion.momentum, motion.v)


def inertial_force(kinematics: Kinematics, energies: Energies, bodies: Bodies, q: ca.SX, v: ca.SX) -> ca.SX:
    """d/dt(dT/dv) - dT/dq + dV/dq - f at zero accelerations of the coordinates.

    For a rigid body's T the first two are sum_i (dr_i/dq)^T m a_i with the acceleration a_i that remains when dv/dt = 0: of
    the two halves of d/dt(dT/dv) and dT/dq nothing that cancels is ever built. All reverse sweeps are one.
    """
    remaining = kinematics.without_accelerations()
    positions: list[Scalar] = [energies.total(energies.potential)]
    forces: list[Scalar] = [1.0]
    rates, powers = list[Scalar](), list[Scalar]()  # of what works by its rates
    if kinematics.symbols.attitudes:
        rates, powers, positions = [rate_of_potential(kinematics, energies.potential)], [1.0], [ca.SX(0)]
    for inertia in bodies.inertias:
        moved, wrench = (rates, powers) if kinematics.geometry.by_rates else (positions, forces)
        for position, force in body_reaction(remaining, inertia):
            if not (isinstance(position, float) or isinstance(force, float)):
                moved.append(position)
                wrench.append(force)
    for load in energies.loads:
        place, is_rate = load.moving
        moved, wrench = (rates, powers) if is_rate else (positions, forces)
        moved += place
        wrench += [-force for force in load.force]
    h = ca.densify(ca.jtimes(column(*positions), q, column(*forces), True))
    if rates:
        h = h + ca.densify(ca.jtimes(column(*rates), v, column(*powers), True))
    _refuse_turned(kinematics, bodies)
    return h + _lagrange(kinematics, energies.total(bodies.rest), q, v) if bodies.rest else h


def _refuse_turned(kinematics: Kinematics, bodies: Bodies) -> None:
    """Raises LagError L0901 for kinetic energies of attitudes that are no rigid body's."""
    attitudes = kinematics.symbols.attitudes
    turned = [x for name in attitudes for part in parts_of(name)
              for x in (kinematics.symbols.positions[part], kinematics.symbols.rates[part])]
    for term in bodies.rest if turned else ():
        if ca.depends_on(as_expression(term.value), ca.vertcat(*turned)):
            fail("L0901", "not supported yet: a kinetic energy that attitudes change, and that is of no rigid body",
                 term.statement.span, "state it by hinges, or of a body: m*dot(f.v, f.v)/2, dot(f.omega, I*f.omega)/2")


def body_reaction(kinematics: Kinematics, inertia: Inertia) -> list[tuple[Scalar, Scalar]]:
    """The place of a body's frame and the wrench its inertia asks for, number by number."""
    place = kinematics.pose(inertia.frame, 0)
    return inertial_reaction(inertia, place, kinematics.pose(inertia.frame, 2), kinematics.geometry)


def _lagrange(kinematics: Kinematics, T: ca.SX, q: ca.SX, v: ca.SX) -> ca.SX:
    """d/dt(dT/dv) - dT/dq at zero accelerations, by one reverse sweep and one forward sweep along v."""
    t, tau = kinematics.symbols.time, kinematics.symbols.tau
    slopes = ca.densify(ca.gradient(T, ca.vertcat(v, q)))
    n = q.numel()
    return ca.jtimes(slopes[:n], ca.vertcat(q, t), ca.vertcat(v, tau)) - slopes[n:]


def _slopes(kinematics: Kinematics, lagrangian: ca.SX, v: ca.SX) -> tuple[Later[ca.SX], ca.SX]:
    """dL/dv, where the rate of time is 1, and dL/dt."""
    t = kinematics.symbols.time
    if not kinematics.is_timed:
        return Later(lambda: ca.densify(ca.gradient(lagrangian, v))), ca.SX(0)
    slopes = ca.densify(ca.gradient(lagrangian, ca.vertcat(v, t)))
    (momentum,) = _on_time([slopes[:-1, 0]], kinematics)
    return Later(lambda: momentum), slopes[-1]


def _stack(kinematics: Kinematics, *kinds: str) -> ca.SX:
    """Of one kind after the other."""
    variables = kinematics.graph.model.variables
    names = [name for kind in kinds for name, variable in variables.items() if variable.kind == kind]
    return column(*[x for name in names for x in scalars_of(kinematics.symbols.values[name])])


def _require_mass(kinematics: Kinematics, of_bodies: frozenset[int], momentum: Later[ca.SX], v: ca.SX) -> None:
    """A coordinate whose momentum does not depend on any rate moves no mass, whatever the numbers. `of_bodies`: hashes of the
    symbols in T, where that is of rigid bodies alone, squares of what rates make: known before the momenta are."""
    if not momentum.is_known and all(rate.__hash__() in of_bodies for rate in kinematics.symbols.rates.values()):
        return
    massless = [k for k, moves in enumerate(ca.which_depends(momentum.value, v, 1, True)) if not moves]
    if massless:
        refuse_loose(kinematics, [kinematics.graph.coordinates[k] for k in massless])


@dataclass(frozen=True)
class _Short:
    """The collected inertia and what is left beside it: M and h anew."""

    inertia: Collected
    rest: ca.SX
    momentum: Later[ca.SX]

    def whole(self) -> ca.SX:
        """h."""
        return self.inertia.generalised() + self.rest

    def is_shorter(self, kinematics: Kinematics, momentum: ca.SX, h: ca.SX) -> bool:
        rates = ca.vertcat(*kinematics.symbols.rates.values())
        own, other = ([ca.jacobian(p, rates), force] for p, force in ((self.momentum.value, self.whole()), (momentum, h)))
        return _work(own, kinematics) < _work(other, kinematics)


def _collected(kinematics: Kinematics, energies: Energies, bodies: Bodies, slopes: Later[ca.SX], damping: ca.SX,
               is_held: bool) -> _Short | None:
    """None for scenes with too many coordinates."""
    symbols = kinematics.symbols
    q, v = (column(*values.values()) for values in (symbols.positions, symbols.rates))
    most = _MOST_HELD if is_held else _MOST_FREE
    if symbols.attitudes or not 0 < v.numel() <= most:
        return None
    momentum = slopes.value
    if ca.jacobian_sparsity(momentum, v[0]).nnz() > MOST_COORDINATES:
        return None  # a chain's whole pattern has as many entries as there are pairs of links
    largest = max(map(len, blocks_of(ca.jacobian_sparsity(momentum, v))), default=0)
    if largest > MOST_COORDINATES or (v.numel() > MOST_COORDINATES and not ca.depends_on(momentum, q)):
        return None
    weights, springs = split_weights(kinematics, energies.potential)
    inner = inertial_force(kinematics, replace(energies, potential=weights, loads=()), bodies, q, v)
    outer = inertial_force(kinematics, replace(energies, potential=springs), replace(bodies, inertias=(), rest=()), q, v)
    resting = ca.substitute(momentum, v, ca.SX.zeros(v.numel()))
    inner, rest, resting = _on_time([inner, outer + damping, resting], kinematics)
    inertia = collect(kinematics, ca.jacobian(momentum, v), inner, is_held)
    return _Short(inertia, rest, Later(lambda: inertia.momentum(v) + resting)) if inertia is not None else None


def _work(expressions: list[ca.SX], kinematics: Kinematics) -> int:
    return count_nodes(expressions, [kinematics.algebra.state])


def _solve(kinematics: Kinematics, energies: Energies, bodies: Bodies, momentum: Later[ca.SX], inertial: Later[ca.SX],
           v: ca.SX, short: _Short | None) -> tuple[ca.SX, str, dict[str, int]]:
    """The accelerations by the way that counts fewest nodes, and what each way that is open counts."""
    ways: dict[str, ca.SX] = {}
    tree = articulate(kinematics, bodies)
    if tree is not None:
        ways["tree"] = _along(tree, energies, inertial)
    if tree is None or coupled_pairs(kinematics) <= _DENSEST * v.numel():
        ways["dense"] = solve_dense(momentum.value, -inertial.value, v)
    if short is not None:
        ways["collected"] = short.inertia.accelerations(short.rest)
    if len(ways) == 1:
        (way,) = ways
        return ways[way], way, {}
    nodes = {way: _work([a], kinematics) for way, a in ways.items()}
    best = min(nodes, key=lambda way: nodes[way])
    nearly = _NEARLY if v.numel() <= MOST_COORDINATES else 1.0
    if (short is not None and nodes["collected"] <= nearly * nodes[best]
            and short.is_shorter(kinematics, momentum.value, inertial.value)):
        best = "collected"
    return ways[best], best, nodes


def _hold(kinematics: Kinematics, bodies: Bodies, energies: Energies, constraints: Constraints, free: FreeMotion,
          for_any_mass: bool, partition: Partition | None) -> tuple[Held, dict[str, int]]:
    """The constrained motion by the way that counts fewest nodes, and what each way that was tried counts."""
    rows = constraint_rows(kinematics, constraints)
    M, J = (ca.jacobian_sparsity(x, free.v) for x in (free.momentum, rows.rate))
    is_preferred = prefers(M, J, kinematics.geometry.by_rates or kinematics.graph.has_inner_loops)
    tree = articulate(kinematics, bodies) if is_preferred is not False and not for_any_mass else None
    along = None
    if tree is not None:
        alone = _along(tree, energies, Later(lambda: free.h))
        forces, acting = forces_of_loops(kinematics, constraints.rows), _granted(tree, energies)
        balls = _balls(kinematics, tree, partition.points, acting) if partition is not None and acting is not None else ()
        own = FreeTree(tree, alone, forces, range(tree.size), acting, balls)
        along = own if is_even(kinematics, own.balance) else None
    found = [constrain(kinematics, rows, replace(free, tree=along), for_any_mass)]
    if is_preferred is None and found[0][2].tree is not None:
        found.append(constrain(kinematics, rows, free, for_any_mass))
    nodes: dict[str, int] = {}
    best = _shortest(found, kinematics, nodes)
    short = bring_down(best[2], replace(free, tree=along), partition) if partition is not None else None
    return _shortest([best, (*best[:2], short)], kinematics, nodes) if short is not None else best, nodes


def _shortest(found: Sequence[Held], kinematics: Kinematics, nodes: dict[str, int]) -> Held:
    """Of several, with what each counts, which comes to `nodes`."""
    if len(found) == 1:
        return found[0]
    nodes |= {held.way: _work([held.regular.acceleration if held.regular else acceleration], kinematics)
              for acceleration, _, held in found if held.way not in nodes}
    return min(found, key=lambda held: nodes[held[2].way] / (1 if held[2].way == "constrained" else _CLEARLY))


def _along(tree: Tree, energies: Energies, inertial: Later[ca.SX]) -> ca.SX:
    """The accelerations of the tree itself."""
    found = tree.accelerate(energies)
    if found is None:
        found = tree.solve(-inertial.value)
    return _on_time([found], tree.kinematics)[0]


def _granted(tree: Tree, energies: Energies) -> Granted | None:
    """What acts on its bodies, by wrenches."""
    found = tree.granted(energies)
    if found is None or not _knows(tree.kinematics, column(*found.r, *(x for load in found.loads.values() for x in load))):
        return found

    def on_time(numbers: Sequence[Scalar]) -> list[Scalar]:
        return [as_expression(x) for x in _on_time([*map(ca.SX, numbers)], tree.kinematics)]

    return Granted({k: on_time(load) for k, load in found.loads.items()}, on_time(found.r))


def _balls(kinematics: Kinematics, tree: Tree, points: Sequence[HeldPoints], acting: Granted) -> Sequence[Ball]:
    """Points held together in space; none where supports move."""
    if not points or kinematics.is_timed:
        return ()
    from lagrangia.dynamics.ball_joints import ball_at
    from lagrangia.dynamics.spatial_tree import SpatialBodies

    assert isinstance(tree, SpatialBodies)
    return [ball for x in points if (ball := ball_at(kinematics, tree, x, acting)) is not None]


def _on_time(expressions: list[ca.SX], kinematics: Kinematics) -> list[ca.SX]:
    """Where the rate of time is 1. Most scenes do not know it: to put it in would make all their nodes anew."""
    found = [ca.SX(x) for x in expressions]  # some are numbers
    knows = _knows(kinematics, ca.veccat(*found))
    return list(ca.substitute(found, [kinematics.symbols.tau], [ca.SX(1)])) if knows else found


def _knows(kinematics: Kinematics, expression: ca.SX) -> bool:
    """Whether the rate of time stands in it."""
    return kinematics.is_timed and bool(ca.depends_on(expression, kinematics.symbols.tau))


def is_quadratic(energies: Energies, v: ca.SX, but_for_rest: bool = False) -> bool:
    """Whether kinetic energies of one's own are quadratic in the rates, perhaps but for what they are at rest: a hoop that turns
    evenly may be a constant in one."""
    own = energies.total(tuple(term for term in energies.kinetic if not term.statement.is_of_library))
    if own.is_constant():
        return True
    M, momentum = ca.hessian(own, v)
    left = ca.substitute(momentum if but_for_rest else ca.vertcat(own, momentum), v, ca.SX.zeros(v.numel()))
    return not ca.depends_on(M, v) and ca.densify(left).is_zero()


def coupled_pairs(kinematics: Kinematics) -> int:
    """Entries that the mass matrix of a tree may have: coordinates on one way to the root are coupled."""
    above = {root.frame: len(root.attributes) for root in kinematics.graph.roots}
    count = sum(n * n for n in above.values())
    for edge in kinematics.graph.edges:
        own = len(edge.coordinates)
        count += own * (2 * above[edge.parent] + own)
        above[edge.child] = above[edge.parent] + own
    return count


def solve_dense(momentum: ca.SX, r: ca.SX, v: ca.SX) -> ca.SX:
    """Sparse M = L D L^T, ordered by minimum degree. M is positive definite for trees, so no pivoting is needed."""
    M = ca.jacobian(momentum, v)
    diagonal, upper, order = ca.ldl(M, True)
    return ca.ldl_solve(r, diagonal, upper, order)


def solve_mass(kinematics: Kinematics, motion: Motion, r: ca.SX) -> ca.SX:
    """The solution (n,) of M x = r, the way the accelerations are solved for. Only for scenes without constraints."""
    if motion.collected is not None:
        return motion.collected.solve(r)
    tree = articulate(kinematics, motion.bodies) if motion.way == "tree" else None
    if tree is None:
        return solve_dense(motion.momentum, r, motion.v)
    return _on_time([tree.solve(r)], kinematics)[0]


def count_nodes(expressions: list[ca.SX], arguments: list[ca.SX]) -> int:
    """Operations that depend on the arguments, common subexpressions counted once."""
    rest = ca.symvar(ca.veccat(*expressions, *arguments))
    moving = ca.SX(ca.vertcat(*arguments))
    movers = symbols_in(moving)
    fixed = [s for s in rest if s.__hash__() not in movers]
    shared = ca.cse(ca.veccat(*expressions))
    reduced = ca.extract_parametric(shared, ca.vertcat(*fixed), {"extract_trivial": True})[0] if fixed else shared
    function = ca.Function("count", [moving], [reduced], {"allow_free": True})
    kinds = (ca.OP_INPUT, ca.OP_OUTPUT, ca.OP_CONST, ca.OP_PARAMETER)
    return sum(1 for k in range(function.n_instructions()) if function.instruction_id(k) not in kinds)


__all__ = ["Motion", "Span", "build_motion", "count_nodes", "inertial_force", "mass_matrix"]
