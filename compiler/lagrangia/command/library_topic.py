"""The texts of `lag help library`, read off the library itself, and of `lag help drives`."""

import re

from lagrangia.base.folders import data_folder

_CLASS = re.compile(r'^( *)(partial )?(model|package) (\w+)(?:\s+"([^"]*)")?', re.MULTILINE)

DRIVES = """\
model DriveTrain
  import Rotational.*;
  Torque       motor(tau = 4*ramp(time, 0, 0.5));
  Inertia      rotor(J = 0.02), load(J = 1.5);
  IdealGear    gear(ratio = 5);
  Clutch       clutch(cgeo = 0.2, fn_max = 1200, f_normalized = ramp(time, 1, 0.5));
equation
  connect(motor.flange, rotor.flange_a);    connect(rotor.flange_b, gear.flange_a);
  connect(gear.flange_b, clutch.flange_a);  connect(clutch.flange_b, load.flange_a);
end DriveTrain;

Rotational and Translational have the components of the Modelica Standard Library by their names, with its parameters:
Inertia, Spring, Damper, ElastoBacklash, BearingFriction, Clutch, Brake, FreeWheel, OneWayClutch, IdealGear, LossyGear,
IdealPlanetary, IdealRollingWheel, Torque, Position, Speed, Accelerate, EddyCurrentTorque, sensors; Mass, Rod, ElastoGap,
MassWithStopAndFriction, Vehicle and others.
`lag help library` lists them. They are named in full, as Rotational.Inertia, or imported: import Rotational.*;
import R = Rotational;

Flanges      A flange has one position, phi or s. connect(a, b) makes it one; so does a(flange_a = b.flange_b). Torques and
             forces follow from virtual work; where nothing has mass, as between two springs, the place follows from the forces.
             A connector of your own: connector Flange Angle phi; end Flange; its variables are given by an equation of the
             component (flange_a.phi = phi), by what they meet, or are coordinates.
Housings     stand still; with useSupport = true they turn with the flange `support`, which takes what acts against them.
Friction     tau_pos and mu_pos are rows of a rate and what it takes there; it sticks exactly, and holds up to peak times the
             first at rest. A clutch needs an inertia on both sides. FreeWheel.tau is the torque with which it carries along,
             clutch.tau, brake.tau, spring.tau what goes through them. LossyGear rubs by the torque that it hands on, by the rows
             of its lossTable, and may lock itself.
Starts       spring.phi_rel(start = 0.1, fixed = true) is an initial equation; without fixed it has no effect (L0608).
             Where a start fits in two ways (der(b.s)^2 = 4, a loop whose crank alone is given) L0609 tells which was taken: the
             one nearest to the starts of the others, which choose: b.v(start = 2). The search for others begins
             within a turn, or twice the natural size (by starts and levers, else 1 m), of what was taken, and goes no further.
Planar       scenes have shafts by Rotational.HingeFlange(of = hinge.phi) and Translational.SliderFlange(of = slider.s).
Pictures     lag draw FILE.lag shows a drive train along its shaft, by its connections (`lag help drawing`).
Sensors      TorqueSensor, ForceSensor and MultiSensor stand between two flanges: what the first side does to the second.
Modelica     Its names are understood: import Modelica.Units.SI; Modelica.Mechanics.Rotational.Components.Inertia.
             lag import FILE.mo makes a .lag file of a model of Modelica.Mechanics.Rotational and Translational, Modelica.Blocks
             (Sources, Math, Continuous: those of the package Blocks) and Modelica.Units: names, parameters and comments stay,
             what has no counterpart is left out as a comment, and the exit code is 1. Heat ports are left out: damper.lossPower
             is what becomes heat, of all that rubs. Filters of Position and Speed are, too (without exact = true Modelica has
             them): they move exactly. A Vehicle stands still exactly, so that vReg has no meaning.
Sources      Position, Speed and Accelerate move exactly. Accelerate starts where its phi and w (s and v) do: a(phi(start = 1)).
             What it moves has inertia (a spring alone has none), and what moves it is acc.tau or acc.f."""


def library_topic() -> str:
    """Names and descriptions of all components, by file; those of packages as well."""
    lines = []
    for file in sorted((data_folder("models") / "library").glob("*.lag")):
        found = [m.groups() for m in _CLASS.finditer(file.read_text(encoding="utf-8")) if m[2] is None]
        package = next((name for _, _, kind, name, _ in found if kind == "package"), None)
        models = [(name, description or "") for _, _, kind, name, description in found if kind == "model"]
        if models:
            lines.append(f"{file.stem}:" if package is None else f"{file.stem}: import {package}.*;")
            lines += [f"  {name:20} {description}" for name, description in models]
    return "\n".join([*lines, "", f"The sources are worth reading: {data_folder('models') / 'library'}"])


def reference_topic() -> str:
    """The reference of the language."""
    return (data_folder("grammar") / "reference.md").read_text(encoding="utf-8")
