"""Natural modes: undamped, K phi = omega^2 M phi, and the eigenvalues of the damped motion, s = -zeta omega +- i omega_d."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lagrangia.base.diagnostics import fail
from lagrangia.base.html_table import MOST_COLUMNS, MOST_ROWS, html_notes, html_table, missing
from lagrangia.base.records import dataclass
from lagrangia.study.linearization import Linearization, no_mass
from lagrangia.view.mechanism import Mechanism

Matrix = NDArray[np.float64]
_ROUNDING = 1e-11  # of the largest omega^2: below, a mode is rigid-body motion
_DEFECTIVE = 1e-6  # of the largest |s|: what rounding makes of a double zero
_SYMMETRIC = 1e-9
_OF_MOTION = "modes without damping, and shapes, are of what vibrates about rest: this scene moves"


@dataclass(frozen=True)
class Mode:
    """`omega2` (rad/s)^2, negative where the motion runs away; `shape` of all coordinates, by the scaling asked for."""

    omega2: float
    shape: Mapping[str, float]
    kind: str  # "oscillation", "one way" (something that just touches bars the way back), "rigid body", "divergence"
    way: str = ""  # where several ways of moving meet: the one that it belongs to

    @property
    def omega(self) -> float:
        """rad/s; 0 for rigid-body motion, and for motion that runs away, whose rate is `growth`."""
        return float(np.sqrt(self.omega2)) if self.kind in ("oscillation", "one way") else 0.0

    @property
    def frequency(self) -> float:
        """Hz."""
        return self.omega / (2 * np.pi)

    @property
    def growth(self) -> float:
        """1/s, of motion that runs away as exp(growth t)."""
        return float(np.sqrt(-self.omega2)) if self.kind == "divergence" else 0.0

    @property
    def title(self) -> str:
        """Its frequency, or how it runs away, in words."""
        if self.kind == "rigid body":
            return "rigid body, 0 Hz"
        if self.kind == "divergence":
            return f"runs away, exp({self.growth:.4g} t)"
        told = f"{self.frequency:.4g} Hz, {self.omega:.4g} rad/s"
        return f"{told}, one way" if self.kind == "one way" else told


@dataclass(frozen=True)
class DampedMode:
    """One eigenvalue s of the damped motion, of a pair the one with the positive imaginary part."""

    eigenvalue: complex
    way: str = ""

    @property
    def omega(self) -> float:
        """|s|, rad/s."""
        return abs(self.eigenvalue)

    @property
    def damped_omega(self) -> float:
        """rad/s, of the oscillation as one sees it."""
        return self.eigenvalue.imag

    @property
    def frequency(self) -> float:
        """Hz, of the oscillation as one sees it."""
        return self.eigenvalue.imag / (2 * np.pi)

    @property
    def motion(self) -> str:
        """In words."""
        if self.eigenvalue == 0:
            return "rigid body"
        return "oscillation" if self.eigenvalue.imag > 0 else "dies out" if self.eigenvalue.real < 0 else "runs away"

    @property
    def damping_ratio(self) -> float:
        """zeta = -Re(s)/|s|; NaN for s = 0."""
        return 0.0 - self.eigenvalue.real / self.omega if self.omega else float("nan")


@dataclass(frozen=True)
class Modes:
    """Undamped modes by frequency; `damped` by |s|. `notes` say what does not fit the picture of plain vibration. Where several
    ways of moving meet, the modes of each way stand together, and `linearization` is that of the first."""

    name: str
    coordinates: tuple[str, ...]
    modes: tuple[Mode, ...]
    damped: tuple[DampedMode, ...]
    has_damping: bool
    is_gyroscopic: bool
    scaling: str
    notes: tuple[str, ...]
    linearization: Linearization
    mechanism: Mechanism | None = None

    @property
    def ways(self) -> tuple[str, ...]:
        """By the coordinates that move; one without a name at ordinary positions."""
        return tuple(dict.fromkeys([*(mode.way for mode in self.modes), *(mode.way for mode in self.damped)]))

    def __len__(self) -> int:
        return len(self.modes)

    def __getitem__(self, k: int) -> Mode:
        return self.modes[k]

    def _repr_html_(self) -> str:
        """In a notebook: tables of frequencies, damping and shapes."""
        if not self.damped:
            return html_notes([f"{self.name}: no modes, nothing can move", *self.notes])
        ways = ["way of moving"] * (len(self.ways) > 1)
        rows = [(k, *([mode.way] if ways else []), mode.kind, mode.frequency, mode.omega,
                 1 / mode.frequency if mode.frequency else None, mode.growth or None)
                for k, mode in enumerate(self.modes[:MOST_ROWS], 1)]
        heads = ["mode", *ways, "kind", "f [Hz]", "omega [rad/s]", "period [s]", "growth [1/s]"]
        parts = [html_table(heads, rows, f"{self.name}: modes")] if rows else []
        if self.has_damping or self.is_gyroscopic:
            damped = [(*([item.way] if ways else []), item.motion, item.frequency, item.damped_omega, item.omega,
                       item.damping_ratio, item.eigenvalue.real) for item in self.damped[:MOST_ROWS]]
            heads = [*ways, "motion", "f [Hz]", "omega [rad/s]", "|s| [rad/s]", "zeta", "rate [1/s]"]
            parts.append(html_table(heads, damped, "with damping" if self.has_damping else "gyroscopic"))
        if not len(self):
            return "".join([*parts, html_notes(self.notes)])
        shown = range(min(len(self), MOST_COLUMNS))
        shapes = [(name, *(self[k].shape[name] for k in shown)) for name in self.coordinates[:MOST_ROWS]]
        scaled = "mass-normalised" if self.scaling == "mass" else "the largest entry of each is 1"
        parts.append(html_table(["", *(f"mode {k + 1}" for k in shown)], shapes, f"shapes ({scaled})"))
        return "".join([*parts, html_notes([*missing(len(self), "modes"), *self.notes])])

    @property
    def frequencies(self) -> Matrix:
        """Hz, undamped."""
        return np.array([mode.frequency for mode in self.modes])

    @property
    def omega(self) -> Matrix:
        """rad/s, undamped."""
        return np.array([mode.omega for mode in self.modes])

    @property
    def shapes(self) -> Matrix:
        """(coordinates, modes)."""
        return np.array([[mode.shape[name] for mode in self.modes] for name in self.coordinates])

    def to_dict(self) -> dict[str, Any]:
        """All of it as plain data, for files."""
        undamped = [{"frequency": m.frequency, "omega": m.omega, "growth": m.growth, "kind": m.kind, "shape": dict(m.shape),
                     **_of_way(m.way)} for m in self.modes]
        damped = [{"real": m.eigenvalue.real, "imag": m.eigenvalue.imag, "frequency": m.frequency, "omega": m.omega,
                   "damping_ratio": None if np.isnan(m.damping_ratio) else m.damping_ratio, **_of_way(m.way)}
                  for m in self.damped]
        return {"name": self.name, "point": dict(self.linearization.point), "scaling": self.scaling, "modes": undamped,
                "damped": damped, "notes": self.notes}

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickled without the mechanism: the shapes are then drawn as bars."""
        return Modes, (self.name, self.coordinates, self.modes, self.damped, self.has_damping, self.is_gyroscopic, self.scaling,
                       self.notes, self.linearization)

    def plot(self, path: Any = None) -> Any:
        """Each shape as the deflected mechanism, or as bars where nothing has an extent; returns the matplotlib Figure. Raises
        LagError L0916 about a state that moves while constraints hold it."""
        from lagrangia.study.pictures import Shapes, draw_modes

        if self.linearization.free_rates:
            fail("L0916", f"not supported yet: shapes of {self.name} ({_OF_MOTION})")

        q = np.array([self.linearization.point.get(name, 0.0) for name in self.coordinates])  # attitudes are not turned there
        shapes = tuple((mode.title, np.array([mode.shape[name] for name in self.coordinates])) for mode in self.modes)
        return draw_modes(Shapes(self.name, self.coordinates, q, shapes, self.mechanism), path)


def _of_way(way: str) -> dict[str, str]:
    return {"way": way} if way else {}


def modes_of_ways(found: Mapping[str, Modes]) -> Modes:
    """The modes of ways of moving that meet, by their names, as one."""
    first = next(iter(found.values()))
    modes = tuple(replace(mode, way=way) for way, own in found.items() for mode in own.modes)
    damped = tuple(replace(mode, way=way) for way, own in found.items() for mode in own.damped)
    notes = dict.fromkeys(note for own in found.values() for note in own.notes)
    word = f"a singular position, where {len(found)} ways of moving meet: small motion is along one of them"
    return replace(first, modes=modes, damped=damped, has_damping=any(own.has_damping for own in found.values()),
                   is_gyroscopic=any(own.is_gyroscopic for own in found.values()), notes=(*notes, word))


def find_modes(linear: Linearization, names: tuple[str, ...], kept: Sequence[int], mass_normalised: bool = False,
               mechanism: Mechanism | None = None) -> Modes:
    """`names` (n,) of all coordinates, of which `kept` are discrete variables. Raises RunError where M is singular."""
    coordinates = tuple(name for k, name in enumerate(names) if k not in kept)
    if linear.free_rates:
        return Modes(linear.name, coordinates, (), damped_modes(linear, True), True, True, "maximum 1",
                     (*linear.notes, _OF_MOTION), linear)
    t = linear.tangent
    M, C, K = (t.W.T @ A @ t.W for A in (t.M, t.C, t.K))
    notes = list(linear.notes)
    is_symmetric = bool(np.abs(K - K.T).max(initial=0.0) <= _SYMMETRIC * np.abs(K).max(initial=0.0))
    if not is_symmetric and linear.is_equilibrium:
        notes.append("the stiffness is not symmetric: forces follow the motion; modes that the undamped form does not know are "
                     "among the eigenvalues")
    if not linear.is_equilibrium:
        notes.append("the point is no equilibrium: these are modes of the motion seen from a point that it leaves")
    omega2, shapes = _undamped(M, K, is_symmetric)
    scale = float(np.abs(omega2).max(initial=0.0))
    full = np.delete(t.N @ t.W @ shapes, kept, axis=0)
    modes = []
    for w2, column, own in zip(omega2, full.T, shapes.T, strict=True):
        swing = "one way" if _is_barred(linear.barred, own) else "oscillation"
        kind = "rigid body" if abs(w2) <= _ROUNDING * scale or w2 == 0 else swing if w2 > 0 else "divergence"
        largest = column[int(np.abs(column).argmax())] if column.size else 1.0
        scaled = (column * np.sign(largest) if mass_normalised else column / largest) + 0.0
        modes.append(Mode(float(w2), dict(zip(coordinates, map(float, scaled), strict=True)), kind))
    symmetric, skew = (float(np.abs(part).max(initial=0.0)) for part in ((C + C.T) / 2, (C - C.T) / 2))
    has_damping, is_gyroscopic = symmetric > _SYMMETRIC * skew, skew > _SYMMETRIC * symmetric
    if is_gyroscopic:
        notes.append("forces across the motion (the antisymmetric part of C, of frames that turn) are left out of the undamped "
                     "modes and the shapes; the eigenvalues have them")
    damped = damped_modes(linear, any(mode.kind == "rigid body" for mode in modes))
    return Modes(linear.name, coordinates, tuple(modes), damped, has_damping, is_gyroscopic,
                 "mass" if mass_normalised else "maximum 1", tuple(notes), linear, mechanism)


def _undamped(M: Matrix, K: Matrix, is_symmetric: bool) -> tuple[Matrix, Matrix]:
    """omega^2 in rising order, and shapes with phi^T M phi = 1."""
    try:
        L = np.linalg.cholesky(M)
    except np.linalg.LinAlgError:
        raise no_mass() from None
    reduced = np.linalg.solve(L, np.linalg.solve(L, K).T).T
    if is_symmetric:
        values, vectors = np.linalg.eigh((reduced + reduced.T) / 2)
    else:
        found, complex_vectors = np.linalg.eig(reduced)
        order = np.argsort(found.real)
        values, vectors = found.real[order], complex_vectors.real[:, order]
        vectors = vectors / np.maximum(np.linalg.norm(vectors, axis=0), 1e-300)
    return np.asarray(values), np.linalg.solve(L.T, vectors)


def damped_modes(linear: Linearization, has_rigid: bool) -> tuple[DampedMode, ...]:
    """Eigenvalues of A with Im >= 0 by size; those that only rounding keeps from zero are zero."""
    s = linear.eigenvalues
    largest = float(np.abs(s).max(initial=0.0))
    nothing = (_DEFECTIVE if has_rigid else 1e-14) * largest
    found = [complex(0.0) if abs(x) <= nothing else complex(x.real, 0.0 if abs(x.imag) <= 1e-13 * largest else x.imag) for x in s]
    return tuple(DampedMode(x) for x in sorted((x for x in found if x.imag >= 0), key=abs))


def _is_barred(barred: Matrix | None, shape: Matrix) -> bool:
    """Whether motion of this shape, of the free rates, passes a gap that is just closed."""
    return barred is not None and bool((np.abs(barred @ shape) > _SYMMETRIC * (np.abs(barred) @ np.abs(shape))).any())


_WORST = ("unstable", "unknown", "neutral", "one-sided", "stable", "asymptotically stable", "fixed")


def stability_of_ways(found: Sequence[Linearization]) -> tuple[str, float]:
    """That of the way of moving that is least stable; nothing moves where there is none."""
    return min((stability(linear) for linear in found), key=lambda x: (_WORST.index(x[0]), -x[1]), default=("fixed", 0.0))


def stability(linear: Linearization) -> tuple[str, float]:
    """Of a position of rest, and the largest real part of an eigenvalue, 1/s. Where something just touches that free motion would
    pass, eigenvalues know of no way back; what is near stays near where all forces take energy, or keep it in a potential."""
    kind, growth = _by_eigenvalues(linear)
    if linear.barred is None or kind not in ("stable", "asymptotically stable"):
        return kind, growth
    t = linear.tangent
    C, K = (t.W.T @ A @ t.W for A in (t.C, t.K))
    is_symmetric = np.abs(K - K.T).max() <= _SYMMETRIC * np.abs(K).max()
    keeps = not linear.has_signals and is_symmetric and np.linalg.eigvalsh(K + K.T).min() > 0
    takes = np.linalg.eigvalsh(C + C.T).min() >= -_SYMMETRIC * np.abs(C).max()
    return ("one-sided" if keeps and takes else "unknown"), float("nan")


def _by_eigenvalues(linear: Linearization) -> tuple[str, float]:
    t = linear.tangent
    if t.W.shape[1] == 0:
        return "fixed", 0.0
    omega2, _ = _undamped(t.W.T @ t.M @ t.W, t.W.T @ t.K @ t.W, False)
    scale = float(np.abs(omega2).max(initial=0.0))
    has_rigid = bool((np.abs(omega2) <= _ROUNDING * scale).any()) or scale == 0
    s = linear.eigenvalues
    if linear.has_signals:
        has_rigid = bool((np.abs(s) <= 1e-9 * np.abs(s).max(initial=0.0)).any())
    size = max(float(np.abs(s).max(initial=0.0)), float(np.sqrt(scale)))
    margin = (_DEFECTIVE if has_rigid else 1e-9) * size
    growth = float(s.real.max(initial=-np.inf)) if s.size else 0.0
    if growth > margin:
        return "unstable", growth
    if has_rigid:
        return "neutral", 0.0
    return ("asymptotically stable", growth) if growth < -margin else ("stable", 0.0)
