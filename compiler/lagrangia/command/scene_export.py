"""`lag export`: a scene as Python with NumPy alone, a serialised CasADi file, a flat Modelica model, SymPy, LaTeX."""

import re
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lagrangia.algebra.lookup_functions import MOST_WRITTEN
from lagrangia.base.diagnostics import Diagnostic, LagError, fail, suggest
from lagrangia.base.result_files import Target, keep_apart, write_text
from lagrangia.base.spelling import python_text
from lagrangia.constraints.parameters import parameters_of
from lagrangia.dynamics.switches import bends
from lagrangia.language.delays import refuse_delays
from lagrangia.language.flat import Guard
from lagrangia.language.samplers import refuse_held
from lagrangia.needs.origins import place_of_moving_support
from lagrangia.run.request import USUAL
from lagrangia.study.small_motion import build_small_motion

if TYPE_CHECKING:
    from lagrangia.dynamics.freedom import Freedom
    from lagrangia.model import Model

TARGETS = {"sympy": ".py", "latex": ".tex", "python": ".py", "casadi": ".casadi", "modelica": ".mo"}
_FEW, _LARGE = 4, 5_000_000  # names that are told; characters of a file whose size is
_LOST, STARTS = "outputs are not written: ", "starts are those of"
_INSTRUCTIONS = "by instructions, as the equations are too large to be read; --components has joints and bodies in their place"
_MATRICES = ("M", "J", "jacobian", "jacobian_u", "jacobian_p")
_ARGUMENTS = {"t": "t", "q": "q[{}]", "v": "v[{}]", "u": "u[{}]", "p": "p[{}]"}
_WORDS = {
    "M": "Mass matrix (n, n): M dv/dt + h + J^T lambda = 0.", "h": "(n,): M dv/dt + h + J^T lambda = 0.",
    "rhs": "Accelerations dv/dt, (n,).", "energies": "T, V and D.", "outputs": "OUTPUTS.",
    "jacobian": "d(dv/dt)/d(q, v), (n, 2 n).", "jacobian_u": "d(dv/dt)/du, (n, len(INPUTS)).",
    "jacobian_p": "d(dv/dt)/dp, (n, len(PARAMETERS)): through what follows, and 0 for its own entries.",
    "Phi": "Holonomic constraints, zero on the motion.", "J": "dPhi/dq, (m, n).",
    "turning": "dq/dt, where q has unit quaternions of attitudes, real parts first.",
    "bias": "(m,): J dv/dt + bias = 0.", "lambda": "Multipliers, (m,).",
}


def export(model: "Model", target: str, path: Path, names: Mapping[str, str] | None = None, force: bool = False) -> str:
    """Writes the file; returns what to say of it.

    Raises LagError: L0704 for an unknown target, L0712 for a scene too large, L0909 for one whose supports' rates jump.
    """
    _require_target(target)
    keep_apart([path], [model.path, *model.scene.notes["files"]])
    if target == "casadi":
        require_smooth(model, target)
        count = _write_casadi(model, path)
        told = f"{path}: {count} CasADi functions; casadi.FileDeserializer('{path}').unpack() is a list of them"
    else:
        text = exported_text(model, target, names, force)
        write_text(path, text)
        told = "; ".join([f"{path}: {_size(text)}", *re.findall(rf"^  // ((?:{_LOST}|{_INSTRUCTIONS}).*)$", text, re.MULTILINE)])
    return "; ".join([told, *(_starts_told(model) if target in ("python", "casadi", "modelica") else [])])


def _size(text: str) -> str:
    """In megabytes, too, where editors and importers will feel it."""
    megabytes = f", {len(text) / 1e6:.0f} MB" if len(text) > _LARGE else ""
    return f"{text.count(chr(10))} lines{megabytes}"


def exported_text(model: "Model", target: str, names: Mapping[str, str] | None = None, force: bool = False) -> str:
    """What the file would hold. Raises LagError L0704 for a target that is no text."""
    _require_target(target)
    if target == "casadi":
        fail("L0704", "an export to 'casadi' is no text: it cannot go to standard output", None, "give a file with -o")
    if target in ("python", "modelica"):
        require_smooth(model, target)
    text = {"python": _python, "modelica": _modelica}.get(target, _page)(model, target, names or {}, force)
    if target == "sympy":
        text = "".join(f"# {remark}\n" for remark in remarks(model, target)) + text
    return text if text.endswith("\n") else text + "\n"


def _require_target(target: str) -> None:
    if target not in TARGETS:
        fail("L0704", f"there is no export to '{target}'", None, *filter(None, [suggest(target, TARGETS)]),
             f"the targets are {', '.join(TARGETS)}")


def require_smooth(model: "Model", target: str) -> None:
    """Raises LagError L0909 where impulses act, which right-hand sides do not tell of."""
    compilation = model.compilation
    refuse_held(compilation.flat, f"the export to {target}")
    refuse_delays(compilation.flat, f"the export to {target}")
    if target == "python":
        _refuse_long_tables(model, target)
    if whens := [when for when in compilation.flat.whens if when.resets]:
        fail("L0909", f"not supported yet: to export to {target} a scene in which {compilation.flat.set_at_events} at events",
             whens[0].span, "an FMU has the events: --to fmu")
    if "kick" in compilation.functions.table:
        fail("L0909", f"not supported yet: to export a scene to {target} whose supports jump, or their rates",
             place_of_moving_support(compilation.kinematics), "an FMU takes the impulses into account: --to fmu",
             "or let the support start and stop smoothly")


def _refuse_long_tables(model: "Model", target: str) -> None:
    if long := [table for table in model.scene.tables if table.n > MOST_WRITTEN]:
        fail("L0901", f"not supported yet: the table '{long[0].name}' of {long[0].n} points in the export to {target}", None,
             f"it writes tables of at most {MOST_WRITTEN} points out; --to casadi and --to fmu look up what is longer")


def export_warnings(model: "Model", target: str) -> list[Diagnostic]:
    """What the scene means and the export cannot keep: friction that sticks, and events, where they are not refused."""
    c = model.compilation
    events = [Diagnostic("warning", "L0741", f"the event '{when.condition.span.text}' is left out of the export to {target}, "
                         "whose equations hold between events", when.span, "", ("an FMU has the events: --to fmu",))
              for when in c.flat.whens if target == "sympy" and when.resets]
    if target not in ("python", "casadi", "modelica", "sympy"):
        return events
    alike: dict[str, list[Guard]] = {}  # as those of each component of a class
    for guard in c.flat.guards:
        alike.setdefault(guard.condition.span.text, []).append(guard)
    for text, guards in alike.items():
        names = [*dict.fromkeys(guard.component for guard in guards if guard.component)] if len(guards) > 1 else []
        events.append(Diagnostic("warning", "L0741", f"'{text}', which ends a run or has to hold, is left out of the export to "
                                 f"{target}" + (f" ({_few(names)})" if names else ""), guards[0].span, "",
                                 ("lag simulate and an FMU ask for it: --to fmu",)))
    if not bends(c.run) or not c.motion.q.numel():
        return events
    stated = [load.statement for load in c.energies.loads] + [term.statement for term in c.energies.dissipation]
    spans = {statement.component: statement.span for statement in stated if not statement.is_signal}  # no limit of a signal
    rubbing = build_small_motion(c.kinematics, c.constraints, c.run).rubs_dry
    return events + [
        Diagnostic("warning", "L0741", f"{name or 'this'} is dry friction, which the export to {target} has as a force that "
                       "jumps with the sign of a rate: nothing sticks in it, an integrator chatters about rest", spans.get(name),
                       "", ("an FMU holds what sticks, by events: --to fmu",)) for name in rubbing if name in spans]


def remarks(model: "Model", target: str) -> list[str]:
    """The same for the file itself, without what would end a text or a comment."""
    told = (re.sub(r'["\\\n]', " ", found.message) for found in export_warnings(model, target))
    return [f"{text}; an FMU has what sticks, and events" for text in told]


def _page(model: "Model", target: str, names: Mapping[str, str], force: bool) -> str:
    from lagrangia.paper.sheet import Request, write_equations

    form = "worked" if target == "latex" else "lagrange"
    return write_equations(model.path, Request(form, target, names, is_forced=force), model.model, model.structural)


def starts(model: "Model") -> dict[str, float]:
    """The assembled start, by coordinate and der(coordinate); by the parts of quaternions of attitudes."""
    run = model.run(replace(USUAL, at=[model.scene.start]))
    names = [c.name for c in (*model.scene.told_positions, *model.scene.rates)]
    return {name: float(run[name][0]) for name in names}


def parameters_of_starts(model: "Model") -> list[str]:
    """Those that the assembled start depends on."""
    import casadi as ca

    c = model.compilation
    table, p = c.functions.table, c.motion.p
    known = parameters_of(c.kinematics, p, ())
    values = table["start"].call([known])
    if "initial" in table:
        symbols = [ca.SX.sym(name, table["initial"].size1_in(name)) for name in table["initial"].name_in()]
        values = [*values, table["initial"].call([*symbols[:2], known, *symbols[3:]])[0]]
    return [name for name, is_read in zip(model.parameter_names, ca.which_depends(ca.veccat(*values), p), strict=True) if is_read]


def _starts_told(model: "Model") -> list[str]:
    deciding = parameters_of_starts(model)
    return [f"{STARTS} {_few(deciding)} as declared: other values need other starts"] if deciding else []


def _few(names: Sequence[str]) -> str:
    return ", ".join(names[:_FEW]) + (", ..." if len(names) > _FEW else "")


def inputs(model: "Model") -> dict[str, float]:
    """The start values of the inputs, which hold while nobody gives others."""
    return {u.name: u.value or 0.0 for u in model.scene.inputs}


def _modelica(model: "Model", target: str, names: Mapping[str, str], force: bool) -> str:
    from lagrangia.dynamics.freedom import find_freedom
    from lagrangia.paper.equations import without_rows
    from lagrangia.paper.modelica import write_modelica
    from lagrangia.paper.sheet import Request, written_book

    try:
        request = Request(names=names, is_forced=force)
        book = written_book(model.path, request, model.model, model.structural, has_quaternions=True)
    except LagError as error:
        if any(diagnostic.code != "L0712" for diagnostic in error.diagnostics):
            raise
        return _by_instructions(model, target, names)
    model = model.in_space
    c = model.compilation
    freedom = find_freedom(c.kinematics, c.motion, c.constraints, c.initial, c.functions.table)
    book = replace(book, equations=without_rows(book.equations, freedom.dependent))
    remarks_on = [*remarks(model, target), *_starts_told(model), *_left_out(freedom)]
    return write_modelica(book, starts(model) | inputs(model), remarks_on)


def _by_instructions(model: "Model", target: str, names: Mapping[str, str]) -> str:
    """What the scene is compiled to, where its equations are too large to be read. Raises LagError L0506, L0711, L0712, L0901."""
    from lagrangia.compile.people_functions import flat_function
    from lagrangia.dynamics.freedom import find_freedom
    from lagrangia.paper.modelica_instructions import write_instructions

    _refuse_long_tables(model, target)
    model = model.general
    c = model.compilation
    freedom = find_freedom(c.kinematics, c.motion, c.constraints, c.initial, c.functions.table)
    function = flat_function(c.kinematics, c.motion, c.constraints, model.output_names)
    values = dict(zip(model.parameter_names, model.parameter_values().tolist(), strict=True)) | starts(model) | inputs(model)
    remarks_on = [_INSTRUCTIONS, *remarks(model, target), *_starts_told(model), *_left_out(freedom)]
    return write_instructions(function, model.scene, c.flat, values, freedom.dependent, names, remarks_on)


def _left_out(freedom: "Freedom") -> list[str]:
    return [f"left out: {what}" for what in freedom.repeated if freedom.dependent]


# -------------------------------------------------------------------- CasADi, Python


def _write_casadi(model: "Model", path: Path) -> int:
    """A list: all functions of t, q, v, u, p, `all_parameters` of p, and the constants `parameters`, `inputs`, `start` (q, v) as
    functions without arguments. Then a dictionary of the names of the entries of q, u, p and y, and those of p that `follow`."""
    import casadi as ca

    first = starts(model)
    q, v = (ca.DM([first[c.name] for c in columns]) for columns in (model.scene.told_positions, model.scene.rates))
    table = model.functions() | model.derivatives()
    mapping = table.pop("parameters")
    p = ca.SX.sym("p", len(model.parameter_names))
    functions = [*table.values(), ca.Function("all_parameters", [p], mapping.call([p]), ["p"], ["parameters"]),
                 ca.Function("parameters", [], [ca.DM(model.parameter_values())], [], ["p"]),
                 ca.Function("inputs", [], [ca.DM(list(inputs(model).values()))], [], ["u"]),
                 ca.Function("start", [], [q, v], [], ["q", "v"])]
    with Target(path, binary=True) as target, tempfile.TemporaryDirectory(prefix="lagrangia-") as folder:
        file = Path(folder) / "functions"
        serializer = ca.FileSerializer(str(file))
        serializer.pack(functions)
        serializer.pack({"q": list(model.position_names), "u": list(model.input_names), "p": list(model.parameter_names),
                         "y": list(model.output_names), "follow": _following(model, mapping)})
        del serializer  # closes the file
        target.stream.write(file.read_bytes())
    return len(functions)


def _following(model: "Model", mapping: Any) -> list[str]:
    """Parameters whose values follow from others: their entries of p are not read. `mapping`: p -> all values."""
    read = set(zip(*mapping.jac_sparsity(0, 0).get_triplet(), strict=True))
    return [name for k, name in enumerate(model.parameter_names) if (k, k) not in read]


def _parameters_text(mapping: Any) -> str:
    """`parameters` of the Python module: from a vector, or by name."""
    from lagrangia.compile.numpy_module import write_function

    return f'''def parameters(p=()):
    """All values in the order of PARAMETERS, FOLLOWING worked out. p: as the functions take it, or changes by name."""
    if len(p) == 0 or hasattr(p, "keys"):
        changes = dict(p)
        if wrong := [name for name in changes if name not in PARAMETERS or name in FOLLOWING]:
            raise ValueError(f"no parameters that can be given: {{', '.join(wrong)}}")
        p = list({{**PARAMETERS, **changes}}.values())
    return _parameters(p)


{write_function("_parameters", mapping, {"p": "p[{}]"}, "All values, from p.", None)}'''


def _python(model: "Model", target: str, names: Mapping[str, str], force: bool) -> str:
    from lagrangia.compile.numpy_module import write_function

    scene, first, functions = model.scene, starts(model), model.functions() | model.derivatives()
    mapping = functions.pop("parameters")
    values = dict(zip(model.parameter_names, model.parameter_values().tolist(), strict=True))
    n = len(model.position_names)
    turning = "turning(t, q, v, u, p)" if "turning" in functions else "v"
    title = f"{scene.name}: {scene.description}" if scene.description else scene.name
    head = [f'"""{python_text(title)}.', "",
            "Functions of t, q, v, u, p in SI units, the entries in the order of COORDINATES, INPUTS and PARAMETERS;",
            "scipy.integrate.solve_ivp(slope, (0, 1), START) integrates it.",
            *remarks(model, target), *_starts_told(model), '"""', "", "import numpy as np", "",
            f"COORDINATES = {list(model.position_names)!r}", f"INPUTS = {inputs(model)!r}", f"PARAMETERS = {values!r}",
            f"FOLLOWING = {_following(model, mapping)!r}  # from other parameters: their entries of p are not read",
            f"OUTPUTS = {list(model.output_names)!r}",
            f"START = np.array({[first[c.name] for c in (*scene.told_positions, *scene.rates)]!r})  # q, v", "", "",
            "def slope(t, y, u=None, p=None):", '    """dy/dt of y = (q, v)."""', f"    q, v = y[:{n}], y[{n}:]",
            "    u = np.array(list(INPUTS.values())) if u is None else u",
            "    p = np.array(list(PARAMETERS.values())) if p is None else p",
            f"    return np.concatenate([{turning}, rhs(t, q, v, u, p)])", ""]
    parts = ["\n".join(head), _parameters_text(mapping)]
    for name, function in functions.items():
        matrix = function.size_out(0) if name in _MATRICES else None
        stacked = _stacked(function)
        called = "multipliers" if name == "lambda" else name
        parts.append(write_function(called, stacked, _ARGUMENTS, _WORDS.get(name, name), matrix))
    return "\n\n".join(parts)


def _stacked(function: Any) -> Any:
    """One output that holds them all."""
    import casadi as ca

    arguments = [ca.SX.sym(f"x{k}", function.size1_in(k), function.size2_in(k)) for k in range(function.n_in())]
    results = function.call(arguments)
    whole = results[0] if len(results) == 1 else ca.vertcat(*results)
    return ca.Function("stacked", arguments, [whole])
