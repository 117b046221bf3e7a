"""Options of what people do with their texts: format, server, doc, new, test."""

from argparse import ArgumentParser


def add_format(parser: ArgumentParser) -> None:
    """Of `lag format`."""
    add = parser.add_argument
    add("files", nargs="+", metavar="FILE", help="files, folders (all .lag files in them), or - for standard input to output")
    add("--check", action="store_true", help="write nothing; exit code 1 where a file would change")
    add("--diff", action="store_true", help="write nothing; print what would change")


def add_import(parser: ArgumentParser) -> None:
    """Of `lag import`."""
    parser.add_argument("file", metavar="FILE", help="of Modelica (.mo: Rotational, Translational, Blocks), a robot (.urdf), "
                                                     "or a scene of MuJoCo (.xml)")
    parser.add_argument("-o", "--output", metavar="FILE.lag", help="where it goes (beside it, with the ending .lag)")


def add_server(parser: ArgumentParser) -> None:
    """Of `lag server`."""
    parser.add_argument("--stdio", action="store_true", help="over standard input and output, as always: editors like to say so")


def add_doc(parser: ArgumentParser) -> None:
    """Of `lag doc`."""
    add = parser.add_argument
    add("files", nargs="*", metavar="FILE", help="your own, beside the library; a folder with package.lag is a package")
    add("-o", "--output", default="site", metavar="FOLDER", help="where to: site by default")


def add_new(parser: ArgumentParser) -> None:
    """Of `lag new`."""
    parser.add_argument("folder", metavar="NAME", help="of the project and its new folder")


def add_test(parser: ArgumentParser) -> None:
    """Of `lag test`."""
    add = parser.add_argument
    add("files", nargs="*", metavar="FILE", help="files or folders; the folder tests by default")
    add("--tolerance", default="1e-6", metavar="SHARE", help="allowed differences from stored tables, by the largest value")
    add("--update", action="store_true", help="store what the runs give")
