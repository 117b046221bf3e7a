"""The house rules of DESIGN.md that a machine can check: the rooms and their order, sizes, imports, descriptions."""

import ast
import graphlib
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

import pytest

from lagrangia.language.component_library import library
from lagrangia.language.tree import ClassDefinition, Declaration

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "compiler" / "lagrangia"

# A room imports only rooms above it here: down this list is down the pipeline. `model` is a module.
ROOMS = """
    base
    native
    run
    algebra
    language
    frames
    constraints
    dynamics
    needs
    compile
    view
    study
    paper
    draw
    solids
    fmu
    play
    editor
    site
    model
    bench
    command
""".split()

LOOSE = {"__init__", "__main__", "model"}
RESERVED = {"grammar", "runtime", "models"}  # folders of data in a wheel
# Where libraries that take time to load, or bind to one way of doing things, may be imported: rooms and modules.
HEAVY_HOMES = {
    "lark": {"language"},
    "casadi": {"algebra", "frames", "constraints", "dynamics", "needs", "compile", "study", "fmu", "model", "bench",
               "command/scene_export", "draw", "solids"},
    "pygls": {"editor/server", "editor/protocol", "command/server"},
    "sympy": {"algebra/with_sympy", "algebra/normal_form", "paper"},
    "matplotlib": {"view/curves", "study/pictures", "study/sweep/pictures", "bench/plot", "draw/paint"},
}
LONGEST_WELCOME = 8  # lines of what a room says about itself
TOP_LEVEL = {"pyproject.toml", "grammar", "compiler", "runtime", "models", "tests", "README.md", "LICENSE", "CHANGELOG.md"}
METHODS = {"study/swept"}  # of a model
COMPILERS = {"native/build", "native/c_code", "native/series"}  # a run that stays on its tape does without
REFUSALS = {"language/expectations"}  # and a text that is right without these
HEAVY = {"casadi", "sympy", "matplotlib", "scipy", "pandas", "lark", "numpy", "pygls"}
LONGEST_FILE, LONGEST_FUNCTION = 500, 40
SUFFIXES = {".py", ".c", ".h", ".lark", ".lag"}


def tracked() -> list[Path]:
    """The files of the repository, as paths from its top."""
    if shutil.which("git") is None or not (ROOT / ".git").exists():
        pytest.skip("this is no git checkout")
    listing = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True)
    return [Path(line) for line in listing.stdout.splitlines() if (ROOT / line).exists()]


# ---------------------------------------------------------------- rooms


MODULES = {path.relative_to(PACKAGE).with_suffix("").as_posix(): path for path in sorted(PACKAGE.rglob("*.py"))}


@cache
def parsed(path: Path) -> ast.Module:
    """What a file says."""
    return ast.parse(path.read_text(encoding="utf-8"))


def tree_of(module: str) -> ast.Module:
    """What a module says, parsed."""
    return parsed(MODULES[module])


@cache
def nodes_of(path: Path) -> tuple[ast.AST, ...]:
    """All of what a file says."""
    return tuple(ast.walk(parsed(path)))


def room_of(module: str) -> str:
    """The room of "room/name"; a module of the package's root stands for itself."""
    return module.partition("/")[0]


@cache
def imported(module: str) -> frozenset[str]:
    """What a module imports, wherever in it the import stands: "room/name" of the package, names of other libraries."""
    return frozenset(name for _, name in named(module, nodes_of(MODULES[module])))


def named(module: str, nodes: Iterable[ast.AST]) -> Iterator[tuple[int, str]]:
    """The line and the name of all that the imports among these nodes of a module name."""
    for node in nodes:
        if isinstance(node, ast.Import):
            yield from ((node.lineno, resolved(alias.name)) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{module}: imports say where things are from the top"
            inside = [resolved(f"{node.module}.{alias.name}") for alias in node.names]
            yield from ((node.lineno, name if name in MODULES else resolved(node.module or "")) for name in inside)


def resolved(dotted: str) -> str:
    """The module of the package, or the library, that a dotted name begins with."""
    first, *rest = dotted.split(".")
    if first != "lagrangia":
        return first
    name = "/".join(rest) or "__init__"
    return name if name in MODULES else f"{name}/__init__" if f"{name}/__init__" in MODULES else name


def test_every_file_is_in_a_room() -> None:
    assert {path.stem for path in PACKAGE.glob("*.py")} == LOOSE
    rooms = {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
    assert rooms == set(ROOMS) - {"model"}
    assert not rooms & RESERVED
    assert {room_of(module) for module in MODULES} == {*ROOMS, *LOOSE}


@pytest.mark.parametrize("room", [room for room in ROOMS if room != "model"])
def test_a_room_says_what_belongs_there(room: str) -> None:
    """And holds nothing else that would hide where a thing lives."""
    text = MODULES[f"{room}/__init__"].read_text(encoding="utf-8")
    (words,) = ast.parse(text).body
    said = ast.literal_eval(ast.unparse(words))
    assert "Here belongs: " in said and "Not here: " in said
    assert len(said.splitlines()) <= LONGEST_WELCOME


@pytest.mark.parametrize("room", ROOMS)
def test_imports_point_to_rooms_before(room: str) -> None:
    """An import inside a function counts as well: it is there to save time, not to hide a circle."""
    allowed = {*ROOMS[: ROOMS.index(room) + 1]}
    for module in (module for module in MODULES if room_of(module) == room):
        assert {name for name in imported(module) & MODULES.keys() if room_of(name) not in allowed} == set(), module


@pytest.mark.parametrize("room", ROOMS)
def test_no_circle_in_a_room(room: str) -> None:
    own = {module for module in MODULES if room_of(module) == room}
    graphlib.TopologicalSorter({module: imported(module) & own for module in sorted(own)}).prepare()


@cache
def parts(module: str) -> tuple[list[ast.AST], list[ast.AST]]:
    """What runs where a module is imported, and what runs where its functions are called."""
    nodes = nodes_of(MODULES[module])
    late = [node for function in nodes if isinstance(function, ast.FunctionDef) for node in ast.walk(function)]
    never = [node for test in nodes if isinstance(test, ast.If) and ast.unparse(test.test) == "TYPE_CHECKING"
             for node in ast.walk(test)]
    others = {*late, *never}
    return [node for node in nodes if node not in others], late


@cache
def loads(module: str) -> frozenset[str]:
    """The libraries that come with a module: by itself, or by what stands at the head of what it imports."""
    names = {name for _, name in named(module, parts(module)[0])}
    return frozenset(names - MODULES.keys()).union(*(loads(name) for name in names & MODULES.keys()))


def test_imports_wait_for_heavy_libraries_alone() -> None:
    """Commands and the methods of a model fetch what they are about when asked; elsewhere only weight is a reason."""
    idle = [f"{module}:{line} fetches {name}" for module in MODULES
            if room_of(module) not in ("command", "model") and module not in METHODS
            for line, name in named(module, parts(module)[1])
            if name in MODULES and name not in COMPILERS | REFUSALS and not loads(name) & HEAVY]
    assert idle == []


@pytest.mark.parametrize("library", HEAVY_HOMES)
def test_heavy_libraries_stay_in_their_rooms(library: str) -> None:
    users = {module for module in MODULES if library in imported(module)}
    homes = HEAVY_HOMES[library]
    assert {user for user in users if user not in homes and room_of(user) not in homes} == set()
    assert {home for home in homes if not any(home in (user, room_of(user)) for user in users)} == set(), "no longer used there"


def test_no_private_name_crosses_modules() -> None:
    for module, path in MODULES.items():
        froms = (node for node in nodes_of(path) if isinstance(node, ast.ImportFrom))
        private = [name.name for node in froms for name in node.names if re.match(r"_[a-z]", name.name)]
        assert not private, module


def public(tree: ast.AST, where: str = "") -> Iterator[tuple[str, ast.ClassDef | ast.FunctionDef]]:
    """Classes, functions and methods whose names are not private, nor inside of what is."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.ClassDef | ast.FunctionDef) and not node.name.startswith("_"):
            yield where + node.name, node
            if isinstance(node, ast.ClassDef):
                yield from public(node, f"{where}{node.name}.")


def test_everything_public_says_what_it_is() -> None:
    silent = [f"{module}: {name}" for module, path in MODULES.items()
              for name, node in public(parsed(path)) if not ast.get_docstring(node)]
    assert silent == []


def test_what_fails_says_so() -> None:
    """A public function that refuses what it is given names the code of it."""
    for module in MODULES:
        for name, node in public(tree_of(module)):
            calls = [call for call in ast.walk(node) if isinstance(call, ast.Call) and ast.unparse(call.func) == "fail"]
            if isinstance(node, ast.FunctionDef) and calls:
                assert "Raises" in (ast.get_docstring(node) or ""), f"{module}: {name}"


def test_a_cached_scene_runs_without_heavy_libraries(tmp_path: Path) -> None:
    """The second run starts at once, because it finds everything compiled."""
    program = "import sys; from lagrangia.command.cli import main; assert main(sys.argv[1:]) == 0; print(*sys.modules, sep='\\n')"
    command = [sys.executable, "-c", program, "simulate", "--quiet"]
    environment = os.environ | {"LAGRANGIA_CACHE": str(tmp_path / "cache")}

    def loaded(scene: str) -> set[str]:
        file = str(ROOT / "models" / "examples" / f"{scene}.lag")
        run = subprocess.run([*command, file], cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
        return {name.partition(".")[0] for name in run.stdout.split()}

    assert "casadi" in loaded("pendulum"), "the first run compiles; in a tree that was not built, it makes the parser's tables"
    assert "lark" not in loaded("atwood"), "which only says what is wrong with a text"
    assert not HEAVY & loaded("pendulum")


# ---------------------------------------------------------------- the dimension

PLANAR = {"frames/planar", "frames/planar_joints", "frames/planar_inertia", "frames/in_plane"}
# Who asks what a frame is in the plane: what a frame of another kind has to answer, too.
ASK_THE_KIND = """
    frames/closures frames/edges frames/evaluation frames/geometry
    constraints/found_plane
    dynamics/elimination
    draw/scenery draw/values view/mechanism study/pictures study/probes paper/points paper/symbolic
""".split()
OF_THE_PLANE = {"phi", "xy", "vx", "vy", "reaction_torque"}  # names of components and attributes, where these are no text
# Beside the table of attributes: symbols on paper, residuals, which are called phi as well, angles of bodies that add up,
# and hinges in the text of an imported robot, or in that of Modelica.
NAME_THEM = {*PLANAR, "language/frame_attributes", "paper/latex", "paper/notation", "paper/euler_angles", "compile/functions",
             "dynamics/collected_inertia", "editor/urdf_import", "editor/mjcf_reading",
             "paper/multibody_walk"}
RESIDUALS = {"rows", "self", "_parts"}  # whose phi is no angle
FUNCTIONS = {"ca", "sp", "np", "math", "hy"}  # whose sin is no frame's


def test_who_asks_what_the_plane_is() -> None:
    users = {module for module in MODULES if PLANAR & imported(module)}
    assert sorted(users - PLANAR) == sorted(ASK_THE_KIND)


def test_frames_are_asked_for_what_the_plane_has() -> None:
    """An angle, its sine and components are not read off a pose anywhere else."""
    wrong = []
    for module in sorted(MODULES.keys() - NAME_THEM):
        for node in nodes_of(MODULES[module]):
            is_named = isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value in OF_THE_PLANE
            is_read = isinstance(node, ast.Attribute) and node.attr in ("phi", "sin", "cos") \
                and ast.unparse(node.value).rpartition(".")[2] not in (RESIDUALS if node.attr == "phi" else FUNCTIONS)
            if is_named or is_read:
                wrong.append(f"{module}:{node.lineno}")
    assert wrong == []


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
        is_example = path.parts[:2] == ("models", "examples")  # some show what Python does with a model
        assert path.suffix != ".py" or path.parts[0] in ("compiler", "tests") or is_example, path
        assert path.suffix != ".lag" or path.parts[0] in ("models", "tests"), path


def test_no_file_is_long() -> None:
    lengths = {path: len((ROOT / path).read_text(encoding="utf-8").splitlines()) for path in tracked() if path.suffix in SUFFIXES}
    assert not {path: length for path, length in lengths.items() if length >= LONGEST_FILE}


def python_functions(path: Path) -> Iterator[tuple[str, int]]:
    for node in nodes_of(path):
        if isinstance(node, ast.FunctionDef):
            assert node.end_lineno is not None
            yield node.name, node.end_lineno - node.lineno + 1


def c_functions(path: Path) -> Iterator[tuple[str, int]]:
    """A function's braces stand in the first column."""
    for body in re.finditer(r"^(\w[^\n;]*)\n\{\n(.*?)^\}$", path.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE):
        yield body[1], body[0].count("\n") + 1


def test_no_function_is_long() -> None:
    readers = {".py": python_functions, ".c": c_functions}
    lengths = {(path, name): length for path in tracked() if path.suffix in readers
               for name, length in readers[path.suffix](ROOT / path)}
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


# ---------------------------------------------------------------- the run time: folders of C

# A folder includes, and calls, only folders that stand before it.
C_ROOMS = """
    base
    numbers
    model
    start
    state
    events
    steps
    methods
    choice
    run
    standard
    fmi
""".split()
C_EXCEPTIONS = {"state/state.h"}  # a run holds a struct of each room, so that it can be kept and copied as a whole
C_DECLARED_LEFT = {"lag_parts"}  # what a library may lack: declared in choice, filled in run
RUNTIME = ROOT / "runtime"
HEADERS_OF_C = """assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign stdarg stdatomic
    stdbit stdbool stdckdint stddef stdint stdio stdlib stdnoreturn string tgmath threads time uchar wchar wctype""".split()


def test_every_c_file_has_a_folder_and_a_name_of_its_own() -> None:
    """FMUs carry all sources side by side, where a header named like one of C's is taken for it."""
    files = [path for path in tracked() if path.parts[0] == "runtime"]
    assert {path.parts[1] for path in files} == set(C_ROOMS)
    assert all(len(path.parts) == 3 for path in files)
    assert len({path.name for path in files}) == len(files)
    assert not {path.stem for path in files if path.suffix == ".h"}.intersection(HEADERS_OF_C)


def test_c_includes_point_one_way() -> None:
    wrong = []
    for path in sorted(RUNTIME.rglob("*.[ch]")):
        own = path.relative_to(RUNTIME).as_posix()
        for included in re.findall(r'^#include "(.+)"', path.read_text(encoding="utf-8"), re.MULTILINE):
            room, _, name = included.rpartition("/")
            if name.startswith("fmi") and not room:
                continue  # the standard's own
            assert (RUNTIME / included).exists(), f"{own}: {included}"
            if C_ROOMS.index(room) > C_ROOMS.index(path.parent.name) and own not in C_EXCEPTIONS:
                wrong.append(f"{own} -> {included}")
    assert wrong == []


C_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)
C_DECLARED = re.compile(r"^[A-Za-z][^;{}=]*;", re.MULTILINE)
C_MADE = re.compile(r"^(?!static\b)[A-Za-z][\w *]*?\b(lag_\w+)(?:\([^;{]*\)\s*\{|(?:\[[^\]]*\])*\s*=)", re.MULTILINE)


def c_calls(files: list[Path]) -> list[tuple[Path, str, Path]]:
    """(file, function, file that has it) of all calls between these sources and headers, and of all tables that they share."""
    code = {file: C_DECLARED.sub("", C_COMMENT.sub("", file.read_text(encoding="utf-8"))) for file in files}
    made = {file: set(C_MADE.findall(text)) for file, text in code.items()}
    home = {name: file for file, names in made.items() for name in names}
    return [(file, name, home[name]) for file, text in code.items() for name in set(re.findall(r"\blag_\w+", text)) - made[file]
            if name in home and home[name].stem != file.stem]


def test_c_calls_point_one_way() -> None:
    room = {file: C_ROOMS.index(file.parent.name) for file in sorted(RUNTIME.rglob("*.[ch]")) if file.parent.name != "fmi"}
    calls = [call for call in c_calls(list(room)) if call[1] not in C_DECLARED_LEFT]
    assert len(calls) > 1000
    assert [f"{file.name} -> {name}" for file, name, home in calls if room[home] > room[file]] == []


FMI_ORDER = ("compiled image stored states log evaluations exchange_steps settle values exchange cosimulation partial saved life "
             "play").split()


def test_files_of_fmus_call_one_way() -> None:
    """Those that are the same for both versions of the standard."""
    files = [path for path in sorted((RUNTIME / "fmi").glob("*.c")) if not re.match(r"fmi\d", path.name)]
    assert sorted(path.stem for path in files) == sorted(FMI_ORDER)
    place = FMI_ORDER.index
    calls = c_calls(files)
    assert len(calls) > 50
    assert [f"{file.name} -> {name}" for file, name, home in calls if place(home.stem) > place(file.stem)] == []
