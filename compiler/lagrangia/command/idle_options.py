"""Options that would change nothing beside others: refused, each with what it belongs to."""

from argparse import Namespace
from collections.abc import Callable

from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass

Holds = Callable[[Namespace], bool]


@dataclass(frozen=True)
class _Rule:
    """Of these commands, these options (attributes of what was parsed) say nothing where `holds`."""

    commands: tuple[str, ...]
    options: tuple[str, ...]
    holds: Holds
    why: str


_DUMPED = ("output", "plot", "plot_quantities", "spectrum", "section", "overlay", "beside", "linear", "at", "interval", "start",
           "stop", "tolerance", "initial", "input", "start_from", "solver", "engine", "max_step", "max_steps", "stats", "kind")
_NOT_DUMPED = ("reactions", "outputs", "least_squares")  # but where code is made of them
_FLAGS = {"start_from": "from"}  # where an attribute is not called as its option


def flag(name: str) -> str:
    """The option of an attribute."""
    return f"--{_FLAGS.get(name, name).replace('_', '-')}"


def _is_script(options: Namespace) -> bool:
    """Whether `lag equations` writes a script of SymPy."""
    return bool(options.format == "sympy" or (options.format is None and (options.output or "").lower().endswith(".py")))


RULES = (
    _Rule(("simulate",), ("interval",), lambda o: o.at is not None, "--at says the times of the rows"),
    _Rule(("simulate",), ("plot_quantities", "spectrum", "section", "overlay", "beside", "linear"), lambda o: o.plot is None,
          "--plot names the picture that is to show them"),
    _Rule(("simulate", "sweep"), ("stats",), lambda o: o.quiet, "--quiet says nothing but errors"),
    _Rule(("simulate",), _DUMPED, lambda o: o.dump is not None, "--dump prints a phase of the compiler and runs nothing"),
    _Rule(("simulate",), _NOT_DUMPED, lambda o: o.dump not in (None, "needs", "c"), "of what is reported it knows nothing"),
    _Rule(("simulate",), ("engine", "max_step", "max_steps"), lambda o: o.solver.startswith("casadi:"),
          "integrators of CasADi have their own"),
    _Rule(("simulate", "sweep"), ("max_step",), lambda o: o.solver == "linear",
          "the matrix exponential is exact in steps of any length"),
    _Rule(("equations",), ("about",), lambda o: o.form != "linear", "it is the point of --form linear"),
    _Rule(("equations",), ("level", "sections", "first_letter"), lambda o: o.form != "worked", "it belongs to --form worked"),
    _Rule(("equations",), ("form", "sources", "format", "output", "numbers", "language", "fragment"),
          lambda o: o.check is not None,
          "--check prints whether its equation holds"),
    _Rule(("equations",), ("language",), _is_script, "scripts are written in English"),
    _Rule(("equations",), ("level", "sections", "first_letter"), _is_script, "scripts have the equations, not their derivation"),
    _Rule(("bench",), ("stop", "points", "tolerances", "solvers", "plot"), lambda o: o.rhs,
          "--rhs measures accelerations alone"),
    _Rule(("sweep",), ("restart",), lambda o: o.output == "-", "a table on standard output leaves nothing to go on with"),
    _Rule(("test",), ("tolerance",), lambda o: o.update, "--update compares nothing, it stores"),
    _Rule(("modes",), ("mode", "view"), lambda o: o.animate is None, "--animate names the page that is to show it"),
    _Rule(("response",), ("range", "points"), lambda o: o.at is not None, "--at says the frequencies"),
    _Rule(("animate",), ("curves", "names", "beside"), lambda o: o.stroboscope is not None,
          "a stroboscope shows positions alone"),
    _Rule(("animate",), ("curves", "names"), lambda o: o.output is not None and not o.output.lower().endswith(".html"),
          "it is for pages: write .html"),
    _Rule(("export",), ("force",), lambda o: o.to not in ("sympy", "latex", "modelica"), "it is for sympy, latex and modelica"),
)


def refuse_idle(options: Namespace, usual: Callable[[str], object]) -> None:
    """Raises LagError L0706 for an option that differs from what is `usual`, and changes nothing."""
    for rule in RULES:
        if options.name in rule.commands and rule.holds(options):
            for name in rule.options:
                if getattr(options, name) != usual(name):
                    fail("L0706", f"{flag(name)} has no effect here", None, rule.why)
