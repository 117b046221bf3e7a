"""The text of `lag help signals`."""

SIGNALS = """\
States
    Length z(start = 0) "deflection of bristles";
    AppliedForce friction(at = block.center, force = {-(s0*z + s1*der(z)), 0});
  equation
    der(z) = block.v - s0*abs(block.v)/g*z;

A variable with an equation for its rate is a first-order state: filters, motors, controllers, friction with bristles. It is in
all solvers, FMUs of both kinds, sweeps, lag equilibrium, linearize and response; z(start = 1, fixed = true), initial equations,
--initial z=1 and reinit(z, 0) in a `when` hold as of a rate. Forces may read der(z), which is the right-hand side.
The equation is solved for der(z), as T*der(z) = u - z, and may read positions, rates, time, inputs and other states.

In the library   FirstOrder, SecondOrder, Integrator, Limiter, RateLimiter, Sensor; PI and PID with limits, whose integral does
                 not wind up; DCMotor between two frames; chirp(time, f0, f1, duration); Hysteresis(low = 19, high = 21, off = 1,
                 on = 0, u = x), a relay with two thresholds, which switches by events at their exact times
connect          connect(sensor.y, control.u) gives the one that has no value the value of the other; control(u = sensor.y) too

    Sensor sensor(T = 0.002, u = axle.phi);
    PID control(k = 20, Ti = 0.5, Td = 0.05, low = -24, high = 24, set = 1);
    DCMotor motor(a = world, b = rotor.center, R = 1, L = 0.01, k = 0.5);
  equation
    connect(sensor.y, control.u);
    connect(control.y, motor.V);

States count in no energy; what their forces do to the mechanism is work. In M, C and K of lag linearize, in FMUs and the exports
to python and casadi each is the rate of a coordinate z.integral of inertia 1, on which nothing depends; A and B have the state.
Not supported yet: states in energies and in the places of frames (let them act as forces), arrays of them (an array of components
does), natural modes and written equations of scenes that have them.

What acts late
    AppliedTorque control(on = pole.b, torque = -k*delay(hinge.phi, 0.05));
    Real x(start = 1);
  equation
    der(x) = -1[1/s]*delay(x, T, before = cos(time*1[rad/s]));

delay(x, T) is x as it was T earlier: of positions, rates, states, held values, inputs and functions of time. T > 0 may be a
parameter, and stays as it is during a run. Before the start it is x as it is there, or what `before` says, a function of time.
What breaks (the start, events, corners, instants) breaks again T later, one derivative smoother each time: these are events, so
that no step goes across them. No step is longer than the shortest delay. In the library: Delay(T = 0.1, u = ...).
In all solvers of steps (erk, erk5, adams, implicit), sweeps, runs in steps (save and restore keep the past) and FMUs for
Co-Simulation, whose saved states have it. Not supported yet: Model Exchange, whose importers keep no past; rest, modes, linearize
and response, written equations and exports; delayed values in places and energies; the rate of one (delay the rate).

Sampled values
    Real e(start = 0); Real i(start = 0); Force F(start = 0);
    AppliedForce push(at = cart.center, force = {F, 0});
  equation
    when sample(0, Ts) then
      e = 1 - cart.s/1[m];
      i = pre(i) + Ts/1[s]*e;
      F = 40[N]*e + 30[N]*i + 8[N.s]*(e - pre(e))/Ts;
    end when;

A variable that a `when sample(first, interval)` gives a value holds it until the next instant: controllers of computers,
difference equations. pre(x) is the value before the instant; x, of another held variable, the new one. Instants are first +
k interval, k = 0, 1, ..., exact in time; both may be parameters. What takes time to compute acts late, as by a second one,
when sample(late, Ts) then applied = F; end when;
In the library: Hold(Ts = 0.01, u = ...), SampledPID(Ts = 0.01, late = 0.002, ...), WhiteNoise(S = 4, Ts = 0.01, seed = 1), whose
density S (squares by Hz) is flat up to some 0.4/Ts, and whose numbers are the same in any run; what it goes through shapes it.
Held values are columns of results and outputs of FMUs (both kinds); they are in all solvers but CasADi's, in sweeps and
runs in steps.
lag linearize has them among the inputs of A and B, and gives the sampled system beside these: from instant to instant, with the
held values among its states and its eigenvalues (A_sampled, B_sampled in files; linear.sampled in Python).
lag equilibrium, modes and response take held values as they are at first, and linearize says where the controller is not at rest.
Not supported yet: held values in places and energies (let them act as forces), exports to python, casadi and equations, several
intervals in the sampled system, acceleration and joint forces as what is sampled.

Inputs
    input Length y;
    Frame road = shift(world, {0, y});

An input may stand wherever a function of time may: in forces, limits of friction, stiffnesses and potentials; in places, the `to`
of a Motion, equations and kinetic energies, where its rates matter. Between the rows it is given by it is a polynomial of time:

    lag simulate car.lag -u y=road.csv            straight lines; where its rate jumps, impulses act on what it moves
                         -u y=road.csv:cubic      the spline with two continuous derivatives; :monotone does not overshoot
                         -u y=0.1 -u "der(y)=0.5" 0.1 m at the start, from there on 0.5 m/s
    model.simulate(inputs=(t, {"y": y, "der(y)": rates}))     the cubic with these rates; lagrangia.slopes(t, y) are a spline's

It has two more inputs beside it, der(y) and der(der(y)) (der(y,2) in an FMU), for who sets it now and then (a run in steps, an
importer): until it is set again it goes on with them. A place that jumps has no speed: it is refused, with its time, where the
rates do not tell of so much. FMI 2 importers may give the first derivative instead (setRealInputDerivatives), in Co-Simulation.
lag linearize has der(y) and der(der(y)) in B where they matter. A factor of what a constraint holds cannot be an input, and
written equations of places that inputs move are not supported yet.
"""
