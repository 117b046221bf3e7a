"""`lag help space`."""

from textwrap import fill

SPACE = """
A scene is in space as soon as its text says what no plane has: a turn about an axis that is not along z, a shift, a load or a
gravity with a third component, or one of the words below. Nothing is declared; `lag explain` says which line it was. Gravity is
{0, -9.81, 0} unless World(gravity = {0, 0, -9.81}) says otherwise.

  joints    Revolute(axis = {1, 0, 0}), Prismatic(along = {0, 0, 1}), Universal, Cylindrical, Screw, PlanarJoint, Weld, Spherical
            and Free (lag help attitudes); an axis has any length but zero, in the axes of a
  places    shift(a, {x, y, z}), where {x, y} means z = 0; turn(a, phi, axis), where turn(a, phi) is about z
  frames    f.r, f.v and the angular velocity f.w have three components, in the world's axes; f.omega is f.w in the frame's own;
            f.x, f.y, f.z; f.R is the matrix that takes its axes to the world's, f.Q the same as a quaternion, real part first and
            continuous. A frame has no phi: the angle of a hinge is hinge.phi
  vectors   to_world(f, v), to_frame(f, v): in other axes; velocity_at(f, r): of the point of f's body that is at r just now;
            dot, cross, norm, products of matrices and vectors
  bodies    Body(m, I = {Ixx, Iyy, Izz}) or I = {{Ixx, Ixy, Ixz}, {Ixy, Iyy, Iyz}, {Ixz, Iyz, Izz}} about the centre of mass, in
            the axes of `center`; one number is that about z, of a body that turns about no other axis. Bar (along x), Disc, Ring,
            Cylinder, Cone (about z), Ball, Box(size = {a, b, c}) reckon theirs
  loads     AppliedForce(force = {Fx, Fy, Fz}), BodyForce, AppliedTorque(torque = {Mx, My, Mz}) in the world's axes, TorquePair;
            of one's own: energy work M on f.attitude. A motor in a hinge: energy work tau on hinge.phi. Two components where
            space has three are told (L0306), but in shift(a, {x, y}), in places as Weld(offset = {x, y}), and in components,
            which may be written for the plane
  hinges    TorsionSpring, TorsionDamper, TorsionStop, TorsionDryFriction, DCMotor, Gear and TorquePair(torque = 3) act about the
            hinge between their frames, or several about parallel axes: TorsionSpring(a = hinge.a, b = hinge.b, k = 2). Of one's
            own: hinge_angle(a, b). A ball joint has no such angle, nor has a Universal as a whole: bind twist = u.phi_a
            SphericalSpring holds a ball joint; Bushing has three stiffnesses along a's axes and three about them
  friction  of joints as in the plane; SlidingFriction(a = plane, b = foot, normal = ...) acts against the slip in the plane of
            a's x and y axes, and holds up to the same force in any direction of it. A joint keeps b there, as PlanarJoint
  gears     Gear, Belt, RoughGear, RoughBelt of the angles of hinges: Gear(r_a = 0.1, r_b = 0.2, phi_a = p.phi, phi_b = q.phi);
            bearings do not feel what the teeth push them with
  planes    where all turns are about parallel axes and nothing shifts along them, the scene runs with the equations of the plane,
            in whatever plane of space that is, and however gravity and loads point; its columns stay those of space. lag explain
            says so, or which line leaves the plane. Reactions have parts across it: who asks for them has the scene run in space
  loops     what is closed is found, and equations that repeat each other are left out: a planar four-bar of spatial hinges, a
            double Cardan shaft and Bricard's six-bar run as they are. lag check names such loops, and so do runs whose reactions
            are asked for: how their joints share what they carry is not unique, and what is told is one way of it, or that of
            least squares: --least-squares 1[m]. A loop that lies in a plane of its own is closed by the equations of a plane
  rolling   RollingDisc and RollingBall on the plane of a base, which may move; Skate does not slip aside. Of one's own:
            dot(velocity_at(wheel, contact), across) = 0. lag linearize and lag modes --about start are exact while they roll:
            models/examples/bicycle.lag

Components for both are written with `dimensions`, which is 2 in the plane and 3 in space: Real along[dimensions] = {1, 0}.

Example:
  model Furuta "An arm turns about the vertical, a rod swings about the arm"
    World world(gravity = {0, 0, -9.81});
    Revolute turning(a = world, w(start = 4));
    Bar arm(m = 0.3, L = 0.3, a = turning.b);
    Revolute swinging(a = arm.b, axis = {1, 0, 0}, phi(start = 2));
    Body rod(m = 0.2, I = {0.0027, 0.0027, 0.00001}, center = shift(swinging.b, {0, 0, -0.2}));
    output Length height = rod.center.z;
  end Furuta;

{MISSING}
"""


def space_topic() -> str:
    """The text, with what is refused as space_limits.py has it."""
    from lagrangia.language.space_limits import NOT_YET

    missing = f"Not there yet, and refused by name: {', '.join(told for told, _ in NOT_YET.values())}."
    return SPACE.replace("{MISSING}", fill(missing, 128)).strip()
