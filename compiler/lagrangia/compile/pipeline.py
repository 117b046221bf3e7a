"""Every phase in order: text -> syntax -> flat -> graph -> kinematics -> energies -> motion -> functions -> scene.

Heavy libraries are imported by the phases that need them, when they are needed.
"""

import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lagrangia.base.diagnostics import Report, Source, fail, suggest
from lagrangia.base.memory import without_collections
from lagrangia.base.records import dataclass
from lagrangia.compile.packages import Packages, enclosing
from lagrangia.compile.sources import read_source, refuse_others
from lagrangia.frames.attitude_starts import refuse_attitudes
from lagrangia.language.classes import build_class_table
from lagrangia.language.component_library import drawn_library, library_classes
from lagrangia.language.consequences import refuse_felt_reactions
from lagrangia.language.delays import refuse_delays
from lagrangia.language.dimensions import check_dimensions
from lagrangia.language.flattening import flatten
from lagrangia.language.given_values import Given, redeclared
from lagrangia.language.lookups import read_planes, read_tables
from lagrangia.language.samplers import refuse_held
from lagrangia.language.space_limits import refuse_statements_in_space
from lagrangia.language.syntax import parse
from lagrangia.language.without_effect import find_idle_words
from lagrangia.run.formulas import AS_DECLARED, Formulas
from lagrangia.run.scene import ALL_REACTIONS

if TYPE_CHECKING:
    from lagrangia.compile.functions import Functions
    from lagrangia.constraints.initial import InitialConditions
    from lagrangia.constraints.partition import Partition
    from lagrangia.constraints.rows import Constraints
    from lagrangia.dynamics.energies import Energies
    from lagrangia.dynamics.hamilton import Hamilton
    from lagrangia.dynamics.motion import Motion
    from lagrangia.frames.graph import ComponentGraph
    from lagrangia.frames.kinematics import Kinematics
    from lagrangia.language.classes import ClassTable
    from lagrangia.language.flat import FlatModel
    from lagrangia.language.kept_components import KeptScene
    from lagrangia.language.tree import ClassDefinition, ImportFile, Syntax
    from lagrangia.run.scene import Scene

PHASES = ("syntax", "flat", "graph", "kinematics", "energies", "motion", "needs", "c")
_DEEPEST_RECURSION = 50_000
_MOST_TREES = 16


@dataclass(frozen=True)
class Compilation:
    """What each phase made. `model` is chosen by name, or is the last model of the file."""

    syntax: "Syntax"
    flat: "FlatModel"
    graph: "ComponentGraph"
    kinematics: "Kinematics"
    constraints: "Constraints"
    energies: "Energies"
    motion: "Motion"  # without what happens at events
    struck: "Kinematics"  # that know the forces of contacts
    run: "Motion"  # with what happens at events
    initial: "InitialConditions"
    functions: "Functions"
    scene: "Scene"
    seconds: Mapping[str, float]


def compile_file(path: Path, model: str | None = None, structural: Mapping[str, Any] | None = None,
                 outputs: tuple[str, ...] = (), formulas: Formulas = AS_DECLARED, given: Given | None = None) -> Compilation:
    """All phases. `outputs` are names to report besides coordinates, rates and declared outputs; `given` are values of parameters
    in the place of those declared. Raises LagError."""
    took: dict[str, float] = {}
    with deep_recursion(), without_collections():
        with _timed(took, "syntax, flat"):
            syntax, flat = flatten_file(path, model, structural)
            flat = redeclared(check_dimensions(flat), given or {})
            refuse_statements_in_space(flat)
        return _compile(syntax, flat, outputs, formulas, took)


def _compile(syntax: "Syntax", flat: "FlatModel", outputs: tuple[str, ...], formulas: Formulas,
             took: dict[str, float]) -> Compilation:
    """What needs CasADi, which is not loaded for a text that is wrong."""
    with _timed(took, "libraries"):
        from lagrangia.compile.functions import build_functions
        from lagrangia.compile.scenes import build_scene, divide
        from lagrangia.constraints.initial import with_motion
        from lagrangia.constraints.partition import find_partition
        from lagrangia.constraints.rows import reduce_kinematics
        from lagrangia.dynamics.energies import build_energies
        from lagrangia.dynamics.freedom import is_held_still
        from lagrangia.dynamics.jacobians import waits
        from lagrangia.dynamics.joint_loads import feel_reactions
        from lagrangia.dynamics.massless import settle_massless
        from lagrangia.dynamics.motion import build_motion
        from lagrangia.dynamics.shared_reactions import asking_for_least_squares

    with _timed(took, "graph, kinematics, energies"):
        kinematics, constraints = reduce_kinematics(_laid_out(flat, outputs, formulas))
        kinematics, constraints, energies = settle_massless(kinematics, constraints, build_energies(kinematics))
    with _timed(took, "motion"):
        constraints, initial = _start(kinematics, constraints, formulas.is_as_written)
        constraints = asking_for_least_squares(kinematics, constraints, initial, formulas.least_squares)
        made_of = constraints, formulas.for_any_mass, find_partition(kinematics, constraints, initial)
        motion = feel_reactions(kinematics, constraints, build_motion(kinematics, energies, *made_of))
        hit, run = _with_impacts(kinematics, energies, motion, made_of)
        initial = with_motion(initial, kinematics, motion.momentum if motion.constrained else None, motion.acceleration)
    with _timed(took, "functions"):
        flow, stuck, hamilton = _flow(kinematics, constraints, energies, run, waits(run))
        functions = build_functions(hit, run, constraints, initial, hamilton, _reported(kinematics.graph, outputs))
    with _timed(took, "freedom"):
        is_still = is_held_still(kinematics, motion, constraints, initial, functions.table)
    with _timed(took, "scene"):
        scene = build_scene(kinematics, run, constraints, initial, functions, is_still, flow, stuck)
        scene = divide(scene, kinematics, run, initial)
    return Compilation(syntax, flat, kinematics.graph, kinematics, constraints, energies, motion, hit, run, initial, functions,
                       scene, took)


def _laid_out(flat: "FlatModel", outputs: tuple[str, ...], formulas: Formulas) -> "Kinematics":
    """The kinematics; of a scene in space that lies in a plane, those of the plane."""
    from lagrangia.frames.graph import build_graph
    from lagrangia.frames.kinematics import build_kinematics

    kinematics = build_kinematics(build_graph(flat), formulas.is_general, formulas.massless)
    if not flat.space.is_spatial or formulas.in_space:
        return kinematics
    from lagrangia.constraints.found_plane import in_its_plane

    return in_its_plane(kinematics, outputs, formulas.is_general, formulas.massless)


def with_what_waits(made: Compilation, outputs: tuple[str, ...]) -> Compilation:
    """The same with the matrix of implicit steps and the momenta of conservative ones."""
    from lagrangia.compile.functions import build_functions
    from lagrangia.compile.scenes import build_scene, divide
    from lagrangia.dynamics.freedom import is_held_still

    with deep_recursion(), without_collections():
        flow, stuck, hamilton = _flow(made.kinematics, made.constraints, made.energies, made.run, waits=False)
        functions = build_functions(made.struck, made.run, made.constraints, made.initial, hamilton,
                                    _reported(made.graph, outputs), is_implicit=True)
        is_still = is_held_still(made.kinematics, made.motion, made.constraints, made.initial, functions.table)
        scene = build_scene(made.kinematics, made.run, made.constraints, made.initial, functions, is_still, flow, stuck)
        return replace(made, functions=functions, scene=divide(scene, made.kinematics, made.run, made.initial))


def _start(kinematics: "Kinematics", constraints: "Constraints", is_as_written: bool
           ) -> "tuple[Constraints, InitialConditions]":
    """The constraints, by their slopes where they only just hold unless `is_as_written`, and where it begins; raises LagError for
    equations whose force acts on what they do not hold, too."""
    from lagrangia.constraints.initial import build_initial
    from lagrangia.constraints.virtual_forces import refuse_forces_elsewhere
    from lagrangia.dynamics.double_roots import lift_double_roots

    initial = build_initial(kinematics, constraints)
    refuse_forces_elsewhere(kinematics, constraints, initial)
    lifted = None if is_as_written else lift_double_roots(kinematics, constraints, initial)
    return (constraints, initial) if lifted is None else (lifted, build_initial(kinematics, lifted))


def _flow(kinematics: "Kinematics", constraints: "Constraints", energies: "Energies", run: "Motion", waits: bool
          ) -> "tuple[str, str, Hamilton | None]":
    """Why the scene does not keep its energy, why it has no conservative steps, and the momenta of these where it needs them,
    unless that waits."""
    from lagrangia.dynamics.hamilton import build_hamilton, energy_flow, is_separable, no_momenta

    flow = energy_flow(kinematics, constraints, energies, run)
    stuck = flow or no_momenta(kinematics, constraints, energies, run)
    return flow, stuck, None if waits or stuck or is_separable(run) else build_hamilton(kinematics, run)


def _with_impacts(kinematics: "Kinematics", energies: "Energies", motion: "Motion",
                  made_of: "tuple[Constraints, bool, Partition | None]") -> "tuple[Kinematics, Motion]":
    """The motion with what holds at contacts, and the kinematics that know these forces; the same where there are no events.
    Raises LagError for forces of which nobody knows what they are at rest."""
    from lagrangia.dynamics.energies import build_energies
    from lagrangia.dynamics.impacts import find_impacts
    from lagrangia.dynamics.joint_loads import feel_reactions
    from lagrangia.dynamics.motion import build_motion
    from lagrangia.dynamics.untold_rest import refuse_untold_rest

    impacts = find_impacts(kinematics, energies.total(energies.kinetic), made_of[0].rows)
    if impacts.pressing:
        kinematics = kinematics.knowing(impacts.contact_forces())
        energies = build_energies(kinematics)
    if impacts.conditions.numel():
        motion = feel_reactions(kinematics, made_of[0], build_motion(kinematics, energies, *made_of, impacts))
    refuse_untold_rest(energies, motion)
    return kinematics, motion


def _reported(graph: "ComponentGraph", outputs: tuple[str, ...]) -> tuple[str, ...]:
    """Declared outputs, those asked for, and coordinates that are no longer among the coordinates, with their rates."""
    from lagrangia.frames.joints import all_reactions

    declared = (v.name for v in graph.model.variables.values() if v.is_output or v.kind == "held")
    lost = (*(c.name for c in graph.dependent_coordinates), *graph.cut_coordinates)
    reactions = all_reactions(graph) if ALL_REACTIONS in outputs else []
    names = dict.fromkeys((*graph.attitudes, *declared, *outputs, *reactions, *lost, *(f"der({name})" for name in lost)))
    return tuple(name for name in names if name != ALL_REACTIONS)


def compile_energies(path: Path, model: str | None = None, structural: Mapping[str, Any] | None = None,
                     given: Given | None = None, has_angles: bool = False,
                     has_quaternions: bool = False) -> "tuple[Kinematics, Constraints]":
    """What the equations for people begin with: text -> kinematics; parameters and energies were checked. `given` are values of
    parameters in the place of those declared; attitudes are known where they are written by angles or quaternions. Raises
    LagError."""
    with deep_recursion():
        _, flat = flatten_file(path, model, structural)
        flat = redeclared(check_dimensions(flat), given or {})
        if flat.states:
            name, state = next(iter(flat.states.items()))
            drives = () if flat.frames.keys() - {"world"} else ("lag export --to modelica --components has them in drives",)
            kind = "discrete variables" if state.is_kept else "first-order states"
            others = "lag simulate and FMUs" if state.is_kept else "lag simulate, FMUs, --to python and --to casadi"
            fail("L0901", f"not supported yet: written equations of scenes with {kind} ('{name}')", state.span,
                 f"{others} have them", *drives)
        _refuse_moving_inputs(flat)
        refuse_held(flat, "written equations")
        refuse_delays(flat, "written equations")
        refuse_felt_reactions(flat, "written equations")
        kinematics, constraints = _kinematics(flat, is_general=False)
        cut = next((cut for cut in kinematics.graph.closures if cut.kind == "ball"), None)
        if not (has_angles or has_quaternions):
            by_angles = () if cut else ("lag equations --angles zxz writes it by Euler's angles: about z, x and z, which move "
                                        "along; any of the twelve sequences",)
            refuse_attitudes(kinematics.graph.attitudes, "these written equations", *by_angles,
                             "the forms lagrange, energies, matrix and first-order have Euler's equations for it")
        elif has_angles and cut:
            fail("L0901", f"not supported yet: equations by angles of a loop that a ball joint closes ('{cut.kept}')", cut.span,
                 "without --angles it has quaternions, in the forms lagrange, energies, matrix and first-order")
        elif has_angles and not kinematics.graph.attitudes:
            fail("L0704", "--angles: no attitude is a coordinate of this scene", flat.span)
        if not any(row.balanced for row in constraints.all_rows):  # which numbers that others could set may be the reason of
            kinematics, constraints = _kinematics(flat, is_general=True)
        return kinematics, constraints


def _kinematics(flat: "FlatModel", is_general: bool) -> "tuple[Kinematics, Constraints]":
    from lagrangia.constraints.parameters import require_possible
    from lagrangia.constraints.rows import reduce_kinematics
    from lagrangia.dynamics.energies import build_energies
    from lagrangia.dynamics.impacts import find_impacts
    from lagrangia.dynamics.massless import settle_massless
    from lagrangia.frames.graph import build_graph
    from lagrangia.frames.kinematics import build_kinematics

    kinematics, constraints = reduce_kinematics(build_kinematics(build_graph(flat), is_general))
    if not kinematics.symbols.positions:
        fail("L0505", "nothing can move: the scene has no coordinate", flat.span,
             "joints (Revolute, Prismatic, ...) and bodies joined to nothing have coordinates")
    require_possible(kinematics)
    energies = build_energies(kinematics)
    kinematics, constraints, _ = settle_massless(kinematics, constraints, energies)
    find_impacts(kinematics, energies.total(energies.kinetic), constraints.rows)  # which tells what is wrong with events
    return kinematics, constraints


def _refuse_moving_inputs(flat: "FlatModel") -> None:
    name = next((name for name, is_placing in flat.moving_inputs.items() if is_placing), None)
    if name is not None:
        fail("L0901", f"not supported yet: written equations of places that inputs move ('{name}')", flat.variables[name].span,
             "write a function of time in its place; lag simulate, FMUs, --to python and --to casadi have them")


def flatten_file(path: Path, model: str | None = None, structural: Mapping[str, Any] | None = None, is_drawn: bool = False
                 ) -> "tuple[Syntax, FlatModel]":
    """Text -> syntax -> flat model, with the figures of the library's components where it `is_drawn`. Raises LagError."""
    with deep_recursion():
        syntax, imported = read_files(path)
        return syntax, flatten_files(syntax, imported, model, structural, is_drawn)


def flatten_files(syntax: "Syntax", imported: "list[Syntax]", model: str | None = None,
                  structural: Mapping[str, Any] | None = None, is_drawn: bool = False, kept: "KeptScene | None" = None
                  ) -> "FlatModel":
    """The same of files that are read; `kept` has what was made of the model before. Raises LagError."""
    packages = Packages(syntax)
    table = build_class_table(drawn_library() if is_drawn else library_classes(), [syntax, *imported], packages.find)
    flat = flatten(table, _choose(syntax, table, model), structural, kept)
    has_more = bool(syntax.imports or table.files or syntax.annotations)
    unused = find_idle_words(syntax, _brought(syntax, imported)) if has_more else Report()
    read = tuple(os.path.abspath(file.source.name) for file in (*imported, *packages.read))
    return replace(flat, warnings=(*flat.warnings, *unused.diagnostics), tables=read_tables(flat.lookups),
                   planes=read_planes(flat.lookups), read=read)


def _brought(main: "Syntax", imported: "list[Syntax]") -> "list[tuple[ImportFile, list[Syntax]]]":
    """Of each file that one imports, the file and all that it imports itself."""
    known = {os.path.realpath(file.source.name): file for file in (main, *imported)}

    def target(item: "ImportFile") -> "Syntax":
        return known[os.path.realpath(Path(item.span.source.name).parent / item.path)]

    found = []
    for item in main.imports:
        files = [target(item)]
        for file in files:
            files += [new for other in file.imports if (new := target(other)) not in files and new is not main]
        found.append((item, files))
    return found


def read_files(path: Path, read: Callable[[Path], Source] = read_source,
               tree: "Callable[[Source], Syntax] | None" = None) -> "tuple[Syntax, list[Syntax]]":
    """The file and all that it imports, each once; an editor reads what people have not saved yet, and has trees of it. Raises
    LagError."""
    refuse_others(path)
    tree = tree or (_tree if read is read_source else parse)  # an editor knows its sources again
    main = tree(read(path))
    found: dict[Path, Syntax] = {path.resolve(): main}
    report = Report()
    pending = [(path, main)]
    while pending:
        here, syntax = pending.pop()
        for item in syntax.imports:
            target = Path(os.path.realpath(here.parent / item.path))
            if target in found:
                continue  # also a cycle of imports ends here
            if target.suffix != ".lag":
                report.error("L0002", f"'{item.path}' is no Lagrangia file: the name of one ends in .lag", item.span)
                continue
            if not target.is_file():
                report.error("L0002", f"there is no file '{item.path}'", item.span, f"looked for {here.parent / item.path}")
                continue
            found[target] = tree(read(here.parent / item.path))
            pending.append((here.parent / item.path, found[target]))
    report.raise_errors()
    return main, [*(syntax for syntax in found.values() if syntax is not main), *enclosing(main)]


def _tree(source: Source) -> "Syntax":
    return _parsed(source.name, source.text)


@lru_cache(maxsize=_MOST_TREES)
def _parsed(name: str, text: str) -> "Syntax":
    """The same tree for the same text: of a file of many models that are looked at in turn it is made once."""
    return parse(Source(name, text))


def _choose(syntax: "Syntax", table: "ClassTable", name: str | None) -> Any:
    """By its full name or its own, or the last one of the file that is complete and stands in no other class."""
    models = [c for c in table.user.values() if c.name_span.source is syntax.source and c.kind in ("model", "block")]
    if name is not None:
        chosen = [c for c in models if c.name == name] or [c for c in models if c.name_span.text == name]
        if len(chosen) != 1:
            hints = [suggest(name, [c.name for c in models])] if not chosen else [f"it is {_either(chosen)}"]
            what = "has no model" if not chosen else "has more than one model"
            fail("L0003", f"'{syntax.source.name}' {what} '{name}'", None, *filter(None, hints))
        return chosen[0]
    complete = [c for c in models if not c.is_partial]
    outer = [c for c in complete if any(c.name_span == top.name_span for top in syntax.classes)]
    if not outer:
        hint = f"those in its packages are run by name: --model {_either(complete[-5:])}" if complete else (
            "a scene is: model Name ... end Name;")
        fail("L0003", f"'{syntax.source.name}' has no model to run", None, hint)
    return outer[-1]


def _either(models: "list[ClassDefinition]") -> str:
    return " or ".join(c.name for c in models)


@contextmanager
def _timed(seconds: dict[str, float], what: str) -> Iterator[None]:
    begin = time.perf_counter()
    yield
    seconds[what] = time.perf_counter() - begin


@contextmanager
def deep_recursion() -> Iterator[None]:
    """Expressions are trees, and long sums are deep ones: the parser bounds how deep. Raises LagError L0102."""
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(max(limit, _DEEPEST_RECURSION))
    try:
        yield
    except RecursionError:
        fail("L0102", "the model is nested too deeply", None, "name parts of long expressions with variables of their own")
    finally:
        sys.setrecursionlimit(limit)
