"""Each phase's product as text, for --dump and for the golden files of the tests."""

from collections.abc import Callable, Mapping
from typing import Any

from lagrangia.base.diagnostics import fail
from lagrangia.compile.pipeline import PHASES, Compilation
from lagrangia.language.tree import (
    Array,
    Binary,
    Boolean,
    Call,
    EnumerationLiteral,
    Flat,
    FrameRef,
    IfExpression,
    Local,
    Number,
    Ref,
    String,
    Time,
    Unary,
)
from lagrangia.native.c_code import write_c

_LONGEST = 400


def dump(compilation: Compilation, phase: str) -> str:
    """Raises LagError L0705 for an unknown phase."""
    if phase not in _DUMPS:
        fail("L0705", f"there is no phase '{phase}'", None, f"the phases are {', '.join(PHASES)}")
    return _DUMPS[phase](compilation)


def _syntax(compilation: Compilation) -> str:
    return "\n".join(_tree(definition, 0) for definition in compilation.syntax.classes)


def _tree(node: Any, depth: int) -> str:
    """A node a line, its fields indented; spans are left out."""
    indent = "  " * depth
    if isinstance(node, tuple):
        return "\n".join(_tree(item, depth) for item in node)
    if not hasattr(node, "__dataclass_fields__"):
        return f"{indent}{node!r}"
    lines, plain = [], []
    for name in node.__dataclass_fields__:
        value = getattr(node, name)
        if name.endswith("span") or value in ((), None, "", frozenset(), False):
            continue
        if isinstance(value, tuple) or hasattr(value, "__dataclass_fields__"):
            lines.append(f"{indent}  {name}:\n{_tree(value, depth + 2)}")
        else:
            plain.append(f"{name}={sorted(value) if isinstance(value, frozenset) else value!r}")
    head = f"{indent}{type(node).__name__}({', '.join(plain)})"
    return "\n".join([head, *lines])


def _flat(compilation: Compilation) -> str:
    model = compilation.flat
    lines = [f"model {model.name}"]
    lines += [f"structural {name} = {value:g}" if isinstance(value, float) else f"structural {name} = {value}"
              for name, value in model.structural.items()]
    for variable in model.variables.values():
        size = f"[{', '.join(map(str, variable.shape))}]" if variable.shape else ""
        unit = f" [{variable.unit}]" if variable.unit else ""
        bound = f" = {_text(variable.binding)}" if variable.binding is not None else ""
        start = f", start {_text(variable.start)}" if variable.start is not None else ""
        lines.append(f"{'output ' if variable.is_output else ''}{variable.kind} {variable.name}{size}{unit}{bound}{start}")
    lines += [f"frame {name}" + (" (ground)" if frame.is_ground else "") for name, frame in model.frames.items()]
    lines += [f"{_text(e.left)} = {_text(e.right)}" for e in model.frame_equations]
    lines += [f"{_text(e.left)} = {_text(e.right)}" for e in model.constraints]
    lines += [f"{e.kind} {e.component}: {_text(e.value)}" for e in model.energies]
    lines += [f"work {w.component}: {_text(w.force)} on {_text(w.position)}" for w in model.works]
    for when in model.whens:
        resets = "; ".join(f"{_text(reset.rate)} becomes {_text(reset.value)}" for reset in when.resets)
        lines.append(f"when {_text(when.condition)}: {resets}")
    lines += [f"initially {_text(e.left)} = {_text(e.right)}" for e in model.initial_equations]
    return "\n".join(lines)


def _text(node: Flat) -> str:
    """A flat expression with resolved names."""
    match node:
        case Ref() | FrameRef():
            return str(node)
        case Number(value):
            return f"{value:g}"
        case Boolean(value) | String(value):
            return repr(value)
        case EnumerationLiteral(type_name, name):
            return f"{type_name}.{name}"
        case Time():
            return "time"
        case Local(name):
            return name
        case Unary(operator, operand):
            return f"not {_text(operand)}" if operator == "not" else f"-{_text(operand)}"
        case Binary(operator, left, right):
            return f"({_text(left)} {operator} {_text(right)})"
        case IfExpression(condition, then, otherwise):
            return f"(if {_text(condition)} then {_text(then)} else {_text(otherwise)})"
        case Array(items):
            return "{" + ", ".join(map(_text, items)) + "}"
        case Call(function, arguments):
            return f"{function}({', '.join(map(_text, arguments))})"


def _graph(compilation: Compilation) -> str:
    return compilation.graph.summary()


def _kinematics(compilation: Compilation) -> str:
    kinematics = compilation.kinematics
    lines = []
    for name in compilation.flat.frames:
        if name in compilation.graph.unused_frames:
            continue
        parts = ((attribute, kinematics.frame(name, attribute, 0)) for attribute in kinematics.graph.model.space.whole_motion)
        lines.append(f"{name}: " + ", ".join(f"{attribute} = {_components(value)}" for attribute, value in parts))
    return "\n".join(lines)


def _components(value: Any) -> str:
    return f"({', '.join(map(_components, value))})" if isinstance(value, tuple) else _short(value)


def _energies(compilation: Compilation) -> str:
    energies = compilation.energies
    lines = []
    for symbol, terms in (("T", energies.kinetic), ("V", energies.potential), ("D", energies.dissipation)):
        lines += [f"{symbol} {term.component}: {_short(term.value)}" for term in terms]
    for load in energies.loads:
        force, position = (", ".join(map(_short, x)) for x in (load.force, load.position))
        lines.append(f"f {load.statement.component}: ({force}) on ({position})")
    return "\n".join(lines)


def _motion(compilation: Compilation) -> str:
    from lagrangia.dynamics.motion import mass_matrix

    motion = compilation.motion
    n = motion.q.numel()
    ways = ", ".join(f"{way} {count} operations" for way, count in motion.nodes.items())
    lines = [f"{n} coordinates; accelerations: {motion.way}, {ways}"]
    if n <= 12:
        M = mass_matrix(motion)
        lines += [f"M[{i + 1},{j + 1}] = {_short(M[i, j])}" for i in range(n) for j in range(i + 1) if M.sparsity().has_nz(i, j)]
    lines += [f"h[{k + 1}] = {_short(motion.h[k])}" for k in range(min(n, 50))]
    return "\n".join(lines)


def _needs(compilation: Compilation) -> str:
    from lagrangia.needs.table import find_needs

    c = compilation
    needs = find_needs(c.kinematics, c.constraints, c.energies, c.run, c.initial, c.scene)
    return "\n".join(f"{need.what:22} {'yes' if need.is_needed else 'no ':3}  {need.why}" for need in needs)


def _c(compilation: Compilation) -> str:
    scene = compilation.scene
    return write_c(scene.name, scene.sizes, scene.tapes, scene.coordinate_kind, scene.fixed, scene.event_kind, scene.patterns)


def _short(value: Any) -> str:
    text = str(value)
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}... ({len(text)} characters)"


_DUMPS: Mapping[str, Callable[[Compilation], str]] = {
    "syntax": _syntax, "flat": _flat, "graph": _graph, "kinematics": _kinematics, "energies": _energies, "motion": _motion,
    "needs": _needs, "c": _c,
}
