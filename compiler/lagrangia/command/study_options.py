"""Options of analyses: equilibrium, linearize, modes, response."""

from argparse import ArgumentParser
from pathlib import Path

from lagrangia.command.common_options import add_sharing


def _add_numbers(parser: ArgumentParser, about: bool) -> None:
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


def add_equilibrium(parser: ArgumentParser) -> None:
    """Of `lag equilibrium`."""
    _add_numbers(parser, about=False)
    add_sharing(parser)
    parser.add_argument("--starts", type=int, metavar="N", help="from how many places it is searched (24; 1: the start alone)")
    parser.add_argument("-o", "--output", metavar="FILE", help="a file for programs (.json)")


def add_linearize(parser: ArgumentParser) -> None:
    """Of `lag linearize`."""
    _add_numbers(parser, about=True)
    _add_pair(parser)
    parser.add_argument("-o", "--output", metavar="FILE", help="the matrices (.json, .mat, .npz)")


def add_modes(parser: ArgumentParser) -> None:
    """Of `lag modes`."""
    _add_numbers(parser, about=True)
    parser.add_argument("--mass-normalised", action="store_true", help="shapes with phi' M phi = 1, not largest entry 1")
    parser.add_argument("-o", "--output", metavar="FILE", help="a file for programs (.json)")
    parser.add_argument("--plot", metavar="FILE", type=Path, help="a picture of the shapes (.png, .svg, .pdf)")
    parser.add_argument("--animate", metavar="FILE", help="a page or film of one mode (.html, .svg, .gif, .webp, .mp4; in space "
                        ".glb: glTF)")
    parser.add_argument("--mode", type=int, default=1, metavar="N", help="the mode that --animate shows (1)")
    parser.add_argument("--view", metavar="AZIMUTH,ELEVATION", help="from where a scene in space is seen in a film, degrees")


def add_response(parser: ArgumentParser) -> None:
    """Of `lag response`."""
    _add_numbers(parser, about=True)
    _add_pair(parser)
    add = parser.add_argument
    add("--range", metavar="LOW:HIGH", help="frequencies in Hz; by default a decade beyond the modes on both sides")
    add("--points", type=int, default=400, metavar="N", help="so many over the range, and more around resonances (400)")
    add("--at", metavar="F,F,...", help="these frequencies in Hz, instead of a range")
    add("-o", "--output", metavar="FILE", help="magnitude, phase, real and imaginary parts (.csv)")
    add("--plot", metavar="FILE", type=Path, help="the Bode plot (.png, .svg, .pdf)")


def _add_pair(parser: ArgumentParser) -> None:
    parser.add_argument("--from", dest="excite", metavar="NAME,...",
                        help="what excites: an input, a load P.force[2], a prescribed coordinate, a place road.y; by default "
                             "the inputs, and loads and supports that depend on time")
    parser.add_argument("--to", metavar="NAME,...", help="any quantities; by default the coordinates and declared outputs")


