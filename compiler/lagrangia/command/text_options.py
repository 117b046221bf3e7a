"""Options of what reads a scene, or writes it for people and programs: check, explain, equations, export, fmu check, help."""

from argparse import ArgumentParser, BooleanOptionalAction
from pathlib import Path

from lagrangia.command.common_options import add_sharing


def add_check(parser: ArgumentParser) -> None:
    """Of `lag check`."""
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE")


def add_explain(parser: ArgumentParser) -> None:
    """Of `lag explain`."""
    add = parser.add_argument
    add("file", type=Path, metavar="FILE")
    add("--model", metavar="NAME", help="the model; the last of the file by default")
    add("-p", "--parameter", action="append", default=[], metavar="NAME=VALUE", help="a parameter: -p n=20")
    add("--json", action="store_true", help="the same for programs")


def add_help(parser: ArgumentParser) -> None:
    """Of `lag help`."""
    parser.add_argument("topic", nargs="?")


def add_fmu_check(parser: ArgumentParser) -> None:
    """Of `lag fmu check`."""
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE")
    parser.add_argument("--run", action=BooleanOptionalAction, default=True,
                        help="load and run its binary, which is to trust it")
    parser.add_argument("--seconds", type=float, default=20.0, metavar="S",
                        help="a run of it is given up after so much time (20)")


def add_equations(parser: ArgumentParser) -> None:
    """Of `lag equations`."""
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
    add("--format", metavar="FORMAT", help="text, markdown, latex, html, or sympy: a Python script (or as -o ends)")
    add("--language", default="en", metavar="CODE", help="of the headings and sentences: en, pt, de, fr, es")
    add("--fragment", action="store_true", help="of LaTeX: what stands in a document of your own, with labels lag:a, lag:b")
    add("--names", metavar="NAME=SYMBOL,...", help="symbols of your own: --names tilt.phi=theta,guide.s=x")
    add("--angles", metavar="AXES", help="attitudes by Euler's angles about these axes, which move along: zxz, zyx, ...")
    add("--numbers", action="store_true", help="put the values of the parameters in")
    add("--about", metavar="NAME=VALUE,...", help="the point of the linear form; an equilibrium by default")
    add("-p", "--parameter", action="append", default=[], metavar="NAME=VALUE", help="a parameter: -p L=2 -p n=3")
    add("--force", action="store_true", help="write even what is too large to read")
    add("-o", "--output", metavar="FILE", help="write to a file instead of standard output")


def add_export(parser: ArgumentParser) -> None:
    """Of `lag export`."""
    add = parser.add_argument
    add("file", type=Path, metavar="FILE")
    add("--to", required=True, metavar="TARGET", help="fmu, python (NumPy alone), casadi, modelica, sympy, latex")
    add("--model", metavar="NAME", help="the model; the last of the file by default")
    add("-p", "--parameter", action="append", default=[], metavar="NAME=VALUE",
        help="a structural parameter: -p n=3; in an FMU, other ones get this start value")
    add("--names", metavar="NAME=SYMBOL,...", help="symbols of your own, for modelica, sympy and latex")
    add("--components", action="store_true", default=None,
        help="a drive train, or joints and bodies, with components of the Modelica Standard Library, for modelica")
    add("--force", action="store_true", help="write even what is too large to read")
    add("--fmi", metavar="VERSION", help="of an FMU: 2 (the default), 3 or both")
    add("--kind", metavar="KIND,...", help="of an FMU: Model Exchange (me), Co-Simulation (cs); both by default")
    add("--platforms", metavar="LIST", help="of an FMU's binaries: host (the default), all, or names: x86_64-windows, ...")
    add("--engine", metavar="ENGINE", help="of an FMU for this machine: tape (no compiler), native, or auto (the default)")
    add("--sources", action=BooleanOptionalAction, help="put the C sources into an FMU, by default")
    add("--arrays", action=BooleanOptionalAction, help="vectors and matrices are arrays in FMI 3, by default; else scalars")
    add("--outputs", metavar="NAME,NAME,...", help="more outputs of an FMU")
    add_sharing(parser)
    add("--info", action="append", default=[], metavar="NAME=TEXT", help="author, version, copyright, license of an FMU")
    add("-o", "--output", metavar="FILE", help="the file; by default the model's name in this folder (- for standard output)")


