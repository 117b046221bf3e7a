"""What `lag simulate` says of a run."""

import math
import sys
from argparse import Namespace
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from lagrangia.base.spelling import plain_text
from lagrangia.model import Model
from lagrangia.run.engines import Engine, describe
from lagrangia.run.moved_starts import FIXED, moved_starts, quantity
from lagrangia.run.request import Experiment, Values
from lagrangia.run.runtime import Solver, Statistics
from lagrangia.run.scene import Scene
from lagrangia.run.simulate import Progress, short_steps, shortcomings
from lagrangia.run.solvers import AUTO, name_of, reason_of
from lagrangia.view.statics import is_static, reaction_table, told_shares

_MOST_ROWS = 40  # MOST_ROWS of runtime/run/unsure.c


def _told_states(scene: Scene) -> str:
    """What else than coordinates the state has."""
    named = (("first-order states", [*scene.flowing.values()]), ("discrete variables", scene.discrete))
    return "".join(f" and {what} ({', '.join(own)})" for what, own in named if own)


def summarise(options: Namespace, model: Model, progress: Progress, target: str, compiled: float, loaded: float) -> None:
    """Prints what a run was, and with --stats what it cost."""
    scene, experiment, statistics = model.scene, progress.experiment, progress.statistics
    out = sys.stdout if target != "-" else sys.stderr

    def say(text: str) -> None:
        print(text, file=out)

    say(f"{scene.name}: {scene.description}" if scene.description else scene.name)
    n = scene.n - len(scene.signals)
    names = ", ".join(scene.told[:6]) + (", ..." if len(scene.told) > 6 else "")
    say(f"  {n} coordinate{'s' if n != 1 else ''}{f' ({names})' if names else ''}{_told_states(scene)}, "
        f"{experiment.start:g} to {experiment.stop:g} s, tolerance {experiment.tolerance:g}")
    if scene.notes["is_prescribed"]:
        say("  no freedom is left: its motion is prescribed")
    engine = model.engine_for(options.solver)
    solver = "" if engine else f"casadi:{options.solver.partition(':')[2] or 'cvodes'}"
    how = ""
    if statistics is not None and engine is not None:
        solver = methods_of(statistics, options.solver, scene.sizes["n_events"] + scene.sizes["n_switches"] > 0)
        met = statistics.events
        events = f", {met} event{'s' if met != 1 else ''}" if met else ""
        how = f", {engine.how}: {statistics.steps} steps, {statistics.rhs_evaluations} evaluations{events}"
    say(f"  {solver}{how} in {_time(progress.seconds)}")
    if statistics is not None and engine is not None and options.solver == AUTO:
        say(f"  {name_of(Solver(statistics.choice.solver))}: {reason_of(statistics.choice, scene)}")
    if statistics is not None:
        scale = statistics.energy_size
        relative = f" ({statistics.energy_residual / scale:.1e} of {scale:.3g} J)" if 0 < scale < math.inf else ""
        say(f"  energy account closes to {statistics.energy_residual:.1e} J{relative}")
        for text in (*shortcomings(progress), *filter(None, [short_steps(scene, progress)])):
            say(f"  {text}")
    if progress.ended:
        say(f"  {progress.ended}")
    _tell_unlooked(scene, say)
    apart = "" if experiment.at is not None else f", one every {experiment.interval:g} s"
    say(plain_text(f"  {progress.rows} rows in {target}{apart}" + (f", picture in {options.plot}" if options.plot else "")))
    if options.stats:
        _tell(model, engine, progress, compiled, loaded, say)


def _tell_unlooked(scene: Any, say: Callable[[str], None]) -> None:
    """Where forces that rounding decides near dead points are not looked for."""
    rows = scene.sizes["n_multipliers"]
    if scene.sizes["outputs_need_acceleration"] and rows and (rows > _MOST_ROWS or scene.n > 2 * _MOST_ROWS):
        say(f"  forces that rounding decides near dead points are told in scenes of up to {_MOST_ROWS} constraints and "
            f"{2 * _MOST_ROWS} coordinates, not here")


def methods_of(statistics: Statistics, asked: str, is_cut: bool) -> str:
    """What ran, with the steps of each method where there were several, and why another than the one asked for did."""
    counts = {name_of(Solver(k)): count for k, count in enumerate(statistics.steps_by) if count}
    if counts and (rest := statistics.steps - sum(counts.values())) > 0:
        counts["at rest"] = rest
    names = list(counts) or [name_of(statistics.solver)]
    shown = names[0] if len(names) == 1 else ", ".join(f"{name} ({count} steps)" for name, count in counts.items())
    if asked in (AUTO, *names):
        return shown
    why = ", as events and friction cut its steps" if is_cut else ", which could not go on"
    return f"{shown} in place of {asked}{why}"


def methods_of_runs(bits: Any) -> list[str]:
    """What took steps in any of many runs, (runs,) bits by the numbers of solvers; with how many runs where it was not all."""
    moved = int((bits != 0).sum())
    found = [(name_of(Solver(k)), int((bits >> k & 1).sum())) for k in sorted(Solver) if (bits >> k & 1).any()]
    return [name if count == moved else f"{name} (in {count} runs)" for name, count in found]


def tell_assembly(scene: Any, experiment: Experiment, row: Sequence[float], out: Any) -> None:
    """Where the loops were closed, when start values were free to choose."""
    free = [k for k in range(scene.n) if scene.fixed[k] != FIXED]
    if not (scene.notes["loops"] and scene.sizes["n_initial_positions"] and free and row and row[0] == experiment.start):
        return
    size = max(map(abs, row[1 : 1 + scene.n]))
    kept = [x if abs(x) > 1e-12 * size else 0.0 for x in row[1 : 1 + scene.n]]  # but for rounding
    turned = set(scene.turned)  # their numbers are against what they were turned to
    told = [k for k in free if scene.coordinates[k].name not in turned]
    shown = [f"{scene.coordinates[k].name} = {quantity(kept[k], scene.coordinates[k].unit)}" for k in told[:4]]
    shown += [f"{' and '.join(scene.notes['attitudes'])} as they fit"] if turned else []
    more = ", ..." if len(told) > 4 else ""
    print(f"  loops closed at {', '.join(shown)}{more}; `lag check` tells whether there are other ways", file=out)


def singular_start(scene: Scene, freedom: Mapping[str, Any]) -> str:
    """What is singular about the start as the file states it; "" where nothing is."""
    if freedom["is_rigid_at_start"]:
        return "the start is a singular position: nothing moves there, and parts a little longer let it go"
    if ways := freedom["ways_at_start"]:
        return f"the start is a singular position, where {len(ways)} ways of moving meet: {'; or '.join(ways)}"
    if freedom["degrees_at_start"] > freedom["degrees_of_freedom"]:
        return f"the start is a singular position: {freedom['degrees_at_start'] - len(scene.signals)} degrees of freedom there"
    return ""


def tell_singular_start(options: Namespace, model: Model, progress: Progress, out: Any) -> None:
    """Of loops whose steps missed the tolerance, which singular positions bring about: nobody looks at others for it."""
    if progress.experiment.start == model.scene.start and shortcomings(progress) and (text := stated_singular(options, model)):
        print(f"  {text}", file=out)


def stated_singular(options: Namespace, model: Model) -> str:
    """The same of a run that starts as the file states it, and of loops."""
    is_as_stated = not (options.parameter or options.initial)
    return singular_start(model.scene, model.freedom) if model.scene.notes["loops"] and is_as_stated else ""


def tell_moved(scene: Any, progress: Progress, values: Values, row: Sequence[float], out: Any) -> None:
    """What moved_starts.py has to say."""
    for said in moved_starts(scene, progress, values, row):
        print(f"  {said}", file=out)


def tell_reactions(scene: Any, row: Sequence[float], out: Any) -> None:
    """What a scene that cannot move is computed for."""
    if is_static(scene) and row and (straight := scene.notes["touching"]["told"]):
        print(f"  no freedom is left, so it stands still; nothing bounds the forces, for {straight[0]} only just holds", file=out)
    elif is_static(scene) and row and (table := reaction_table(scene, row)):
        print(f"  no freedom is left, so it stands still; on the port b of each joint act, at t = {row[0]:g} s", file=out)
        print("\n".join(f"    {line}" for line in table), file=out)


def _tell(model: Model, engine: Engine | None, progress: Progress, compiled: float, loaded: float,
          say: Callable[[str], None]) -> None:
    scene, statistics = model.scene, progress.statistics
    notes = scene.notes
    ways = ", ".join(f"{way} {count}" for way, count in notes["ways"].items())
    say(f"  accelerations: {notes['way']}, {notes['acceleration_nodes']} nodes, "
        f"{notes['nodes_per_coordinate']} a coordinate (tried: {ways})")
    say(f"  right-hand side: {notes['rhs_operations']} operations; {scene.sizes['n_hoisted']} values hoisted out of it")
    how = "found in the cache" if model.is_cached else "; ".join(f"{k} {_time(v)}" for k, v in model.compilation.seconds.items())
    ready = f"{'native code' if engine.how == 'native' else 'run time'} in {_time(loaded)}" if engine else "no native code"
    say(f"  compiled in {_time(compiled)} ({how}); {ready}")
    if engine is not None:
        say(f"  {describe(scene)}")
    if statistics is not None and statistics.steps:
        say(f"  steps {statistics.smallest_step:.3g} to {statistics.largest_step:.3g} s, {statistics.rejected} rejected, "
            f"{statistics.dense_outputs} dense outputs, {statistics.events} events; "
            f"{_time(progress.seconds / statistics.rhs_evaluations)} an evaluation")
        worst = (*scene.coordinates, *scene.rates)[statistics.worst].name if 0 <= statistics.worst < 2 * scene.n else "none"
        say(f"  the steps were limited last by {worst}")
        figures = ", ".join(f"{name} {value}" for name, value in statistics.choice.figures.items())
        say(f"  solver by the rule '{statistics.choice.rule}'" + (f": {figures}" if figures else ""))


def _time(seconds: float) -> str:
    for unit, factor in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= factor:
            return f"{seconds / factor:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"


def tell_shared(model: Model, row: Sequence[float], out: Any) -> None:
    """What leaves the reactions that outputs and loads are made of one way of several, or those of least squares: equations that
    repeat each other."""
    if row and model.scene.notes["tells_reactions"]:
        for told in told_shares(model.freedom["repeated"], model.formulas.least_squares):
            print(f"  {told}", file=out)
