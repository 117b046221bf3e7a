"""Many runs of a scene on one core, from different starts of one coordinate: time a run beside its error.

    python tests/benchmarks/ensemble.py [--scene NAME] [--runs N] [--repeats N] [--peers heyoka,jax,mujoco]

Our sweep as it is, in lanes where these serve, and the same with one run after another; beside it, where they are installed,
heyoka's taylor_adaptive_batch (8 lanes, its loop over batches in Python), diffrax' Dopri8 in JAX under vmap, and MuJoCo's RK4
with fixed steps. The error is the median over the runs of that of the coordinate at the end, against our runs at a tolerance of
1e-14. Processor time of this process: the shortest of the repeats, in which all ways take turns; of JAX after it has compiled.
"""

import argparse
import operator
import os
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import peer_mujoco
import rollouts

import lagrangia as lag
from lagrangia.bench.heyoka_peer import translate
from lagrangia.run.request import Request
from lagrangia.study.sweep.journal import Ledger
from lagrangia.study.sweep.measures import read_measures
from lagrangia.study.sweep.plan import Design
from lagrangia.study.sweep.threads import run_on_threads

FOLDER = Path(__file__).resolve().parents[2] / "models" / "examples"
SCENE = FOLDER / "double_pendulum.lag"
STOP, LANES = 5.0, 8
# The coordinate whose start differs, from where to where; what MuJoCo calls the scene.
SCENES = {"double_pendulum": ("elbow.phi", 0.1, 1.0, "double pendulum"), "spring_pendulum": ("bob.center.x", 0.1, 0.5, ""),
          "cart_pole": ("hinge.phi", 0.1, 0.4, ""), "pushed_cart": ("hinge.phi", 0.1, 0.4, ""),
          "chain": ("hinge[1].phi", 0.5, 1.0, ""), "four_bar": ("O.phi", 0.5, 0.7, ""),
          "stick_slip": ("block.s", 0.0, 0.1, ""), "bouncing_ball": ("y.s", 1.2, 1.4, "")}
TOLERANCES = {"ours": (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10, 1e-12),
              "heyoka": (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 2.3e-16),
              "jax": (1e-6, 1e-9, 1e-12), "mujoco": (1e-3, 1e-6)}
ERRORS = (-5.0, -7.2, -8.8, -10.8, -12.8)  # decades at which lanes are compared with heyoka
PUSH = 1.0  # N more a second from 0 on, by the input of the cart that has no feedback
Work = Callable[[], np.ndarray]  # the coordinate at the end of each run


@dataclass(frozen=True)
class Many:
    """The runs: a model, a coordinate and its starts; what MuJoCo calls it, and a scene of its own."""

    model: lag.Model
    coordinate: str
    starts: np.ndarray
    case: str

    @property
    def place(self) -> int:
        """That of the coordinate among all."""
        return list(self.model.coordinate_names).index(self.coordinate)

    def states(self) -> np.ndarray:
        """At the start, (runs, 2 n): where loops close, each as one of our runs begins."""
        names = self.model.coordinate_names
        asked = [*names, *(f"der({name})" for name in names)]

        def begin(initial: dict[str, float]) -> list[float]:
            run = self.model.simulate(at=[0.0], initial=initial, inputs=self.inputs())
            return [run[name][0] for name in asked]

        if self.model.scene.sizes["n_multipliers"]:
            return np.array([begin({self.coordinate: float(start)}) for start in self.starts])
        found = np.tile(begin({}), (len(self.starts), 1))
        found[:, self.place] = self.starts
        return found

    def slope(self) -> ca.Function:
        """d(q, v)/dt of t and (q, v)."""
        n = len(self.model.coordinate_names)
        rhs, p = self.model.functions()["rhs"], self.model.parameter_values()
        t, x = ca.SX.sym("t"), ca.SX.sym("x", 2 * n)
        u = ca.repmat(PUSH * t, len(self.model.scene.inputs), 1)
        return ca.Function("slope", [t, x], [ca.vertcat(x[n:], rhs.expand()(t, x[:n], x[n:], u, p))])

    def inputs(self) -> tuple[np.ndarray, dict[str, list[float]]] | None:
        """Their table."""
        names = [entry.name for entry in self.model.scene.inputs]
        return (np.array([0.0, STOP]), {name: [0.0, PUSH * STOP] for name in names}) if names else None


def ours(many: Many, tolerance: float, in_lanes: bool = True, solver: str = "auto") -> Work:
    request = Request(stop=STOP, tolerance=tolerance, initial={many.coordinate: many.starts}, solver=solver,
                      inputs=many.inputs())
    suited, job = many.model.prepared_for(read_measures(f"final({many.coordinate})"), request, Design())
    job = replace(job, sweep=replace(job.sweep, in_lanes=in_lanes))
    engine = suited.engine_for(solver)
    if engine is None:
        raise SystemExit("there is no run time here, and no C compiler")

    def work() -> np.ndarray:
        ledger = Ledger(job)
        run_on_threads(job, engine, ledger, 1)
        return ledger.results[:, 0]

    return work


def by_heyoka(many: Many, tolerance: float) -> Work:
    import heyoka

    states, place = many.states(), many.place
    variables = heyoka.make_vars(*(f"y{k}" for k in range(states.shape[1])))
    slopes = translate(many.slope(), [[heyoka.time], list(variables)])
    system = list(zip(variables, slopes, strict=True))
    steps = heyoka.taylor_adaptive_batch(system, np.zeros((states.shape[1], LANES)), tol=tolerance)
    padded = np.concatenate([states, np.repeat(states[-1:], -len(states) % LANES, axis=0)])

    def work() -> np.ndarray:
        found = np.empty(len(padded))
        for k in range(0, len(padded), LANES):
            steps.set_time(0.0)
            steps.state[:] = padded[k : k + LANES].T
            steps.propagate_until(STOP)
            found[k : k + LANES] = steps.state[place]
        return found[: len(states)]

    return work


def by_jax(many: Many, tolerance: float) -> Work:
    import diffrax
    import jax

    jax.config.update("jax_enable_x64", True)
    slope, states, place = _in_jax(many.slope()), many.states(), many.place

    def one(y: Any) -> Any:
        steps = diffrax.PIDController(rtol=tolerance, atol=tolerance)
        found = diffrax.diffeqsolve(diffrax.ODETerm(lambda t, y, _: slope(t, y)), diffrax.Dopri8(), 0.0, STOP, 1e-3, y,
                                    stepsize_controller=steps, max_steps=None)
        return found.ys[0, place]

    every = jax.jit(jax.vmap(one))
    every(states).block_until_ready()
    return lambda: np.asarray(every(states))


def _in_jax(function: ca.Function) -> Callable[[Any, Any], Any]:
    """CasADi's instructions, one by one."""
    import jax.numpy as jnp

    known = {"ADD": operator.add, "SUB": operator.sub, "MUL": operator.mul, "DIV": operator.truediv, "NEG": operator.neg,
             "SIN": jnp.sin, "COS": jnp.cos, "SQRT": jnp.sqrt, "SQ": lambda x: x * x, "TWICE": lambda x: 2 * x,
             "INV": lambda x: 1 / x, "POW": jnp.power, "CONSTPOW": jnp.power, "ATAN2": jnp.arctan2, "FABS": jnp.abs}
    operations = {getattr(ca, f"OP_{name}"): what for name, what in known.items()}

    def slope(t: Any, y: Any) -> Any:
        work: list[Any] = [None] * max(1, function.sz_w())
        found: list[Any] = [0.0] * function.numel_out(0)
        for k in range(function.n_instructions()):
            op, read, write = function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)
            if op == ca.OP_INPUT:
                work[write[0]] = y[read[1]] if read[0] else t
            elif op == ca.OP_CONST:
                work[write[0]] = function.instruction_constant(k)
            elif op == ca.OP_OUTPUT:
                found[write[1]] = work[read[0]]
            else:
                work[write[0]] = operations[op](*(work[place] for place in read))
        return jnp.stack(found)

    return slope


def by_mujoco(many: Many, tolerance: float) -> Work:
    import mujoco

    model = mujoco.MjModel.from_xml_string(peer_mujoco.SCENES[many.case]())
    steps = round(100 * STOP * (1e-3 / tolerance) ** 0.25)
    model.opt.timestep = STOP / steps
    data, states, place = mujoco.MjData(model), many.states(), many.place

    def work() -> np.ndarray:
        found = np.empty(len(states))
        for k, state in enumerate(states):
            mujoco.mj_resetData(model, data)
            data.qpos[:], data.qvel[:] = np.split(state, 2)
            mujoco.mj_step(model, data, nstep=steps)
            found[k] = data.qpos[place]
        return found

    return work


PEERS = {"heyoka": by_heyoka, "jax": by_jax, "mujoco": by_mujoco}


def measured(ways: dict[str, Work], repeats: int, exact: np.ndarray) -> dict[str, tuple[float, float]]:
    """The shortest time and the median error of each."""
    found: dict[str, tuple[float, float]] = {}
    for _ in range(repeats):
        for name, work in ways.items():
            begin = time.process_time()
            ends = work()
            seconds = time.process_time() - begin
            found[name] = min(seconds, found.get(name, (seconds, 0.0))[0]), float(np.median(np.abs(ends - exact)))
    return found


def prepared(many: Many, peers: list[str]) -> dict[str, Work]:
    ways: dict[str, Work] = {}
    for tolerance in TOLERANCES["ours"]:
        ways[f"lanes, {tolerance:g}"] = ours(many, tolerance)
        ways[f"one by one, {tolerance:g}"] = ours(many, tolerance, False)
    has_outside = not many.model.scene.sizes["n_switches"]
    for peer in peers:
        if not (has_outside if peer != "mujoco" else many.case):
            print(f"{peer}: not this scene")
            continue
        try:
            ways |= {f"{peer}, {tolerance:g}": PEERS[peer](many, tolerance) for tolerance in TOLERANCES[peer]}
        except ImportError:
            print(f"{peer}: not installed")
    return ways


def seconds_at(decade: float, found: dict[str, tuple[float, float]], who: str) -> float:
    """To an error: between the ways of one peer that no other is both sooner and more exact than; NaN where none is so exact."""
    points = sorted((np.log10(max(error, 1e-18)), seconds) for name, (seconds, error) in found.items() if name.startswith(who))
    best = [(error, seconds) for k, (error, seconds) in enumerate(points) if all(seconds < before for _, before in points[:k])]
    errors, times = zip(*best, strict=True)
    return float(np.exp(np.interp(decade, errors, np.log(times), left=np.nan)))


def main() -> None:
    """Prints a line a way and a tolerance, and what lanes take by what heyoka takes at the same errors."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scene", default="double_pendulum", choices=SCENES)
    parser.add_argument("--runs", type=int, default=4000)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--peers", default=",".join(PEERS))
    options = parser.parse_args()
    if "jax" in options.peers:  # one core, as all others here
        os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
    coordinate, low, high, case = SCENES[options.scene]
    is_pushed = options.scene == "pushed_cart"
    model = lag.loads(rollouts.SCENE) if is_pushed else lag.load(FOLDER / f"{options.scene}.lag")
    many = Many(model, coordinate, np.linspace(low, high, options.runs), case)
    exact = ours(many, 1e-14, False, "taylor" if options.scene == "double_pendulum" else "auto")()
    found = measured(prepared(many, [peer for peer in options.peers.split(",") if peer]), options.repeats, exact)
    for name, (seconds, error) in sorted(found.items(), key=lambda item: item[0].split(",")[0]):
        print(f"{name:20} {1e6 * seconds / options.runs:7.1f} us a run, error 1e{np.log10(max(error, 1e-17)):.1f}")
    for decade in ERRORS if any(name.startswith("heyoka") for name in found) else ():
        ratio = seconds_at(decade, found, "lanes") / seconds_at(decade, found, "heyoka")
        print(f"lanes by heyoka at an error of 1e{decade}: {ratio:.2f}")


if __name__ == "__main__":
    main()
