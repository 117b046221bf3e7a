"""`lag sweep`: many runs of one scene."""

import sys
from argparse import Namespace
from pathlib import Path

from lagrangia.base.diagnostics import fail
from lagrangia.base.interruptions import INTERRUPTED
from lagrangia.base.result_files import Target, cells, is_device, keep_apart
from lagrangia.base.spelling import plain_text
from lagrangia.command.arguments import (
    asked,
    assignments,
    input_tables,
    keep_foreign,
    load_model,
    read_inputs,
    refuse_idle_sharing,
    tell,
    tell_given,
    tell_inputs,
    tell_warnings,
)
from lagrangia.command.chance import ended, told_of_chance
from lagrangia.command.summary import methods_of_runs
from lagrangia.model import Model
from lagrangia.run.batch import Ending
from lagrangia.run.request import plan
from lagrangia.run.simulate import DOUBTFUL
from lagrangia.run.solvers import name_of
from lagrangia.study.sweep.journal import Journal, Ledger
from lagrangia.study.sweep.keeping import Dataset, Keeper
from lagrangia.study.sweep.measures import Measure, quantities, read_measures
from lagrangia.study.sweep.plan import Design, Job
from lagrangia.study.sweep.progress import Bar
from lagrangia.study.sweep.run import require_place, run_job
from lagrangia.study.sweep.table import Sweep
from lagrangia.study.sweep.values import is_single, names_of_runs, range_remarks
from lagrangia.view.curves import require_format

_MOST_SHOWN = 12  # measures in the summary
_DRY_ROWS = 10


def sweep_command(options: Namespace) -> int:
    """0 when at least one run went well, and no energy account is open; runs that fail are rows of the table. Raises LagError."""
    target = options.output or f"{options.file.stem}_sweep.csv"
    if not options.dry_run:
        require_place(target, [options.file, *filter(None, [options.runs]), *input_tables(options.input)])
    model, job = _prepare(options)
    keep_foreign(options, target, ["run", *(measure.text for measure in job.measures)])
    if options.plot is not None:
        require_format(options.plot)
        keep_apart([options.plot, target], [options.file])
    if options.dry_run:
        return _show(job)
    if options.keep and (target == "-" or is_device(target)):
        fail("L0706", "--keep puts its folder beside the table: the table needs a file", None, "-o FILE.csv")
    if target == "-" or is_device(target):
        return _finish(options, model, _run(options, model, job, Ledger(job)), target, None)
    Target(Path(target)).abandon()  # better told now than after the runs
    with Journal(job, Path(f"{target}.part"), options.restart) as journal:
        if journal.found and not options.quiet:
            print(f"goes on with {target}.part: {journal.found} of {job.runs} runs are done", file=sys.stderr)
        keeper = Dataset(_folder(target), job.scene, journal) if options.keep else None
        code = _finish(options, model, _run(options, model, job, journal, keeper), target, journal)
        if keeper is not None and code == 0 and not options.quiet:
            print(f"  {len(job.sweep.row_times)} rows of each run in {keeper.folder}")
        return code


def _folder(target: str) -> Path:
    return Path(target).with_name(f"{Path(target).stem}_runs")


def _prepare(options: Namespace) -> tuple[Model, Job]:
    measures = read_measures(options.outputs or "")
    given = dict(assignments(options.parameter, "-p"))
    single = [(name, text) for name, text in given.items() if is_single(text)]
    model = load_model(options, single, quantities(measures))
    refuse_idle_sharing(model)
    scene = model.scene
    varied = {name: text for name, text in given.items() if name not in model.structural}
    request = asked(options, varied, dict(assignments(options.initial, "--initial")), read_inputs(options.input, scene))
    tell_warnings(options, model)
    tell_inputs(options, model, plan(scene, request), request.inputs)
    tell_given(options, model, request, names_of_runs(options.runs))
    tell(options, model, range_remarks(request.parameters, request.initial))
    design = Design(options.runs, options.samples, options.seed, options.sampling, options.together, options.seconds_per_run,
                    options.keep, options.until)
    return model.prepared_for(measures, request, design)


def _run(options: Namespace, model: Model, job: Job, ledger: Ledger, keeper: Keeper | None = None) -> Sweep:
    bar = Bar(ledger, job.runs, sys.stderr)
    try:
        return run_job(job, model, ledger, jobs=options.jobs, dask=options.dask, watch=bar, keeper=keeper)
    finally:
        bar.close()


def _finish(options: Namespace, model: Model, sweep: Sweep, target: str, journal: Journal | None) -> int:
    entered = sweep.ledger.entered
    if sweep.interrupted:
        how = f"kept in {journal.path}; the same command goes on with them" if journal is not None else "lost"
        print(f"interrupted: {entered} of {sweep.runs} runs are done, and {how}", file=sys.stderr)
        return INTERRUPTED
    if target == "-":
        for text in sweep.lines():
            sys.stdout.write(text)
    else:
        sweep.write(target)
    if journal is not None:
        journal.remove()
    if options.plot is not None:
        sweep.plot(options.plot)
    if not options.quiet:
        _summarise(sweep, target, entered - (journal.found if journal is not None else 0), options.stats)
    tell(options, model, [*sweep.odd_inertias(), *(warning.render() for warning in sweep.broken())])
    if not sweep.ok.any():
        print("error: no run went well" + "".join(f"\n   = {count} runs: {what}" for what, count in sweep.common_failures()),
              file=sys.stderr)
        return 1
    return _judge(sweep)


def _judge(sweep: Sweep) -> int:
    """1 where runs are in the table whose energy account is open."""
    count = int((sweep.ledger.outcomes["kind"] == Ending.OPEN).sum())
    if count:
        print(f"error: the energy account of {count} of {sweep.runs} runs misses by more than the tolerance explains: their "
              "rows, which say so, are not the motion of this scene\n   = a smaller --tolerance, or another --solver",
              file=sys.stderr)
    return 1 if count else 0


# -------------------------------------------------------------------- what is said


def _show(job: Job) -> int:
    """The runs there would be, without running any."""
    names = job.variations.names
    print(f"{job.scene.name}: {job.runs} runs; measures {', '.join(measure.text for measure in job.measures)}")
    print(",".join(("run", *names)))
    for k, row in enumerate(job.variations.values(0, min(job.runs, _DRY_ROWS)).tolist()):
        print(cells((k, *row)))
    if job.runs > _DRY_ROWS:
        print("...")
    return 0


def _in_lanes(sweep: Sweep, now: int) -> str:
    """How many of the runs made now went on together, and how full the lanes were."""
    lanes = sweep.ledger.lanes
    if not lanes.room and lanes.alone:
        return f"lanes: not used ({lanes.alone} runs do not suit them: constraints that repeat others, rest, or starts that fail)"
    if not lanes.room:
        return f"lanes: not used ({_why_alone(sweep)})"
    alone = f", {lanes.alone} of them made again alone" if lanes.alone else ""
    together = lanes.runs + lanes.alone
    left = f"; they left for events {lanes.left / together:.3g} times a run" if lanes.left else ""
    return f"lanes: {together} of {now} runs eight at a time{alone}; {100 * lanes.steps / lanes.room:.0f} % full{left}"


def _why_alone(sweep: Sweep) -> str:
    """What lanes do not serve (runtime/run/run_lanes.h)."""
    job, settings = sweep.job, sweep.job.sweep.settings
    solver, sizes = name_of(settings.solver), job.scene.sizes
    is_free, has_loops = solver == "auto", sizes.get("n_multipliers", 0) > 0
    is_linear = methods_of_runs(sweep.ledger.outcomes["methods"]) == ["linear"]
    reasons = {
        "fewer than four runs": not job.sweep.in_lanes,
        "--max-steps": settings.max_steps > 0,
        "pirk evaluates the eight stages of one run at once": solver == "pirk",
        "linear steps from row to row, by matrices that runs of equal parameters share": solver == "linear" or is_linear,
        f"{solver} has none": solver not in ("auto", "taylor", "erk", "erk5", "erk9"),
        "friction in the plane, or delays": sizes.get("n_cones", 0) + sizes.get("n_delays", 0) > 0,
        "events beside inputs, loops or guards, or in steps that are not those of series": sizes.get("n_switches", 0) > 0,
        "forces that are narrow, which steps alone look for": sizes.get("n_looks", 0) > 0,
        "one degree of freedom that swings back the way it came": is_free and sizes.get("is_swing", 0) > 0,
        "loops, which have some by erk, erk5 and erk9": is_free and has_loops,
        "loops of bodies that turn freely in space": has_loops and sizes.get("n_attitudes", 0) > 0,
    }
    return next((why for why, is_so in reasons.items() if is_so), "a measure, or a choice of auto, that they do not serve")


def _summarise(sweep: Sweep, target: str, now: int, has_stats: bool) -> None:
    out = sys.stdout if target != "-" else sys.stderr

    def say(text: str) -> None:
        print(text, file=out)

    failed = sweep.runs - int(sweep.ok.sum())
    rate = f" ({now / sweep.seconds:.0f} runs a second)" if now and sweep.seconds > 0 else ""
    say(f"{sweep.job.scene.name}: {sweep.runs} runs, {failed} failed, in {sweep.seconds:.3g} s{rate}")
    say(f"  {sweep.experiment}")
    for what, count in sweep.common_failures() if failed else []:
        say(f"  {count} failed: {what}")
    for measure in sweep.job.measures[:_MOST_SHOWN]:
        say(f"  {measure.text}: {_spread(sweep, measure)}")
        for line in told_of_chance(sweep, measure):
            say(f"    {line}")
    if sweep.job.until is not None:
        say(f"  {ended(sweep, sweep.job.until)}")
    steps = sweep.ledger.outcomes["steps"].sum()
    energy = float(sweep.ledger.outcomes["energy"][sweep.ok].max(initial=0.0))
    if has_stats:
        say(f"  {_in_lanes(sweep, now)}")
    by = ", ".join(methods_of_runs(sweep.ledger.outcomes["methods"]))
    accounts = f"; the energy accounts close to {energy:.1e} of the largest energy" if sweep.ok.any() else ""
    say(f"  {steps} steps{f' by {by}' if by else ''}{accounts}")
    if wrong := int((sweep.ledger.outcomes["energy"][sweep.ok] > DOUBTFUL).sum()):
        say(f"  they miss by more than a tenth in {wrong} of {sweep.runs} runs: unless at rest, the motion is probably wrong; "
            "compare with a smaller tolerance, or another solver")
    say(plain_text(f"  {sweep.runs} rows in {target}"))


def _spread(sweep: Sweep, measure: Measure) -> str:
    """Least and largest value, the runs they come from, and how many runs that did not fail have none."""
    import numpy as np

    values = sweep[measure.text]
    if not np.isfinite(values).any():
        return "none"
    units = sweep.units()
    unit = units[len(sweep.job.variations.names) + sweep.job.measures.index(measure)]
    ends = []
    for k in (int(np.nanargmin(values)), int(np.nanargmax(values))):
        row = sweep.job.variations.values(k, k + 1)[0].tolist()
        varied = [f"{name} = {x:.6g}" for name, x in zip(sweep.job.variations.names[:3], row, strict=False)]
        ends.append(f"{values[k]:.6g}{f' {unit}' if unit else ''} (run {k}{': ' if varied else ''}{', '.join(varied)})")
    without = int((sweep.ok & np.isnan(values)).sum())
    return f"{ends[0]} to {ends[1]}{f'; {without} without a value' if without else ''}"
