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
The equation is solved for der(z), and may read positions, rates, time, inputs and other states.

In the library   FirstOrder, SecondOrder, Integrator, Limiter, RateLimiter, Sensor; PI and PID with limits, whose integral does
                 not wind up; DCMotor between two frames; chirp(time, f0, f1, duration)
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
does), natural modes and written equations of scenes that have them, delay(x, T), values that are held between samples.

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
