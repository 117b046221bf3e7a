"""`lag equilibrium`, `linearize`, `modes` and `response`: options -> numbers -> text, tables and pictures."""

import json
import math
from argparse import Namespace
from pathlib import Path
from typing import Any

from lagrangia.base.checked_values import MOST_POINTS, MOST_STARTS, a_count_within, a_frequency, a_span
from lagrangia.base.diagnostics import RunError, fail
from lagrangia.base.result_files import write_text
from lagrangia.command.arguments import keep_inputs, load_asked, names_once, number, refuse_idle_sharing, tell, view_asked
from lagrangia.model import Model
from lagrangia.view.curves import require_format


def equilibrium_command(options: Namespace) -> int:
    """Exit code 1 where there is no equilibrium to be found."""
    from lagrangia.study.text import equilibria_text

    if options.starts is not None:
        a_count_within("number of starts", options.starts, 1, MOST_STARTS)
    _require(options.output, ".json")
    model, values = _load(options)
    refuse_idle_sharing(model, tells_reactions=True)
    found = model.equilibrium(**values, starts=options.starts)
    if not found.found:
        raise RunError("; ".join(["no equilibrium was found: from all starts, forces stay unbalanced or it runs away",
                                  "try other values with --initial, or more --starts", *found.notes]))
    _say(options, model, equilibria_text(found))
    if options.output is not None:
        _write(options.output, [_plain(item) for item in found.found])
    return 0


def _plain(item: Any) -> dict[str, Any]:
    plain = {name: getattr(item, name) for name in ("stability", "potential", "growth", "n_neutral", "residual", "ways")}
    plain["growth"] = None if math.isnan(item.growth) else item.growth
    pairs = [[x.real, x.imag] for x in item.eigenvalues]
    return {"position": dict(item.position), **plain, "eigenvalues": pairs, "reactions": dict(item.reactions),
            "contacts": dict(item.contacts), "friction": dict(item.friction)}


def linearize_command(options: Namespace) -> int:
    """`lag linearize`: the matrices of small motion as text, or in a file. Raises LagError, RunError."""
    from lagrangia.study.text import linearization_text

    _require(options.output, ".json", ".mat", ".npz")
    model, values = _load(options)
    linear = model.linearize(**values, about=options.about, excitations=_names(options.excite, "--from"),
                             outputs=_names(options.to, "--to"))
    _say(options, model, linearization_text(linear))
    if options.output is not None:
        print(f"\nmatrices in {linear.save(options.output)}")
    return 0


def modes_command(options: Namespace) -> int:
    """`lag modes`: frequencies, damping and shapes as text, in a file, as a picture, as a page. Raises LagError, RunError."""
    from lagrangia.solids.showing import require_any
    from lagrangia.study.text import modes_text

    _require(options.output, ".json")
    if options.plot is not None:
        require_format(options.plot)
    if options.animate is not None:
        require_any(options.animate)
    model, values = _load(options)
    modes = model.modes(**values, about=options.about, mass_normalised=options.mass_normalised)
    _say(options, model, modes_text(modes))
    if options.output is not None:
        _write(options.output, modes.to_dict())
    if options.plot is not None:
        modes.plot(options.plot)
        print(f"picture in {options.plot}")
    if options.animate is not None:
        _animate(options, model, modes, values)
    return 0


def _animate(options: Namespace, model: Model, modes: Any, values: dict[str, Any]) -> None:
    from lagrangia.solids.modes_film import animate_mode_of_any

    if not len(modes):
        fail("L0706", "--animate: there is no mode to be shown")
    number = a_count_within("number of the mode", options.mode, 1, len(modes))
    animate_mode_of_any(model.fitting(values["parameters"]), model.study(**values), modes, number - 1, options.animate,
                        view_asked(options.view))
    print(f"mode {number} in {options.animate}")


def response_command(options: Namespace) -> int:
    """`lag response`: a frequency response as text, in a file, as a picture. Raises LagError, RunError."""
    from lagrangia.study.text import response_text

    _require(options.output, ".csv")
    if options.plot is not None:
        require_format(options.plot)
    a_count_within("number of points", options.points, 2, MOST_POINTS)
    frequencies = None if options.at is None else sorted({a_frequency(number(text, "--at")) for text in options.at.split(",")})
    span = _span(options.range)
    model, values = _load(options)
    response = model.response(_names(options.excite, "--from"), _names(options.to, "--to"), **values, about=options.about,
                              frequencies=frequencies, span=span, points=options.points)
    _say(options, model, response_text(response))
    if options.output is not None:
        print(f"{response.frequencies.size} rows in {response.to_csv(options.output)}")
    if options.plot is not None:
        response.plot(options.plot)
        print(f"picture in {options.plot}")
    return 0


def _say(options: Namespace, model: Model, text: str) -> None:
    """Prints what was found; warnings among its remarks go where all warnings go. Raises LagError L0710."""
    lines = text.splitlines()
    warnings = [line for line in lines if line.lstrip().startswith("warning[")]
    tell(options, model, [line.strip() for line in warnings])
    print("\n".join(line for line in lines if line not in warnings))


def _load(options: Namespace) -> tuple[Model, dict[str, Any]]:
    """The model and the numbers it is looked at with. Raises LagError."""
    keep_inputs(options, options.output, getattr(options, "animate", None))
    model, asked = load_asked(options)
    return model, {"parameters": asked.parameters, "initial": asked.initial, "inputs": asked.inputs, "time": options.time}


def _names(text: str | None, option: str) -> tuple[str, ...] | None:
    """Names between commas, each once; None where nothing is said. Raises LagError L0706, L0711."""
    return None if text is None else names_once(text, option)


def _span(text: str | None) -> tuple[float, float] | None:
    if text is None:
        return None
    low, colon, high = text.partition(":")
    if not colon:
        fail("L0706", f"'{text}' after --range is not of the form LOW:HIGH", None, "in Hz: --range 0.1:100")
    return a_span((number(low, "--range"), number(high, "--range")))


def _require(path: str | None, *endings: str) -> None:
    if path is not None and Path(path).suffix not in endings:
        fail("L0004", f"'{path}' is no file that can be written here", None, f"its name should end in {' or '.join(endings)}")


def _write(path: str, plain: Any) -> None:
    write_text(Path(path), json.dumps(plain, indent=1, allow_nan=False) + "\n")
    print(f"written to {path}")
