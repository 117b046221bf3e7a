"""Options that several subcommands have."""

from argparse import ArgumentParser
from pathlib import Path


def add_values(parser: ArgumentParser) -> None:
    """Start values and inputs."""
    add = parser.add_argument
    add("--initial", action="append", default=[], metavar="NAME=VALUE",
        help="a start value of a coordinate or rate: --initial hinge.phi=1.2")
    add("-u", "--input", action="append", default=[], metavar="NAME=VALUE|NAME=FILE|FILE.csv",
        help="an input: a constant, or a table with a column time")


def add_sharing(parser: ArgumentParser) -> None:
    """How joints share what is not determined."""
    parser.add_argument("--least-squares", metavar="LENGTH", help="reactions that joints share in no way of their own: those "
                        "whose squares add up to least, torques over this length: 1, 20[cm]")


def add_start(parser: ArgumentParser) -> None:
    """The scene, and with what values it begins."""
    add = parser.add_argument
    add("file", type=Path, metavar="FILE")
    add("--model", metavar="NAME", help="the model; the last of the file by default")
    add("-p", "--parameter", action="append", default=[], metavar="NAME=VALUE", help="a parameter: -p L=2 -p n=3")
    add_values(parser)


