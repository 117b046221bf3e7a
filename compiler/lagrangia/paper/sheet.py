"""`lag equations`: from a file to a page. Imports SymPy, so only what asks for equations imports this."""

import re
from collections.abc import Callable, Mapping
from dataclasses import field, replace
from functools import cache
from pathlib import Path
from typing import Any

from lagrangia.algebra.normal_form import TooLarge
from lagrangia.base.attitude_values import SEQUENCES
from lagrangia.base.checked_values import a_text
from lagrangia.base.diagnostics import LagError, fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.compile.pipeline import compile_energies, compile_file, deep_recursion
from lagrangia.constraints.parameters import default_parameters, find_odd_inertias
from lagrangia.dynamics.impulses import rates_jump
from lagrangia.dynamics.negative_inertia import refuse_negative_inertia
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.frame_attributes import component_named
from lagrangia.language.given_values import Given
from lagrangia.language.values import read_value
from lagrangia.paper.book import Book
from lagrangia.paper.checking import check_equation
from lagrangia.paper.derivation import exercise_form, worked_form
from lagrangia.paper.document import Document
from lagrangia.paper.equations import constants_of_motion, derive, with_values
from lagrangia.paper.forms import FORMS
from lagrangia.paper.latex_page import as_fragment
from lagrangia.paper.linear_matrices import Begin, Linear, linearize
from lagrangia.paper.linear_page import linear_form, values_of
from lagrangia.paper.numbered import NUMBERED, WORDS, numbered_form
from lagrangia.paper.overview import structure_page
from lagrangia.paper.pages import PRINTERS, Page, names_in, printed
from lagrangia.paper.phrase_table import LANGUAGES
from lagrangia.paper.phrases import spoken
from lagrangia.paper.symbolic import SymbolicScene, build_symbolic
from lagrangia.paper.sympy_script import write_script
from lagrangia.paper.textbook import letters_of, name_symbols, presentation_of
from lagrangia.run.formulas import Formulas
from lagrangia.run.request import check_values

ALL_FORMS = (*FORMS, *NUMBERED, "linear", "worked", "exercise")
SOURCES = ("auto", "potential", "force")
LEVELS = ("short", "full", "lecture")
ALL_FORMATS = (*PRINTERS, "sympy")
MOST_TERMS, MOST_WORKED_TERMS = 700, 300  # of equations that fill two pages, and whose derivation fills six
MOST_KINETIC_TERMS = 250
MOST_COORDINATES, MOST_FORCED_COORDINATES = 24, 60
MOST_PRODUCTS, MOST_FORCED_PRODUCTS = 20_000, 200_000  # some 0.2 ms each
_DIGITS = 6
_FORMS_OF_SCRIPTS = tuple(form for form in ALL_FORMS if form != "exercise")  # whose solution is not told


@dataclass(frozen=True)
class Request:
    """What is asked for. `names` maps source names to names on paper, `about` coordinates to the point of the linear form."""

    form: str = "lagrange"
    format: str = "text"
    names: Mapping[str, str] = field(default_factory=dict)
    parameters: Given = field(default_factory=dict)
    has_numbers: bool = False
    is_forced: bool = False
    about: Mapping[str, str] | None = None
    sources: str = "auto"  # whether loads of time stand in V_f, "potential", or on the right, "force"
    level: str = "full"
    sections: tuple[str, ...] = ()
    first_letter: str = "a"
    figure: str = ""  # an SVG's text, for pages of HTML, or TikZ, for LaTeX
    language: str = "en"
    is_fragment: bool = False  # of LaTeX: what stands in a document of one's own
    angles: str = ""  # the sequence of axes by whose angles attitudes are written

    @property
    def has_quaternions(self) -> bool:
        """Whether attitudes are known by their quaternions, and move by Euler's equations."""
        return not self.angles and self.form in FORMS and self.format != "sympy"

    @property
    def has_source_potentials(self) -> bool:
        """By themselves, numbered forms and the derivation have them."""
        return self.sources == "potential" or (self.sources == "auto" and self.form in (*NUMBERED, "worked", "exercise"))


def write_equations(path: Path, request: Request, model: str | None = None, structural: Mapping[str, Any] | None = None) -> Page:
    """The page. Raises LagError: L0702 for what is no text, L0704 an unknown form or format, L0711 names, L0712 too large, L0713
    no equilibrium."""
    for what in ("form", "format", "language"):
        a_text(what, getattr(request, what))
    request = replace(request, form=WORDS.get(request.form, request.form))
    _choose("form", request.form, ALL_FORMS)
    _choose("sources", request.sources, SOURCES)
    _choose("level", request.level, LEVELS)
    _choose("language", request.language, LANGUAGES)
    if not re.fullmatch("[a-z]{1,2}", request.first_letter):
        fail("L0704", f"--first-letter: '{request.first_letter}' is no letter", None, "one or two small letters: f, ab")
    _choose("format", request.format, ALL_FORMATS)
    if request.angles:
        _choose("sequence of angles", request.angles, SEQUENCES)
    if request.format == "sympy" and request.form not in _FORMS_OF_SCRIPTS:
        fail("L0704", f"there is no script of the form '{request.form}'", None,
             "an exercise has no solution to compute with; --format sympy has all other forms")
    if request.is_fragment and request.format != "latex":
        fail("L0704", f"--fragment: there are no fragments of the format '{request.format}'", None, "--format latex has them")
    kinematics, constraints = compile_energies(path, model, structural, request.parameters, bool(request.angles),
                                               request.has_quaternions)
    _check_size(kinematics, request)
    odd = find_odd_inertias(kinematics)
    odd.raise_errors()
    if request.has_numbers:
        refuse_negative_inertia(kinematics)
    with deep_recursion():
        scene = build_symbolic(kinematics, constraints, request.form == "linear", request.angles, request.format == "sympy")
        begin = cache(lambda: start_of(request.parameters, path, model, structural, request.angles))
        found = _written(kinematics, scene, request, begin, rates_jump(kinematics, constraints))
    flat = kinematics.graph.model
    told = (*flat.warnings, *odd.diagnostics)
    found.warnings = tuple(warning.render() for warning in told if warning.code not in flat.allowed)
    found.files = tuple(lookup.path for lookup in flat.lookups)
    return found


def idle_words(page: Page, path: Path, request: Request, model: str | None, structural: Mapping[str, Any]) -> list[str]:
    """What the page is the same without: --sources, and parameters that are given a value, on pages of symbols."""
    def is_idle(other: Request) -> bool:
        try:
            return write_equations(path, other, model, structural) == page
        except LagError:
            return False

    found, other = [], "force" if request.sources == "potential" else "potential"
    if request.sources != "auto" and is_idle(replace(request, sources=other)):
        found.append(f"--sources {request.sources} has no effect: with the other choice the page is the same")
    form = WORDS.get(request.form, request.form)
    if request.has_numbers or request.format == "sympy" or not (form in FORMS or form in NUMBERED):
        return found
    for name, value in request.parameters.items():
        if is_idle(replace(request, parameters={k: x for k, x in request.parameters.items() if k != name})):
            found.append(f"-p {name}={value} has no effect: this page is in symbols, --numbers writes values")
    return found


def written_book(path: Path, request: Request, model: str | None = None, structural: Mapping[str, Any] | None = None,
                 has_quaternions: bool = False) -> Book:
    """The equations for other writers, within the same limits; `has_quaternions`: programs, which know attitudes and signs.
    Raises LagError L0711, L0712."""
    kinematics, constraints = compile_energies(path, model, structural, request.parameters, bool(request.angles), has_quaternions)
    _check_size(kinematics, request)
    with deep_recursion():
        scene = build_symbolic(kinematics, constraints, angles=request.angles, is_signed=has_quaternions)
        limit = MOST_FORCED_PRODUCTS if request.is_forced else MOST_PRODUCTS
        try:
            e = derive(scene, limit, None if request.is_forced else MOST_KINETIC_TERMS)
        except TooLarge:
            fail("L0712", "the equations are too large to be written out", scene.kinematics.graph.model.span,
                 "--force tries longer; --to python and --to casadi take any scene")
        names = name_symbols(scene, request.names)
        return Book(e, presentation_of(e, names, 20 * limit), names, (), parameter_values(kinematics), False)


def _check_size(kinematics: Kinematics, request: Request) -> None:
    n = len(kinematics.symbols.positions)
    if n > (MOST_FORCED_COORDINATES if request.is_forced else MOST_COORDINATES):
        fail("L0712", f"the equations of {n} coordinates are too many to read", kinematics.graph.model.span,
             f"at most {MOST_COORDINATES}; with --force {MOST_FORCED_COORDINATES}",
             "model.functions() of the Python interface has M, h and the accelerations of any scene")


def _written(kinematics: Kinematics, scene: SymbolicScene, request: Request, begin: Callable[[], Begin],
             has_kicks: bool) -> Page:
    printer = as_fragment if request.is_fragment else PRINTERS.get(request.format)
    try:
        book = _book(kinematics, scene, request, has_kicks)
        if printer is None:
            return Page(_script(book, request, begin))
        found = printed(printer, _page(book, request, begin))
        there = {name.base for name in names_in(found.document)}
        found.idle = tuple(letter for letter, name in book.letters.items() if name.base not in there)
        return found
    except TooLarge as large:
        if not request.is_forced:
            return _too_large(scene, request, printer, large)
        fail("L0712", f"the equations are too large even when forced: they take more than {MOST_FORCED_PRODUCTS} products", None,
             "the energies and their structure are printed without --force")


def _book(kinematics: Kinematics, scene: SymbolicScene, request: Request, has_kicks: bool) -> Book:
    """Raises TooLarge."""
    values = parameter_values(kinematics)
    limit = MOST_FORCED_PRODUCTS if request.is_forced else MOST_PRODUCTS
    names = name_symbols(scene, request.names)
    numbered = with_values(scene, {p.symbol: values[p.name] for p in scene.parameters}) if request.has_numbers else scene
    is_bound = not request.is_forced and request.form != "linear"  # whose matrices are small, or numbers
    e = derive(numbered, limit, MOST_KINETIC_TERMS if is_bound else None)
    if is_bound and e.terms > (MOST_WORKED_TERMS if request.form == "worked" else MOST_TERMS):
        raise TooLarge(e.terms, e.T)
    presentation = presentation_of(e, names, 20 * limit, _DIGITS if request.has_numbers else 0)
    return Book(e, presentation, names, constants_of_motion(e), values, request.has_numbers, has_kicks,
                request.has_source_potentials, request.level, request.sections, request.first_letter,
                letters_of(scene, names, request.names))


def checked(path: Path, equation: str, request: Request, model: str | None = None,
            structural: Mapping[str, Any] | None = None) -> tuple[bool, str]:
    """Whether an equation is one of the scene, and what to say of it. Raises LagError as check_equation and written_book do."""
    def begin() -> Begin:
        return start_of(request.parameters, path, model, structural, request.angles)

    return check_equation(written_book(path, request, model, structural), equation, begin)


def page_of(path: Path, request: Request, model: str | None = None, structural: Mapping[str, Any] | None = None
            ) -> tuple[Book, Document]:
    """The page before it is printed, and what it was made of. Raises LagError, and TooLarge for what is too large to read."""
    kinematics, constraints = compile_energies(path, model, structural, request.parameters, bool(request.angles),
                                               request.has_quaternions)
    with deep_recursion():
        scene = build_symbolic(kinematics, constraints, request.form == "linear", request.angles)
        begin = cache(lambda: start_of(request.parameters, path, model, structural, request.angles))
        book = _book(kinematics, scene, request, rates_jump(kinematics, constraints))
        return book, _page(book, request, begin)


def _page(book: Book, request: Request, begin: Callable[[], Begin]) -> Document:
    return spoken(replace(_form(book, request, begin), figure=request.figure, language=request.language))


def _form(book: Book, request: Request, begin: Callable[[], Begin]) -> Document:
    if request.form == "exercise":
        return exercise_form(book)
    if request.form == "worked":
        return worked_form(book, _small(book, begin))
    if request.form == "linear":
        return linear_form(book, _linear(book, request, begin))
    return numbered_form(book, request.form) if request.form in NUMBERED else FORMS[request.form](book)


def _linear(book: Book, request: Request, begin: Callable[[], Begin]) -> Linear:
    about = None if request.about is None else _point(book, request.about)
    return linearize(book.equations, values_of(book), begin, about)


def _script(book: Book, request: Request, begin: Callable[[], Begin]) -> str:
    return write_script(book, request.form, _linear(book, request, begin) if request.form == "linear" else None)


def _small(book: Book, begin: Callable[[], Begin]) -> Linear | None:
    """The small motion that the derivation ends with, where nothing jumps and there is a position of rest."""
    if book.equations.scene.events or book.has_kicks:
        return None
    try:
        return linearize(book.equations, values_of(book), begin)
    except LagError as error:
        if any(d.code in ("L0912", "L0713") for d in error.diagnostics):
            return None
        raise


def start_of(parameters: Given, path: Path, model: str | None = None, structural: Mapping[str, Any] | None = None,
             angles: str = "") -> Begin:
    """The assembled start, from which positions of rest are sought. Raises LagError L0606 where it does not assemble, L0713 where
    attitudes are written by angles."""
    if angles:
        fail("L0713", "not supported yet: positions of rest in Euler's angles are not looked for", None,
             "name one: --about tip.theta=0.5")
    from lagrangia.study.analysis import Study

    compilation = compile_file(path, model, structural, formulas=Formulas(in_space=True), given=parameters)
    study = Study(compilation, check_values(compilation.scene), None)
    return Begin(study.start[0], study.reach, study.is_angle, study.is_preferred)


def _too_large(scene: SymbolicScene, request: Request, printer: Any, large: TooLarge) -> Page:
    if printer is None:
        fail("L0712", "the scene is too large for a script that people read", None, "--force writes it all the same")
    document = structure_page(scene, name_symbols(scene, request.names), large)
    return printed(printer, spoken(replace(document, language=request.language)))


def _choose(what: str, given: str, known: tuple[str, ...]) -> None:
    if given not in known:
        fail("L0704", f"there is no {what} '{given}'", None, *filter(None, [suggest(given, known)]),
             f"the {what}s are {', '.join(known)}")


def _point(book: Book, about: Mapping[str, str]) -> dict[str, float]:
    scene = book.equations.scene
    model = scene.kinematics.graph.model
    found = {}
    for name, text in about.items():
        if name not in scene.names:
            fail("L0706", f"--about: there is no coordinate '{name}'", None, *filter(None, [suggest(name, scene.names)]))
        variable = model.variables.get(name)
        found[name] = _scalar(name, text, variable.unit if variable else component_named(name).unit)
    return found


def _scalar(name: str, text: str, unit: str) -> float:
    try:
        value = read_value(text, unit)
    except ValueError as error:
        fail("L0706", f"{name} = {text}: {error}")
    if isinstance(value, list):
        fail("L0706", f"{name} = {text}: one number is needed")
    return value


# -------------------------------------------------------------------- numbers


def parameter_values(kinematics: Kinematics) -> dict[str, float]:
    """All parameters by name in SI units; g under world.gravity."""
    parameters = [v for v in kinematics.graph.model.variables.values() if v.kind == "parameter"]
    labels = [label for v in parameters for label, _ in v.elements()]
    numbers = dict(zip(labels, default_parameters(kinematics)[1].full().ravel().tolist(), strict=True))
    gravity = [abs(x) for label, x in numbers.items() if label.startswith("world.gravity[") and x]
    return numbers | ({"world.gravity": gravity[0]} if len(gravity) == 1 else {"world.gravity": 0.0})
