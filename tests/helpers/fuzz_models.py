"""Random models, valid and nearly valid: components of the whole library, or known scenes with a few words changed.

The same seed gives the same text. What the library holds is read from its files, so that what is added there is tried too.
"""

import random
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

_ROOT = Path(__file__).parents[2]
_MODEL = re.compile(r"^(partial )?model (\w+).*?^end \2;", re.M | re.S)
_WORDS = re.compile(r'"[^"\n]*"|//[^\n]*|[A-Za-z_]\w*|\d+\.?\d*(?:[eE][-+]?\d+)?|\s+|<>|[<>:=]=|.', re.S)
PLAIN = ("1", "2", "0.5", "0.1", "3", "10", "0.02", "1.5", "100", "1e3", "2.5[cm]", "30[deg]", "1[kN/m]")
NASTY = ("0", "-1", "1e-310", "1e308", "-1e308", "1e-160", "1e160", "0/0", "1/0", "-1/0", "99999999999999999999", "sqrt(-1)",
         "log(0)", "1e400", "2147483648", "-0.0", "asin(2)", "{1, 2}", "{}", "true", '"text"', "0*1e308*10", "exp(1000)",
             "5e-324")
NAMES = ("x", "b1", "'a b'", "'q$'", "'ü'", "_y", "'<b>'", "'x.y'", "'[1]'", "'\\n'", "der", "time", "world", "lambda",
    "'\"'", "α",
         "x" * 300, "class", "def", "int", "double", "q", "M")
ONE = ("sin", "cos", "tan", "exp", "log", "sqrt", "abs", "sign", "floor", "atan", "tanh", "step", "asin", "acos")
TWO = ("max", "min", "atan2", "mod")
FUNCTIONS = ("sin", "cos", "tan", "exp", "log", "sqrt", "abs", "sign", "floor", "asin", "acos", "atan", "tanh", "step",
    "der", "norm", "sum",
             "max", "min", "virtual", "pre", "contact_force", "integer", "not", "cross", "dot", "atan2", "mod", "distance",
                 "rotate")


@dataclass(frozen=True, eq=False)
class Component:
    """What a model of the library can be given."""

    name: str
    ports: tuple[str, ...]
    parameters: tuple[str, ...]  # those without a value
    open: tuple[str, ...]  # parameters with a value, and variables
    units: dict[str, str]
    coordinates: tuple[str, ...]


@cache
def library() -> tuple[Component, ...]:
    """All models of the library that are not partial."""
    texts: dict[str, str] = {}
    partial = set()
    for file in sorted((_ROOT / "models" / "library").glob("*.lag")):
        for match in _MODEL.finditer(file.read_text(encoding="utf-8")):
            texts[match[2]] = match[0]
            partial |= {match[2]} if match[1] else set()
    return tuple(_component(name, texts) for name in texts if name not in partial | {"World"})


def _component(name: str, texts: dict[str, str]) -> Component:
    text = re.sub(r'"[^"]*"', "", texts[name]).partition("\n")[2]
    declared = re.split(r"^(?:equation|energy|drawing)\b", text, flags=re.M)[0]
    ports, parameters, opened, coordinates = [], [], [], []
    units: dict[str, str] = {}
    for line in re.findall(r"[^;]+", declared):
        if extended := re.search(r"extends (\w+)", line):
            if extended[1] in texts:
                below = _component(extended[1], texts)
                ports += below.ports
                parameters += [p for p in below.parameters if not re.search(rf"\b{p} *=", line)]
                opened += below.open
                coordinates += below.coordinates
                units |= below.units
            continue
        if not (found := re.match(r"\s*(parameter |coordinate )?([A-Z]\w*) +(\w.*)", line, re.S)):
            continue
        for part in re.split(r",(?![^({]*[)}])", found[3]):
            word = re.match(r"\s*(\w+)", part)
            if word is None:
                continue
            kind = found[2] if found[1] is None else found[1].strip()
            place = {"Frame": ports, "coordinate": coordinates}.get(kind, opened if "=" in re.sub(r"\(.*?\)", "",
                part) or kind != "parameter" else parameters)
            place.append(word[1])
            units[word[1]] = _units().get(found[2], "")
    return Component(name, tuple(ports), tuple(dict.fromkeys(parameters)), tuple(dict.fromkeys(opened)), units,
        tuple(coordinates))


@cache
def _units() -> dict[str, str]:
    types = (_ROOT / "models" / "library" / "types.lag").read_text(encoding="utf-8")
    return dict(re.findall(r'^type (\w+) *= Real\(unit = "([^"]*)"', types, re.M))


@cache
def known_scenes() -> tuple[str, ...]:
    """Scenes of the examples, of the cases, and of the expected errors."""
    folders = [_ROOT / "models" / "examples", *(_ROOT / "tests" / name for name in ("cases", "errors"))]
    texts = [file.read_text(encoding="utf-8") for folder in folders for file in sorted(folder.glob("*.lag"))]
    return tuple(text for text in texts if len(text) < 4_000)


def random_model(seed: int) -> str:
    """Odd seeds: components put together at random; even ones: a known scene, changed in a few words."""
    chance = random.Random(seed)
    if seed % 2:
        text = _Author(chance).model()
        return _changed(chance, text, 1) if chance.random() < 0.15 else text
    return _changed(chance, chance.choice(known_scenes()), chance.choice((1, 1, 1, 2, 3, 6)))


# ---------------------------------------------------------------- words changed


def _changed(chance: random.Random, text: str, times: int) -> str:
    words = _WORDS.findall(text)
    names = sorted({word for word in words if re.match(r"[A-Za-z_]\w*$", word)})
    for _ in range(times):
        places = [i for i, word in enumerate(words) if word.strip() and not word.startswith(("//", '"'))]
        if not places:
            break
        at = chance.choice(places)
        if chance.random() < 0.4:
            at = chance.choice([i for i in places if words[i][0].isdigit()] or places)
        word = words[at]
        way = chance.random()
        if not re.match(r"\w", word) and way < 0.9:
            continue
        if word[0].isdigit() and way < 0.95:
            words[at] = chance.choice(NASTY if chance.random() < 0.7 else PLAIN)
        elif word[0].isalpha() and way < 0.8:
            known = [c.name for c in library()]
            near = sorted({word for i,
                word in enumerate(words) if word in names and (words[i - 1] == ".") == (words[at - 1] == ".")})
            words[at] = chance.choice(known if word in known and way < 0.6 else near if way < 0.75 else (*FUNCTIONS, *known,
                *NASTY, *NAMES))
        elif way < 0.83:
            words[at] = ""
        elif way < 0.85:
            words[at] = f"{word} {word}"
        elif way < 0.95:
            other = chance.choice(places)
            words[at], words[other] = words[other], words[at]
        else:
            words[at] = chance.choice(("(", ")", "{", "}", "[1]", "[0]", "[2]", ".r", ".x", ".phi", ";", ",", "=", "+", "*",
                "/", "^", "[m]", ":"))
    return "".join(words)


# ---------------------------------------------------------------- models put together


class _Author:
    """Writes one model: bodies, joints between places, loads, equations, and what else the language has."""

    def __init__(self, chance: random.Random) -> None:
        self.chance = chance
        self.is_wild = chance.random() < 0.35  # else every number and place is as it should be
        self.frames = ["world"]
        self.coordinates: list[str] = []  # as they are
        self.pure: list[str] = []  # and by their unit
        self.numbers: list[str] = ["time/1[s]"]
        self.lines: list[str] = []
        self.equations: list[str] = []
        self.initial: list[str] = []
        self.before: list[str] = []
        self.count = 0

    def model(self) -> str:
        if self.chance.random() < 0.5:
            self.lines.append(f"World world(gravity = {{{self.number()}, {self.number()}}});")
        if self.chance.random() < 0.3:
            self.lines.append(f"parameter Real p = {self.number()};")
            self.numbers.append("p")
        if self.chance.random() < 0.2:
            self.lines.append(f"input Real u(start = {self.number()});")
            self.numbers.append("u")
        for _ in range(self.chance.choice((1, 1, 2, 2, 3, 4))):
            self.component() if self.is_wild and self.chance.random() < 0.5 else self.jointed_body()
        for _ in range(self.chance.choice((0, 1, 1, 2, 3))):
            self.component()
        for kind in (self.user_function, self.own_coordinate, self.condition, self.equation, self.start, self.output,
            self.experiment,
                     self.loop, self.own_energy, self.heir):
            if self.chance.random() < (0.2 if self.is_wild else 0.12):
                kind()
        return "\n".join([*self.before, "model M", *(f"  {line}" for line in self.lines),
                          *(["equation", *(f"  {line}" for line in self.equations)] if self.equations else []),
                          *(["initial equation", *(f"  {line}" for line in self.initial)] if self.initial else []),
                              "end M;", ""])

    def name(self) -> str:
        self.count += 1
        if self.is_wild and self.chance.random() < 0.04:
            return self.chance.choice(NAMES)
        return f"c{self.count}"

    def number(self) -> str:
        if self.is_wild and self.chance.random() < 0.12:
            return self.chance.choice(NASTY)
        return self.chance.choice(PLAIN[:10])

    def place(self) -> str:
        frame = self.chance.choice(self.frames)
        way = self.chance.random()
        if way < 0.25:
            return f"shift({frame}, {{{self.number()}, {self.number()}}})"
        return f"turn({frame}, {self.number()})" if way < 0.3 else frame

    def expression(self, depth: int = 2) -> str:
        """A number without unit, in most cases."""
        way = self.chance.random()
        if depth == 0 or way < 0.3:
            frame = self.chance.choice(self.frames)
            return self.chance.choice([*self.numbers, *(self.pure or ["1"]), self.chance.choice(PLAIN[:10]), self.number(),
                f"{frame}.x/1[m]",
                                       f"{frame}.phi", f"{frame}.w*1[s]", f"dot({frame}.v, {frame}.v)/1[m2/s2]"])
        if way < 0.6:
            if self.chance.random() < 0.15:
                return f"({self.expression(depth - 1)})^{self.chance.choice(('2', '3', '-1', '0.5', '2', self.number()))}"
            return f"({self.expression(depth - 1)} {self.chance.choice('++--**/')} {self.expression(depth - 1)})"
        if way < 0.8:
            return f"{self.chance.choice(ONE)}({self.expression(depth - 1)})"
        if way < 0.85:
            return f"{self.chance.choice(TWO)}({self.expression(depth - 1)}, {self.expression(depth - 1)})"
        if self.is_wild and way < 0.88:
            many = ", ".join(self.expression(depth - 1) for _ in range(self.chance.choice((1, 1, 2))))
            return f"{self.chance.choice(FUNCTIONS)}({many})"
        return f"(if {self.comparison(depth - 1)} then {self.expression(depth - 1)} else {self.expression(depth - 1)})"

    def quantity(self, unit: str) -> str:
        expression = self.expression()
        is_bare = unit in ("", "rad") or (self.is_wild and self.chance.random() < 0.1)
        return expression if is_bare else f"{expression}*1[{unit}]"

    def comparison(self, depth: int = 1) -> str:
        return f"{self.expression(depth)} {self.chance.choice(('<', '>', '<=', '>=', '==', '<>'))} {self.expression(depth)}"

    def value(self) -> str:
        return self.number() if self.chance.random() < (0.8 if self.is_wild else 0.95) else self.expression()

    def jointed_body(self) -> None:
        """A body on a joint, or floating."""
        kinds = {kind.name: kind for kind in library()}
        centre = ""
        if self.chance.random() < 0.85:
            joint = kinds[self.chance.choice(("Revolute", "Revolute", "Prismatic", "Planar", "Rolling"))]
            name = self.declare(joint, {joint.ports[0]: self.place()})
            centre = f"{name}.{joint.ports[1]}"
        body = kinds[self.chance.choice(("Body", "PointMass", "Bar", "Disc"))]
        given = {"center": centre or self.place()} if self.chance.random() < 0.9 else {}
        self.declare(body, given if centre else {})

    def component(self) -> None:
        """What ties or pushes at places that are there, and anything else of the library."""
        kind = self.chance.choice([kind for kind in library() if self.is_wild or (not kind.coordinates and kind.name != "Weld")])
        given = {port: self.place() for port in kind.ports if self.chance.random() < (0.97 if port != "center" else 0.5)}
        self.declare(kind, given, self.chance.choice((2, 3)) if self.chance.random() < 0.05 else 0)

    def declare(self, kind: Component, bound: dict[str, str], size: int = 0) -> str:
        """Ports as they are bound, parameters by numbers; a few modifications more."""
        name, each = self.name(), "each " if size else ""
        given = {port: f"{{{place}}}" if port == "pulley" else place for port, place in bound.items()}
        given |= {parameter: self.value() for parameter in kind.parameters if not self.is_wild or self.chance.random() < 0.97}
        if kind.open and self.chance.random() < 0.2:
            word = self.chance.choice(kind.open)
            given[word] = self.quantity(kind.units[word])
        for word in ("force", "torque", "normal", "x", "y", "of", "to", "s", "phi", "V", "D", "a", "b"):
            if word in kind.open and word not in given and kind.name not in ("Stop", "RoughStop", "TorsionStop"):
                is_vector = word == "force" and len(kind.ports) == 1
                is_place = word in ("of", "a", "b", "s", "phi") and self.coordinates and self.chance.random() < 0.9
                given[word] = (self.vector() if is_vector else self.chance.choice(self.coordinates) if is_place
                               else self.quantity(kind.units[word]))
        values = [f"{each}{word} = {value}" for word, value in given.items()]
        if kind.coordinates and self.chance.random() < 0.4:
            values.append(f"{each}{self.chance.choice(kind.coordinates)}(start = {self.number()}"
                          f"{self.chance.choice(('', '', ', fixed = true', ', fixed = false'))})")
        self.lines.append(f"{kind.name} {name}{f'[{size}]' if size else ''}({', '.join(values)});")
        element = f"{name}[1]" if size else name
        self.frames += [f"{element}.{port}" for port in kind.ports if port != "pulley"]
        for coordinate in kind.coordinates:
            self.coordinates.append(f"{element}.{coordinate}")
            self.pure.append(f"{element}.{coordinate}" + ("/1[m]" if kind.units[coordinate] == "m" else ""))
            self.pure.append(f"der({element}.{coordinate})" + ("/1[m/s]" if kind.units[coordinate] == "m" else "*1[s]"))
        return element

    def vector(self) -> str:
        return f"{{{self.quantity('N')}, {self.quantity('N')}}}" if self.chance.random() < 0.9 else self.expression()

    def user_function(self) -> None:
        self.before.append(f"function f input Real x; output Real y = if x > {self.number()} then "
                           f"{self.chance.choice(FUNCTIONS)}(x) "
                           f"else x^{self.number()}; end f;")
        self.numbers.append(f"f({self.chance.choice([*self.numbers, *self.pure])})")

    def own_coordinate(self) -> None:
        name = self.name()
        self.lines.append(f"coordinate Real {name}(start = {self.number()});")
        self.coordinates.append(name)
        self.pure.append(name)

    def own_energy(self) -> None:
        if self.coordinates:
            q = self.chance.choice(self.coordinates)
            self.before.append(f"model E Real of; Real rate = der(of); energy kinetic {self.number()}*rate^2/2; "
                               f"{self.chance.choice(('potential', 'dissipation', 'kinetic'))} {self.number()}*of^2; end E;")
            self.lines.append(f"E {self.name()}(of = {q});")

    def condition(self) -> None:
        target = self.chance.choice([*self.coordinates, "time"])
        body = f"reinit(der({target}), {self.chance.choice(('-0.5*', '0*', '2*'))}pre(der({target})))"
        if self.chance.random() < 0.1:
            body = f"{target} = {self.expression()}"
        self.equations.append(f"when {self.comparison()} then {body}; end when;")

    def equation(self) -> None:
        way = self.chance.random()
        if way < 0.4:
            self.equations.append(f"connect({self.place()}, {self.chance.choice([*self.frames, *self.coordinates])});")
        elif way < 0.6:
            self.equations.append(f"{self.chance.choice(self.frames)} = {self.place()};")
        else:
            self.equations.append(f"{self.expression(1)} = {self.expression()};")

    def loop(self) -> None:
        end = self.chance.choice(("2", "3", "0", self.number()))
        self.equations.append(f"for i in 1:{end} loop {self.expression(1)} = i*{self.expression()}; end for;")

    def start(self) -> None:
        self.initial.append(f"{self.expression(1)} = {self.expression(1)};")

    def output(self) -> None:
        name = self.name()
        self.lines.append(f"output Real {name} = {self.expression()};")
        self.numbers.append(name)

    def experiment(self) -> None:
        tolerance = self.chance.choice(("1e-6", "1e-3", self.number()))
        self.lines.append(f"annotation(experiment(StopTime = {self.number()}, Tolerance = {tolerance}));")

    def heir(self) -> None:
        """A model under the name that is extended."""
        base: Sequence[str] = [c.name for c in library()]
        self.before.append(f"model H extends {self.chance.choice(base)}; parameter Real extra = {self.number()}; end H;")
        self.lines.append(f"H {self.name()};")
