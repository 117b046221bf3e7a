"""`lag draw`: the scene at one moment, as a picture."""

from argparse import Namespace

from lagrangia.base.result_files import is_device
from lagrangia.command.arguments import (
    assignments,
    keep_inputs,
    load_model,
    named_pairs,
    number,
    open_parameters,
    read_inputs,
    tell_warnings,
    values_with_units,
)
from lagrangia.draw.drawing import require_picture


def draw_command(options: Namespace) -> int:
    """`lag draw`: writes a picture. Raises LagError, RunError."""
    target = options.output or f"{options.file.stem}.svg"
    if target != "-" and not is_device(target):
        require_picture(target)
        keep_inputs(options, target)
    given = assignments(options.parameter, "-p")
    model = load_model(options, given, ())
    tell_warnings(options, model)
    initial = values_with_units(assignments(options.initial, "--initial"), model.scene.start_units)
    at = None if options.at is None else number(options.at, "--at")
    text = model.draw(None if target == "-" else target, at=at, names=named_pairs(options.names or "", "--names"),
                      parameters=open_parameters(model.scene, given), initial=initial,
                      inputs=read_inputs(options.input, model.scene))
    print(text.rstrip() if target == "-" else f"written to {target}")
    return 0
