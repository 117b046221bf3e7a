"""`lag animate`: a run, and a page or a film that shows it."""

import sys
from argparse import Namespace

from lagrangia.base.checked_values import a_count_within
from lagrangia.base.diagnostics import RunError, fail
from lagrangia.command.arguments import (
    assignments,
    keep_inputs,
    load_model,
    named_pairs,
    names_once,
    open_parameters,
    read_inputs,
    tell_inputs,
    tell_warnings,
    values_with_units,
)
from lagrangia.command.run_picture import beside_request, refuse_twice
from lagrangia.draw.drawing import require_picture
from lagrangia.draw.film import animate_run, draw_stroboscope, require_film
from lagrangia.draw.several import Beside
from lagrangia.model import Model
from lagrangia.run.request import Request, check_values, plan
from lagrangia.view.trajectory import Trajectory

_MOST_POSITIONS = 200


def animate_command(options: Namespace) -> int:
    """`lag animate`: writes the file; of a run that fails what was computed. Raises LagError, RunError."""
    target = _target(options)
    given = assignments(options.parameter, "-p")
    model = load_model(options, given, ())
    tell_warnings(options, model)
    initial = values_with_units(assignments(options.initial, "--initial"), model.scene.start_units)
    request = Request(options.start, options.stop, options.tolerance, options.interval, initial=initial,
                      parameters=open_parameters(model.scene, given), inputs=read_inputs(options.input, model.scene))
    refuse_twice("--beside", options.beside)
    others = [(text, beside_request(model, request, text)) for text in options.beside]
    tell_inputs(options, model, plan(model.scene, request), request.inputs)
    failure: RunError | None = None
    try:
        run = model.run(request)
    except RunError as error:
        if error.trajectory is None or not len(error.trajectory.rows):
            raise
        run, failure = error.trajectory, error
    beside = [_beside(model, text, other) for text, other in others]
    _write(options, model, run, request, target, beside)
    print(f"written to {target}")
    if failure is not None:
        raise RunError(f"{failure}\nwhat was computed before is shown in {target}")
    return 0


def _target(options: Namespace) -> str:
    target: str = options.output or options.file.stem + (".html" if options.stroboscope is None else ".svg")
    if options.stroboscope is not None:
        a_count_within("number of positions", options.stroboscope, 1, _MOST_POSITIONS)
        for option, value in (("--curves", options.curves), ("--names", options.names), ("--beside", options.beside)):
            if value:
                fail("L0706", f"{option} has no place in a picture of many positions", None, "leave it out")
        require_picture(target)
    else:
        require_film(target)
        for option, value in (("--curves", options.curves), ("--names", options.names), ("--trace", options.trace)):
            if value is not None and not target.lower().endswith(".html"):
                fail("L0918", f"not supported yet: {option} in a film", None, "write .html")
    keep_inputs(options, target)
    return target


def _beside(model: Model, label: str, request: Request) -> Beside:
    """Raises LagError; RunError where it fails."""
    fitting = model.fitting(request.parameters)
    return Beside(label, fitting, model.run(request),
                  check_values(fitting.scene, request.parameters, request.initial, request.inputs))


def _write(options: Namespace, model: Model, run: Trajectory, request: Request, target: str, beside: list[Beside]) -> None:
    values = check_values(model.scene, request.parameters, request.initial, request.inputs)
    traces = names_once(options.trace, "--trace")
    if options.stroboscope is not None:
        draw_stroboscope(model, run, values, options.stroboscope, target, traces)
        return
    animate_run(model, run, values, target, names=named_pairs(options.names or "", "--names"), traces=traces,
                quantities=names_once(options.curves, "--curves"), tell=_tell if sys.stderr.isatty() else None, beside=beside)


def _tell(done: int, whole: int) -> None:
    sys.stderr.write(f"\r[{'#' * (30 * done // whole):.<30}] {done} of {whole} pictures")
    if done == whole:
        sys.stderr.write("\r" + " " * 60 + "\r")
    sys.stderr.flush()
