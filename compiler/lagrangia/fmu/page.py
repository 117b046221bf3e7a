"""documentation/index.html of an FMU: what it is, its variables, its equations when they can be read, its component graph."""

from html import escape

from lagrangia.fmu.entries import entries
from lagrangia.fmu.variable import Variable
from lagrangia.fmu.variables import FmuModel
from lagrangia.fmu.xml import About

_GROUPS = (("parameter", "Parameters", "what the model is made of; those without a value follow from others"),
           ("input", "Inputs", "given from outside"), ("output", "Outputs", "reported"),
           ("state", "States", "coordinates and their rates"), ("energy", "Energies", "the energy account"),
           ("real", "Constants", "compiled in"))
_STYLE = ("body{font-family:sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color:#222}table{border-collapse:collapse}"
          "td,th{border-bottom:1px solid #ddd;padding:.2em .8em;text-align:left}pre{background:#f6f6f6;padding:1em;"
          "overflow:auto}")


def write_page(model: FmuModel, about: About, equations: str, graph: str) -> str:
    """`equations` as text, empty when the scene is too large to read; `graph` as SVG."""
    scene = model.scene
    parts = [f"<h1>{escape(scene.name)}</h1>", f"<p>{escape(scene.description)}</p>",
             f"<p>{scene.n} coordinates; {scene.start:g} to {scene.stop:g} s, tolerance {scene.tolerance:g}. Units are SI. "
             "Co-Simulation steps by the model's own solver; parameters may be changed while it runs. "
             f"Made by {escape(about.tool)}; the model's source is in extra/.</p>"]
    for group, title, text in _GROUPS:
        variables = model.of(group)
        if variables:
            parts += [f"<h2>{title}</h2><p>{text}</p>", _table(variables)]
    if equations:
        parts += ["<h2>Equations of motion</h2>", f"<pre>{escape(equations)}</pre>"]
    parts += ["<h2>Component graph</h2><p>Frames; blue: rigidly connected, orange: joints with their coordinates.</p>", graph]
    head = f'<head><meta charset="utf-8"><title>{escape(scene.name)}</title><style>{_STYLE}</style></head>'
    return "\n".join(['<!DOCTYPE html>', f'<html lang="en">{head}<body>', *parts, "</body></html>", ""])


def _table(variables: tuple[Variable, ...]) -> str:
    rows = ["<tr><th>name</th><th>value</th><th>unit</th><th>what it is</th></tr>"]
    for v in variables:
        value = "" if v.start is None else f"{v.start:g}" if isinstance(v.start, float) else str(v.start)
        cells = (v.name, value, v.unit if v.unit != "1" else "", v.description)
        rows.append("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>")
    return "<table>" + "\n".join(rows) + "</table>"


def license_text(about: About, has_windows: bool) -> str:
    """What the licence of the model is, and those of what is compiled into its binaries."""
    own = about.info.get("license", "The licence of the model is its author's to choose.")
    text = f"{own}\n\nThe run time in sources/ and binaries/ is Lagrangia's, under the MIT licence.\n"
    if has_windows:
        text += ("\nThe Windows binary contains start-up code of mingw-w64 (Zope Public License 2.1, public domain):\n"
                 "This software is provided by the copyright holders and contributors \"as is\" and any express or implied "
                 "warranties are disclaimed.\nhttps://www.mingw-w64.org\n")
    return text


def write_terminals(model: FmuModel) -> str:
    """FMI 3: the icon, and a terminal for each component that has both inputs and outputs: its flange."""
    members: dict[str, list[Variable]] = {}
    for variable in (entry.variable for entry in entries(model)):
        component, dot, _name = variable.name.rpartition(".")
        if variable.group not in ("input", "output"):
            continue
        if dot:
            members.setdefault(component, []).append(variable)
    flanges = {name: found for name, found in members.items() if {v.group for v in found} == {"input", "output"}}
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', '<fmiTerminalsAndIcons fmiVersion="3.0">', "  <GraphicalRepresentation>",
             '    <CoordinateSystem x1="-100" y1="-100" x2="100" y2="100" suggestedScalingFactorTo_mm="0.1"/>',
             '    <Icon x1="-100" y1="-100" x2="100" y2="100"/>', "  </GraphicalRepresentation>"]
    if flanges:
        lines.append("  <Terminals>")
        for name, found in flanges.items():
            lines.append(f'    <Terminal name="{escape(name)}" matchingRule="bus" terminalKind="mechanical flange">')
            short = {v.name: v.name.rpartition(".")[2] for v in found}
            lines += [f'      <TerminalMemberVariable variableName="{escape(long)}" memberName="{escape(member)}"'
                      ' variableKind="signal"/>' for long, member in short.items()]
            lines.append("    </Terminal>")
        lines.append("  </Terminals>")
    return "\n".join([*lines, "</fmiTerminalsAndIcons>", ""])
