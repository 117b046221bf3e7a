"""Random models that are right: components of the library joined as they should be, with numbers of all sizes.

The same seed gives the same text. Nearly all of them compile and run; what does not is to say why.
"""

import math
import random
from dataclasses import dataclass, field

_TIMES = ("sin({w}[rad/s]*time)", "cos({w}[rad/s]*time)", "exp(-time/{w}[s])", "(if time < 0.1 then 1 else -0.5)", "time/1[s]",
          "table(time, {{0[s], 0.1[s], 0.3[s]}}, {{0, 1, -1}})", "step(time - 0.12[s])", "1", "(time/1[s])^2",
          "tanh({w}*time/1[s])")


@dataclass
class _Coordinate:
    name: str
    rate: str
    is_angle: bool


@dataclass
class ValidModel:
    """Written part by part; `places` are frames, `coordinates` of the joints that were made."""

    chance: random.Random
    lines: list[str] = field(default_factory=list)
    equations: list[str] = field(default_factory=list)
    places: list[str] = field(default_factory=lambda: ["world"])
    coordinates: list[_Coordinate] = field(default_factory=list)
    count: int = 0
    spread: float = 1.0  # decades that numbers span

    def text(self) -> str:
        """The whole model."""
        chance = self.chance
        self.spread = chance.choice((0.3, 0.3, 1.0, 3.0))
        if chance.random() < 0.4:
            self.lines.append(f"World world(gravity = {{{chance.choice(('0', self.size()))}, {chance.choice(('0', '-9.81'))}}});")
        if chance.random() < 0.3:
            self.lines.append("input Real u(start = 0);")
        for _ in range(chance.choice((1, 1, 2, 2, 3, 4))):
            chance.choice((self.jointed, self.jointed, self.jointed, self.block, self.floating, self.rolling, self.chain))()
        parts = (self.spring, self.spring, self.damper, self.load, self.along_a_coordinate, self.along_a_coordinate,
                 self.massless, self.friction, self.stop, self.tie, self.gear, self.loop, self.event, self.curve, self.named)
        for _ in range(chance.choice((0, 1, 2, 3, 4))):
            chance.choice(parts)()
        if chance.random() < 0.3:
            self.lines.append(f"output Real y = {self.chance.choice([c.name for c in self.coordinates] or ['time'])};")
        stop = chance.choice(("0.3", "0.3", "1", self.size()))
        self.lines.append(f"annotation(experiment(StopTime = {stop}, Tolerance = {chance.choice(('1e-4', '1e-6', '1e-9'))}));")
        stated = ["equation", *(f"  {line}" for line in self.equations)] if self.equations else []
        body, note = self.lines[:-1], self.lines[-1]
        return "\n".join(["model M", *(f"  {line}" for line in body), *stated, f"  {note}", "end M;", ""])

    # ------------------------------------------------------------ numbers and names

    def size(self, typical: float = 1.0) -> str:
        """Positive."""
        return f"{typical * 10 ** self.chance.uniform(-self.spread, self.spread):.3g}"

    def signed(self, typical: float = 1.0) -> str:
        return self.chance.choice(("", "-")) + self.size(typical)

    def name(self) -> str:
        self.count += 1
        return f"c{self.count}"

    def place(self) -> str:
        frame = self.chance.choice(self.places)
        way = self.chance.random()
        if way < 0.4:
            return f"shift({frame}, {{{self.signed(0.3)}, {self.signed(0.3)}}})"
        return f"turn({frame}, {self.signed()})" if way < 0.45 else frame

    def in_time(self) -> str:
        """A number without unit that changes."""
        if self.chance.random() < 0.15 and "input Real u(start = 0);" in self.lines:
            return "u"
        return self.chance.choice(_TIMES).format(w=self.size(3))

    def declare(self, kind: str, *given: str, places: tuple[str, ...] = ()) -> str:
        name = self.name()
        self.lines.append(f"{kind} {name}({', '.join(given)});")
        self.places += [f"{name}.{place}" for place in places]
        return name

    # ------------------------------------------------------------ what moves

    def start(self, name: str, rate: str) -> str:
        chance = self.chance
        first = f", {name}(start = {self.signed(0.3)}{chance.choice(('', ', fixed = true'))})" if chance.random() < 0.7 else ""
        return first + (f", {rate}(start = {self.signed(0.5)})" if chance.random() < 0.3 else "")

    def body(self, at: str) -> None:
        kind = self.chance.choice(("Body", "Bar", "Disc", "Bar"))
        given = {"Body": f"I = {self.size(0.1)}", "Bar": f"L = {self.size(0.7)}", "Disc": f"r = {self.size(0.2)}"}[kind]
        port = self.chance.choice(("center", "a")) if kind == "Bar" else "center"
        self.declare(kind, f"m = {self.size()}", given, f"{port} = {at}",
                     places=("center", *(("b",) if kind == "Bar" else ())))

    def jointed(self) -> None:
        if self.chance.random() < 0.6:
            joint = self.declare("Revolute", f"a = {self.place()}" + self.start("phi", "w"))
            self.coordinates.append(_Coordinate(f"{joint}.phi", f"{joint}.w", True))
        else:
            along = self.chance.choice(("{1, 0}", "{0, 1}", "{3, 4}", f"{{{self.signed()}, {self.signed()}}}"))
            joint = self.declare("Prismatic", f"a = {self.place()}, along = {along}" + self.start("s", "v"))
            self.coordinates.append(_Coordinate(f"{joint}.s", f"{joint}.v", False))
        self.body(f"{joint}.b")

    def block(self) -> None:
        along = self.chance.choice(("{1, 0}", "{0, 1}"))
        name = self.declare("Block", f"m = {self.size()}", f"base = {self.place()}", f"along = {along}" + self.start("s", "v"),
                            places=("center",))
        self.coordinates.append(_Coordinate(f"{name}.s", f"{name}.v", False))

    def floating(self) -> None:
        kind = self.chance.choice(("PointMass", "Disc"))
        more = (f"r = {self.size(0.2)}",) if kind == "Disc" else ()
        name = self.declare(kind, f"m = {self.size()}", *more)
        self.coordinates += [_Coordinate(f"{name}.center.{x}", f"der({name}.center.{x})", False) for x in "xy"]
        if kind == "Disc":
            self.places.append(f"{name}.center")

    def rolling(self) -> None:
        kind = self.chance.choice(("Rolling", "RollingInTrough", "RollingOnDisc"))
        more = () if kind == "Rolling" else (f"R = {self.size(2)}",)
        r = self.size(0.1)
        name = self.declare(kind, f"r = {r}", *more, f"base = {self.place()}")
        self.declare("Disc", f"m = {self.size()}", f"r = {r}", f"center = {name}.center", places=("center",))
        self.coordinates.append(_Coordinate(f"{name}.{'s' if kind == 'Rolling' else 'alpha'}",
                                            f"der({name}.{'s' if kind == 'Rolling' else 'alpha'})", kind != "Rolling"))

    def chain(self) -> None:
        n, hinge, link = self.chance.choice((2, 3, 8)), self.name(), self.name()
        self.lines.append(f"Revolute {hinge}[{n}](each phi(start = {self.signed(0.2)})); "
                          f"Bar {link}[{n}](each m = {self.size()}, each L = {self.size(0.3)});")
        self.equations += [f"connect({self.chance.choice(self.places)}, {hinge}[1].a);",
                           f"for i in 1:{n} loop connect({hinge}[i].b, {link}[i].a); end for;",
                           f"for i in 1:{n - 1} loop connect({link}[i].b, {hinge}[i+1].a); end for;"]
        self.coordinates.append(_Coordinate(f"{hinge}[1].phi", f"{hinge}[1].w", True))
        self.places.append(f"{link}[{n}].b")

    # ------------------------------------------------------------ what acts

    def spring(self) -> None:
        a, b = self.place(), self.place()
        kind, *given = self.chance.choice((("Spring", f"k = {self.size(50)}"), ("TorsionSpring", f"k = {self.size(5)}"),
                                           ("SpringDamper", f"k = {self.size(50)}, c = {self.size()}"),
                                           ("AxialSpring", f"k = {self.size(50)}, along = {{0, 1}}"),
                                           ("DuffingSpring", f"k = {self.size(50)}, k3 = {self.signed(100)}")))
        free = f", s_rel0 = {self.size(0.3)}" if kind in ("Spring", "SpringDamper") and self.chance.random() < 0.5 else ""
        self.declare(kind, f"a = {a}", f"b = {b}", given[0] + free)

    def damper(self) -> None:
        kind, c = self.chance.choice((("Damper", 1), ("TorsionDamper", 0.1), ("QuadraticDamper", 1)))
        self.declare(kind, f"a = {self.place()}", f"b = {self.place()}", f"c = {self.size(c)}")

    def load(self) -> None:
        kind = self.chance.choice(("AppliedForce", "BodyForce", "AppliedTorque", "ForcePair"))
        if kind == "AppliedTorque":
            self.declare(kind, f"on = {self.chance.choice(self.places)}", f"torque = {self.signed()}*1[N.m]*{self.in_time()}")
        elif kind == "ForcePair":
            self.declare(kind, f"a = {self.place()}", f"b = {self.place()}", f"force = {self.signed()}*1[N]*{self.in_time()}")
        else:
            force = f"{{{self.signed()}*1[N]*{self.in_time()}, {self.signed()}}}"
            self.declare(kind, f"at = {self.place()}", f"force = {force}")

    def along_a_coordinate(self) -> None:
        if not self.coordinates:
            return
        q = self.chance.choice(self.coordinates)
        kind = "Torsion" if q.is_angle else ""
        way = self.chance.choice(("spring", "damper", "energy"))
        if way == "spring":
            self.declare(f"{kind}Spring", f"k = {self.size(20)}", f"{'twist' if kind else 'stretch'} = {q.name}")
        elif way == "damper":
            self.declare(f"{kind}Damper", f"c = {self.size()}", f"rate = {q.rate}")
        elif not kind:
            self.declare("GeneralSpring", f"V = {self.size(10)}*1[J]*(1 - cos({q.name}/{self.size(0.5)}[m]))")

    def massless(self) -> None:
        """A place that moves no mass, between a spring and something else."""
        q = next((c for c in self.coordinates if not c.is_angle), None)
        if q is None:
            return
        node = self.declare("Prismatic", "a = world")
        self.declare("Spring", f"k = {self.size(50)}", f"stretch = {q.name} - {node}.s")
        if self.chance.random() < 0.5:
            self.declare("Spring", f"k = {self.size(50)}", f"stretch = {node}.s")
        if self.chance.random() < 0.5:
            self.declare("Damper", f"c = {self.size()}", f"rate = {node}.v")
        if self.chance.random() < 0.3:
            self.declare("DuffingSpring", f"k = {self.size(10)}", f"k3 = {self.size(100)}", f"stretch = {node}.s")

    def friction(self) -> None:
        if not self.coordinates:
            return
        q = self.chance.choice(self.coordinates)
        most = self.chance.choice((self.size(), f"{self.size()}*abs({self.in_time()})"))
        if q.is_angle:
            self.declare("TorsionDryFriction", f"tau = {most}*1[N.m]", f"rate = {q.rate}")
        elif self.chance.random() < 0.7:
            self.declare("DryFriction", f"F = {most}*1[N]", f"rate = {q.rate}")
        else:
            self.declare("QuadraticDamper", f"c = {self.size()}", f"rate = {q.rate}")

    def stop(self) -> None:
        if not self.coordinates:
            return
        q = self.chance.choice(self.coordinates)
        room = self.size(0.4)
        gap = self.chance.choice((f"{q.name} + {room}", f"{room} - {q.name}"))
        kind = "TorsionStop" if q.is_angle else "Stop"
        self.declare(kind, f"gap = {gap}", f"e = {self.chance.choice(('0', '0.5', '1', '0.9'))}")

    # ------------------------------------------------------------ what holds

    def tie(self) -> None:
        if len(self.coordinates) < 2:
            return
        a, b = self.chance.sample(self.coordinates, 2)
        if self.chance.random() < 0.5:
            unit = "rad" if a.is_angle else "m"
            self.declare("Motion", f"of = {a.name}", f"to = {self.size(0.2)}[{unit}]*sin({self.size(3)}[rad/s]*time)")
        elif a.is_angle == b.is_angle:
            self.declare("Coupler", f"a = {a.name}", f"b = {b.name}", f"ratio = {self.signed()}")
        else:
            angle, length = (a, b) if a.is_angle else (b, a)
            self.declare("Rack", f"r = {self.signed(0.2)}", f"s = {length.name}", f"phi = {angle.name}")

    def gear(self) -> None:
        base = self.chance.choice(self.places)
        p, q = (self.declare("Revolute", f"a = {at}") for at in (base, f"shift({base}, {{0.3, 0}})"))
        for joint in (p, q):
            if self.chance.random() < 0.8:
                self.declare("Disc", f"m = {self.size()}", f"r = {self.size(0.1)}", f"center = {joint}.b")
            else:
                self.declare("TorsionSpring", f"k = {self.size(20)}", f"twist = {joint}.phi")
        self.declare(self.chance.choice(("Gear", "Belt")), f"r_a = {self.size(0.1)}", f"r_b = {self.size(0.2)}", f"a = {p}.b",
                     f"b = {q}.b", f"carrier = {base}")

    def loop(self) -> None:
        """A four-bar that closes, hung from some place."""
        base, crank, coupler, rocker, width = self.chance.choice(self.places), 0.3, 0.8, 0.6, 0.7
        phi = self.chance.uniform(0.3, 2.5)
        x, y = crank * math.cos(phi), crank * math.sin(phi)
        d = math.hypot(width - x, -y)
        beta = math.acos((coupler**2 + d**2 - rocker**2) / (2 * coupler * d)) + math.atan2(-y, width - x)
        o, pin, c = (self.name() for _ in range(3))
        bars = [self.name() for _ in range(3)]
        self.lines += [
            f"Revolute {o}(a = {base}, phi(start = {phi:.6f}, fixed = true));",
            f"Revolute {pin}(a = {bars[0]}.b, phi(start = {beta - phi:.6f})), {c}(a = {bars[1]}.b);",
            f"Revolute {c}e(a = shift({base}, {{{width}, 0}}));",
            f"Bar {bars[0]}(m = {self.size()}, L = {crank}, a = {o}.b), "
            f"{bars[1]}(m = {self.size()}, L = {coupler}, a = {pin}.b), "
            f"{bars[2]}(m = {self.size()}, L = {rocker}, b = {c}.b, a = {c}e.b);"]
        self.coordinates.append(_Coordinate(f"{o}.phi", f"{o}.w", True))
        self.places.append(f"{bars[1]}.center")

    def event(self) -> None:
        if not self.coordinates:
            return
        q = self.chance.choice(self.coordinates)
        condition = self.chance.choice((f"{q.name} > {self.size(0.4)}", f"time > {self.size(0.1)}",
                                        "mod(time, 0.1[s]) < 0.05[s]"))
        self.equations.append(f"when {condition} then reinit(der({q.name}), {self.chance.choice(('-0.5', '0.3', '-1'))}"
                              f"*pre(der({q.name}))); end when;")

    def curve(self) -> None:
        name = self.name()
        self.lines.append(f"Length x{name} = {self.size(0.3)}[m]*sin({self.size(2)}*{name}.u);")
        self.lines.append(f"PointOnCurve {name}(base = world, x = {self.size()}[m]*{name}.u, y = x{name}, "
                          f"point = {name}m.center); PointMass {name}m(m = {self.size()});")

    def named(self) -> None:
        """A parameter that others follow."""
        if any("K2 = 2" in line for line in self.lines):
            return
        self.lines.insert(0, f"parameter Stiffness K = {self.size(30)}; parameter Stiffness K2 = 2*K;")
        if self.coordinates and not self.coordinates[0].is_angle:
                self.declare("Spring", "k = K2", f"stretch = {self.coordinates[0].name}")


def valid_model(seed: int) -> str:
    """The text of one scene."""
    return ValidModel(random.Random(seed)).text()
