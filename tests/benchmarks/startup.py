"""The first answer: whole processes from start to result, with an empty cache, with another scene in it, and once more.

    python tests/benchmarks/startup.py [--repeat N] [--links N,N,...] [--fmu] [--peers PYTHON,...]

Wall and processor time (its children's with it), medians; the ratio is that of processor times to `python -c "import casadi"` in
the same run, which takes turns with all others. Chains have an empty cache each time. Modules are compiled before anything is
measured, as installing does, also those of a source tree and where PYTHONDONTWRITEBYTECODE is set. Peers are run by the
interpreters named, those of them that have MuJoCo or rumoca: the double pendulum over its experiment, MuJoCo chains over 0.1 s.
"""

import argparse
import compileall
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
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


MOST_NESTED = 300  # bodies in bodies: TinyXML, which MuJoCo reads by, refuses some more
MUJOCO = """
import sys, mujoco
link = "<body pos='{x} 0 0'><joint axis='0 0 1'/><inertial pos='{c} 0 0' mass='{m}' diaginertia='{i} {i} {i}'/>"
n, stop = int(sys.argv[1]), float(sys.argv[2])
one = [(0, .5, 1, 1/12), (1, .35, .5, .5*.49/12)] if n == 2 else [(.5 if k else 0, .25, 1, .25/12) for k in range(n)]
bodies = "".join(link.format(x=x, c=c, m=m, i=i) for x, c, m, i in one) + "</body>"*n
head = "<option gravity='0 -9.81 0' timestep='0.001' integrator='RK4'/>"
model = mujoco.MjModel.from_xml_string(f"<mujoco>{head}<worldbody>{bodies}</worldbody></mujoco>")
data = mujoco.MjData(model)
data.qpos[n == 2] = 1.0
mujoco.mj_step(model, data, nstep=round(stop/0.001))
print(*data.qpos[:2])
"""
RUMOCA = """
import sys, rumoca
model = rumoca.Session().loads(open(sys.argv[1]).read(), model="DoublePendulum")
found = model.simulate(t=(0.0, 10.0), dt=0.02, config=rumoca.SimConfig(rtol=1e-9, atol=1e-9))
print(found.to_numpy(["phi_shoulder"])[-1])
"""


def peers_of(pythons: Sequence[str], links: Sequence[int], folder: Path) -> dict[str, list[str]]:
    """What is run of them, by a name; interpreters that have neither are refused."""
    found = {}
    for python in pythons:
        has = [name for name in ("mujoco", "rumoca") if not subprocess.run([python, "-c", f"import {name}"], capture_output=True,
                                                                           check=False).returncode]
        if not has:
            raise SystemExit(f"{python} has neither MuJoCo nor rumoca")
        if "mujoco" in has:
            found["MuJoCo, double pendulum"] = [python, "-c", MUJOCO, "2", "10"]
            found |= {f"MuJoCo, chain of {n}": [python, "-c", MUJOCO, str(n), "0.1"] for n in links if n <= MOST_NESTED}
        if "rumoca" in has:
            flat = folder / "double_pendulum.mo"
            written = lag("export", str(EXAMPLES / "double_pendulum.lag"), "--to", "modelica", "-o", str(flat))
            subprocess.run(written, check=True, capture_output=True)
            found["rumoca, double pendulum"] = [python, "-c", RUMOCA, str(flat)]
    return found


def one_round(links: Sequence[int], with_fmus: bool, peers: Mapping[str, Sequence[str]]) -> dict[str, tuple[float, float]]:
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
        return found | {name: run(command) for name, command in peers.items()}


def compile_modules() -> None:
    """Those of the package that is measured."""
    spec = find_spec("lagrangia")
    assert spec is not None and spec.submodule_search_locations is not None
    for folder in spec.submodule_search_locations:
        compileall.compile_dir(folder, quiet=2)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--links", default="100,1000")
    parser.add_argument("--fmu", action="store_true", help="FMUs too, the first of which compiles what all share")
    parser.add_argument("--peers", default="", metavar="PYTHON,...", help="interpreters that have MuJoCo or rumoca")
    options = parser.parse_args()
    compile_modules()
    links = [int(n) for n in options.links.split(",") if n]
    with tempfile.TemporaryDirectory() as folder:
        peers = peers_of([python for python in options.peers.split(",") if python], links, Path(folder))
        rounds = [one_round(links, options.fmu, peers) for _ in range(options.repeat)]
    casadi = statistics.median(found["import casadi"][1] for found in rounds)
    print("| whole process | wall | processor time | ratio |\n| --- | --- | --- | --- |")
    for name in rounds[0]:
        wall, spent = (statistics.median(found[name][k] for found in rounds) for k in (0, 1))
        print(f"| {name} | {wall:.2f} s | {spent:.2f} s | {spent / casadi:.1f} |")


if __name__ == "__main__":
    main()
