"""`lag draw`: the scene at one moment, as a picture."""

import sys
from argparse import Namespace

from lagrangia.base.result_files import is_device
from lagrangia.base.spelling import plain_text
from lagrangia.command.arguments import keep_inputs, keep_other, load_asked, named_pairs, number, titles, view_asked
from lagrangia.draw.drawing import require_picture
from lagrangia.solids.showing import draw_any


def draw_command(options: Namespace) -> int:
    """`lag draw`: writes a picture. Raises LagError, RunError."""
    target = options.output or f"{options.file.stem}.svg"
    if target != "-" and not is_device(target):
        require_picture(target)
        keep_inputs(options, target)
    if options.at is not None:
        number(options.at, "--at")  # one
    model, request = load_asked(options)
    keep_other(options, target, *titles(model))
    text = draw_any(model, None if target == "-" else target, request, named_pairs(options.names or "", "--names"),
                    lambda text: print(f"note: {text}", file=sys.stderr), view_asked(options.view))
    print(text.rstrip() if target == "-" else plain_text(f"written to {target}"))
    return 0
