"""Lagrangia: a Modelica-style language for mechanics, with a compiler.

    import lagrangia as lag
    model = lag.load("chain.lag", n=20)
    run = model.simulate(stop=5, tolerance=1e-10, parameters={"link[1].m": 2.0})
    run.time, run["hinge[1].phi"], run.energy.total

The rooms, in the order in which they may import each other (tests/test_structure.py holds it): base, native, run; from text to a
scene: algebra, language, frames, constraints, dynamics, needs, compile; what is done with them: view, study, paper, draw, fmu,
play; with texts: editor, site; `model` is the interface in Python, which bench and command use. Each room's __init__.py says what
belongs there. The C of a run is in runtime/, in folders of the same kind, tests are in tests/<room>/, and what they share in
tests/helpers/.

To add, beside a test in the room of the same name and a line in CHANGELOG.md:

- a component: a model in models/library/*.lag, in the language itself; `lag help library` shows it from there.
- a joint: as any component, of frames (b = turn(a, phi)); what is cut where it closes a loop: its kind in
  frames/planar_joints.py.
- an attribute of a frame: a row of the tables in language/frame_attributes.py; what it is of a pose: frames/planar.py and
  spatial.py.
- what space has and had not: a row less in language/space_limits.py.
- a solver: a LagMethod in runtime/methods/NAME.c; its number in runtime/state/settings.h and run/runtime.py, its place in
  runtime/choice/methods.c, its name in run/solvers.py, its paragraph in command/topics.py.
- a rule by which `auto` chooses: a row of runtime/choice/choice.c, of what is decided before a run of run/rules.py.
- a form of the equations: a function of the book in paper/, with its name in FORMS of paper/forms.py.
- a subcommand: command/NAME.py, its row in command/parser.py, its options in one of command/*_options.py, its row in README.md.
- a diagnostic: fail("L0...", what, span, what to do) where it is found (base/diagnostics.py); a text that brings it about in
  tests/errors/NAME.lag, and `pytest tests/language/test_errors.py --update` writes what is said beside it.
- an option of a run: run/request.py, which the command line, Python, sweeps, benchmarks and FMUs hand down.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from lagrangia.base.version import VERSION

if TYPE_CHECKING:
    from lagrangia.base.diagnostics import (
        Diagnostic,
        EngineWarning,
        Error,
        InputWarning,
        Interrupted,
        LagError,
        RunError,
        RunWarning,
    )
    from lagrangia.model import Model, load, loads
    from lagrangia.run.input_rates import slopes
    from lagrangia.run.stepped import SteppedRun
    from lagrangia.view.trajectory import EnergyAccount, Trajectory

__version__ = VERSION
__all__ = ["Diagnostic", "EnergyAccount", "EngineWarning", "Error", "InputWarning", "Interrupted", "LagError", "Model",
           "RunError", "RunWarning", "SteppedRun", "Trajectory", "load", "loads", "slopes"]
_PLACES = dict.fromkeys(__all__, "base.diagnostics") | dict.fromkeys(("Model", "load", "loads"), "model") | dict.fromkeys(
    ("EnergyAccount", "Trajectory"), "view.trajectory") | {
    "SteppedRun": "run.stepped", "slopes": "run.input_rates"}


def __getattr__(name: str) -> Any:
    """What is asked for is imported then: the command `lag` needs little of it."""
    if name not in _PLACES:
        raise AttributeError(f"module 'lagrangia' has no attribute '{name}'")
    value = globals()[name] = getattr(import_module(f"lagrangia.{_PLACES[name]}"), name)
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
