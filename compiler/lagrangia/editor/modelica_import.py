"""Modelica text -> Lagrangia text: names of the Modelica Standard Library that have a counterpart, by the words of the text.

Names, parameters, descriptions and comments stay as they are. Annotations of pictures go. What has no counterpart is left out, as
a comment, together with the equations that name it.
"""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path

from lagrangia.base.records import dataclass
from lagrangia.editor.modelica_arguments import WAY, arguments, is_said, without_idle, without_unknown
from lagrangia.language.component_library import library_package

_WORDS = re.compile(
    r'"(?:[^"\\]|\\.)*"|//[^\n]*|/\*.*?\*/|'
    r'[A-Za-z_]\w*(?:\s*\.\s*[A-Za-z_]\w*)*|\d[\d.]*(?:[eE][+-]?\d+)?|\s+|.', re.DOTALL)
UNITS = {
    "Angle": "Angle", "AngularVelocity": "AngularVelocity", "AngularAcceleration": "AngularAcceleration", "Length": "Length",
    "Distance": "Length", "Radius": "Length", "Diameter": "Length", "Height": "Length", "Position": "Position", "Area": "Area",
    "Volume": "Volume", "Velocity": "Velocity", "Acceleration": "Acceleration", "Mass": "Mass", "Density": "Density",
    "Inertia": "Inertia", "MomentOfInertia": "Inertia", "Force": "Force", "Torque": "Torque", "Frequency": "Frequency",
    "AngularFrequency": "AngularFrequency", "Time": "Time", "Energy": "Energy", "Power": "Power", "Pressure": "Pressure",
    "TranslationalSpringConstant": "Stiffness", "TranslationalDampingConstant": "Damping", "Current": "Current",
    "RotationalSpringConstant": "TorsionStiffness", "RotationalDampingConstant": "TorsionDamping", "Voltage": "Voltage",
    "ElectricCurrent": "Current", "ElectricPotential": "Voltage", "Temperature": "Temperature", "Momentum": "Momentum",
    "AngularMomentum": "AngularMomentum", "DimensionlessRatio": "Ratio", "Efficiency": "Ratio",
}
_UNIT_PACKAGES = ("Modelica.Units.SI", "Modelica.SIunits")
_WITHOUT_PACKAGES = (*_UNIT_PACKAGES, "Modelica.Constants", "Modelica.Math")  # inside, of what is known of them
_WARMING = {"Copper": "3.92e-3", "Aluminium": "4e-3", "Brass": "1.1e-3", "Bronze": "0.8e-3", "Zero": "0"}  # of resistances, 1/K
_FUNCTIONS = {"sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp", "log", "log10"}
_CONSTANTS = {"pi": "pi", "g_n": "9.80665", "e": "exp(1)"}
_CONVERSIONS = {  # what stands before the number that is converted
    "from_deg": "pi/180*", "to_deg": "180/pi*", "from_rpm": "pi/30*", "to_rpm": "30/pi*", "from_kmh": "1/3.6*", "to_kmh": "3.6*",
    "from_Hz": "2*pi*", "to_Hz": "0.5/pi*", "from_bar": "1e5*", "to_bar": "1e-5*", "from_degC": "273.15 + ",
    "to_degC": "-273.15 + ", "from_minute": "60*", "to_minute": "1/60*", "from_hour": "3600*", "to_hour": "1/3600*",
}
_CONVERTED = "#"  # stands before that, until its brackets are written
_INTERFACES = {"Flange_a": "Flange", "Flange_b": "Flange", "Support": "Flange", "PartialTwoFlanges": "TwoFlanges",
               "PartialCompliant": "Compliant", "PartialCompliantWithRelativeStates": "Compliant"}
_PACKAGES = frozenset("Rotational Translational Components Sources Sensors Interfaces Blocks Thermal Math Icons".split())
_OF_MECHANICS = ("Components", "Sources", "Sensors", "Interfaces")
_OF_BLOCKS = ("Sources", "Math", "Continuous", "Nonlinear", "Logical", "Tables")
_OLD_TABLES = {"CombiTable1D": "CombiTable1Dv"}  # as it was called before version 4
_SIGNALS = {"RealInput": "input Real", "RealOutput": "output Real"}  # of Modelica.Blocks.Interfaces
_SECTIONS = ("equation", "algorithm", "public", "protected")
_CLASSES = ("model", "class", "package", "block", "connector", "record")


@dataclass(frozen=True)
class Imported:
    """The text, and what was left out of it: statements in one line each, with what to write instead where that is known."""

    text: str
    left_out: tuple[str, ...]
    read: tuple[Path, ...] = ()  # files that it was made of, but the first


def imported(text: str) -> Imported:
    """A Modelica text in this language."""
    statements = list(_statements(_without_annotations(_WORDS.findall(text.removeprefix("\ufeff")))))
    aliases = dict(pair for statement in statements for pair in _aliases(statement))
    around = list(_around(statements[0])) if statements else []
    if around:  # in the library itself, whose outermost package imports it
        aliases.setdefault("SI", "Modelica.Units.SI")
    has_pi = "pi" not in aliases and any("pi" in _declared(told[1:], 0) for told in map(_told, statements))
    left, missing, out = list[str](), set[str](), list[str]()
    for statement in statements:
        meant = [_meaning(word, aliases, around) for word in statement]
        if out and _COMMENT_ENDS.search(out[-1]) and not _LINE_ENDS.match("".join(statement)):  # on the line of what is left out
            out.append("\n")
        first = next((k for k, word in enumerate(statement) if _is_name(word) and word not in _PREFIXES), None)
        told = " ".join("".join(statement).split())
        if first is not None and _goes(statement[first], told):
            out.append(_space(statement).rstrip(" \t"))
            continue
        written = None if missing & set(_heads(statement)) else _written(statement, meant, has_pi)
        if written is None:
            missing |= set(_declared(statement, first))
            instead = _instead(told)  # which is told once
            left.append(told if any(before.endswith(instead) for before in left) else told + instead)
            out.append(f"{_space(statement)}{_LEFT_OUT}{told}")
        else:
            left += written.left_out
            out.append(written.text)
    return Imported("".join(out).strip() + "\n", tuple(left))


def _written(statement: Sequence[str], meant: Sequence[str | None], has_pi: bool) -> Imported | None:
    """A statement in the words that are meant; None where one has no counterpart. `has_pi`: pi is a name of the text's own."""
    words = [f"{_MISSING}{word}" if name is None else name for name, word in zip(meant, statement, strict=True)]
    if any(_FLOW.search(word) for word in words):
        return None
    left = [*_held_temperatures(words), *_filtered(words)]
    if words == list(statement):
        return Imported("".join(words), tuple(left))
    if has_pi:
        words = [name if name == word else _PI.sub(repr(math.pi), name) for name, word in zip(words, statement, strict=True)]
    words = without_idle(words)  # whatever they are given
    converted = None if any(word.startswith(_MISSING) for word in words) else _converted(words)
    if converted is None:
        return None
    kept, unknown = without_unknown(converted)
    return None if any(word.startswith(WAY) for word in kept) else Imported("".join(kept), (*left, *unknown))


_LEFT_OUT = "// left out: "
_COMMENT_ENDS = re.compile(_LEFT_OUT + r".*\Z")
_LINE_ENDS = re.compile(r"[ \t]*(\r?\n|//|\Z)")
_MISSING = "?"  # stands before a name that has no counterpart
_PI = re.compile(r"(?<![\w.])pi\b")
_INSTEAD = {  # what a statement names that has no counterpart, and what to write
    r"\b(heatPort|internalHeatPort|Thermal)\b": "heat is not of this language: what a component turns into heat is its "
    "lossPower, as damper.lossPower; the account of energies counts it as dissipated, or as work",
    r"\bMultiBody\b": "frames, bodies and joints in space have names of their own here: lag help space",
    r"\bElectrical\b": "currents are not of this language: a torque or a force acts as a formula says, as Torque m(tau = k*i)",
    r"\bCombi(Time)?Table\w*": "table(x, ...) or table2(x, y, ...) of points or a file in a formula: lag help tables",
}


def _instead(told: str) -> str:
    """What to write for a statement that was left out, in brackets; nothing where that is not known."""
    return next((f" ({instead})" for name, instead in _INSTEAD.items() if re.search(name, told)), "")


def _held_temperatures(statement: Sequence[str]) -> list[str]:
    """That what brakes by eddy currents warms up, which changes how it brakes."""
    told = [word for word in _told(statement) if _is_name(word)]
    at = told.index("useHeatPort") if "useHeatPort" in told else len(told)
    if told[at + 1 : at + 2] == ["true"] and told[0].rpartition(".")[2] in ("EddyCurrentTorque", "EddyCurrentForce"):
        return [f"the heatPort of {told[1]} (its temperature stays T, which is 293.15 K unless it is given)"]
    return []


def _filtered(statement: Sequence[str]) -> list[str]:
    """That what moves as a filtered signal says moves as the signal itself."""
    told = [word for word in _told(statement) if _is_name(word)]
    is_exact = "exact" in told[:-1] and told[told.index("exact") + 1] == "true"
    if len(told) > 1 and told[0] in FILTERED and not is_exact:
        return [f"the filter of {told[1]} (it moves exactly as its signal says, as with exact = true)"]
    return []


FILTERED = frozenset(f"{package}.{name}" for package in ("Rotational", "Translational") for name in ("Position", "Speed"))


def without_leading_dots(text: str) -> str:
    """With spaces in place of dots before names that are looked for from outside of all classes: .Modelica.Constants.pi."""
    found, last = list[str](), ";"
    for word in _WORDS.findall(text):
        head, dot, rest = word.partition(".")
        is_leading = (dot and head.rstrip() in _BEFORE_NAMES) or (word == "." and not _is_name(last) and last not in (")", "]"))
        found.append(f"{head} {rest}" if is_leading else word)
        if not word.isspace():
            last = word
    return "".join(found)


_BEFORE_NAMES = frozenset("""extends import parameter constant input output final inner outer discrete redeclare replaceable each
    constrainedby public protected equation algorithm initial flow stream and or not if then else elseif in loop""".split())
_FLOW = re.compile(r"\.(flange\w*|support)\.(tau|f)$")  # what flows there, which is no variable here
_PREFIXES = frozenset("parameter constant input output final inner outer replaceable redeclare discrete".split())


def _goes(first: str, told: str) -> bool:
    """Whether a statement says nothing here: what it imports from is not, pictures are not read."""
    return (first == "import" and "Modelica" in told) or first == "within" or (first == "extends" and "Icons." in told)


def _is_name(word: str) -> bool:
    return word[:1].isalpha() or word[:1] == "_"


def _told(statement: Sequence[str]) -> list[str]:
    """Its words, without spaces and comments."""
    return [word for word in statement if is_said(word)]


def _space(statement: Sequence[str]) -> str:
    """What stands before it: lines and comments."""
    found = []
    for word in statement:
        if is_said(word):
            break
        found.append(word)
    return "".join(found)


def _without_annotations(words: Sequence[str]) -> list[str]:
    """Without them, but for experiment(...) of those of classes."""
    found, at = list[str](), 0
    while at < len(words):
        if words[at] != "annotation":
            found.append(words[at])
            at += 1
            continue
        end = _closing(words, at)
        kept = next((k for k in range(at, end) if words[k] == "experiment"), None)
        if kept is not None:
            found += ["annotation", "(", *words[kept : _closing(words, kept) + 1], ")"]
        else:
            while found and found[-1].isspace():
                found.pop()
            if found and found[-1] in (";", "equation", "algorithm"):  # of the class: its semicolon goes, too
                end = next(k for k in range(end, len(words)) if words[k] == ";")
        at = end + 1
    return found


def _closing(words: Sequence[str], at: int) -> int:
    """The bracket that closes the first one behind a place; the last word where none does."""
    depth = 0
    for k in range(at, len(words)):
        depth += (words[k] == "(") - (words[k] == ")")
        if words[k] == ")" and depth == 0:
            return k
    return len(words) - 1


def _statements(words: Sequence[str]) -> Iterator[list[str]]:
    """Up to each semicolon; heads of sections and classes by themselves."""
    current, depth = list[str](), 0
    for k, word in enumerate(words):
        current.append(word)
        depth += (word in ("(", "[", "{")) - (word in (")", "]", "}"))
        is_named = _opens_class(current) and not _description_follows(words, k)
        if (word == ";" and depth == 0) or word in _SECTIONS or is_named:
            yield current
            current = []
    if current:
        yield current


def _opens_class(statement: Sequence[str]) -> bool:
    """Whether it is `model Name`, perhaps with its description, and no short class."""
    told = [word for word in _told(statement) if word not in ("partial", "encapsulated", "final")]
    is_head = len(told) in (2, 3) and told[0] in _CLASSES and _is_name(told[1])
    return is_head and (len(told) == 2 or told[2].startswith('"'))


def _description_follows(words: Sequence[str], at: int) -> bool:
    following = next((word for word in words[at + 1 :] if is_said(word)), "")
    return following.startswith('"') or following == "="


def _aliases(statement: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Short names that an import gives: name, full name; of all of a package "*" and its name, and that name."""
    told = _told(statement)
    if told[:1] != ["import"]:
        return
    if "=" in told:
        yield told[1], told[3]
    elif "*" in told:
        yield f"*{told[1].rstrip('.')}", told[1].rstrip(".")
    elif "{" in told:
        package = told[1].rstrip(".")
        yield from ((name, f"{package}.{name}") for name in told[2:] if _is_name(name))
    else:
        yield told[1].rpartition(".")[2], told[1]


def _around(first: Sequence[str]) -> Iterator[str]:
    """The packages of the library that the text stands in, as its first statement says, the innermost first."""
    told = [re.sub(r"\s", "", word) for word in _told(first)]
    package = told[1] if told[:1] == ["within"] and told[1].startswith("Modelica") else ""
    while package:
        yield package
        package = package.rpartition(".")[0]


def _meaning(word: str, aliases: Mapping[str, str], around: Sequence[str]) -> str | None:
    """A word in this language; None where a name of the Modelica Standard Library has no counterpart."""
    if not _is_name(word):
        return word
    name = re.sub(r"\s", "", word)
    head, dot, rest = name.partition(".")
    if head in aliases and aliases[head].startswith("Modelica"):
        name = aliases[head] + dot + rest
    elif not dot:
        packages = [full for short, full in aliases.items() if short.startswith("*") and full.startswith("Modelica")]
        return next((found for full in packages if (found := _in_package(full, name)) is not None), word)
    if name.startswith("Modelica."):
        return _of_library(name)
    packages = [*around, *(full for short, full in aliases.items() if short.startswith("*") and full.startswith("Modelica"))]
    found = next((found for package in packages if (found := _in_package(package, name)) is not None), word)
    return None if found == word and packages and head in _PACKAGES else found


def _in_package(package: str, name: str) -> str | None:
    """A name as one of a package of the library; None where it has no counterpart, or is none that the package is known for."""
    if (package in _WITHOUT_PACKAGES and "." in name) or (package in _UNIT_PACKAGES and name not in UNITS):
        return None
    return _of_library(f"{package}.{name}")


def _of_library(name: str) -> str | None:
    """A full name in this language; None where it has no counterpart."""
    parts = name.split(".")
    last = parts[-1]
    if parts[-2] == "Conversions" and parts[1] in ("Units", "SIunits"):
        return _CONVERTED + _CONVERSIONS[last] if last in _CONVERSIONS else None
    if parts[1:3] == ["Blocks", "Types"] and parts[3:4] and parts[3] in ("Init", "Extrapolation", "Smoothness"):
        return f"{WAY}{parts[3]}.{last}" if len(parts) == 5 else None
    if parts[1:4] == ["Blocks", "Types", "SimpleController"] and len(parts) == 5:
        return f"Blocks.SimpleController.{last}"
    if parts[1:3] == ["Blocks", "Interfaces"]:
        return _SIGNALS.get(last)
    if parts[1:3] == ["Units", "SI"] or parts[1] == "SIunits":
        return UNITS.get(last, "Real")
    if parts[1] == "Math":
        return last if last in _FUNCTIONS else None
    if parts[1:5] == ["Electrical", "Machines", "Thermal", "Constants"]:
        return _WARMING.get(last.removeprefix("alpha20"))
    if parts[1] == "Constants":
        return _CONSTANTS.get(last)
    if (parts[1], len(parts)) not in (("Mechanics", 5), ("Blocks", 4)):
        return None
    package, kinds = ("Blocks", _OF_BLOCKS) if parts[1] == "Blocks" else (parts[2], _OF_MECHANICS)
    if parts[-2] not in kinds:
        return None
    last = (_INTERFACES if package != "Blocks" else _OLD_TABLES).get(last, last)
    return f"{package}.{last}" if last in _classes_of(package) else None


@cache
def _classes_of(package: str) -> frozenset[str]:
    found = library_package(package)
    return frozenset(inner.name for outer in found.classes for inner in outer.classes) if found is not None else frozenset()


def _converted(words: Sequence[str]) -> list[str] | None:
    """With conversions of units written out, in brackets: (pi/180*(30)) for from_deg(30). None for one of no single number."""
    found = list(words)
    for k, word in enumerate(words):
        if not word.startswith(_CONVERTED):
            continue
        opening = next((j for j in range(k + 1, len(words)) if is_said(words[j])), len(words))
        spans = arguments(words, opening) if words[opening : opening + 1] == ["("] else []
        told = [_told(words[first:last]) for first, last in spans]
        if len(told) != 1 or not told[0] or (told[0][1:2] == ["="] and told[0][2:3] != ["="]):  # from_deg(u = 30)
            return None
        found[k] = f"({word.removeprefix(_CONVERTED)}"
        found[spans[0][1]] += ")"
    return found


def _heads(statement: Sequence[str]) -> Iterator[str]:
    """The first part of each name."""
    return (re.split(r"\s*\.", word)[0] for word in statement if _is_name(word))


def _declared(statement: Sequence[str], first: int | None) -> list[str]:
    """The components that a declaration declares: names outside of brackets behind its type."""
    found, depth, is_name = list[str](), 0, True
    for word in statement[(first if first is not None else -1) + 1 :]:
        depth += word in ("(", "[", "{")
        depth -= word in (")", "]", "}")
        if depth == 0 and _is_name(word) and is_name:
            found.append(word)
            is_name = False
        is_name = is_name or (word == "," and depth == 0)
    return found
