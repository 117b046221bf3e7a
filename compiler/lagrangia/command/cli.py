"""The command `lag`. Heavy imports happen in the commands that need them: a scene compiled before starts at once."""

import argparse
import atexit
import contextlib
import gc
import os
import re
import sys
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NoReturn

from lagrangia.base.diagnostics import EngineWarning, LagError, RunError, render_all
from lagrangia.base.interruptions import INTERRUPTED, ended_as_by_control_c
from lagrangia.base.spelling import prepare_output
from lagrangia.base.version import VERSION
from lagrangia.command.idle_options import refuse_idle

DONE, FAILED, WRONG = 0, 1, 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Exit codes: 0 done, 1 the run failed, 2 the input is wrong, 130 interrupted."""
    atexit.register(gc.freeze)  # what ends with the process need not be searched for cycles
    prepare_output()
    parsed = _parser().parse_args(arguments)
    warnings.filterwarnings("ignore", category=RuntimeWarning)  # of NumPy: what is not finite is told in our words
    warnings.filterwarnings("ignore", category=EngineWarning)  # so is this
    with ended_as_by_control_c():
        return _execute(parsed)


def _execute(parsed: argparse.Namespace) -> int:
    try:
        refuse_idle(parsed, parsed.parser.get_default)
        code = int(parsed.command(parsed))
        sys.stdout.flush()
        return code
    except LagError as error:
        print(render_all(error.diagnostics, _is_colored()), file=sys.stderr)
        return WRONG
    except RunError as error:
        print(f"error: {error}", file=sys.stderr)
        return FAILED
    except BrokenPipeError:
        _drop_output()
        return FAILED
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return INTERRUPTED
    except MemoryError:
        return _out_of_memory()
    except OSError as error:
        where = f"'{error.filename}': " if error.filename else ""
        print(f"error: {where}{error.strerror or error}", file=sys.stderr)
        _drop_output()
        return FAILED
    except Exception as error:
        if "std::bad_alloc" in str(error):  # as CasADi says it
            return _out_of_memory()
        return _refused(error) or _confess(error)


def _refused(error: Exception) -> int:
    """Where the C compiler could not do its work: no place for its files, an installation that lacks its headers."""
    from lagrangia.native.build import CompilerError

    if not isinstance(error, CompilerError):
        return DONE
    print(f"error: the C compiler refused\n{error}\n   = LAGRANGIA_CC names another one, or none", file=sys.stderr)
    return FAILED


def _out_of_memory() -> int:
    print("error: not enough memory", file=sys.stderr)
    return FAILED


def _drop_output() -> None:
    """What could not be written is not tried again when the interpreter ends."""
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _confess(error: Exception) -> int:
    """What arrives here is a fault of the compiler, not of the model."""
    if os.environ.get("LAGRANGIA_TRACEBACK"):
        raise error
    print(f"bug: {type(error).__name__}: {error}", file=sys.stderr)
    print("This is a fault of lagrangia, not of your model. Please report it with the model;\n"
          "LAGRANGIA_TRACEBACK=1 shows where it happened.", file=sys.stderr)
    return FAILED


def _is_colored() -> bool:
    return sys.stderr.isatty() and "NO_COLOR" not in os.environ


def _simulate(options: argparse.Namespace) -> int:
    if options.file.suffix.lower() == ".fmu":
        from lagrangia.command.fmu_simulate import simulate_fmu_command

        return simulate_fmu_command(options)
    from lagrangia.command.simulate import simulate_command

    return simulate_command(options)


def _check_fmu(options: argparse.Namespace) -> int:
    from lagrangia.command.fmu_check import check_fmu_command

    return check_fmu_command(options)


def _sweep(options: argparse.Namespace) -> int:
    from lagrangia.command.sweep import sweep_command

    return sweep_command(options)


def _check(options: argparse.Namespace) -> int:
    from lagrangia.command.check import check_command

    return check_command(options)


def _explain(options: argparse.Namespace) -> int:
    from lagrangia.command.explain import explain_command

    return explain_command(options)


def _bench(options: argparse.Namespace) -> int:
    from lagrangia.command.bench import bench_command

    return bench_command(options)


def _equations(options: argparse.Namespace) -> int:
    from lagrangia.command.equations import equations_command

    return equations_command(options)


def _draw(options: argparse.Namespace) -> int:
    from lagrangia.command.draw import draw_command

    return draw_command(options)


def _animate(options: argparse.Namespace) -> int:
    from lagrangia.command.animate import animate_command

    return animate_command(options)


def _play(options: argparse.Namespace) -> int:
    from lagrangia.command.play import play_command

    return play_command(options)


def _analysis(options: argparse.Namespace) -> int:
    from lagrangia.command import analysis as analysis_commands

    commands = {"equilibrium": analysis_commands.equilibrium_command, "linearize": analysis_commands.linearize_command,
                "modes": analysis_commands.modes_command, "response": analysis_commands.response_command}
    return commands[options.name](options)


def _export(options: argparse.Namespace) -> int:
    from lagrangia.command.export import export_command

    return export_command(options)


def _help(options: argparse.Namespace) -> int:
    from lagrangia.command.topics import TOPICS, topic_text

    if options.topic is None:
        print("Topics, each shown by `lag help TOPIC`:\n")
        for name, (summary, _) in TOPICS.items():
            print(f"  {name:12} {summary}")
        return DONE
    print(topic_text(options.topic))
    return DONE


class _Parser(argparse.ArgumentParser):
    """Errors in the form of all other diagnostics; -1e6 and -1,2 are values as -1 is, and no options (Python takes -1 and -1.5
    alone for numbers)."""

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        super().__init__(*arguments, **settings)
        self._negative_number_matcher = re.compile(r"-\.?\d")
        for action in (None, "store"):
            self.register("action", action, _Once)

    def error(self, message: str) -> NoReturn:
        print(f"error[L0700]: {message}\n   = {self.format_usage().strip()}", file=sys.stderr)
        raise SystemExit(WRONG)


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog="lag", description="Lagrangia: a language for mechanics, with a compiler. `lag help` lists the topics.")
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version and stop")
    commands = parser.add_subparsers(dest="name", required=True, metavar="COMMAND", parser_class=_Parser)
    _add_simulate(_add(commands, "simulate", _simulate, "compute the motion of a scene, or of any FMU"))
    _add_sweep(_add(commands, "sweep", _sweep, "run a scene many times, with other parameters and start values"))
    check = _add(commands, "check", _check, "look for errors without running")
    check.add_argument("files", nargs="+", type=Path, metavar="FILE")
    explain = _add(commands, "explain", _explain, "say what a scene needs of a general simulation, and what it skips")
    explain.add_argument("file", type=Path, metavar="FILE")
    explain.add_argument("--model", metavar="NAME", help="the model; the last of the file by default")
    explain.add_argument("-p", "--parameter", action="append", default=[], metavar="NAME=VALUE",
                         help="a parameter: -p n=20")
    explain.add_argument("--json", action="store_true", help="the same for programs")
    _add_bench(_add(commands, "bench", _bench, "measure run time against error, beside other solvers"))
    _add_equations(_add(commands, "equations", _equations, "write the equations of motion for people"))
    _add_draw(_add(commands, "draw", _draw, "draw the scene as a textbook does"))
    _add_animate(_add(commands, "animate", _animate, "show the motion of a scene"))
    _add_play(_add(commands, "play", _play, "make a page that computes the motion, with sliders"))
    _add_equilibrium(_add(commands, "equilibrium", _analysis, "find positions of rest, their stability and reactions"))
    _add_linearize(_add(commands, "linearize", _analysis, "give the matrices of small motion"))
    _add_modes(_add(commands, "modes", _analysis, "find natural frequencies, damping ratios and mode shapes"))
    _add_response(_add(commands, "response", _analysis, "compute a frequency response"))
    _add_export(_add(commands, "export", _export, "write a scene for other programs"))
    _add_fmu(commands.add_parser("fmu", help="look for errors in an FMU", description="Look for errors in an FMU."))
    topics = _add(commands, "help", _help, "longer texts: the language, the library, the solver")
    topics.add_argument("topic", nargs="?")
    return parser


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


def _add(commands: "argparse._SubParsersAction[_Parser]", name: str, command: Callable[[argparse.Namespace], int],
         text: str) -> argparse.ArgumentParser:
    parser = commands.add_parser(name, help=text, description=text[0].upper() + text[1:] + ".")
    parser.set_defaults(command=command, parser=parser)
    if name != "help":
        parser.add_argument("--allow", action="append", default=[], metavar="CODE,...", help="warnings that are meant: L0224")
        parser.add_argument("--strict", action="store_true", help="take warnings for errors")
    return parser


def _add_simulate(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("file", type=Path, metavar="FILE")
    add("--model", metavar="NAME", help="the model to run; the last of the file by default")
    add("--start", type=float, metavar="T", help="start time in s")
    add("--stop", type=float, metavar="T", help="stop time in s")
    add("--tolerance", type=float, metavar="TOL", help="error allowed, relative to the size of each coordinate (1e-8)")
    add("--interval", type=float, metavar="DT", help="time between two rows of the result")
    add("--at", metavar="T,T,...", help="the times of the rows, instead of an interval")
    add("-p", "--parameter", action="append", default=[], metavar="NAME=VALUE", help="a parameter: -p L=2 -p 'k=1[kN/m]' -p n=20")
    _add_values(parser)
    add("--outputs", metavar="NAME,NAME,...", help="quantities to report besides coordinates, rates and outputs")
    add("--reactions", action="store_true", help="report the force and torque of every joint and tie")
    add("-o", "--output", metavar="FILE", help="the result (FILE.csv; - for standard output); by default NAME.csv in this folder")
    add("--plot", metavar="FILE", type=Path, help="a picture (.png, .svg, .pdf)")
    add("--plot-quantities", metavar="NAME,...",
        help="what the picture shows, over time, or one against another (theta:theta'); all coordinates by default")
    add("--spectrum", metavar="NAME,...", help="amplitudes over frequency in the picture")
    add("--section", metavar="NAME[=VALUE]", help="the picture shows the states in which this rises through 0, or the value")
    add("--overlay", action="append", default=[], metavar="FILE.csv", help="a table beside the run in the picture: a measurement")
    add("--beside", action="append", default=[], metavar="NAME=VALUE,...", help="another run in the picture, with these values")
    add("--linear", action="store_true", help="small motion beside the run in the picture")
    add("--solver", default="auto", metavar="NAME", help="auto, erk, erk5, linear, implicit, ...; see `lag help solver`")
    add("--engine", choices=("auto", "native", "tape"), default="auto",
        help="compiled, interpreted, or (auto) what costs less time; the reckoning is shown by --stats")
    add("--max-step", type=float, default=0.0, metavar="DT", help="largest step in s")
    add("--max-steps", type=int, default=0, metavar="N", help="give up after so many steps (0: never)")
    add("--kind", metavar="KIND", help="of an FMU: me (Model Exchange) or cs (Co-Simulation, where there is one)")
    add("--stats", action="store_true", help="say what was done, and in what time")
    add("--quiet", action="store_true", help="say nothing but errors")
    add("--dump", metavar="PHASE",
        help="print what a phase makes, and stop: syntax, flat, graph, kinematics, energies, motion, needs, c")


def _add_bench(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("file", type=Path, metavar="FILE")
    add("--model", metavar="NAME", help="the model; the last of the file by default")
    add("--stop", type=float, metavar="T", help="stop time in s")
    add("--points", type=int, default=10, metavar="N", help="output times, at equal distances (10)")
    add("-p", "--parameter", action="append", default=[], metavar="NAME=VALUE", help="a parameter: -p L=2 -p n=20")
    add("--tolerances", metavar="TOL,TOL,...", help="given to every solver; 1e-2 to 1e-13 by default")
    add("--solvers", metavar="NAME,NAME,...", help="erk, casadi:erk, ..., scipy:Radau, heyoka; casadi means all of it")
    add("--repeat", type=int, default=15, metavar="N", help="runs whose median counts (15)")
    add("-o", "--output", metavar="FILE", help="the points as a table (.csv, .json)")
    add("--plot", metavar="FILE", type=Path, help="a picture (.png, .svg, .pdf)")


def _add_sweep(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("file", type=Path, metavar="FILE")
    add("--model", metavar="NAME", help="the model to run; the last of the file by default")
    add("-p", "--parameter", action="append", default=[], metavar="NAME=VALUES",
        help="-p m=1,2,5 -p k1=100:2000:50 (from:to:step) -p 'c=linspace(1,2,11)' -p 'L=normal(1,0.01)'; all combinations")
    add("--initial", action="append", default=[], metavar="NAME=VALUES", help="start values of a coordinate or rate, likewise")
    add("--runs", type=Path, metavar="FILE.csv", help="a table of parameters and start values, with a line for each run")
    add("--together", action="store_true", help="lists side by side instead of all their combinations")
    add("--samples", type=int, metavar="N", help="how many samples of the random values are taken")
    add("--sampling", default="random", metavar="WAY", help="random, or lhs: a Latin hypercube")
    add("--seed", type=int, default=0, metavar="N", help="of the random values; the same seed gives the same values")
    add("--outputs", metavar="MEASURE,...",
        help="what is kept of each run: max(y), at(0.5, y), 'first_time(y > 3)', ... (lag help sweep); by default final values")
    add("-u", "--input", action="append", default=[], metavar="NAME=VALUE|FILE.csv", help="an input, the same in all runs")
    add("--start", type=float, metavar="T", help="start time in s")
    add("--stop", type=float, metavar="T", help="stop time in s")
    add("--tolerance", type=float, metavar="TOL", help="error allowed, relative to the size of each coordinate (1e-8)")
    add("--interval", type=float, metavar="DT", help="how closely the motion is looked at, at least")
    add("--solver", default="auto", metavar="NAME", help="as of lag simulate, but for those of CasADi")
    add("--engine", choices=("auto", "native", "tape"), default="auto",
        help="compiled, interpreted, or (auto) what costs less time; the reckoning is shown by --stats")
    add("--max-step", type=float, default=0.0, metavar="DT", help="largest step in s")
    add("--max-steps", type=int, default=0, metavar="N", help="a run fails after so many steps (0: never)")
    add("--seconds-per-run", type=float, default=0.0, metavar="S", help="a run fails after so much time (0: never)")
    add("--jobs", type=int, metavar="N", help="threads; as many as there are cores by default")
    add("--dask", metavar="ADDRESS", help="run on the cluster of this Dask scheduler: tcp://host:8786")
    add("-o", "--output", metavar="FILE", help="the table (.csv, .parquet; - for standard output); by default NAME_sweep.csv")
    add("--restart", action="store_true", help="begin anew, whatever an interrupted sweep has left in FILE.part")
    add("--dry-run", action="store_true", help="only say which runs there would be")
    add("--quiet", action="store_true", help="say nothing but errors")


def _add_numbers(parser: argparse.ArgumentParser, about: bool) -> None:
    """What all analyses are told."""
    add = parser.add_argument
    add("file", type=Path, metavar="FILE")
    add("--model", metavar="NAME", help="the model; the last of the file by default")
    add("-p", "--parameter", action="append", default=[], metavar="NAME=VALUE", help="a parameter: -p L=2 -p 'k=1[kN/m]' -p n=20")
    add("--initial", action="append", default=[], metavar="NAME=VALUE", help="where it begins: --initial hinge.phi=10[deg]")
    add("-u", "--input", action="append", default=[], metavar="NAME=VALUE", help="a constant input")
    add("--time", type=float, metavar="T", help="the time at which supports and loads are looked at; the start time by default")
    if about:
        add("--about", default="equilibrium", metavar="POINT",
            help="equilibrium: the one found from the start values (default); start: the start values themselves")


def _add_equilibrium(parser: argparse.ArgumentParser) -> None:
    _add_numbers(parser, about=False)
    parser.add_argument("--starts", type=int, metavar="N", help="from how many places it is searched (24; 1: the start alone)")
    parser.add_argument("-o", "--output", metavar="FILE", help="a file for programs (.json)")


def _add_linearize(parser: argparse.ArgumentParser) -> None:
    _add_numbers(parser, about=True)
    _add_pair(parser)
    parser.add_argument("-o", "--output", metavar="FILE", help="the matrices (.json, .mat, .npz)")


def _add_modes(parser: argparse.ArgumentParser) -> None:
    _add_numbers(parser, about=True)
    parser.add_argument("--mass-normalised", action="store_true", help="shapes with phi' M phi = 1, not largest entry 1")
    parser.add_argument("-o", "--output", metavar="FILE", help="a file for programs (.json)")
    parser.add_argument("--plot", metavar="FILE", type=Path, help="a picture of the shapes (.png, .svg, .pdf)")
    parser.add_argument("--animate", metavar="FILE", help="a page or film of one mode (.html, .gif, .webp)")
    parser.add_argument("--mode", type=int, default=1, metavar="N", help="the mode that --animate shows (1)")


def _add_response(parser: argparse.ArgumentParser) -> None:
    _add_numbers(parser, about=True)
    _add_pair(parser)
    add = parser.add_argument
    add("--range", metavar="LOW:HIGH", help="frequencies in Hz; by default a decade beyond the modes on both sides")
    add("--points", type=int, default=400, metavar="N", help="so many over the range, and more around resonances (400)")
    add("--at", metavar="F,F,...", help="these frequencies in Hz, instead of a range")
    add("-o", "--output", metavar="FILE", help="magnitude, phase, real and imaginary parts (.csv)")
    add("--plot", metavar="FILE", type=Path, help="the Bode plot (.png, .svg, .pdf)")


def _add_pair(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--from", dest="excite", metavar="NAME,...",
                        help="what excites: an input, a load P.force[2], a prescribed coordinate, a place road.y; by default "
                             "the inputs, and loads and supports that depend on time")
    parser.add_argument("--to", metavar="NAME,...", help="any quantities; by default the coordinates and declared outputs")


def _add_export(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("file", type=Path, metavar="FILE")
    add("--to", required=True, metavar="TARGET", help="fmu, python (NumPy alone), casadi, modelica, sympy, latex")
    add("--model", metavar="NAME", help="the model; the last of the file by default")
    add("-p", "--parameter", action="append", default=[], metavar="NAME=VALUE",
        help="a structural parameter: -p n=3; in an FMU, other ones get this start value")
    add("--names", metavar="NAME=SYMBOL,...", help="symbols of your own, for modelica, sympy and latex")
    add("--force", action="store_true", help="write even what is too large to read")
    add("--fmi", metavar="VERSION", help="of an FMU: 2 (the default), 3 or both")
    add("--kind", metavar="KIND,...", help="of an FMU: Model Exchange (me), Co-Simulation (cs); both by default")
    add("--platforms", metavar="LIST", help="of an FMU's binaries: host (the default), all, or names: x86_64-windows, ...")
    add("--engine", metavar="ENGINE", help="of an FMU for this machine: tape (no compiler), native, or auto (the default)")
    add("--sources", action=argparse.BooleanOptionalAction, help="put the C sources into an FMU, by default")
    add("--outputs", metavar="NAME,NAME,...", help="more outputs of an FMU")
    add("--info", action="append", default=[], metavar="NAME=TEXT", help="author, version, copyright, license of an FMU")
    add("-o", "--output", metavar="FILE", help="the file; by default the model's name in this folder (- for standard output)")


def _add_fmu(parser: argparse.ArgumentParser) -> None:
    commands = parser.add_subparsers(dest="name", required=True, metavar="COMMAND", parser_class=_Parser)
    check = _add(commands, "check", _check_fmu, "look for errors in an FMU, whoever made it, and in its motion")
    check.add_argument("files", nargs="+", type=Path, metavar="FILE")
    check.add_argument("--run", action=argparse.BooleanOptionalAction, default=True,
                       help="load and run its binary, which is to trust it")


def _add_draw(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    _add_start(parser)
    add("--at", metavar="T", help="the time at which it is drawn; the start by default")
    add("--names", metavar="NAME=SYMBOL,...", help="symbols of your own: --names tilt.phi=theta,guide.s=x")
    add("-o", "--output", metavar="FILE",
        help="the picture (.svg, .pdf, .png, .tex: TikZ; - for the SVG on standard output); by default NAME.svg here")


def _add_animate(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    _add_start(parser)
    add("--start", type=float, metavar="T", help="start time in s")
    add("--stop", type=float, metavar="T", help="stop time in s")
    add("--tolerance", type=float, metavar="TOL", help="error allowed, relative to the size of each coordinate (1e-8)")
    add("--interval", type=float, metavar="DT", help="time between two positions that are shown")
    add("--trace", metavar="FRAME,...", help="frames whose ways are drawn: --trace lower.b")
    add("--curves", metavar="NAME,...", help="quantities beside the picture; the coordinates and outputs by default")
    add("--beside", action="append", default=[], metavar="NAME=VALUE,...", help="another run by thin lines, with these values")
    add("--stroboscope", type=int, metavar="N", help="so many positions in one picture (.svg, .pdf, .png)")
    add("--names", metavar="NAME=SYMBOL,...", help="symbols of your own: --names tilt.phi=theta,guide.s=x")
    add("-o", "--output", metavar="FILE", help="the page or film (.html, .gif, .webp); by default NAME.html in this folder")


def _add_play(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    _add_start(parser)
    add("--stop", type=float, metavar="T", help="the end of the run whose digits are shown, in s; the page goes on")
    add("--tolerance", type=float, metavar="TOL", help="error allowed, relative to the size of each coordinate (1e-8)")
    add("--trace", metavar="FRAME,...", help="frames whose ways are drawn: --trace lower.b")
    add("--names", metavar="NAME=SYMBOL,...", help="symbols of your own: --names tilt.phi=theta,guide.s=x")
    add("-o", "--output", metavar="FILE.html", help="the page; without it a temporary file, which is opened")


def _add_values(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("--initial", action="append", default=[], metavar="NAME=VALUE",
        help="a start value of a coordinate or rate: --initial hinge.phi=1.2")
    add("-u", "--input", action="append", default=[], metavar="NAME=VALUE|FILE.csv",
        help="an input: a constant, or a table with a column time")


def _add_start(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("file", type=Path, metavar="FILE")
    add("--model", metavar="NAME", help="the model; the last of the file by default")
    add("-p", "--parameter", action="append", default=[], metavar="NAME=VALUE", help="a parameter: -p L=2 -p n=3")
    _add_values(parser)


def _add_equations(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("file", type=Path, metavar="FILE")
    add("--model", metavar="NAME", help="the model; the last of the file by default")
    add("--form", default="lagrange", metavar="FORM",
        help="lagrange, energies, matrix, first-order, linear, worked (the whole derivation), 5.16 ... 5.32: lag help equations")
    add("--sources", default="auto", metavar="SIDE", help="potential: loads of time stand in V; force: on the right-hand side")
    add("--level", default="full", metavar="LEVEL", help="of the derivation: short, full or lecture")
    add("--sections", metavar="NAME,...", help="of the derivation, these alone: kinetic,potential,equations")
    add("--check", metavar="EQUATION", help="whether it is one of the scene: --check \"m*x'' + k*x = P(t)\"; exit code 1 if not")
    add("--first-letter", default="a", metavar="LETTER", help="of the derivation's formulas, to go on from another page")
    add("--format", default="text", metavar="FORMAT", help="text, markdown, latex, html, or sympy: a Python script")
    add("--language", default="en", metavar="CODE", help="of the headings and sentences: en, pt, de, fr, es")
    add("--fragment", action="store_true", help="of LaTeX: what stands in a document of your own, with labels lag:a, lag:b")
    add("--names", metavar="NAME=SYMBOL,...", help="symbols of your own: --names tilt.phi=theta,guide.s=x")
    add("--numbers", action="store_true", help="put the values of the parameters in")
    add("--about", metavar="NAME=VALUE,...", help="the point of the linear form; an equilibrium by default")
    add("-p", "--parameter", action="append", default=[], metavar="NAME=VALUE", help="a parameter: -p L=2 -p n=3")
    add("--force", action="store_true", help="write even what is too large to read")
    add("-o", "--output", metavar="FILE", help="write to a file instead of standard output")


if __name__ == "__main__":
    sys.exit(main())
