"""What `lag` understands: its subcommands, each with the functions that add its options and run it.

Both are imported when the subcommand is called.
"""

import argparse
import re
import sys
from collections.abc import Callable
from importlib import import_module
from typing import Any, NoReturn

from lagrangia.base.records import dataclass
from lagrangia.base.spelling import read_number, read_whole
from lagrangia.base.version import VERSION

WRONG = 2  # the exit code


@dataclass(frozen=True)
class _Command:
    """`run` is what does it and `options` what adds its options: "module of this room:function"."""

    name: str
    about: str
    run: str
    options: str


_RUNS, _STUDIES, _PICTURES, _TEXTS = "run_options", "study_options", "picture_options", "text_options"
_EDITS = "editor_options"
COMMANDS = (
    _Command("simulate", "compute the motion of a scene, or of any FMU", "simulate:simulate_command", f"{_RUNS}:add_simulate"),
    _Command("sweep", "run a scene many times, with other parameters and start values", "sweep:sweep_command",
             f"{_RUNS}:add_sweep"),
    _Command("check", "look for errors without running", "check:check_command", f"{_TEXTS}:add_check"),
    _Command("explain", "say what a scene needs of a general simulation, and what it skips", "explain:explain_command",
             f"{_TEXTS}:add_explain"),
    _Command("bench", "measure run time against error, beside other solvers", "bench:bench_command", f"{_RUNS}:add_bench"),
    _Command("equations", "write the equations of motion for people", "equations:equations_command", f"{_TEXTS}:add_equations"),
    _Command("draw", "draw the scene as a textbook does", "draw:draw_command", f"{_PICTURES}:add_draw"),
    _Command("animate", "show the motion of a scene", "animate:animate_command", f"{_PICTURES}:add_animate"),
    _Command("play", "make a page that computes the motion, with sliders", "play:play_command", f"{_PICTURES}:add_play"),
    _Command("equilibrium", "find positions of rest, their stability and reactions", "analysis:equilibrium_command",
             f"{_STUDIES}:add_equilibrium"),
    _Command("linearize", "give the matrices of small motion", "analysis:linearize_command", f"{_STUDIES}:add_linearize"),
    _Command("modes", "find natural frequencies, damping ratios and mode shapes", "analysis:modes_command",
             f"{_STUDIES}:add_modes"),
    _Command("response", "compute a frequency response", "analysis:response_command", f"{_STUDIES}:add_response"),
    _Command("export", "write a scene for other programs", "export:export_command", f"{_TEXTS}:add_export"),
    _Command("format", "lay texts out in the one style of the language", "format:format_command", f"{_EDITS}:add_format"),
    _Command("lint", "look for what could be written better", "lint:lint_command", f"{_TEXTS}:add_check"),
    _Command("server", "answer an editor: the language server", "server:server_command", f"{_EDITS}:add_server"),
    _Command("import", "make a .lag file of Modelica or of a robot", "modelica_import:import_command", f"{_EDITS}:add_import"),
    _Command("doc", "write the library and your files as pages to be read", "doc:doc_command", f"{_EDITS}:add_doc"),
    _Command("new", "begin a project: part, scene, test", "new:new_command", f"{_EDITS}:add_new"),
    _Command("test", "run models that test others, and compare with stored tables", "test:test_command", f"{_EDITS}:add_test"),
)
_FMU_CHECK = _Command("check", "look for errors in an FMU, whoever made it, and in its motion", "fmu_check:check_fmu_command",
                      f"{_TEXTS}:add_fmu_check")
_HELP = _Command("help", "longer texts: the language, the library, the solver", "help:help_command", f"{_TEXTS}:add_help")
_WITHOUT_WARNINGS = ("help", "format", "server", "doc", "new")  # commands that tell none


def build_parser(wanted: str = "") -> argparse.ArgumentParser:
    """The parser of the whole command line; of the one command, where `wanted` is its name."""
    parser = _Parser(prog="lag", description="Lagrangia: a language for mechanics, with a compiler. `lag help` lists the topics.")
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and stop")
    commands = parser.add_subparsers(dest="name", required=True, metavar="COMMAND", parser_class=_Parser)
    chosen = [command for command in COMMANDS if command.name == wanted]
    for command in chosen or COMMANDS:
        _add(commands, command)
    if chosen:
        return parser
    fmu = commands.add_parser("fmu", help="look for errors in an FMU", description="Look for errors in an FMU.")
    _add(fmu.add_subparsers(dest="name", required=True, metavar="COMMAND", parser_class=_Parser), _FMU_CHECK)
    _add(commands, _HELP)
    return parser


def _add(commands: "argparse._SubParsersAction[_Parser]", command: _Command) -> None:
    parser = commands.add_parser(command.name, help=command.about, description=command.about[0].upper() + command.about[1:] + ".")
    parser.command = command


def _function(place: str) -> Callable[[Any], Any]:
    module, _, name = place.partition(":")
    found: Callable[[Any], Any] = getattr(import_module(f"lagrangia.command.{module}"), name)
    return found


class _Parser(argparse.ArgumentParser):
    """Errors in the form of all other diagnostics; -1e6 and -1,2 are values as -1 is, and no options (Python takes -1 and -1.5
    alone for numbers). Of a command it has the options when it is asked to read some."""

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        self.is_asked = False  # for help
        super().__init__(*arguments, **settings)
        self._negative_number_matcher = re.compile(r"-\.?\d")
        self.command: _Command | None = None
        for action in (None, "store"):
            self.register("action", action, _Once)
        self.register("type", float, read_number)
        self.register("type", int, read_whole)

    def _get_formatter(self) -> argparse.HelpFormatter:
        """Each option that is added asks for one; how wide the terminal is counts where help is printed."""
        return self.formatter_class(prog=self.prog) if self.is_asked else argparse.HelpFormatter(self.prog, width=80)

    def format_help(self) -> str:
        """As wide as the terminal."""
        self.is_asked = True
        return super().format_help()

    def format_usage(self) -> str:
        """Likewise."""
        self.is_asked = True
        return super().format_usage()

    def parse_known_args(self, *arguments: Any, **settings: Any) -> Any:
        """Adds the options of its command before."""
        if (command := self.command) is not None:
            self.command = None
            self.set_defaults(command=_function(command.run), parser=self)
            if command.name not in _WITHOUT_WARNINGS:
                add = self.add_argument
                add("--allow", action="append", default=[], metavar="CODE,...", help="warnings that are meant: L0224")
                add("--strict", action="store_true", help="take warnings for errors")
                if command is not _FMU_CHECK:
                    add("--path", action="append", default=[], metavar="FOLDER",
                        help="where packages are looked for, before $LAGRANGIA_PATH")
            _function(command.options)(self)
        return super().parse_known_args(*arguments, **settings)

    def error(self, message: str) -> NoReturn:
        """Ends with the exit code of wrong input."""
        print(f"error[L0700]: {message}\n   = {self.format_usage().strip()}", file=sys.stderr)
        raise SystemExit(WRONG)


class _Once(argparse.Action):
    """Keeps the value of an option, which may be given once: the last of several would hold without a word."""

    def __call__(self, parser: argparse.ArgumentParser, options: argparse.Namespace, value: Any, option: str | None = None
                 ) -> None:
        given = options.__dict__.setdefault("given", set())
        if option is not None and self.dest in given:
            parser.error(f"{option} is given twice")
        given.add(self.dest)
        setattr(options, self.dest, value)


class _Version(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *rest: object) -> None:
        print(f"lagrangia {VERSION}")
        parser.exit()

