"""Options of pictures: draw, animate, play."""

from argparse import ArgumentParser

from lagrangia.command.common_options import add_start


def add_draw(parser: ArgumentParser) -> None:
    """Of `lag draw`."""
    add = parser.add_argument
    add_start(parser)
    add("--at", metavar="T", help="the time at which it is drawn; the start by default")
    add("--names", metavar="NAME=SYMBOL,...", help="symbols of your own: --names tilt.phi=theta,guide.s=x")
    add("--view", metavar="AZIMUTH,ELEVATION", help="from where a scene in space is seen, degrees: --view=-60,22")
    add("-o", "--output", metavar="FILE",
        help="the picture (.svg, .pdf, .png, .tex: TikZ; - for the SVG on standard output); by default NAME.svg here")


def add_animate(parser: ArgumentParser) -> None:
    """Of `lag animate`."""
    add = parser.add_argument
    add_start(parser)
    add("--start", type=float, metavar="T", help="start time in s")
    add("--stop", type=float, metavar="T", help="stop time in s")
    add("--tolerance", type=float, metavar="TOL", help="error allowed, relative to the size of each coordinate (1e-8)")
    add("--interval", type=float, metavar="DT", help="time between two positions that are shown")
    add("--trace", metavar="FRAME,...", help="frames whose ways are drawn: --trace lower.b")
    add("--curves", metavar="NAME,...", help="quantities beside the picture; the coordinates and outputs by default")
    add("--beside", action="append", default=[], metavar="NAME=VALUE,...|FILE.csv",
        help="another run by thin lines, with these values; several with k=1:5:1, or those of a table")
    add("--stroboscope", type=int, metavar="N", help="so many positions in one picture (.svg, .pdf, .png)")
    add("--names", metavar="NAME=SYMBOL,...", help="symbols of your own: --names tilt.phi=theta,guide.s=x")
    add("--view", metavar="AZIMUTH,ELEVATION", help="from where a scene in space is seen in a film, degrees: --view=-60,22")
    add("-o", "--output", metavar="FILE",
        help="the page or film (.html, .svg, .gif, .webp, .mp4; in space .glb: glTF); by default NAME.html here")


def add_play(parser: ArgumentParser) -> None:
    """Of `lag play`."""
    add = parser.add_argument
    add_start(parser)
    add("--stop", type=float, metavar="T", help="the end of the run whose digits are shown, in s; the page goes on")
    add("--tolerance", type=float, metavar="TOL", help="error allowed, relative to the size of each coordinate (1e-8)")
    add("--trace", metavar="FRAME,...", help="frames whose ways are drawn: --trace lower.b")
    add("--names", metavar="NAME=SYMBOL,...", help="symbols of your own: --names tilt.phi=theta,guide.s=x")
    add("-o", "--output", metavar="FILE.html", help="the page; without it a temporary file, which is opened")


