"""The ways to run a scene, by the names that `--solver` takes."""

from collections.abc import Mapping

from lagrangia.base.diagnostics import fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.run.choice import Choice
from lagrangia.run.runtime import Solver
from lagrangia.run.scene import Scene

AUTO = "auto"
CASADI = ("casadi:cvodes", "casadi:idas", "casadi:rk", "casadi:collocation")


@dataclass(frozen=True)
class Way:
    """A solver of the run time: its number there, and what it is in words."""

    number: Solver
    title: str


WAYS: Mapping[str, Way] = {
    "erk": Way(Solver.ERK, "explicit Runge-Kutta 8(5,3) of Dormand and Prince"),
    "erk5": Way(Solver.ERK5, "explicit Runge-Kutta 5(4) of Tsitouras"),
    "erk9": Way(Solver.ERK9, "explicit Runge-Kutta 9(8) of Verner, whose steps end at rows"),
    "pirk": Way(Solver.PIRK, "Gauss collocation of order 16, its eight stages at once"),
    "adams": Way(Solver.ADAMS, "Adams' methods of variable order, one evaluation a step"),
    "linear": Way(Solver.LINEAR, "matrix exponential, exact for linear scenes"),
    "islands": Way(Solver.ISLANDS, "islands that do not interact, each by its own solver and steps"),
    "implicit": Way(Solver.IMPLICIT, "Radau IIA of order 5, 9 and 13"),
    "taylor": Way(Solver.TAYLOR, "Taylor series of the motion, of an order that follows from the tolerance"),
    "conservative": Way(Solver.CONSERVATIVE, "symplectic steps of fixed length, for scenes that keep their energy"),
}


def is_casadi(name: str) -> bool:
    """Whether it is one of CasADi's."""
    return name.partition(":")[0] == "casadi"


def applicable(scene: Scene) -> tuple[str, ...]:
    """The names of the run time's solvers that can run this scene."""
    return tuple(name for name in WAYS if name not in scene.refused)


def number_of(name: str, scene: Scene) -> Solver:
    """The run time's number of the solver `name`. Raises LagError L0704 when there is none, or none for this scene."""
    if isinstance(name, str) and name == AUTO:
        return Solver.AUTO
    if not isinstance(name, str) or name not in WAYS:
        known = [AUTO, *WAYS, *CASADI]
        fail("L0704", f"there is no solver '{name}'", None, *filter(None, [suggest(str(name), known)]),
             f"the solvers are {', '.join(known)}")
    if name in scene.refused:
        fail("L0704", f"the solver '{name}' cannot run this scene: {scene.refused[name]}", None,
             f"here one can choose {', '.join((AUTO, *applicable(scene)))}")
    return WAYS[name].number


def name_of(number: Solver) -> str:
    """The name of a solver by its number in C."""
    others = {Solver.TRANSITION: "linear", Solver.ORBIT: "swings told from one of them"}
    return next((name for name, way in WAYS.items() if way.number is number), others.get(number, AUTO))


def reason_of(choice: Choice, scene: Scene) -> str:
    """Why a solver was chosen; with what decided while the scene was compiled, where that was it."""
    is_form = choice.solver == scene.sizes.get("solver", Solver.AUTO) and choice.rule != "asked"
    return f"{choice.why}; {scene.notes['form']}" if is_form and scene.notes.get("form") else choice.why
