"""`lag animate`: a run, and a page or a film that shows it."""

import sys
from argparse import Namespace

from lagrangia.base.checked_values import a_count_within
from lagrangia.base.diagnostics import RunError
from lagrangia.base.spelling import plain_text
from lagrangia.command.arguments import (
    keep_inputs,
    keep_other,
    load_asked,
    named_pairs,
    names_once,
    tell_broken,
    tell_inputs,
    titles,
    view_asked,
)
from lagrangia.command.beside import requests_beside
from lagrangia.draw.drawing import require_picture
from lagrangia.draw.film import MOST_POSITIONS
from lagrangia.model import Model
from lagrangia.run.request import Request, plan
from lagrangia.solids.showing import animate_any, require_any, stroboscope_of_any
from lagrangia.view.trajectory import Trajectory


def animate_command(options: Namespace) -> int:
    """`lag animate`: writes the file. Raises LagError, RunError."""
    target = _target(options)
    model, request = load_asked(options)
    keep_other(options, target, *titles(model))
    others = requests_beside(model, request, options.beside)
    tell_inputs(options, model, plan(model.scene, request), request.inputs)
    run, failure = run_as_far(model, request)
    beside = {label: model.run(other) for label, other in others}
    for shown in (run, *beside.values()):
        tell_broken(options, model, shown.progress)
    traces = names_once(options.trace, "--trace")
    if options.stroboscope is not None:
        stroboscope_of_any(run, options.stroboscope, target, traces)
    else:
        animate_any(run, target, names=named_pairs(options.names or "", "--names"), traces=traces, beside=beside,
                    quantities=names_once(options.curves, "--curves"), tell=_tell if sys.stderr.isatty() else None,
                    note=lambda text: print(f"note: {text}", file=sys.stderr), view=view_asked(options.view))
    print(plain_text(f"written to {target}"))
    if failure is not None:
        raise RunError(f"{failure}\nwhat was computed before is shown in {target}")
    return 0


def run_as_far(model: Model, request: Request) -> tuple[Trajectory, RunError | None]:
    """The motion, as far as it goes, and what stopped it. Raises LagError; RunError where nothing was computed."""
    try:
        return model.run(request), None
    except RunError as error:
        if error.trajectory is None or not len(error.trajectory.rows):
            raise
        return error.trajectory, error


def _target(options: Namespace) -> str:
    target: str = options.output or options.file.stem + (".html" if options.stroboscope is None else ".svg")
    if options.stroboscope is not None:
        a_count_within("number of positions", options.stroboscope, 1, MOST_POSITIONS)
        require_picture(target)
    else:
        require_any(target)
    keep_inputs(options, target)
    return target


def _tell(done: int, whole: int) -> None:
    sys.stderr.write(f"\r[{'#' * (30 * done // whole):.<30}] {done} of {whole} pictures")
    if done == whole:
        sys.stderr.write("\r" + " " * 60 + "\r")
    sys.stderr.flush()
