"""Options of what runs a scene: simulate, sweep, bench."""

from argparse import ArgumentParser
from pathlib import Path

from lagrangia.command.common_options import add_sharing, add_values


def add_simulate(parser: ArgumentParser) -> None:
    """Of `lag simulate`."""
    add = parser.add_argument
    add("file", type=Path, metavar="FILE")
    add("--model", metavar="NAME", help="the model to run; the last of the file by default")
    add("--start", type=float, metavar="T", help="start time in s")
    add("--stop", type=float, metavar="T", help="stop time in s")
    add("--tolerance", type=float, metavar="TOL", help="error allowed, relative to the size of each coordinate (1e-8)")
    add("--interval", type=float, metavar="DT", help="time between two rows of the result")
    add("--at", metavar="T,T,...", help="the times of the rows, instead of an interval")
    add("-p", "--parameter", action="append", default=[], metavar="NAME=VALUE", help="a parameter: -p L=2 -p 'k=1[kN/m]' -p n=20")
    add_values(parser)
    add("--from", dest="start_from", metavar="equilibrium",
        help='start at rest, at the position reached from the start values; or in steady motion: "steady hinge.w=12"')
    add("--outputs", metavar="NAME,NAME,...", help="quantities to report besides coordinates, rates and outputs")
    add("--reactions", action="store_true", help="report the force and torque of every joint and tie")
    add_sharing(parser)
    add("-o", "--output", metavar="FILE",
        help="the result (.csv, .jsonl, .parquet, .npz, .mat; - for standard output); by default NAME.csv in this folder")
    add("--stream", action="store_true", help="rows stand in the file as they come, and stay there if the run is killed")
    add("--plot", metavar="FILE", type=Path, help="a picture (.png, .svg, .pdf)")
    add("--plot-quantities", metavar="NAME,...",
        help="what the picture shows, over time, or one against another (theta:theta'); all coordinates by default")
    add("--spectrum", metavar="NAME,...", help="amplitudes over frequency in the picture")
    add("--section", metavar="NAME[=VALUE]", help="the picture shows the states in which this rises through 0, or the value")
    add("--overlay", action="append", default=[], metavar="FILE.csv", help="a table beside the run in the picture: a measurement")
    add("--beside", action="append", default=[], metavar="NAME=VALUE,...|FILE.csv",
        help="another run in the picture, with these values; several with k=1:5:1, or those of a table")
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


def add_bench(parser: ArgumentParser) -> None:
    """Of `lag bench`."""
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
    add("--rhs", action="store_true", help="the accelerations of a tree in space alone, beside Pinocchio and MuJoCo")


def add_sweep(parser: ArgumentParser) -> None:
    """Of `lag sweep`."""
    add = parser.add_argument
    add("file", type=Path, metavar="FILE")
    add("--model", metavar="NAME", help="the model to run; the last of the file by default")
    add("-p", "--parameter", action="append", default=[], metavar="NAME=VALUES",
        help="-p m=1,2,5 -p k1=100:2000:50 (from:to:step) -p 'c=linspace(1,2,11)' -p 'L=normal(1,0.01)'; all combinations")
    add("--initial", action="append", default=[], metavar="NAME=VALUES", help="start values of a coordinate or rate, likewise")
    add("--runs", type=Path, metavar="FILE.csv", help="a table of parameters and start values, with a line for each run")
    add("--together", action="store_true", help="lists side by side instead of all their combinations")
    add("--samples", type=int, metavar="N", help="how many samples of the random values are taken")
    add("--sampling", default="random", metavar="WAY",
        help="random; lhs: a Latin hypercube; saltelli: N (values + 2) runs, for Sobol' indices")
    add("--seed", type=int, default=0, metavar="N", help="of the random values; the same seed gives the same values")
    add("--outputs", metavar="MEASURE,...",
        help="what is kept of each run: max(y), at(0.5, y), 'first_time(y > 3)', ... (lag help sweep); by default final values")
    add("-u", "--input", action="append", default=[], metavar="NAME=VALUE|FILE.csv", help="an input, the same in all runs")
    add_sharing(parser)
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
    add("--keep", action="store_true",
        help="whole trajectories too, rows an interval apart: Parquet files in a folder beside the table, NAME_sweep_runs")
    add("--until", metavar="CONDITION", help="random runs end when a standard error is small enough: 'se(mean(max(y))) < 1e-3'")
    add("--plot", metavar="FILE", type=Path, help="a picture of measures over what is varied (.png, .svg, .pdf)")
    add("--stats", action="store_true", help="say how many runs went on together, and how full the processor's lanes were")
    add("--restart", action="store_true", help="begin anew, whatever an interrupted sweep has left in FILE.part")
    add("--dry-run", action="store_true", help="only say which runs there would be")
    add("--quiet", action="store_true", help="say nothing but errors")


