"""`lag explain`: the table of needs, and the solver that follows from it, as text and as JSON."""

import json
import textwrap
from collections.abc import Sequence
from dataclasses import asdict, replace
from typing import TYPE_CHECKING

from lagrangia.base.records import dataclass
from lagrangia.run.engines import Engine
from lagrangia.run.runtime import Settings, Solver, first_choice
from lagrangia.run.scene import Scene
from lagrangia.run.solvers import CASADI, WAYS, name_of, reason_of

if TYPE_CHECKING:
    from lagrangia.needs.table import Need

_WIDTH = 118
NONE = "none"


@dataclass(frozen=True)
class Begun:
    """What `auto` begins with: a solver's name, the row that took it, and the row's reason."""

    solver: str
    rule: str
    why: str


def chosen_for(scene: Scene, engine: Engine | None) -> Begun:
    """What `auto` begins with, at the scene's own tolerance; NONE where nothing can run it."""
    if engine is None:
        return _without_engine(scene)
    settings = Settings(scene.start, scene.stop, scene.tolerance)
    choice = first_choice(engine.runtime.library, engine.model, settings)
    return Begun(name_of(Solver(choice.solver)), choice.rule, reason_of(choice, scene))


def _without_engine(scene: Scene) -> Begun:
    if CASADI[0] in scene.refused:
        return Begun(NONE, "no compiler", "nothing can run it: there is no C compiler (pip install ziglang brings one)")
    return Begun(CASADI[0], "no compiler", "there is no C compiler")


def without_compiler(scene: Scene, casadi: str) -> Scene:
    """The scene where there is neither a run time nor a C compiler to build it. `casadi`: why CasADi cannot run it."""
    sizes = {name: size for name, size in scene.sizes.items() if name != "solver"}
    refused = dict.fromkeys(WAYS, "there is no C compiler") | dict(scene.refused) | dict.fromkeys(CASADI * bool(casadi), casadi)
    return replace(scene, sizes=sizes, refused=refused)


def as_json(scene: Scene, needs: Sequence["Need"], begun: Begun) -> str:
    """The solver, what each solver could do, and all needs with their reasons."""
    solvers = {name: {"title": title, "can_run": name not in scene.refused, "reason": scene.refused.get(name, "")}
               for name, title in _titles(begun.solver).items()}
    return json.dumps({"model": scene.name, "solver": begun.solver, "rule": begun.rule, "why": begun.why,
                       "tolerance": scene.tolerance, "solvers": solvers, "needs": [asdict(n) for n in needs]}, indent=2)


def as_text(scene: Scene, needs: Sequence["Need"], begun: Begun) -> str:
    """The solver and why, what the scene needs, and what it does without."""
    chosen = begun.solver
    lines = [f"{scene.name}: solver {chosen}, tolerance {scene.tolerance:g}",
             *textwrap.wrap(_reason(scene, begun), _WIDTH, initial_indent="  ", subsequent_indent="  "), ""]
    for title, wanted in (("needed", True), ("not needed", False)):
        rows = [need for need in needs if need.is_needed is wanted]
        lines += [title, *(line for need in rows for line in _row(need)), ""]
    titles = _titles(chosen)
    lines.append("other solvers")
    for name in (name for name in titles if name != chosen):
        wrapped = textwrap.wrap(scene.refused.get(name, titles[name]), _WIDTH - 21, break_long_words=False)
        lines += [f"  {name:18} {wrapped[0]}", *(" " * 21 + line for line in wrapped[1:])]
    return "\n".join(lines).rstrip()


def _titles(chosen: str) -> dict[str, str]:
    """Of all solvers; CasADi's where there is no compiler for others."""
    casadi = {} if chosen in WAYS else {name: _of_casadi(name) for name in CASADI}
    return casadi | {name: way.title for name, way in WAYS.items()}


def _of_casadi(name: str) -> str:
    return f"CasADi's {name.partition(':')[2]}"


def _reason(scene: Scene, begun: Begun) -> str:
    """What it is, and why `auto` takes it."""
    chosen = begun.solver
    if chosen == NONE:
        return begun.why
    if chosen not in WAYS:
        return f"{_of_casadi(chosen)}: {begun.why}"
    turns = chosen in ("erk", "erk5", "erk9", "pirk", "adams", "taylor") and "implicit" not in scene.refused
    return f"{WAYS[chosen].title}: {begun.why}" + ("; implicit steps where it turns out stiff" if turns else "")


def _row(need: "Need") -> list[str]:
    figure = (f"costs {need.cost}" if need.cost else "") if need.is_needed else (f"saves {need.saving}" if need.saving else "")
    parts = [need.why, figure, need.place]
    text = "; ".join(part for part in parts if part)
    wrapped = textwrap.wrap(text, _WIDTH - 26, break_long_words=False) or [""]
    return [f"  {need.what:23} {wrapped[0]}", *(" " * 26 + line for line in wrapped[1:])]
