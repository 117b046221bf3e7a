"""`lag equations`: options -> Request -> page."""

from argparse import Namespace
from pathlib import Path

from lagrangia.base.diagnostics import LagError, RunError
from lagrangia.base.result_files import keep_apart, write_text
from lagrangia.command.arguments import (
    assignments,
    keep_inputs,
    load_model,
    named_pairs,
    names_once,
    open_parameters,
    part_structural,
    tell_texts,
)
from lagrangia.run.request import Request as Drawn

_FORMATS = {".md": "markdown", ".html": "html", ".htm": "html", ".tex": "latex", ".py": "sympy"}  # by the endings of files


def equations_command(options: Namespace) -> int:
    """`lag equations`: prints or writes the equations of motion, or checks one (1 where it is wrong). Raises LagError."""
    from lagrangia.paper.sheet import Request, checked, idle_words, write_equations

    keep_inputs(options, options.output)
    options.format = options.format or _FORMATS.get(Path(options.output or "").suffix.lower(), "text")
    structural, parameters = part_structural(options, assignments(options.parameter, "-p"))
    about = None if options.about is None else named_pairs(options.about, "--about")
    names = named_pairs(options.names or "", "--names")
    request = Request(options.form, options.format, names, parameters, options.numbers, options.force, about, options.sources,
                      options.level, names_once(options.sections, "--sections"), options.first_letter, _figure(options, names),
                      options.language, options.fragment, options.angles or "")
    if options.check is not None:
        is_right, told = checked(options.file, options.check, request, options.model, structural)
        print(told)
        return 0 if is_right else 1
    text = write_equations(options.file, request, options.model, structural)
    vain = [f"warning[L0224]: --names {letter}={names[letter]} has no effect: '{letter}' stands nowhere on this page"
            for letter in text.idle]
    vain += [f"warning[L0224]: {what}" for what in idle_words(text, options.file, request, options.model, structural)]
    tell_texts(options, [*text.warnings, *vain])
    if options.output in (None, "-"):
        print(text)
    else:
        keep_apart([options.output], text.files)
        write_text(Path(options.output), text + "\n")
        print(f"written to {options.output}")
    return 0


def _figure(options: Namespace, names: dict[str, str]) -> str:
    """What derivations and statements of problems show, as SVG on pages of HTML and as TikZ in LaTeX, but not in fragments, which
    need amsmath alone; "" where the scene has no start to be drawn at."""
    has_room = options.format == "html" or (options.format == "latex" and not options.fragment)
    if not has_room or options.form not in ("worked", "exercise") or options.check is not None:
        return ""
    from lagrangia.draw.svg import write_svg
    from lagrangia.draw.tikz import write_tikz
    from lagrangia.solids.showing import page_any

    given = assignments(options.parameter, "-p")
    model = load_model(options, given, ())
    known = {name: symbol for name, symbol in names.items() if name in model.coordinate_names}
    try:
        page = page_any(model, Drawn(parameters=open_parameters(model.scene, given)), known)
        if not page.paths:
            return ""
        return write_svg(page) if options.format == "html" else write_tikz(page)
    except (LagError, RunError):
        return ""
