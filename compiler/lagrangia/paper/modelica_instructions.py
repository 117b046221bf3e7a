"""Instructions -> a flat Modelica model, of scenes whose equations are too large to be written out: a variable an instruction.

Trees give their accelerations. What is constrained has M a + h + J^T lambda = 0 and the constraints differentiated twice, which
mu closes as in `modelica`: s = v + J^T mu are the rates of positions.
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any

from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.compile.statements import entries_read, statements, texts_of
from lagrangia.language.flat import FlatModel
from lagrangia.paper.layout import Name
from lagrangia.paper.modelica import RESERVED, closing_line, experiment_line, identifier, output_line, quoted, unit_of
from lagrangia.paper.notation import Wanted, name_all
from lagrangia.paper.turnings import turnings_of
from lagrangia.run.scene import Scene

_MOST, _NOTHING = 100_000, "0.0"  # instructions; an entry that is 0
_TRUE = {"LT": "{0} < {1}", "LE": "{0} <= {1}", "EQ": "{0} <= {1} and {0} >= {1}", "NE": "{0} < {1} or {0} > {1}",
         "AND": "noEvent(abs({0}) > 0 and abs({1}) > 0)", "OR": "noEvent(abs({0}) > 0 or abs({1}) > 0)",
         "NOT": "not noEvent(abs({0}) > 0)"}
_TEXTS = texts_of({
    "ASSIGN": "{0}", "ADD": "{0} + {1}", "SUB": "{0} - {1}", "MUL": "{0}*{1}", "DIV": "{0}/{1}", "NEG": "-{0}", "SQ": "{0}*{0}",
    "TWICE": "2*{0}", "INV": "1/{0}", "POW": "{0}^{1}", "CONSTPOW": "{0}^{1}", "FMIN": "min({0}, {1})", "FMAX": "max({0}, {1})",
    "ATAN2": "atan2({0}, {1})", "FMOD": "rem({0}, {1})", "HYPOT": "sqrt({0}*{0} + {1}*{1})", "FABS": "abs({0})",
    "COPYSIGN": "if {1} >= 0 then abs({0}) else -abs({0})", "IF_ELSE_ZERO": "if noEvent(abs({0}) > 0) then {1} else 0",
    "ASINH": "log({0} + sqrt({0}*{0} + 1))", "ACOSH": "log({0} + sqrt({0}*{0} - 1))", "ATANH": "log((1 + {0})/(1 - {0}))/2",
    **{name: f"{name.lower()}({{0}})" for name in
       "SQRT SIN COS TAN ASIN ACOS ATAN SINH COSH TANH EXP LOG SIGN FLOOR CEIL".split()},
    **{name: f"if {text} then 1 else 0" for name, text in _TRUE.items()}})


@dataclass(frozen=True)
class _Names:
    """Identifiers in the order of the functions' arguments, parameters by their places; those of multipliers, and of rates of
    positions, by their places as well."""

    q: list[str]
    v: list[str]
    a: list[str]
    u: list[str]
    p: Mapping[int, str]
    forces: Mapping[int, str]  # lambda
    closers: Mapping[int, str]  # mu
    paces: list[str]  # s
    outputs: Mapping[str, str]
    closing: str
    taken: frozenset[str]

    @property
    def prefix(self) -> str:
        """Which no other one begins with, but for a number behind it."""
        found = "x"
        while any(name.startswith(found) and name[len(found) :].isdigit() for name in self.taken):
            found += "_"
        return found


def write_instructions(function: Any, scene: Scene, flat: FlatModel, values: Mapping[str, float], left_out: Collection[int],
                       chosen: Mapping[str, str], remarks: Iterable[str] = ()) -> str:
    """`function`: as compile.people_functions.flat_function makes it; `values`: of parameters, inputs and the assembled start by
    their names; `left_out`: the places of constraints that repeat others; `chosen`: names on paper by names of the model.

    Raises LagError L0711 for names, L0712 for more than 100 000 instructions, L0901 for what Modelica has no words for.
    """
    names = _named(function, scene, flat, left_out, chosen)
    p = [names.p.get(k, "") for k in range(len(scene.parameters))]
    arguments = [["time"], names.q, names.v, names.u, p, names.paces]
    try:
        steps, results = statements(function, [entries.__getitem__ for entries in arguments], _TEXTS, names.prefix)
    except NotImplementedError as error:
        fail("L0901", f"not supported yet: {error} in the export to modelica", flat.span, "--to fmu and --to casadi have it")
    if len(steps) > _MOST:
        fail("L0712", f"the equations are too large to be written out: {len(steps)} operations", flat.span,
             f"at most {_MOST}; --to casadi and --to fmu take any scene")
    entries = dict(zip(function.name_out(), results, strict=True))
    told, lost = _outputs(scene, flat, names, entries["outputs"])
    remarks = [*([f"outputs are not written: {', '.join(lost)}"] if lost else []), *remarks]
    lines = [f"model {identifier(flat.name)}{quoted(flat.description)}", *(f"  // {remark}" for remark in remarks)]
    lines += [*_declarations(scene, names, values), *told, "protected"]
    lines += [f"  Real {x};" for x in names.paces if x not in names.v]
    lines += [f"  Real {names.prefix}{k} annotation(HideResult = true);" for k in range(len(steps))]
    lines += ["equation", *(f"  {step};" for step in steps), *(f"  {x};" for x in _equations(scene, names, entries))]
    return "\n".join([*lines, experiment_line(flat), f"end {identifier(flat.name)};"])


def _named(function: Any, scene: Scene, flat: FlatModel, left_out: Collection[int], chosen: Mapping[str, str]) -> _Names:
    taken = {*RESERVED}

    def new(wanted: str) -> str:
        found = identifier(wanted)
        while found in taken:
            found += "_"
        taken.add(found)
        return found

    coordinates = [x.name for x in scene.coordinates]
    turnings = turnings_of(scene.attitudes, coordinates, {*flat.variables, *coordinates})
    rates = {k: name for turning in turnings for k, name in zip(turning.places, turning.told, strict=True)}
    parts = {f"{turning.name}[{k}]": name for turning in turnings for k, name in enumerate(turning.quaternion, 1)}
    positions, inputs = [parts.get(x.name, x.name) for x in scene.told_positions], [x.name for x in scene.inputs]
    parameters = {k: scene.parameters[k].name for k in entries_read(function, 4)}
    wanted = [*positions, *rates.values(), *parameters.values(), *inputs]
    on_paper = name_all([Wanted(name) for name in wanted], chosen, [Name("t")])
    spelt = {name: new("_".join(filter(None, (on_paper[name].base, on_paper[name].sub)))) for name in wanted}
    v = [spelt[rates[k]] if k in rates else new(f"{spelt[name]}_d") for k, name in enumerate(coordinates)]
    a = [new(f"{x}_d" if k in rates else f"{x}d") for k, x in enumerate(v)]
    rows, holonomic = (function.size1_out("J"), function.numel_out("Phi")) if "J" in function.name_out() else (0, 0)
    kept = [k for k in range(rows) if k not in left_out]
    forces = {k: new(f"lambda_{i}") for i, k in enumerate(kept, 1)}
    closers = {k: new(f"mu_{i}") for i, k in enumerate(kept, 1) if k < holonomic}
    paces = [new(f"{x}_s") for x in v] if closers else v
    outputs = {x.name: new(x.name) for x in flat.variables.values() if x.is_output}
    return _Names([spelt[name] for name in positions], v, a, [spelt[name] for name in inputs],
                  {k: spelt[name] for k, name in parameters.items()}, forces, closers, paces, outputs, new("closing"),
                  frozenset(taken))


def _declarations(scene: Scene, names: _Names, values: Mapping[str, float]) -> Iterator[str]:
    """Of parameters, inputs, states with their starts, accelerations and multipliers."""
    for k, name in names.p.items():
        p = scene.parameters[k]
        yield f"  parameter Real {name}{unit_of(p.unit)} = {values[p.name]!r}{quoted(p.description)};"
    for name, u in zip(names.u, scene.inputs, strict=True):
        yield f"  input Real {name}(start = {values[u.name]!r}); // {u.name}"
    for name, x in zip((*names.q, *names.v), (*scene.told_positions, *scene.rates), strict=True):
        unit = unit_of("" if x.unit == "1" else x.unit)[1:-1]
        yield f"  Real {name}(start = {values[x.name]!r}, fixed = true{f', {unit}' if unit else ''}){quoted(x.name)};"
    for name in (*names.a, *names.forces.values(), *names.closers.values()):
        yield f"  Real {name};"
    if names.forces or scene.attitudes:
        yield closing_line(names.closing)


def _outputs(scene: Scene, flat: FlatModel, names: _Names, entries: Sequence[str]) -> tuple[list[str], list[str]]:
    """Declarations of the outputs, and the names of matrices."""
    known = dict(zip((x.name for x in scene.outputs), entries, strict=True))
    declared = [x for x in flat.variables.values() if x.is_output]
    told = [output_line(x, names.outputs[x.name], [known[label] for label, _ in x.elements()]) for x in declared
            if len(x.shape) <= 1]
    return [f"  {line}" for line in told], [x.name for x in declared if len(x.shape) > 1]


def _equations(scene: Scene, names: _Names, entries: Mapping[str, list[str]]) -> Iterator[str]:
    """How states change, and what gives accelerations, multipliers and paces."""
    for x, a in zip(names.v, names.a, strict=True):
        yield f"der({x}) = {a}"
    attitudes = {f"{name}[{k}]": name for name in scene.attitudes for k in range(1, 5)}
    told = [x.name for x in scene.told_positions]
    for x, source, rate in zip(names.q, told, entries["turning"], strict=True):
        parts = [y for y, other in zip(names.q, told, strict=True) if attitudes.get(source, source) == attitudes.get(other)]
        gap = f" + {names.closing}*(1 - {' - '.join(f'{y}*{y}' for y in parts)})/2*{x}" if parts else ""
        yield f"der({x}) = {rate}{gap}"
    if "rhs" in entries:
        yield from (f"{a} = {x}" for a, x in zip(names.a, entries["rhs"], strict=True))
    else:
        yield from _constrained(names, entries)


def _constrained(names: _Names, entries: Mapping[str, list[str]]) -> Iterator[str]:
    """M a + h + J^T lambda = 0 and what the constraints say of accelerations and paces."""
    n, m = len(names.v), len(entries["bias"])
    M, J = _rows(entries["M"], n, n), _rows(entries["J"], m, n)
    for k in range(n):
        forces = _products([J[row][k] for row in names.forces], names.forces.values())
        yield f"{_sum([*_products(M[k], names.a), entries['h'][k], *forces])} = 0"
    for row in names.forces:
        yield f"{_sum([*_products(J[row], names.a), entries['bias'][row]])} = -{names.closing}*{entries['rate'][row]}"
    for k, x in enumerate(names.paces if names.closers else []):
        steps = _products([J[row][k] for row in names.closers], names.closers.values())
        yield f"{x} = {_sum([names.v[k], *steps])}"
    moved = [f"({s} - {v})" for s, v in zip(names.paces, names.v, strict=True)]
    for row in names.closers:
        gaps = _products(J[row], moved)
        yield f"{_sum([entries['rate'][row], *gaps])} = -{names.closing}*{entries['Phi'][row]}"


def _rows(entries: Sequence[str], m: int, n: int) -> list[list[str]]:
    """Of a matrix (m, n), from its columns."""
    return [[entries[i + j * m] for j in range(n)] for i in range(m)]


def _products(factors: Iterable[str], others: Iterable[str]) -> list[str]:
    return [y if x == "1.0" else f"{x}*{y}" for x, y in zip(factors, others, strict=True) if x != _NOTHING]


def _sum(terms: Iterable[str]) -> str:
    return " + ".join(x for x in terms if x != _NOTHING) or _NOTHING
