"""The text of `lag help attitudes`."""

ATTITUDES = """\
model Top
  World     world(gravity = {0, 0, -9.81});
  Spherical tip(a = world, S(start = angles("zxz", 0, 30[deg], 0)), w(start = {0, 0, 200}));
  Body      top(m = 0.5, I = {0.0008, 0.0008, 0.001}, center = shift(tip.b, {0, 0, 0.1}));
end Top;

coordinate Rotation S   three degrees of freedom: b = turn(a, S) turns a frame by it. der(S) is the angular velocity of b
             against a in b's axes. Spherical and Free have one; a body that is joined to nothing has x, y, z and S.
Starts       S(start = angles("zxz", a, b, c)): about the first axis, then about the second as it has moved, then about the
             third; any of the twelve sequences of x, y, z whose neighbours differ. axis_angle({x, y, z}, angle), or
             quaternion(a, b, c, d), real part first, both of any length but 0. w(start = {0, 0, 10[rpm]}); fixed as elsewhere.
             Floating: Body b(center(r(start = ...), Q(start = angles(...)), omega(start = ...))), or w(start = ...) in the
             world's axes. Initial equations of f.R, f.w, f.omega hold at the start as others do.
             --initial 'tip.S=angles("zxz", 0, 20[deg], 0)' (or axis_angle, quaternion), in sweeps several with commas between
             them; in Python initial={"tip.S": [a, b, c, d]} or such a text. Rows of a run go on where they ended: all four parts
             of a quaternion by name are a start, too. In arrays of coordinates (rollouts, prepared runs) an attitude is three
             numbers tip.S.s[1] to [3], 4 tan(angle/4) along the axis of the turn; they come back as NaN, tip.S[1] to [4] tell.
Results      tip.S[1] to tip.S[4], a unit quaternion (b against a), real part first: not negative at the start, then continuous;
             der(tip.S)[1] to [3], also called tip.w[1] to [3]. f.R (a matrix) and f.Q say how any frame is turned in the world.
Equations    of a Rotation are Euler's: d/dt dT/dw + w x dT/dw = torque. The state is the modified Rodrigues vector of what the
             attitude has turned since the latest step began, and w: no singular place, no norm to keep, no sines.
             lag equations prints them (forms lagrange, energies, matrix, first-order) with w1, w2, w3 and Q' = Q (0, w)/2;
             --angles zxz writes them by Euler's angles, in all forms, with momenta that stay and an effective potential.
Solvers      erk, erk5, erk9, pirk, taylor (series of the unit quaternion, Q' = Q (0, w)/2, and of w), implicit, casadi:cvodes and
             its like. adams does not know attitudes: its past slopes are told against what each step moves; nor do conservative
             (no positions belong to their momenta) and islands; linear never will, as they turn. auto takes none of these.
FMUs         have the unit quaternion tip.S[1] to [4] and der(tip.S) (tip.w) as states. In Model Exchange dQ/dt = P (0, w)/2 +
             k (P - Q) with P = Q/|Q|: no other length says anything, and none lasts; k = 100/(stop - start). Co-Simulation steps
             as lag simulate does. A start is set as a whole: its length says nothing, parts that are not set are as declared.
Functions    of model.functions(), --to casadi and --to python have the unit quaternion among q (model.position_names), of any
             length; turning is dq/dt. --to modelica writes Euler's equations with the quaternion, whose length is kept.
Small motion is in small turns tip.S.s[1] to [3] about the turned axes (rad), three of each attitude; the point is told by its
             quaternion. About a start that turns (--about start), as a sleeping top, frequencies are those seen from the turned
             axes, and it is told whether the motion is steady. --from equilibrium begins at rest, --from "steady tip.w[3]=150"
             where the body spins so about its own axes and these stay: upright, of a top. Regular precession is not that, as
             the axes of the body go round: it is steady by hinges, a Universal and a Revolute (as a disc that rolls round a
             circle, --from "steady spin.w=8 yaw.w=1.5", and flyballs in a loop). lag simulate --plot F --linear shows
             small motion beside the run, in quaternions.
Not supported yet: kinetic energies of der(S) that are no rigid body's, --angles of a loop that a ball joint
closes."""
