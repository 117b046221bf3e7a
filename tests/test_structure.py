"""The house rules of DESIGN.md that a machine can check: the order of the modules, sizes, what is imported when, descriptions."""

import ast
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from lagrangia.compile.pipeline import library
from lagrangia.language.tree import ClassDefinition, Declaration

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "compiler" / "lagrangia"

# A module imports only modules that stand before it: down this list is down the pipeline, from text to the command line.
ORDER = """
    version
    folders
    store
    diagnostics
    interruptions
    spelling
    targets
    given
    units
    values
    tree
    plain_tree
    recovery
    expectations
    syntax
    classes
    meanings
    instances
    folding
    dealing
    names
    algorithms
    flat
    walk
    unread
    idle
    flattening
    dimensions
    observables
    scalars
    algebra
    numbering
    casadi_algebra
    events
    evaluation
    edges
    consequences
    graph
    joints
    planar
    lines
    closures
    kinematics
    directions
    energies
    bodies
    harmonics
    collected
    parameters
    impacts
    constraints
    initial
    orthogonal
    branches
    equilibrium
    nonnegative
    grips
    metric
    newton
    assembly
    virtual_forces
    positions
    double_roots
    partition
    forces
    elimination
    kkt
    schur
    evenness
    null_space
    constrained_motion
    motion
    holding
    switches
    jacobians
    released
    drives
    reactions
    linearity
    waves
    loads
    linear_form
    linear_choice
    hamilton
    spectrum
    islands
    factors
    impulses
    functions
    assemblies
    freedom
    linearization
    sympy_algebra
    symbolic
    series
    equations
    layout
    typeset
    latex
    mathml
    notation
    document
    presentation
    textbook
    structure
    book
    forms
    worked
    rest_points
    linear_matrices
    linear_page
    pages
    sympy_script
    modelica
    numpy_module
    tapes
    mirrors
    runtime
    interpret
    scene
    instructions
    rolled
    taylor
    widecode
    ccode
    scenes
    dependence
    places
    needs
    prebuilt
    native
    runtime_library
    batch
    cache
    pipeline
    dumps
    solvers
    engines
    explain
    request
    simulate
    casadi_solvers
    fmu_xmltree
    fmu_archive
    fmu_description
    fmu_rules
    fmu_structure
    fmu_binary
    fmu_parts
    fmu_schemas
    sweep_measures
    sweep_values
    sweep_plan
    sweep_journal
    sweep_pieces
    sweep_threads
    sweep_dask
    sweep_table
    sweep
    plot
    trajectory
    statics
    fmu_factors
    fmu_derivatives
    fmu_model
    fmu_source
    fmu_xml
    fmu_xml2
    fmu_xml3
    fmu_pictures
    fmu_page
    fmu_build
    fmu
    fmu_importer
    fmu_integrate
    fmu_probe
    fmu_worker
    fmu_process
    fmu_run
    probes
    small_motion
    resting
    mechanism
    analysis_plot
    modes
    response
    analysis
    analysis_text
    equation_sheet
    model
    bench_problem
    bench_peers
    bench_reference
    bench_heyoka
    bench
    bench_table
    bench_plot
    topics
    arguments
    summary
    check_command
    explain_command
    simulate_command
    sweep_command
    bench_command
    analysis_commands
    exports
    equations_command
    fmu_command
    fmu_compare
    fmu_check
    fmu_check_command
    fmu_simulate_command
    export_command
    cli
    __main__
    __init__
""".split()
EXCEPTIONS: dict[tuple[str, str], str] = {}

TOP_LEVEL = {"pyproject.toml", "grammar", "compiler", "runtime", "models", "tests", "README.md", "LICENSE", "CHANGELOG.md"}
HEAVY = {"casadi", "sympy", "matplotlib", "scipy", "pandas", "lark", "numpy"}
LONGEST_FILE, LONGEST_FUNCTION = 500, 40
SUFFIXES = {".py", ".c", ".h", ".lark", ".lag"}


def tracked() -> list[Path]:
    """The files of the repository, as paths from its top."""
    if shutil.which("git") is None or not (ROOT / ".git").exists():
        pytest.skip("this is no git checkout")
    listing = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True)
    return [Path(line) for line in listing.stdout.splitlines() if (ROOT / line).exists()]


# ---------------------------------------------------------------- imports


def imported(module: Path) -> set[str]:
    """The modules of the package that a module names in an import, wherever in it the import stands."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module == "lagrangia":
            names = [f"lagrangia.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [node.module or ""]
        else:
            continue
        found |= {name.split(".")[1] for name in names if name.startswith("lagrangia.")}
    return {name if (PACKAGE / f"{name}.py").exists() else "__init__" for name in found}


def test_every_module_has_its_place_in_the_order() -> None:
    assert sorted(ORDER) == sorted(module.stem for module in PACKAGE.glob("*.py"))


@pytest.mark.parametrize("module", ORDER)
def test_imports_point_up_the_pipeline(module: str) -> None:
    allowed = {*ORDER[: ORDER.index(module)], *(target for source, target in EXCEPTIONS if source == module)}
    assert imported(PACKAGE / f"{module}.py") <= allowed


def test_no_private_name_crosses_modules() -> None:
    for module in PACKAGE.glob("*.py"):
        froms = (node for node in ast.walk(ast.parse(module.read_text(encoding="utf-8"))) if isinstance(node, ast.ImportFrom))
        private = [name.name for node in froms for name in node.names if re.match(r"_[a-z]", name.name)]
        assert not private, module.stem


def test_every_exception_is_needed() -> None:
    for source, target in EXCEPTIONS:
        assert target in imported(PACKAGE / f"{source}.py")


def test_a_cached_scene_runs_without_heavy_libraries(tmp_path: Path) -> None:
    """The second run starts at once, because it finds everything compiled."""
    program = "import sys; from lagrangia.command.cli import main; assert main(sys.argv[1:]) == 0; print(*sys.modules, sep='\\n')"
    command = [sys.executable, "-c", program, "simulate", str(ROOT / "models" / "examples" / "pendulum.lag"), "--quiet"]
    environment = os.environ | {"LAGRANGIA_CACHE": str(tmp_path / "cache")}

    def loaded() -> set[str]:
        run = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
        return {name.partition(".")[0] for name in run.stdout.split()}

    assert {"casadi", "lark"} <= loaded(), "the first run compiles"
    assert not HEAVY & loaded()


# ---------------------------------------------------------------- sizes and places


def test_the_top_level_holds_only_what_belongs_there() -> None:
    names = {path.parts[0] for path in tracked()}
    assert {name for name in names if not name.startswith(".")} <= TOP_LEVEL


def test_one_language_a_folder() -> None:
    home = {".lark": "grammar", ".c": "runtime", ".h": "runtime"}
    for path in tracked():
        if path.parts[:3] == ("tests", "benchmarks", "hand_written"):
            continue  # what the compiler's C is measured against
        assert path.parts[0] == home.get(path.suffix, path.parts[0]), path
        assert path.suffix != ".py" or path.parts[0] in ("compiler", "tests"), path
        assert path.suffix != ".lag" or path.parts[0] in ("models", "tests"), path


def test_no_file_is_long() -> None:
    lengths = {path: len((ROOT / path).read_text(encoding="utf-8").splitlines()) for path in tracked() if path.suffix in SUFFIXES}
    assert not {path: length for path, length in lengths.items() if length >= LONGEST_FILE}


def python_functions(text: str) -> Iterator[tuple[str, int]]:
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef):
            assert node.end_lineno is not None
            yield node.name, node.end_lineno - node.lineno + 1


def c_functions(text: str) -> Iterator[tuple[str, int]]:
    """A function's braces stand in the first column."""
    for body in re.finditer(r"^(\w[^\n;]*)\n\{\n(.*?)^\}$", text, re.DOTALL | re.MULTILINE):
        yield body[1], body[0].count("\n") + 1


def test_no_function_is_long() -> None:
    readers = {".py": python_functions, ".c": c_functions}
    lengths = {(path, name): length for path in tracked() if path.suffix in readers
               for name, length in readers[path.suffix]((ROOT / path).read_text(encoding="utf-8"))}
    assert any(path.suffix == ".c" for path, _ in lengths)
    assert not {where: length for where, length in lengths.items() if length > LONGEST_FUNCTION}


# ---------------------------------------------------------------- the library


@pytest.mark.parametrize("definition", [d for file in library() for d in file.classes if d.kind != "type"], ids=lambda d: d.name)
def test_the_library_describes_itself(definition: ClassDefinition) -> None:
    """Every component and function by a line of its own, every parameter by what it is or the line's formula."""
    assert len(definition.description) > 10
    for element in definition.elements:
        if isinstance(element, Declaration) and "parameter" in element.prefixes:
            assert element.description, element.name


def test_every_quantity_type_has_a_unit() -> None:
    for definition in (d for file in library() for d in file.classes if d.kind == "type"):
        (base,) = definition.elements
        assert any(argument.name == "unit" for argument in base.arguments), definition.name
