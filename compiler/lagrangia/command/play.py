"""`lag play`: a page that computes the motion of a scene, written or opened."""

import tempfile
from argparse import Namespace
from pathlib import Path

from lagrangia.base.diagnostics import RunError, fail
from lagrangia.base.spelling import plain_text
from lagrangia.command.arguments import keep_inputs, load_asked, named_pairs, names_once, tell_inputs
from lagrangia.play.player import play_scene
from lagrangia.play.wasm import require_zig
from lagrangia.run.request import plan


def play_command(options: Namespace) -> int:
    """`lag play`: writes the page; without -o to a temporary file, which is opened. Raises LagError, RunError."""
    if options.output is not None:
        if not options.output.lower().endswith(".html"):
            fail("L0004", f"'{options.output}' is no page that can be written", None, "its name should end in .html")
        keep_inputs(options, options.output)
    require_zig()
    model, request = load_asked(options)
    tell_inputs(options, model, plan(model.scene, request), request.inputs)
    target = options.output or _temporary(options.file.stem)
    failure = play_scene(model, target, request, named_pairs(options.names or "", "--names"),
                         names_once(options.trace, "--trace"))
    print(plain_text(f"written to {target}"))
    if options.output is None:
        _open(Path(target))
    if failure is not None:
        raise RunError(f"{failure}\nwith other values it may go on: {target} computes them")
    return 0


def _temporary(stem: str) -> str:
    with tempfile.NamedTemporaryFile(prefix=f"{stem}-", suffix=".html", delete=False) as file:
        return file.name


def _open(page: Path) -> None:
    import webbrowser

    if not webbrowser.open(page.as_uri()):
        print("no browser was found: open it in one")
