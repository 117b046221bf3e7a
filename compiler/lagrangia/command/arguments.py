"""What the subcommands of `lag` share: what was written after them -> names, values in SI units, tables, the model."""

import os
import re
import sys
from argparse import Namespace
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from math import isfinite
from pathlib import Path
from typing import Any

from lagrangia.base.checked_values import a_length
from lagrangia.base.cutting import cut_pair, split_list, stem
from lagrangia.base.diagnostics import WARNINGS, fail, suggest
from lagrangia.base.folders import kept_remarks
from lagrangia.base.memory import keep_freed_memory
from lagrangia.base.result_files import keep_apart, require_kind
from lagrangia.base.spelling import read_number
from lagrangia.base.tables import read_input_table
from lagrangia.command.input_tables import named_tables, path_of, read_input, together
from lagrangia.compile.sources import refuse_others
from lagrangia.language.values import read_value
from lagrangia.model import Model
from lagrangia.run.formulas import AS_DECLARED
from lagrangia.run.remarks import given_remarks, input_remarks
from lagrangia.run.request import USUAL, Request
from lagrangia.run.simulate import Progress
from lagrangia.view.curves import require_format

_HEAD = 8192  # characters
_TABLES = (".csv", ".txt", ".dat")


def load_model(options: Namespace, given: list[tuple[str, str]], outputs: tuple[str, ...]) -> Model:
    """The model; parameters that turn out to be structural are compiled in, and its formulas are those that the others need.
    Raises LagError L0004 where a result would take the place of a table that it reads."""
    keep_freed_memory()
    names = {name for name, _ in given}
    structural = {}
    if names:
        known = _structural_names(options, outputs)
        structural = _structural_values(options, {name: text for name, text in given if name in known})
    model = Model(options.file, options.model, structural, outputs, replace(AS_DECLARED, least_squares=_sharing(options)))
    usual = (f"{options.file.stem}.csv", f"{options.file.stem}_sweep.csv")
    written = [getattr(options, name, None) for name in ("output", "plot", "animate")]
    keep_apart([*written, *(() if written[0] is not None else usual)], model.scene.notes["files"])
    model.native = {"native": True, "tape": False}.get(getattr(options, "engine", "auto"))
    model = model.fitting(open_parameters(model.scene, given))
    options.made = options, model  # each other: what ends with the process is not taken apart piece by piece before
    return model


def _sharing(options: Namespace) -> float | None:
    """The length after --least-squares, m. Raises LagError L0702, L0706."""
    text = getattr(options, "least_squares", None)
    if text is None:
        return None
    (length,) = values_with_units([("--least-squares", text)], {"--least-squares": "m"}).values()
    return a_length(length)


def refuse_idle_sharing(model: Model, tells_reactions: bool = False) -> None:
    """Raises LagError L0706 where --least-squares changes nothing; `tells_reactions`: whatever its outputs are made of."""
    if model.formulas.least_squares is None:
        return
    if not (tells_reactions or model.scene.notes["tells_reactions"]):
        fail("L0706", "--least-squares has no effect here", None, "no reactions are asked for: --reactions, or outputs")
    if not model.freedom["repeated"]:
        fail("L0706", "--least-squares has no effect here", None, "the mechanics leave no reaction open")


def tell(options: Namespace, model: Model, texts: Iterable[str]) -> None:
    """Warnings, but those whose code the model or the command line allows. Raises LagError L0710."""
    tell_texts(options, [text for text in texts if text.removeprefix("warning[")[:5] not in model.scene.notes["allowed"]])


def tell_texts(options: Namespace, texts: Iterable[str]) -> None:
    """Warnings, but those whose code the command line allows, and none under --quiet. Raises LagError L0710 where --strict is
    given, which takes them for errors: these are told."""
    allowed = allowed_codes(options)
    told = [text for text in texts if text.removeprefix("warning[")[:5] not in allowed]
    for text in told if options.strict or not getattr(options, "quiet", False) else ():
        print(text, file=sys.stderr)
    if told and options.strict:
        fail("L0710", f"{len(told)} warning{'s' if len(told) > 1 else ''}, which --strict takes for errors", None,
             'what is meant is allowed by its code: --allow L0224, or annotation(allow = "L0224") in the model')


def allowed_codes(options: Namespace) -> tuple[str, ...]:
    """Of warnings, by the command line. Raises LagError L0706 for those that do not exist."""
    given = split_names(",".join(options.allow))
    if unknown := [code for code in given if code not in WARNINGS]:
        fail("L0706", f"--allow: there is no warning '{unknown[0]}'", None, f"those are {', '.join(WARNINGS)}")
    return given


def tell_warnings(options: Namespace, model: Model) -> None:
    """What the model says in vain, in its own experiment or in the run that is asked for. Raises LagError L0706."""
    limits = model.scene.notes.get("timed_warnings", {})
    start, stop, at = getattr(options, "start", None), getattr(options, "stop", None), getattr(options, "at", None)
    if hasattr(options, "time"):  # of small motions, which are looked at then; --at has frequencies
        stop, at = options.time, None
    begin = model.scene.start if start is None else start
    end = stop if stop is not None else max(moments(at), default=model.scene.stop) if at is not None else model.scene.stop
    tell(options, model, [*kept_remarks(), *(text for text in model.warnings if text not in limits or (
        limits[text][0] <= begin and end <= limits[text][1]))])


def tell_inputs(options: Namespace, model: Model, experiment: Any, given: Any) -> None:
    """Says what the inputs do that have no value, declared or given, and those whose table ends before the run does."""
    tell(options, model, input_remarks(model.scene, experiment, given))


def tell_given(options: Namespace, model: Model, request: Request, more: Iterable[str] = ()) -> None:
    """Says which parameters are given in vain; `more` are names that each run of a sweep has values of."""
    tell(options, model, given_remarks(model, request, more))


def tell_broken(options: Namespace, model: Model, progress: Progress) -> None:
    """Says which assertions of level warning a run has broken. Raises LagError L0710."""
    tell(options, model, [warning.render() for warning in progress.warned])


def _structural_names(options: Namespace, outputs: tuple[str, ...]) -> set[str]:
    from lagrangia.run.cache import find_scene

    found = find_scene(options.file, options.model, {}, outputs)
    if found is not None:
        return set(found.structural)
    from lagrangia.compile.pipeline import flatten_file

    return set(flatten_file(options.file, options.model)[1].structural)


def part_structural(options: Namespace, given: list[tuple[str, str]]) -> tuple[dict[str, Any], dict[str, str]]:
    """Those that are structural, by their values, and the others, as they were written."""
    if not given:
        return {}, {}
    from lagrangia.compile.pipeline import flatten_file

    known = flatten_file(options.file, options.model)[1].structural
    return (_structural_values(options, {name: text for name, text in given if name in known}),
            {name: text for name, text in given if name not in known})


def _structural_values(options: Namespace, given: Mapping[str, str]) -> dict[str, Any]:
    """Raises LagError L0304 for units that do not fit, as if they were written in the model."""
    values = {name: _structural_value(text) for name, text in given.items()}
    told = {name: text for name, text in given.items() if "[" in text and not isinstance(values[name], str)}
    if told:
        from lagrangia.compile.pipeline import flatten_file
        from lagrangia.language.dimensions import check_dimensions
        from lagrangia.language.overrides import as_written

        written = {name: as_written(name, text) for name, text in told.items()}
        flat = check_dimensions(flatten_file(options.file, options.model, {**values, **written})[1])
        tell_texts(options, [x.render() for x in flat.warnings if x.code == "L0305" and x.span is not None
                             and x.span.source.name.startswith("the value given")])
    return values


def _structural_value(text: str) -> Any:
    if text in ("true", "false"):
        return text == "true"
    try:
        return read_value(text, None)
    except ValueError:
        return text


# -------------------------------------------------------------------- names, numbers and tables


def split_names(text: str | None) -> tuple[str, ...]:
    """Names between commas; a comma in brackets or parentheses belongs to its name, x[1,2]. Raises LagError L0711."""
    return tuple(split_list(text or ""))


def assignment(text: str, option: str) -> tuple[str, str]:
    """`NAME=VALUE`. Raises LagError L0706."""
    name, equals, value = cut_pair(text)
    if not equals or not name.strip() or not value.strip():
        fail("L0706", f"'{text}' after {option} is not of the form NAME=VALUE")
    return name.strip(), value.strip()


def assignments(texts: Iterable[str], option: str) -> list[tuple[str, str]]:
    """`NAME=VALUE`, each name once, be it that of an array or of one of its elements. Raises LagError L0706, L0712."""
    pairs = [assignment(text, option) for text in texts]
    names: set[str] = set()
    for name, _ in pairs:
        base = stem(name)
        if name in names or base in names or (name == base and any(other.startswith(f"{name}[") for other in names)):
            fail("L0712", f"'{name}' is given twice", None, f"{option} takes each name once")
        names.add(name)
    return pairs


def names_once(text: str | None, option: str) -> tuple[str, ...]:
    """Names between commas, each once, at least one. Raises LagError L0706."""
    names = split_names(text)
    if text is not None and not names:
        fail("L0706", f"{option} names nothing", None, "names of quantities with commas between them: tilt.phi,bar.a.y")
    if (twice := next((name for name in names if names.count(name) > 1), None)) is not None:
        fail("L0706", f"{option} names '{twice}' twice")
    return names


def named_pairs(text: str, option: str) -> dict[str, str]:
    """`NAME=VALUE,NAME=VALUE`, each name once. Raises LagError L0706."""
    return dict(assignments(split_names(text), option))


def number(text: str, option: str) -> float:
    """A number after an option. Raises LagError L0706."""
    try:
        return read_number(text)
    except ValueError:
        fail("L0706", f"'{text}' after {option} is no number")


def moments(texts: str) -> list[float]:
    """Those after --at, s. Raises LagError L0706."""
    return [number(text, "--at") for text in texts.split(",") if text.strip()]


def view_asked(text: str | None) -> tuple[float, float] | None:
    """Azimuth and elevation after --view, degrees. Raises LagError L0706."""
    if text is None:
        return None
    found = [number(part, "--view") for part in text.split(",")]
    if len(found) != 2 or not all(isfinite(x) for x in found) or abs(found[1]) > 90:
        fail("L0706", f"--view {text}: an azimuth and an elevation from -90 to 90 are needed, in degrees", None,
             "--view=-60,22 is the usual one, --view=-90,0 from the front, --view=-90,90 from above")
    return found[0], found[1]


def asked(options: Namespace, parameters: Mapping[str, Any], initial: Mapping[str, Any], inputs: Any,
          outputs: Sequence[str] = ()) -> Request:
    """What the options ask of a run, with the values that were read for it."""
    def given(name: str) -> Any:
        return getattr(options, name, getattr(USUAL, name))

    texts = getattr(options, "at", None)
    at = None if texts is None else moments(texts)
    return Request(given("start"), given("stop"), given("tolerance"), given("interval"), at, given("solver"), given("max_step"),
                   given("max_steps"), parameters, initial, inputs, outputs)


def load_given(options: Namespace, outputs: tuple[str, ...] = ()) -> tuple[Model, dict[str, float]]:
    """The model, whose warnings are told, and the parameters that stay open, of commands that take no start values; what is given
    in vain is told. Raises LagError."""
    given = assignments(options.parameter, "-p")
    model = load_model(options, given, outputs)
    tell_warnings(options, model)
    parameters = open_parameters(model.scene, given)
    tell_given(options, model, Request(parameters=parameters))
    return model, parameters


def load_asked(options: Namespace) -> tuple[Model, Request]:
    """The model, whose warnings are told, and what the options ask of a run of it. Raises LagError."""
    given = assignments(options.parameter, "-p")
    model = load_model(options, given, ())
    tell_warnings(options, model)
    initial = start_values(options.initial, model.scene)
    request = asked(options, open_parameters(model.scene, given), initial, read_inputs(options.input, model.scene))
    tell_given(options, model, request)
    return model, request


def start_values(texts: Iterable[str], scene: Any) -> dict[str, Any]:
    """What stands after --initial: attitudes as they are written, all else in SI units. Raises LagError L0706, L0712."""
    given = assignments(texts, "--initial")
    attitudes = {name: text for name, text in given if name in scene.attitudes}
    return {**attitudes, **values_with_units([pair for pair in given if pair[0] not in attitudes], scene.start_units)}


def open_parameters(scene: Any, given: list[tuple[str, str]]) -> dict[str, float]:
    """Those given that are not structural, in SI units."""
    return values_with_units([(name, value) for name, value in given if stem(name) not in scene.structural],
                             {p.name: p.unit for p in scene.parameters})


def values_with_units(given: list[tuple[str, str]], units: dict[str, str]) -> dict[str, float]:
    """Values in SI units; `world.gravity={0,0}` sets the elements of an array. Raises LagError L0706."""
    found: dict[str, Any] = {}
    for name, text in given:
        elements = [known for known in units if re.fullmatch(rf"{re.escape(name)}\[[\d,]+\]", known)]
        try:
            value = read_value(text, units.get(elements[0] if elements else name))
        except ValueError as error:
            fail("L0706", f"{name} = {text}: {error}")
        count = len(value) if isinstance(value, list) else 0
        if count != len(elements) and (elements or name in units):
            wanted = f"{len(elements)} numbers in braces" if elements else "one number"
            fail("L0706", f"{name} = {text}: {wanted} {'are' if elements else 'is'} needed, not {count or 'one'}")
        found |= dict(zip(elements, value, strict=True)) if isinstance(value, list) and elements else {name: value}
    return found


def input_tables(given: list[str]) -> list[str]:
    """The files among them."""
    named = named_tables(given)
    return [*whole_tables(given, named), *map(path_of, named.values())]


def whole_tables(given: list[str], named: Mapping[str, str]) -> list[str]:
    """The files among them that have a column for each input; `named` are those of single ones."""
    return [text for text in given if not cut_pair(text)[1] or (Path(text).suffix == ".csv" and not is_named(text, named))]


def is_named(text: str, named: Mapping[str, str]) -> bool:
    """Whether it gives the table of one input."""
    name, _, path = cut_pair(text)
    return named.get(name) == path


def read_inputs(given: list[str], scene: Any) -> Any:
    """Constants by name, or a table of one CSV file with a column `time` and of files for inputs by their names, in SI units.
    Raises LagError L0301, L0701, L0703, L0706, L0712."""
    named = named_tables(given)
    files = whole_tables(given, named)
    moving = {scene.inputs[piece[0]].name for piece in scene.pieces if piece[1] >= 0}
    units = {p.name: p.unit for p in scene.inputs}
    others = (text for text in given if text not in files and not is_named(text, named))
    constants = values_with_units(assignments(others, "-u"), units)
    if not files and not named:
        return constants
    if len(files) > 1:
        fail("L0703", "one table of inputs can be given", None, "put its columns into one file, or name each: -u NAME=FILE")
    if unknown := next((name for name in named if name not in units), None):
        fail("L0701", f"the scene has no input '{unknown}'", None, *filter(None, [suggest(unknown, units)]))
    tables = [read_input_table(Path(file)) for file in files] + [read_input(name, units[name], named[name], name in moving)
                                                            for name in named]
    known = Counter([*constants, *(name for _, columns in tables for name in columns)])
    if twice := sorted(name for name, count in known.items() if count > 1):
        fail("L0712", f"'{twice[0]}' is given twice", None, f"by -u, and by a column of '{(*files, *named.values())[0]}'")
    times, columns = together(tables)
    return times, {**columns, **{name: [value] * len(times) for name, value in constants.items()}}


# -------------------------------------------------------------------- where results go


def prepare_target(options: Namespace, kinds: Sequence[str] = _TABLES) -> str:
    """Where the rows go. Raises LagError L0004 for a place, or a picture's, that results cannot take."""
    if options.file.suffix.lower() != ".fmu":
        refuse_others(options.file)
    target: str = options.output or f"{options.file.stem}.csv"
    require_kind(target, *kinds)
    if options.plot is not None:
        require_format(options.plot)
    if options.dump is None:
        keep_inputs(options, target)
    return target


def keep_foreign(options: Namespace, target: str, names: Sequence[str]) -> None:
    """Raises LagError L0004 where nobody named a file for the results and the usual one holds something else: a file that has not
    all these names in its first line."""
    if options.output is not None or not os.path.isfile(target):
        return
    import csv

    try:
        with open(target, newline="", encoding="utf-8") as stream:
            head = next(csv.reader(stream), [])
    except (OSError, UnicodeDecodeError, csv.Error):
        head = ["?"]
    if head and not set(names) <= set(head):
        fail("L0004", f"'{target}' is there already, and holds none of these results: it is kept", None,
             f"-o {target} writes over it; another name after -o keeps it")


def keep_other(options: Namespace, target: str | Path, *signs: str) -> None:
    """Raises LagError L0004 where nobody named a file for what is written and the usual one holds something else: a file that has
    none of these signs of ours near its beginning."""
    if options.output is not None or not os.path.isfile(target):
        return
    try:
        with open(target, encoding="utf-8", errors="replace") as stream:
            head = stream.read(_HEAD)
    except OSError:
        head = "?"
    if head and not any(sign in head for sign in signs):
        fail("L0004", f"'{target}' is there already, and nothing of this scene that Lagrangia wrote: it is kept", None,
             f"-o {target} writes over it; another name after -o keeps it")


def titles(model: Model) -> list[str]:
    """Of its pictures and pages: signs by which they are known again."""
    from html import escape

    return [f"<title>{escape(text)}</title>" for text in (model.name, model.scene.description) if text]


def keep_inputs(options: Namespace, *targets: str | Path | None) -> None:
    """Raises LagError L0004 where a result would take the place of the model or of a table that is read."""
    tables = [*input_tables(getattr(options, "input", [])), *getattr(options, "overlay", []),
              *(text for text in getattr(options, "beside", []) if "=" not in text)]
    keep_apart([*targets, getattr(options, "plot", None)], [options.file, *tables])
