"""Longer texts, shown by `lag help TOPIC`."""

from collections.abc import Callable, Mapping

from lagrangia.base.diagnostics import fail, suggest
from lagrangia.command.assertions_topic import ASSERTIONS
from lagrangia.command.attitudes_topic import ATTITUDES
from lagrangia.command.curves_topic import curves_topic
from lagrangia.command.drawing_topic import drawing_topic
from lagrangia.command.editor_topic import EDITOR
from lagrangia.command.errors_topic import ERRORS, warnings_topic
from lagrangia.command.fmu_topic import FMU
from lagrangia.command.library_topic import DRIVES, library_topic, reference_topic
from lagrangia.command.signals_topic import SIGNALS
from lagrangia.command.space_topic import space_topic
from lagrangia.command.tables_topic import TABLES

_LANGUAGE = """\
A file holds models. A model declares parameters, components and coordinates, joins frames by equations, and states energies:

    model Swing "Pendulum with a damper in its hinge"
      parameter Mass m = 2;
      parameter Length L = 1.5[m];
      Revolute hinge(a = world, phi(start = 30[deg]));
      Bar bar(m = m, L = L, a = hinge.b);
      TorsionDamper friction(a = world, b = bar.center, c = 0.1);
      output Length height = bar.b.y;
      annotation(experiment(StopTime = 10, Tolerance = 1e-8));
    end Swing;

Frame f                    a place with an angle: f.r (position), f.x, f.y, f.phi, f.v (velocity), f.w (rate), in world axes
coordinate Angle phi       a generalised coordinate, its rate der(phi). phi(start = 1) is a guess, w(start = 2) one of its rate;
                           with fixed = true they hold exactly. Other values follow: see also `lag check`
b = turn(a, phi)           frame equations: b is a turned about its origin, b = shift(a, {x, y}) moved in a's axes; a = b is one;
                           connect(a, b) is a = b. Each may be used in both directions: nobody chooses loop cuts.
kinetic, potential         terms of T and V in J;  dissipation: of D in W (the integral of force over rate: c*v^2/2);
work F on r                a term of the virtual work: F in N on a position, N.m on an angle
expression = expression    between positions: a constraint. Linear ones (rolling, gears, prescribed motion) remove a coordinate;
                           the others, and closed loops of joints, are kept exactly. Linear in der(...): nonholonomic.
when x < 0 then            an event, where the condition comes true: the rate of any position or angle x gets the value,
  reinit(der(x), value);   by an impulse that works on x: what else jumps follows from masses, joints and loops; see also
end when;                  `lag help events`
hinge.reaction             in outputs and forces: force (2), in world axes, of a joint or a tie (Gear, Belt, Link, Rope) on its
                           port b, the center of a Block, or its last frame; hinge.reaction_torque: about its origin. What acts
                           on a joint's coordinate (stretch = guide.s, a Rack, a Motion, equations of coordinates) acts through
                           the joint, and counts as its reaction: the torque of a drive is hinge.reaction_torque
der(z) = expression        a first-order state, declared as Real z(start = 0): lag help signals
initial equation           where it begins: hinge.phi = 1; or hinge.w = 2; or an equation to be solved, bar.b.y = 0.3; or
                           equilibrium(); at rest under the loads, nearest to the guesses, in each run anew (dry friction aside)
parameter, constant        numbers that a run may change without compiling, and those it may not; Integer and Boolean parameters
                           are structural: they may decide what the scene consists of, and are compiled in
annotation(Evaluate = true)  behind a parameter: where it is 0, 1 or -1, or a direction in space, its numbers are compiled in, and
                           what they make 0 falls away. It can be given all the same: another value has it compiled once more
input, output              given from outside (-u), and reported
model M extends B(k = 2)   inheritance with modifications; M m[n](each k = 1, c = {1, 2, 3}) arrays; if conditions on components
equation for i in 1:n-1 loop connect(link[i].b, link[i+1].a); end for;

A literal may carry a unit: 30[deg], 1.5[kN/m]. A bare number takes the unit of its place. Dimensions are checked.
Gravity is {0, -9.81} unless the scene declares World world(gravity = {0, 0}). A body that is joined to nothing floats with
coordinates of its own, named after its frame: bar.center.x, bar.center.y, bar.center.phi. Ground is always written: a = world.
See also: lag help reference (all constructs, packages, records, matrices), library, functions, events, assertions, signals,
tables, units.
"""

_EVENTS = """\
    when ball.center.y < 0 then
      reinit(ball.center.v[2], -0.8*pre(ball.center.v[2]));
    end when;

The event comes at the moment at which the condition becomes true, found in the dense output of the steps. Conditions compare
with <, <=, > or >= (positions, velocities, time), whole numbers also with == and <> (n == 3, floor(x) == 1, b == true), and go
together with and, or, not. Where events set what is compared to the very level, n >= 1 comes at n = 1, and n > 1 does not. One
that is true at the start, as time >= 0, does not come before it has been false (`lag simulate` says so); time > 0 comes at once.

reinit(rate, value)   the rate is that of anything that the motion decides: der(x) of a position, a distance or an angle,
                      frame.v[1], frame.w, of sums and multiples of these (b.w - a.w), or a variable bound to one; value may
                      read pre(rate), all as before the event. It is reached by impulses L on what is reset,
                      M dv = sum_j (dx_j/dq)^T L_j: constraints, joints and other coordinates answer. Several in one `when`,
                      or of events at the same moment, are found together.
Discrete variables    n = value, of a variable of its own, declared as discrete Real, Integer or Boolean, which keeps it until the
                      next event: n = pre(n) + 1; last = time; on = not pre(on). pre(n) is n before the event; n, of another
                      variable, what it is from there on: events and samples of one instant come in the order of what they read,
                      and those that read each other's values in a circle are told. Integer n(start = 0) begins at 0, or where
                      `when initial()` says; Integer n[3](each start = 0) are three. Forces, outputs and conditions of others may
                      read them; places and energies may not. Columns of results show what is true as 1, what is not as 0.
Rows                  at the instant of an event show what is before it, the last one too, and so do Co-Simulation FMUs at the
                      end of a step: at t = 0.5, sample(0, 0.1) has given 5 values, `when time >= 0.5` comes with the next step.
                      Modelica tools write both; let a run end a little later to see what comes at its end.
when {a, b} then      where one of them comes true, while others are, too; when edge(b) is when b, when change(b) when {b, not b},
                      when change(n) where a discrete variable n gets another value; pre(n) is the value before, there, too
Contacts              where the rate of the condition itself is turned back or stopped, as der(gap) by -e*pre(der(gap)) when
                      gap < 0; or seen from what it meets, a wall that time moves or a body, as b.v by x.v - e*(b.v - x.v) when
                      b.s < x.s; or the rates of both by an impulse between them; in all branches of what is set, else each
                      event sets what is written (L0224). They push and never pull, one impact brings about the next (Newton's
                      cradle), and bounces too small to be told from none come to rest: a force that only pushes holds them,
                      until the motion leaves. Stop and TorsionStop of the library are contacts of any
                      distance or angle; stop.reaction is the force that holds what rests at its ports, between impacts and
                      without friction, and stop.force its size. Impacts of several contacts at once have no one answer in rigid
                      bodies: here those that approach are struck together, then those that approach after that.
contact_force(x)      the force that holds x at the contact of `when x < 0 then reinit(der(x), ...)`; a torque where x is an
                      angle; or that carries along what goes one way, `when der(x) < 0 then reinit(der(x), 0)`. Of contacts
                      forces and dissipation functions may depend on it, as friction does that presses with it:
                      mu*contact_force(x)*abs(slip). RoughStop is such a Stop; Friction(normal = stop.force) rubs
                      anywhere. It sticks, slips and is torn off as other dry friction; in impacts it takes mu times the impulse
                      against the slip that is left, or what leaves none; restitution is less than e where friction
                      would give energy with it. Contacts and friction are one problem, at rest and in impacts: of its
                      solutions those come first that hold. Where friction presses what slides further and no
                      force holds it (Painleve's rod; a chalk that jumps), the slip is stopped by an impulse, without a collision,
                      which is told; a run that finds no impulse either ends with a word.
Forces                conditions may ask for reactions, constraint_force(x) and contact_force(x): when norm(hinge.reaction) > 25
                      then torn = true; end when. Impulses are no forces; what events set cannot ask for forces. A contact that
                      its own force ends is `broken` for good, a discrete variable of its component: when slack < 0 and
                      contact_force(slack) < most then ... For other ends write the event that remembers, and: and not torn
Friction in joints    forces and dissipation functions may feel reactions: mu*radius*norm(hinge.reaction)*abs(hinge.w). Both
                      are solved for together, in loops as well, and stick exactly. RoughRevolute, RoughPrismatic, RoughWheel,
                      RoughGear, Capstan are such; RoughBelt slips; Friction(normal = abs(guide.reaction[2])) rubs anywhere.
                      Where friction presses by its own reaction more than it takes (a light slider that a long rod pushes
                      down, with a large mu) there is no solution, or several (Painleve): the run ends with a word. Events
                      may set rates where rubbing impulses change none (all that moves is set, or the joint's own
                      rate); not yet: other events, contacts that load such joints, and lag equilibrium, modes and equations.
Rates that rest       for others are at their level, `if b.v > 0` is false; friction's F, -F or a copy (2*sign(b.v)) is what holds
when gap < 0 and x < edge then ...    a contact with an edge. With `or` nothing is held that rests.

Energy that impulses take is dissipated, what they add is work. FMUs have the events, in both kinds and versions; exports to
other languages, the solvers linear, conservative and islands, and CasADi's integrators refuse them, as they have none.
Positions of rest and small motion (lag equilibrium, modes, linearize, response) know what rests at contacts: lag help analysis.
In model.functions() contact forces are 0.
"""

_FUNCTIONS = """\
sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh exp log log10 sqrt abs sign floor ceil mod min max
der(x)              the rate of anything along the motion; der(der(x)) in outputs is its acceleration
dot(a, b) cross(a, b) norm(a) rotate(vector, angle)      of vectors of two components
distance(a, b)      between two frames or points
sum(e for i in 1:n), product(...), {e for i in 1:n}      over a range
table(x, {x1, x2, ...}, {y1, y2, ...})                   straight lines between points, held beyond the ends
table(time, "road.csv", column = "z")                    a column of a file over its first one: lag help tables
step(x) pulse(t, start, width) pulse_train(t, start, width, period) ramp(t, start, duration)
if c then a else b  in a formula; a condition on time alone, linear in it or in mod and floor of it, is met exactly: the
                    integrator stops there. Where another one in a force changes (a contact, a point of a table along a
                    coordinate, max, min, abs, sign), a step is found to have gone too far, and the run goes back. A force
                    that jumps with a velocity (dry friction: sign(v), or if v > 0) may hold the motion there: it sticks, by
                    that share of the jump which keeps the velocity, until that is not enough.
                    Friction that turns with a velocity in the plane, F*v/norm(v), is met as well: both components are held
                    while what else acts is less than F. SlidingFriction is that, with a force that presses or a static one
time, pi
contact_force(x)    what holds x at a contact: lag help events
constraint_force(x) the force along x, or torque, of the equation that has x on one side: motor.reaction of a Motion is such a
                    one; its power is that times der(x). Of equations between positions or angles, in outputs
virtual(x)          zero, but with the virtual displacement of x: says in an equation where its force acts (see Gear)

Functions of your own:

    function soft "force of a softening spring"
      input Length s; input Stiffness k;
      output Force F;
    algorithm
      F := k*s/(1 + (s/0.1[m])^2);
    end soft;

They take and give arrays and records, have several results, (a, b) = f(x), loops and branches: lag help reference.
"""

_UNITS = """\
SI units inside. A literal may carry a unit in brackets: 30[deg], 1.5[kN/m], 20[mm], 3[rpm], 2[kg.m2], 5[N.m/rad], 90[km/h].
Products with '.', one '/', powers as digits: kg.m2/s2, N.s/(m.rad). The SI prefixes from q (1e-30) to Y (1e24) go before
m g s A K mol cd N J W Pa Hz rad t L bar eV C V Ohm F H Wb T. Besides them: deg rev % rpm min h d lb lbf inch ft degC.

Quantity types (Mass, Length, Angle, Stiffness, ...) are in the library; Real x(unit = "N/m3") makes one on the spot.
A bare number takes the unit of its place: in sin(3*time) the 3 is in 1/s; an integer divisor, as in m*L^2/12, is a pure number.
Adding metres to seconds is an error. The radian counts as 1.
"""

_SOLVER = """\
erk     explicit Runge-Kutta of order 8(5,3) by Dormand and Prince with dense output of order 7 (Hairer, Norsett, Wanner, Solving
        Ordinary Differential Equations I, II.10), in C. The error of each step is held below the tolerance times the size of each
        coordinate and of each rate; angles count as at most pi. Steps, pulses and corners of tables in time are met exactly,
        also where a pattern comes again by mod(time, T); contacts, and corners of tables along a coordinate, to rounding of the
        dense output: a step holds what conditions say at its beginning, and ends where one of them changes (implicit steps are
        taken again until they end there, as springs make much of errors in between).
erk5    explicit Runge-Kutta of order 5(4) by Tsitouras with dense output of order 4 (Computers & Mathematics with Applications,
        2011): half as many evaluations a step. auto takes it where pirk and taylor do not serve, instead of erk, at loose
        tolerances: above 5e-6 where there are constraints, above 5e-5 where equations are long (over 40 operations a coordinate),
        above 5e-3 elsewhere.
erk9    explicit Runge-Kutta of order 9(8) by Verner (Numerical Algorithms 53, 2010): 16 evaluations a step and up to a quarter
        fewer in all, but no dense output: its steps end at rows. auto takes it in closed loops at tolerances from 2e-4 to 1.5e-2,
        where rows lie some steps apart, unless something depends on conditions of the state.
pirk    Gauss collocation of order 16 whose eight stages are found by iteration (parallel iterated Runge-Kutta methods: van der
        Houwen, Sommeijer, J. Comput. Appl. Math. 29, 1990). A sweep evaluates all eight at once, in registers of up to eight
        numbers or on the tape, for the time of one to three evaluations; a step takes some six sweeps and is three to six times
        as long as one of erk. Same digits whatever the registers. Rows inside a step ask for two to four sweeps more, however
        many they are. auto takes it at tolerances up to 2e-3, in closed loops 2e-4 (of more than 75 operations a coordinate
        1.5e-2), where no conditions on the state, corners or exponentials of what changes ask for closer looks, up to a hundred
        rows a step; from series it takes over where poles of the motion in complex time keep their steps short, not vibration.
        Where sweeps hardly come nearer (stiffness) or a loop comes near a singular position, auto goes on with the others.
adams   Adams' methods of order 1 to 13 in variable steps (Shampine, Gordon, Computer Solution of Ordinary Differential Equations,
        1975; integrated twice for positions, Krogh 1974): one evaluation a step, half as many to an error as erk, rows for next
        to nothing, and more work beside each evaluation. After an event they begin anew at order 1, behind a step of erk, which
        also goes on where they cannot. auto takes them instead of pirk where equations are long (chains of 15 links and more)
        and rows many, without closed loops (where several fold flat at once, only longer steps lead across), events, conditions
        on the state and inputs.
linear  exact, for scenes whose equations are M a + C v + K q = b(t): constant M, C, K and loads that are made of constants,
        polynomials, sines, cosines and exponentials of time and products of these, in pieces between time events, or inputs
        that are linear between the rows of their table. By the matrix exponential, computed in double-double arithmetic: at any
        stiffness, horizon and distance between rows; the tolerance does not matter. `lag explain` says why a scene is not linear.
        auto takes it where it costs less than steps do: many radians of the fastest motion in the time from start to stop. Scenes
        of few states (at most 12, loads among them) it runs by exponentials in doubles, as long as these have the digits that the
        tolerance asks for.
implicit  Radau IIA with 3, 5 or 7 stages, order 5, 9 or 13 (Hairer, Wanner, Solving Ordinary Differential Equations II, IV.8), in
        C, for stiff scenes: springs and dampers far faster than the motion. Exact sparse Jacobians; the number of stages and the
        length of steps follow Newton's iterations and the error; what is stiff is damped, not resolved.
islands  coordinates that do not interact are run apart, each group by the solver and the steps that suit it; up to 8 groups of at
        most 200 coordinates, each with its constraints. auto takes it where some are at least four times as fast as others.
auto    islands or linear where they pay; else pirk, taylor, adams, or erk, erk5, erk9, and from there over to implicit where
        stability and not accuracy keeps steps short, if that gets on faster for the same work, and back. What has one degree of
        freedom and keeps its energy is stepped from one moment of rest to the next, and read from these steps from then on: it
        swings back the way it came. The summary says what was used, and by which rule, with its numbers, as `lag explain` does
        before a run: "pirk: smooth, 252 operations a call, the tolerance 1e-08 at most 0.002". All rules are rows of one table,
        with their limits and what these were measured on: runtime/choice/choice.c.
taylor  Taylor series of the motion about the beginning of each step, of an order that follows from the tolerance (Jorba, Zou,
        Exp. Math. 14, 2005), for small scenes of smooth functions: C written for the scene computes the coefficients. Steps are
        long and rows inside them cost next to nothing. auto takes it instead of erk where it is cheaper, most of all at small
        tolerances, but where exponentials of what moves (exp, tanh) may be too faint for a series to tell of them.
conservative  symplectic steps of equal length: the energy error of a scene that keeps its energy stays bounded, however long.
        Where M is constant, explicit splitting of order 6 (Blanes, Moan, J. Comput. Appl. Math. 142, 2002), whose energy error
        is the tolerance; else Gauss collocation of order 6 to 16 in coordinates and momenta (Hairer, Lubich, Wanner, Geometric
        Numerical Integration, II.1, VI.4). The length of steps is chosen in a trial at the start, so motions that are quick at
        times (close encounters) are not for it; in chaotic motion the energy error creeps. auto never takes it: it promises
        positions, and these steps keep the energy.
casadi:cvodes, casadi:idas    integrators of SUNDIALS through CasADi: an independent check.

Closed loops and constraints: accelerations and multipliers from one sparse linear system, written out and factored without
pivoting (kkt.py), or from J M^-1 J^T of the multipliers with M along the tree of bodies (schur.py) where that counts clearly
fewer: a bar of a long rope hung at both ends costs as much as a link of a chain and three quarters of it more. Linkages that
are put together of pairs of links (four-bars, slider cranks, most machines) are solved in independent coordinates without
multipliers (partition.py, null_space.py) for half to four fifths of the operations and with smaller rounding; which
coordinates, `lag explain` tells. Where these are at a dead point, the linear system takes over. At rows,
and after steps as they drift, the positions, then the velocities are projected back, so that the residual stays at rounding
level. Redundant constraints, massless links and singular positions are part of the game. `lag check` tells degrees of freedom,
loops and what is redundant. A place without mass between springs, dampers, gears and loads is where their forces are in balance:
given by others where that is linear, else one more constraint, between positions or, with linear dampers, between rates
(massless.py); PointMass knot(final m = 0) makes one in the plane. A mass is none where its value is 0, whatever it is bound to
and however it is given (-p m=0 compiles the scene once more; in sweeps, where it is 0 in all runs; in FMUs, and on pages of lag
play, where sliders could change it, where it is final).
--reactions reports the force and torque of every joint and tie, by Lagrange's equations of released directions
(released_directions.py), and of a Motion what it takes: motor.reaction, a force along what it prescribes, or a torque.
So near a dead point that rounding decides a force, it is written as NaN, and the run ends with exit code 1.
Where constraints are redundant, what joints carry is not unique: what is told is one way of it, or, with --least-squares 1[m]
(model.sharing_reactions(1.0) in Python), those reactions whose squares add up to least, of all joints, ties and equations,
forces in N, torques in N.m over that length (shared_reactions.py); FMUs, sweeps, equilibria and friction have them too. Masses
given with -p that are far apart or zero in a loop are noticed; the run then takes formulas that bear them (half as long again,
compiled once).
A scene that cannot move is statics: its reactions are told without being asked for.

Every run keeps the energy account: T + V + dissipated - work of sources - what it began with is zero, but for errors; the
largest residual is printed. Where it exceeds a hundred tolerances, errors have added up, which the summary says (`warnings` of a
trajectory): those of the motion, or of the account itself where powers of dampers and loads are integrated, whose errors limit no
steps. Where it is a tenth of all energy, the motion itself is in doubt; and where there are no powers, or energy rose a
hundredfold what they gave in all, what was computed is another motion, and the exit code is 1.
Supports may move with rates that jump (ramps, tables): momentum then stays as it is, but for what holds the scene; a support
whose place jumps (step) takes along what is told in its frame, and dampers that are linear in rates give an impulse, c times
its way: the limit of ever steeper ramps. A tolerance below 1e-14 is raised to it, and steps that missed
theirs are counted. A result file holds finite numbers alone: where an output has none (the square root of what became negative),
its cell is empty, with a warning; NumPy arrays have nan there.
A scene starts on a tape of instructions; where it runs so long that it pays, it is compiled to native code meanwhile, with the
same digits; --stats says which, and what it took. Compiled scenes are kept in a cache folder ($LAGRANGIA_CACHE, or the system's
place for caches).

The run time comes with the package; without a C compiler scenes run on tapes.

Environment: LAGRANGIA_CACHE, LAGRANGIA_CC (a C compiler's command, or none), CC, NO_COLOR, LAGRANGIA_TRACEBACK=1; at install
LAGRANGIA_KINDS=all, for a run time with all widths of registers, and LAGRANGIA_CC=none, for none at all, where there is no C
compiler and pip finds no ziglang: smooth open scenes then run by CasADi; what needs the run time says so (closed loops, events,
dry friction, cubic tables, sweeps).
"""

_BENCH = """\
lag bench FILE integrates the scene with every solver at every tolerance and prints the time it took and the error it had.

time     processor time of the integration alone: compiled, warm, from the assembled start; the median of --repeat runs
error    of the coordinates, at --points output times: the largest, relative to the largest of the coordinates of its unit
         (at least 1e-3 m or rad), against a reference by a method that is not among the solvers: extrapolation of order 20 in
         extended precision, whose own error is estimated and printed
ours     every solver of --solver in lag simulate that can run the scene, on the same native code
casadi:  erk (5(4)) and rosenbrock, the whole integration written out as C and compiled; cvodes (BDF), adams (CVODES' other
         methods) and idas with compiled equations
scipy:   DOP853, Radau, LSODA with compiled equations and Jacobian, called through pointers
heyoka   Taylor series of an order that follows from the tolerance; our equations become its expressions

Every solver integrates the same accelerations, with parameters and inputs as numbers; where sources jump or bend in time it
starts anew. Nobody but us keeps closed loops closed: their errors show it. A solver whose package is missing is skipped:
pip install "lagrangia[bench]" brings all. The last table compares the fastest of ours with the fastest other at each error.
"""

_SWEEP = """\
lag sweep scene.lag -p k1=100:2000:50 -p m=1,2,5 --initial hinge.phi=10[deg],20[deg] --outputs "max(y), first_time(y > 3)"

runs all combinations of the values, the last one changing fastest, on all cores, and compiles once. Values:
1,2,5                      a list; vectors too: world.gravity={0,-9.81},{0,-1.62}
100:2000:50                from:to:step;  linspace(0, 1, 11) and geomspace(1, 1e6, 7) give a number of values
normal(mean, deviation)    random, with --samples N and --seed; also uniform(low, high), triangular(low, mode, high),
                           lognormal(median, deviation of the logarithm), loguniform(low, high)
--sampling lhs             a Latin hypercube; saltelli: N (values + 2) runs, from which Sobol' indices say what matters (SciPy)
--until CONDITION          ends random runs once a standard error is small enough: se(mean(max(y))) < 1[mm], se(deviation(y))
                           < 0.1, se(quantile(max(y), 0.95)) < 0.01; looked at after 100, 150, 225, ... runs, the same each time
--plot FILE                measures over what is varied, histograms, Sobol' indices, parallel coordinates (.png, .svg, .pdf)
--runs FILE.csv            a line of names (parameters, starts, inputs that are held) and one for each run; --together takes lists
                           side by side
Together they nest: each line of --runs with each value of each list, each of these with each sample. Numbers may carry units.

Measures of a quantity y (a coordinate, der(coordinate), an output, a place such as bar.b.y, energy.kinetic, energy.potential,
energy.dissipated, or abs(...) of one):
final(y) initial(y) at(0.5, y)                at the end (also y alone), the start, a time
min(y) max(y) range(y) time_of_min(y) time_of_max(y)
mean(y) rms(y) integral(y)                    over the time of the run
first_time(y > 3) last_time(abs(y) <= 0.01)   empty when there is no such time; >= and <= hold at the level, too
count(y > 1) duration(y > 1)                  how often, and for how long, it is so
period(y) period(y > 1)                       the mean time from one rise through its mean, or the level, to the next
settling_time(y, 0.02) overshoot(y)           of the way from its start to its end: within 2 % (the default), and beyond it
peak_frequency(y) peak_amplitude(y)           of the strongest vibration, Hz and as y: by Hann's window, between its lines, too
damage(y, 5) damage(y, 5, 100[N])             the sum of (range/size)^slope over rainflow cycles (ASTM E1049), open ones half
Each but the first row over a window of time: max(y, from=2, to=5[s]). Of one run: lag simulate --outputs "x, max(y, from=2)",
and in Python model.measure("max(y)", tolerance=1e-9) and model.rainflow("y, from=2"), all cycles with range, mean and count.
They are those of the motion between rows: extremes and crossings are found on the integrator's dense output. What oscillates
faster than the motion itself needs --interval, which says how closely to look at least. A run ends when all its measures are
known; period(y) and settling_time need its mean or end first, and take it twice.

A run that fails is a row with the reason in its last column, and what was known before. Limits: --max-steps, --seconds-per-run.
Exit code 0: one run or more went well; 1: none did, or the energy account of one is open, whose row is no motion of the scene.
While a sweep is under way its results are in FILE.part. If it is interrupted or killed, the same command goes on from there;
another sweep never does (--restart gives the old one up). --keep writes whole trajectories beside it, rows an --interval apart:
Parquet files with a column run in NAME_sweep_runs. The table is CSV, or Parquet for -o FILE.parquet (pyarrow). Of trees each core
makes eight runs at a time, as exactly: by series, where each leaves for its events and comes back, or without events by erk,
erk5 or erk9, of loops where these are asked for (--stats: how full the registers were, how often runs left, or why not). A run's
digits are the same in any company of four runs or more; up to three are made one by one, with other digits within the tolerance.
--dask tcp://host:8786 runs it on the workers of a Dask scheduler (pip install "lagrangia[dask]", there and here). The scene is
sent as data and built in each worker's cache; a worker that dies costs no run. In Python: model.simulate_many.
"""

_PYTHON = """\
import lagrangia as lag
model = lag.load("chain.lag", n=20)                    # structural parameters at load
run = model.simulate(stop=5, tolerance=1e-10, parameters={"link[1].m": 2.0}, initial={"hinge[1].phi": 1.2})
run.time, run["hinge[1].phi"], run["link[3].b.y"]      # NumPy arrays: coordinates, rates, or any quantity of the scene
run.energy.total, run.energy.residual, run.statistics, run.warnings, run.notes   # notes: what makes steps short
many = model.simulate_many(parameters={"link[1].m": [1, 2, 5]}, outputs=["max(hinge[1].phi)"])   # lag help sweep
again = model.prepare({"hinge[1].phi": 0.1}, {"link[1].m": 1.0}, stop=5)   # for many calls: again([0.2], [2.0]) gives rows,
again.columns, again.warnings        # in microseconds beside the steps; RunWarning: rows are no motion of the scene
many["link[1].m"], many["max(hinge[1].phi)"], many.failures; many.to_pandas(); many.to_parquet("x.parquet")
run.plot("hinge[1].phi", path="chain.png"); run.to_pandas(); run.to_xarray(); run.write("x.csv")  # .jsonl .parquet .npz .mat
model.measure("max(link[3].b.y, from=2), settling_time(hinge[1].phi)", stop=5); model.rainflow("hinge[1].phi")
model.simulate(controllers={"F": lambda t, run: -45*run["hinge.phi"]}, every=0.01)      # sampled feedback on the input F
model.rollout(q0, v0, p, u, times=t).q        # arrays in, arrays out: (runs, times, n); u is held from one time to the next
live = model.start(); live.set(F=1); live.step(0.01); live["hinge.phi"]; live.steps(U, 0.01)   # step by step, or a row of U each
kept = live.save(); live.restore(kept)                 # examples: swing_up.py, environment.py in models/examples
model.draw("chain.svg", at=1); run.animate("chain.html", traces=["link[20].b"])     # lag help drawing
model.functions()                                      # CasADi: M, h, rhs, energies, outputs, jacobian of t, q, v, u, p
model.parameter_names, model.parameter_values()        # p; what is bound to others follows them: its entry is not read
model.functions(given=["link[1].m"])                   # but for what is named here
model.derivatives()                                    # jacobian_u, jacobian_p of dv/dt; parameters: p -> all values
"""

_EQUATIONS = """\
lag equations FILE [--form FORM] [--format FORMAT]
Lagrange's equations as a textbook writes them, derived with SymPy from the same energies that are simulated.

forms     lagrange      d/dt dT/dv - dT/dq + dV/dq + dD/dv = f, written out for every coordinate (the default)
          energies      T, V = V_e + V_f, D and the generalised forces, by component and in all
          5.16 total        d/dt dT/dv - dT/dq = f               5.20 potential    ... + dV/dq = f_nc
          5.21 lagrangian   by L = T - V, f_nc on the right      5.22 conservative the same, where f_nc is 0
          5.23 balance      f_in + f_c + f_nc = 0                5.26 sources      V_e and f_nc on the left, f_f on the right
          5.27 elastic      by L_e = T - V_e, f_nc left          5.31 elastic-dissipation  by L_e and D
          5.32 dissipation  by T, V_e and D: each by its number or its word, with its general formula, the scene's functions and
                        the equations. Loads of time alone stand in V by their potential -F . r; --sources force: as forces
          matrix        M(q) q'' + h = f           first-order  q' = v, v' = M^-1 (f - h)
          linear        M, C, K and the load of small motion about an equilibrium, or --about NAME=VALUE,...; with constraints
                        their Jacobian and multipliers, and then the same without; motion of supports on the right-hand side
          worked        the whole derivation: positions and virtual displacements, the principle of virtual work, T body by body
                        and in all, V, D, generalised forces both ways, Lagrange's equation of each coordinate derivative by
                        derivative, small motion, matrices, constants. Formulas have letters; --first-letter f goes on from
                        another page. --level short (results), full, lecture (more); --sections kinetic,potential,equations of
                        system, coordinates, data, positions, principle, kinetic, potential, dissipation, forces, constraints,
                        equations, small, matrices, constants, checks (units, M positive, the energy theorem)
          exercise      the statement: the scene, its coordinates and data, without the solution (see --check)
formats   text, markdown (formulas between dollars), latex (--fragment: the body alone, which needs amsmath, with labels lag:a),
          html (one page that needs no network and prints well; a click on TeX shows a formula's LaTeX),
          sympy (a Python script that builds the form, derives the equations once more from T, V, D, and asserts all of it)

--names tilt.phi=theta,guide.s=x   symbols of your own: theta, \\theta or θ; k_1 or x_{cm} with a subscript; the pages' letters
                                   T, V, D, L, E, H, W (of virtual work) too: D=sigma
--language pt                      headings and sentences in Portuguese; de, fr, es: German, French, Spanish
--check "m*x'' + (k1+k2)*x = P(t)"  tells whether an equation is the scene's, up to factors and combinations, by value at random
                                   points; else which terms differ (exit code 1). Products with *, powers with ^, x' and x''
--numbers, -p NAME=VALUE           puts the parameters' values in      -o FILE   writes a file

A coordinate is called by its last name where that is unambiguous, phi of tilt.phi; else with its component, phi_O. Parameters of
the model keep their names; a component's that is bound to a formula (I = m L^2/12) stays, and the formula is told below.
Constraints come with multipliers, Phi = 0 and J^T lambda; loads and prescribed coordinates are given functions of time; constants
of the motion are named. What is too large to read is told so, with its energies and structure; --force writes it all the same.
The linear form finds its equilibrium without loads that depend on time, and with supports at rest; linearize, modes and
equilibrium hold loads as they are at the start time. Coefficients that vary with time are taken at the same standstill, and the
page says so. Derivations and exercises of HTML begin with the figure that `lag draw` makes.
From Python: model.equations("worked", "html", names={"tilt.phi": "theta"}), a text that notebooks show typeset.

lag export FILE --to TARGET [-o FILE] writes a scene for other programs, with the start values as they were assembled:
python    a module that needs NumPy alone: M, h, rhs, energies, outputs, ..., slope(t, y) for scipy's solve_ivp; jacobian_u and
          jacobian_p of the accelerations; parameters({"m": 3}) is p with a change
casadi    M, h, rhs, energies, ... of t, q, v, u, p, and parameters, inputs, start: casadi.FileDeserializer(FILE).unpack();
          a second unpack() has the names of the entries of q, u, p, y
modelica  a flat model: Lagrange's equations, parameters with units; constraints differentiated twice, as a linear system, and
          multipliers mu (zero on the exact motion) that keep them closed; `closing` says how fast gaps close, 10/s; attitudes
          are unit quaternions Q_1 to Q_4, their rates w_1 to w_3 by Euler's equations; what is too large to be read is
          written by its instructions, a hidden variable each, up to 100 000 (--force: by equations, which may take long);
          --components: a drive train with those of the Modelica Standard Library, which lag import reads back; joints,
          bodies, springs, forces and torques of a scene with those of Modelica.Mechanics.MultiBody, planar loops by one
          RevolutePlanarLoopConstraint each; what that library cannot say is refused by its name
sympy, latex   the script, and the worked derivation
In the first two p has all parameters; what is bound to others follows them: its entry is not read (FOLLOWING, `follow`).
None of these three takes scenes where rates of supports jump (a ramp, a table): momentum stays as it is there, as an FMU knows.
"""

_ANALYSIS = """\
lag equilibrium FILE    positions of rest: the one reached from the start, and others from --starts N places; stability, reactions
          lag simulate FILE --from equilibrium begins at the first, --from "steady hinge.w=12" where all else stands still
lag linearize FILE      M x'' + C x' + K x = F u and z' = A z + B w, y = C z + D w; -o FILE.json, FILE.mat, FILE.npz
lag modes FILE          natural frequencies, damping ratios, mode shapes; --mass-normalised, --plot FILE, -o FILE.json;
                        --animate FILE.html (.svg, .gif, .mp4, in space .glb) plays --mode N (1), larger than life, loops closed
lag response FILE       frequency response; --range 0.1:100 or --at 1,2,5 (Hz), --points N, --plot FILE, -o FILE.csv
all of them             -p NAME=VALUE, --initial NAME=VALUE, -u NAME=VALUE, --time T, --model NAME

Derivatives are exact. Small motion is taken about the equilibrium near the start values, or, far from any, about the one where
the scene would settle; a start that rests by itself (a pendulum upright) stays. --about start takes the start itself.

About the equilibrium time stands still at T (the start time by default): loads act as they are then, and supports rest where they
are then. Where nothing but loads depends on time, it goes on: a frame that turns steadily keeps turning, and rest is relative to
it. About the start time always goes on: loops are closed at T, supports have their rates and accelerations of that moment, and
drift is what the start does by itself. Contacts and friction that hold while supports move are refused there (L0916).

--from NAME,...   what excites: an input; a load or any variable with a formula (P.force[2], or P for short); a prescribed
                  coordinate or its Motion; the place of a frame that hangs on another one (road.y), with all it carries. By
                  default the inputs, and all loads and supports that depend on time. Where its rate or acceleration matters (a
                  support moves masses or dampers), the state-space form has these as inputs of their own, der(road.y).
--to NAME,...     any quantities, reactions too; by default the coordinates and the declared outputs

Constraints are kept by motion in their null space, with the stiffness that their forces give to curved ones; redundant ones do
no harm. The states are coordinates of the scene and their rates, those that have start values by preference. A mode without
stiffness is rigid-body motion; one that runs away tells its rate. An equilibrium is asymptotically stable, stable (undamped),
neutral or unstable. Where nothing can move it is fixed, and there are no modes. Where constraints are less independent than
elsewhere several ways of moving may meet: each is named by the coordinates that move, with modes of its own, and the equilibrium
is as stable as the least stable of them; matrices of several are refused. Ways that no linear motion tells are called singular.
Where motion moves no mass at one of several equilibria, its stability is unknown.

What holds at rest is among the constraints, and told with its force: contacts that press (a stop, a rope as `when r > L`), which
only push, and friction that sticks, up to its limit. Friction holds the start, if it can; other positions of rest are found as if
there were none, where it then holds without force. Small motion goes along contacts that press; what just touches is told.

Where coefficients of small motion change with time (a pivot that shakes up and down, a load along a pendulum), warning L0740 says
so, and whether time stands still or goes on: stability and frequencies are those of that moment.
Where it rests just where forces bend (a spring that acts one way, play), warning L0743: frequencies are of neither side. So it
is told where something that just touches (a pawl, a wall) bars the way back: such modes are "one way", the rest "one-sided".

From Python: model.equilibrium(), model.linearize(excitations=["road.y"], outputs=["car.s"]), model.modes(), model.response(...)
with parameters=, initial=, inputs=, time=, about=. A linearisation has .M, .C, .K, .A, .B, .output, .D, .save(path) and
.to_control(), modes and responses have .frequencies and .plot(path).
"""

TOPICS: Mapping[str, tuple[str, Callable[[], str]]] = {
    "language": ("models, frames, energies: the language on one page", lambda: _LANGUAGE),
    "reference": ("the language, construct by construct, and what of Modelica is in it", reference_topic),
    "library": ("the components and what they state", library_topic),
    "drives": ("drive trains: shafts, gears, clutches, what slides along a line", lambda: DRIVES),
    "space": ("scenes in three dimensions", space_topic),
    "functions": ("mathematical functions, sources in time, your own functions", lambda: _FUNCTIONS),
    "assertions": ("what has to hold, and where a run ends", lambda: ASSERTIONS),
    "events": ("events that reset rates: impacts, contacts, kicks", lambda: _EVENTS),
    "drawing": ("how components look: the drawing section", drawing_topic),
    "curves": ("pictures of runs: curves, phase portraits, spectra, sections", curves_topic),
    "attitudes": ("ball joints and bodies that turn freely in space", lambda: ATTITUDES),
    "signals": ("inputs, first-order states: filters, motors, controllers", lambda: SIGNALS),
    "tables": ("tables of files and points: roads, measured forces", lambda: TABLES),
    "units": ("units and dimensions", lambda: _UNITS),
    "solver": ("how a scene is run, tolerance, cache, environment", lambda: _SOLVER),
    "sweep": ("many runs: values, measures, failures, going on, clusters", lambda: _SWEEP),
    "python": ("the Python interface", lambda: _PYTHON),
    "bench": ("run time against error: what is measured, and how", lambda: _BENCH),
    "equations": ("the equations of motion for people: forms, formats, names", lambda: _EQUATIONS),
    "fmu": ("FMUs: export, check, simulate", lambda: FMU),
    "analysis": ("equilibria, small motion, modes, frequency response", lambda: _ANALYSIS),
    "editor": ("texts: layout, style, tests, pages, language server", lambda: EDITOR),
    "errors": ("diagnostics and exit codes", lambda: ERRORS),
    "warnings": ("codes of warnings, and how they are allowed", warnings_topic),
}


def topic_text(topic: str) -> str:
    """Raises LagError L0707 for an unknown topic."""
    if topic not in TOPICS:
        fail("L0707", f"there is no help on '{topic}'", None, *filter(None, [suggest(topic, TOPICS)]))
    return TOPICS[topic][1]().rstrip("\n")
