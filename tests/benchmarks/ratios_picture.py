"""Draws a table of ratios as `ratios.py` prints it: time of `auto` beside the fastest peer, a curve a scene.

    python tests/benchmarks/ratios_picture.py [TABLE.md] [-o PICTURE.png]

The table is looked for in a Markdown file, by default the page of this folder. Of a cell with a bar the number
before it is drawn.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path

import matplotlib

PAGE = Path(__file__).with_name("README.md")


def rows(page: str) -> Iterator[tuple[str, list[float]]]:
    """The scenes and their ratios, an error of a decade each; the first row is the errors themselves, under the name "scene"."""
    lines = iter(page.splitlines())
    for line in lines:
        if line.startswith("| scene | 1e-"):
            break
    else:
        raise SystemExit("no table that begins with '| scene | 1e-'")
    while line.startswith("|"):
        name, *cells = [cell.strip() for cell in line.strip("| ").split(" | ")]
        if not name.startswith("-"):
            yield name, [float(cell.split()[0]) for cell in cells]
        line = next(lines, "")


def draw(page: str, path: Path) -> None:
    matplotlib.use("Agg")
    from matplotlib import pyplot

    (_, errors), *scenes = rows(page)
    figure, axes = pyplot.subplots(figsize=(8.5, 4.2), layout="constrained")
    marks = "osv^D<>ph*Xd8Ps"
    for k, (name, ratios) in enumerate(scenes):
        axes.loglog(errors, ratios, marker=marks[k % len(marks)], markersize=4, linewidth=1.1, color=f"C{k % 10}", label=name,
                    linestyle="-" if k < 10 else "--")
    axes.axhline(1, color="black", linewidth=1.4)
    axes.text(errors[0], 1.06, "the fastest peer", ha="left", va="bottom")
    axes.invert_xaxis()
    axes.set(xlabel="error, relative", ylabel="time of auto / time of the peer", ylim=(0.015, 1.6))
    axes.grid(alpha=0.3)
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=8, frameon=False)
    figure.savefig(path, dpi=130, metadata={"Software": None})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("page", nargs="?", type=Path, default=PAGE)
    parser.add_argument("-o", "--output", type=Path, default=Path("ratios.png"))
    options = parser.parse_args()
    draw(options.page.read_text(encoding="utf-8"), options.output)
    print(f"{options.output}: drawn from {options.page.name}")


if __name__ == "__main__":
    main()
