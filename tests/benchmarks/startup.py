"""The first answer: whole processes from start to result, with an empty cache, with another scene in it, and once more.

    python tests/benchmarks/startup.py [--repeat N] [--links N,N,...] [--fmu]

Wall and processor time (its children's with it), medians; the ratio is that of processor times to `python -c "import casadi"` in
the same run, which takes turns with all others. Chains have an empty cache each time.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"
SMALL = ("double_pendulum", "four_bar", "stick_slip")
COMMAND = "import sys; from lagrangia.command.cli import main; sys.exit(main())"


def seconds(command: Sequence[str], cache: str, folder: str) -> tuple[float, float]:
    """Wall and processor time of one process. Raises SystemExit where it fails."""
    before, begin = os.times(), time.perf_counter()
    environment = os.environ | {"LAGRANGIA_CACHE": cache}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    wall, after = time.perf_counter() - begin, os.times()
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(command)}\n{done.stderr}")
    spent = after.children_user + after.children_system - before.children_user - before.children_system
    return wall, spent


def lag(*words: str) -> list[str]:
    return [sys.executable, "-c", COMMAND, *words]


def simulate(scene: str, *words: str) -> list[str]:
    return lag("simulate", str(EXAMPLES / f"{scene}.lag"), "--quiet", "-o", "rows.csv", *words)


def one_round(links: Sequence[int], with_fmus: bool) -> dict[str, tuple[float, float]]:
    """Each process once."""
    with tempfile.TemporaryDirectory() as folder:
        def run(command: Sequence[str], cache: str = "cache") -> tuple[float, float]:
            return seconds(command, str(Path(folder) / cache), folder)

        found = {"import casadi": run([sys.executable, "-c", "import casadi"]), "lag --help": run(lag("--help"))}
        found["suspended_bar, empty cache"] = run(simulate("suspended_bar"))
        found |= {f"{scene}, new": run(simulate(scene)) for scene in SMALL}
        found |= {f"{scene}, again": run(simulate(scene)) for scene in SMALL}
        found["equations of the double pendulum"] = run(lag("equations", str(EXAMPLES / "double_pendulum.lag")))
        for scene in ("four_bar", "slider_crank") if with_fmus else ():
            found[f"FMU of {scene}"] = run(lag("export", str(EXAMPLES / f"{scene}.lag"), "--to", "fmu", "-o", f"{scene}.fmu"))
        for n in links:
            found[f"chain of {n}, new"] = run(simulate("chain", "-p", f"n={n}", "--stop", "0.1"), f"cache{n}")
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--links", default="100,1000")
    parser.add_argument("--fmu", action="store_true", help="FMUs too, the first of which compiles what all share")
    options = parser.parse_args()
    rounds = [one_round([int(n) for n in options.links.split(",") if n], options.fmu) for _ in range(options.repeat)]
    casadi = statistics.median(found["import casadi"][1] for found in rounds)
    print("| whole process | wall | processor time | ratio |\n| --- | --- | --- | --- |")
    for name in rounds[0]:
        wall, spent = (statistics.median(found[name][k] for found in rounds) for k in (0, 1))
        print(f"| {name} | {wall:.2f} s | {spent:.2f} s | {spent / casadi:.1f} |")


if __name__ == "__main__":
    main()
