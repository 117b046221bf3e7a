"""Many short motions from arrays to arrays: for learning, and for controllers that try inputs out before they choose."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from lagrangia.base.checked_values import an_array, by_name
from lagrangia.base.diagnostics import Interrupted, fail
from lagrangia.base.records import dataclass
from lagrangia.run.request import Request
from lagrangia.run.scene import Scene
from lagrangia.study.sweep.journal import Ledger
from lagrangia.study.sweep.keeping import InMemory
from lagrangia.study.sweep.measures import read_measures
from lagrangia.study.sweep.plan import Design
from lagrangia.study.sweep.run import Asked, run_job
from lagrangia.study.sweep.table import Sweep
from lagrangia.view.rows import columns

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True)
class Rollout:
    """`rows` (runs, times, columns), NaN where a run did not come; r["cart.s"] is a column, (runs, times), in SI units."""

    times: "NDArray[np.float64]"  # s
    names: tuple[str, ...]
    rows: "NDArray[np.float64]"
    sweep: Sweep

    def __repr__(self) -> str:
        names = ", ".join([*self.names[1:9], *["..."] * (len(self.names) > 9)])
        begin, end = self.times[[0, -1]].tolist()
        times = f"{len(self.times)} times from {begin:g} to {end:g} s"
        return f"<{len(self.rows)} rollouts of {self.sweep.job.scene.name}, {times}: {names}>"

    def __getitem__(self, name: str) -> "NDArray[np.float64]":
        """Raises LagError L0701."""
        if name not in self.names:
            fail("L0701", f"a rollout has no column '{name}'", None, f"it has {', '.join(self.names[:20])}")
        column: NDArray[np.float64] = self.rows[:, :, self.names.index(name)]
        return column

    @property
    def q(self) -> "NDArray[np.float64]":
        """Coordinates, (runs, times, n); NaN for those of attitudes, whose quaternions are columns."""
        n: int = self.sweep.job.scene.n
        return self.rows[:, :, 1 : 1 + n]

    @property
    def v(self) -> "NDArray[np.float64]":
        """Their rates, (runs, times, n)."""
        n: int = self.sweep.job.scene.n
        return self.rows[:, :, 1 + n : 1 + 2 * n]

    @property
    def ok(self) -> "NDArray[np.bool_]":
        """Which runs went well, (runs,)."""
        return self.sweep.ok

    @property
    def failures(self) -> dict[int, str]:
        """Run -> why it failed."""
        return self.sweep.failures


def roll_out(model: Asked, q0: "ArrayLike | None", v0: "ArrayLike | None", p: "Mapping[str, ArrayLike] | None",
             u: "ArrayLike | None", times: "ArrayLike", *, tolerance: float | None, solver: str, jobs: int | None) -> Rollout:
    """What Model.rollout does. Raises LagError, Interrupted."""
    at = an_array("times", times)
    if at.ndim != 1 or len(at) < 2:
        fail("L0702", f"the times of a rollout are two numbers or more, not an array of the shape {at.shape}")
    scene = model.scene
    held = None if u is None else an_array("u", u)
    given = {**_states(scene, q0, v0), **by_name("parameters", p)}
    table = _table(given, _runs_of(held, len(at), len(scene.inputs)))
    request = Request(float(at[0]), float(at[-1]), tolerance, at=at.tolist(), solver=solver)
    first = scene.rates[0].name if scene.n else "time"
    suited, job = model.prepared_for(read_measures([f"final({first})"]), request, Design(table or None, keeps=True, held=held))
    keeper, ledger = InMemory(job.scene, job.runs, len(at), are_all_new=True), Ledger(job)
    sweep = run_job(job, suited, ledger, jobs=jobs, keeper=keeper)
    if sweep.interrupted:
        raise Interrupted.with_result(sweep, f"after {ledger.entered} of {job.runs} runs")
    sweep.warn()
    return Rollout(at, tuple(c.name for c in columns(job.scene)), keeper.rows, sweep)


def _states(scene: Scene, q0: "ArrayLike | None", v0: "ArrayLike | None") -> "dict[str, NDArray[np.float64]]":
    found = {}
    for what, given, known in (("q0", q0, scene.coordinates), ("v0", v0, scene.rates)):
        if given is None:
            continue
        x = an_array(what, given)
        if x.ndim not in (1, 2) or x.shape[-1] != len(known):
            fail("L0702", f"{what} has the shape (runs, {len(known)}), or ({len(known)},), not {x.shape}", None,
                 f"in the order {', '.join(c.name for c in known[:8])}")
        found.update({column.name: x[..., k] for k, column in enumerate(known)})
    return found


def _runs_of(u: "NDArray[np.float64] | None", times: int, inputs: int) -> int:
    if u is None:
        return 1
    if u.ndim != 3 or u.shape[1:] != (times - 1, inputs):
        fail("L0702", f"u has the shape (runs, {times - 1}, {inputs}): inputs from each time to the next, not {u.shape}", None,
             *([] if inputs else ["the scene has no inputs"]))
    return int(u.shape[0])


def _table(given: "Mapping[str, ArrayLike]", runs: int) -> "dict[str, NDArray[np.float64]]":
    """Columns as long as there are runs."""
    found = {name: an_array(f"'{name}'", x) for name, x in given.items()}
    for name, x in found.items():
        if x.ndim > 1:
            fail("L0702", f"'{name}' is a number, or one for each run, not an array of the shape {x.shape}", None,
                 "a part of a vector has a name of its own: p={'world.gravity[2]': [-9.81, -1.62]}")
    lengths = {name: x.shape[0] for name, x in found.items() if x.ndim == 1} | ({"u": runs} if runs != 1 else {})
    count = max(lengths.values(), default=1)
    for name, length in lengths.items():
        if length != count:
            fail("L0702", f"'{name}' is of {length} runs, and others are of {count}")
    return {name: np.broadcast_to(x, (count,)) for name, x in found.items()}
