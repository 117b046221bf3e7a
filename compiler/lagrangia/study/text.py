"""Equilibria, matrices, modes and responses as text for people."""

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lagrangia.base.html_table import unrounded
from lagrangia.language.frame_attributes import WRENCH_HEADINGS

if TYPE_CHECKING:
    from lagrangia.study.equilibria import Equilibria, Equilibrium
    from lagrangia.study.linearization import Linearization, Sampled
    from lagrangia.study.modes import Mode, Modes
    from lagrangia.study.response import Response

Matrix = NDArray[np.float64]
_WIDEST = 130
_MOST_ROWS = 40  # of a table on the screen; files have all
_NEGLIGIBLE = 1e-13
_UNDAMPED = 1e-9  # damping ratios that rounding leaves
_DEGREE = 180 / np.pi


def equilibria_text(found: "Equilibria") -> str:
    """Each position of rest with its verdict, coordinates, energy and reactions."""
    if not found.found:
        return f"{found.name}: no equilibrium was found"
    count = len(found.found)
    lines = [f"{found.name}: {count} {'equilibrium' if count == 1 else 'equilibria'}, time standing still at {found.time:g} s"]
    if not found.is_reached:
        lines.append("  none is reached from the start itself; found from other places:")
    for k, item in enumerate(found.found):
        reached = ", reached from the start" if k == 0 and found.is_reached else ""
        lines.append(f"{k + 1}: {_verdict(item)}{reached}")
        lines += [f"  {len(item.ways)} ways of moving meet here: {'; or '.join(item.ways)}"] * bool(item.ways)
        lines += [f"  {text}" for text in _positions(item.position, found.units)]
        lines.append(f"  V = {_shown(item.potential)} J; the largest force left over is {item.residual:.1e}")
        lines += [f"  {text}" for text in item.holding]
        if held := found.reactions_on(item):
            lines += [f"  {text}" for text in _reactions(held)]
        lines += [f"  {text}" for text in _positions(found.forces_along(item), found.units)]
    return "\n".join([*lines, *found.notes])


def _verdict(item: "Equilibrium") -> str:
    if item.stability == "unstable":
        return f"unstable: it runs away as exp({item.growth:.4g} t)"
    if item.stability == "singular":
        return "at rest in a singular position, where ways of moving meet: the linearised motion says nothing"
    if item.stability == "unknown":
        return "at rest, and whether it is stable is unknown"
    if item.stability == "fixed":
        return "fixed: nothing can move, so it stands as it is"
    if item.stability == "neutral":
        family = "one of a family: " if item.n_neutral else ""
        return f"neutral: {family}some motion costs nothing, and the linearised motion does not decide"
    if item.stability == "one-sided":
        return "stable, to one side: what is near stays near, but what just touches lets nothing swing through"
    if item.stability == "stable":
        return "stable: it oscillates about it, undamped"
    return f"asymptotically stable: motion dies out at least as exp({item.growth:.4g} t)"


def _positions(position: Mapping[str, float], units: Mapping[str, str]) -> Iterator[str]:
    width = max(map(len, position), default=0)
    for k, (name, value) in enumerate(position.items()):
        if k == _MOST_ROWS:
            yield f"... and {len(position) - k} more"
            return
        unit = units.get(name, "")
        angle = f" = {_shown(value * _DEGREE)} deg" if unit == "rad" else ""
        yield f"{name:{width}} = {_shown(value)} {unit}{angle}".rstrip()


def _reactions(joints: Mapping[str, list[float]]) -> Iterator[str]:
    """A line for each joint."""
    head = "reactions on"
    width = max(*map(len, joints), len(head))
    yield f"{head:{width}}" + "".join(f"{heading:>14}" for heading in WRENCH_HEADINGS[len(next(iter(joints.values())))])
    for joint, numbers in joints.items():
        yield f"{joint:{width}}" + "".join(f"{x:>14.6g}" for x in numbers)


def linearization_text(linear: "Linearization") -> str:
    """The matrices of small motion with the names of rows and columns, and the eigenvalues."""
    about = "equilibrium" if linear.is_equilibrium else "point, which is no equilibrium:"
    point = ", ".join(f"{name} = {_shown(x)}" for name, x in list(linear.point.items())[:8])
    more = ", ..." if len(linear.point) > 8 else ""
    names = rates = linear.coordinates
    told = "M x'' + C x' + K x = F u, with x = " + _some(names)
    if linear.free_rates:
        rates = linear.free_rates
        told = f"M z' + C z + K x = F u, with z = {_some(rates)}; x = {_some(names)}"
    lines = [f"{linear.name}: small motion about the {about} {point}{more}", "", told]
    for name, table, columns in (("M", linear.M, rates), ("C", linear.C, rates), ("K", linear.K, names),
                                 ("F of u", linear.F[0], linear.excitations), ("F of u'", linear.F[1], linear.excitations),
                                 ("F of u''", linear.F[2], linear.excitations)):
        if table.size and (name in "MCK" or table.any()):
            lines += ["", f"{name}", *_matrix(table, rates, columns)]
    if not linear.is_equilibrium:
        lines += ["", "load, left over at the point", *_matrix(linear.load[:, None], rates, ("",))]
    lines += ["", "z' = A z + B w, y = C z + D w"]
    for name, table, rows, columns in (
        ("A", linear.A, linear.states, linear.states), ("B", linear.B, linear.states, linear.inputs),
        ("C", linear.output, linear.outputs, linear.states), ("D", linear.D, linear.outputs, linear.inputs),
    ):
        if table.size:
            lines += ["", name, *_matrix(table, rows, columns)]
    s = linear.eigenvalues
    lines += ["", "eigenvalues of A: " + ", ".join(_complex(x) for x in s[:12] if x.imag >= 0) + (", ..." if s.size > 12 else "")]
    lines += _sampled(linear.sampled) if linear.sampled is not None else []
    lines += map(_note, linear.notes)
    return "\n".join(lines)


def _some(names: Sequence[str]) -> str:
    return ", ".join(names[:8]) + (", ..." if len(names) > 8 else "")


def _sampled(found: "Sampled") -> list[str]:
    lines = ["", f"from instant to instant, {found.interval:g} s apart: z = A z + B w, held values among the states"]
    for name, table, columns in (("A", found.A, found.states), ("B", found.B, found.inputs)):
        if table.size:
            lines += ["", f"{name} of the sampled system", *_matrix(table, found.states, columns)]
    s = found.eigenvalues
    largest = float(np.abs(s).max(initial=0.0))
    dies = "motion dies out" if largest < 1 else "it does not die out" if largest > 1 else ""
    told = ", ".join(_complex(x) for x in s[:12] if x.imag >= 0) + (", ..." if s.size > 12 else "")
    ending = f": {dies}" if dies else ""
    return [*lines, "", f"eigenvalues of the sampled system: {told}; the largest is {largest:.6g} long{ending}"]


def _matrix(table: Matrix, rows: Sequence[str], columns: Sequence[str]) -> list[str]:
    """With the names of rows and columns; of a large one its corner."""
    largest = float(np.abs(table).max(initial=0.0))
    left = max((len(x) for x in rows[:_MOST_ROWS]), default=0) + 2
    columns = columns[: _WIDEST // 12]
    cells = [[f"{0.0 if abs(x) <= _NEGLIGIBLE * largest else x:.6g}" for x in row] for row in table[:_MOST_ROWS, : len(columns)]]
    widths = [max(12, len(name) + 2, *(len(cell) + 1 for cell in column))
              for name, column in zip(columns, zip(*cells, strict=True) if cells else [()] * len(columns), strict=True)]
    shown = len(widths)
    while shown > 1 and left + sum(widths[:shown]) > _WIDEST:
        shown -= 1
    head = "".join(f"{name:>{w}}" for name, w in zip(columns[:shown], widths, strict=False))
    lines = [" " * left + head] if any(columns) else []
    for name, row in zip(rows, cells, strict=False):
        lines.append(f"{name:{left}}" + "".join(f"{cell:>{w}}" for cell, w in zip(row[:shown], widths, strict=False)))
    if shown < table.shape[1] or len(rows) > _MOST_ROWS:
        lines.append(f"  ... of {table.shape[0]} x {table.shape[1]}; -o FILE.json or FILE.mat has all of it")
    return lines


def modes_text(modes: "Modes") -> str:
    """Frequencies, eigenvalues with damping, and shapes."""
    point = ", ".join(f"{name} = {_shown(x)}" for name, x in list(modes.linearization.point.items())[:6])
    more = ", ..." if len(modes.coordinates) > 6 else ""
    lines = [f"{modes.name}: modes about {point}{more}", ""]
    if not modes.damped:
        return "\n".join([f"{lines[0]}: none, nothing can move", *map(_note, modes.notes)])
    for way in modes.ways:
        own = [(k, mode) for k, mode in enumerate(modes.modes[:_MOST_ROWS]) if mode.way == way]
        lines += [*([f"way of moving: {way}"] if way else []), *(_undamped_rows(own) if own else ())]
        if modes.has_damping or modes.is_gyroscopic:
            lines += [*([""] * bool(own)), *_damped(modes, way)]
        lines += [""] * bool(way and way != modes.ways[-1])
    if len(modes) > _MOST_ROWS:
        lines.append(f" ... and {len(modes) - _MOST_ROWS} more; -o FILE.json has all of them")
    if not len(modes):
        return "\n".join([*lines, *map(_note, modes.notes)])
    scaled = "mass-normalised" if modes.scaling == "mass" else "the largest entry of each is 1"
    lines += ["", f"shapes ({scaled})"]
    shown = min(len(modes), 8)
    lines += _matrix(modes.shapes[:, :shown], modes.coordinates, [f"mode {k + 1}" for k in range(shown)]) if shown else []
    return "\n".join([*lines, *map(_note, modes.notes)])


def _note(text: str) -> str:
    return text if text.startswith("warning[") else f"note: {text}"


def _undamped_rows(modes: Sequence[tuple[int, "Mode"]]) -> Iterator[str]:
    yield f"mode{'f [Hz]':>14}{'omega [rad/s]':>15}{'period [s]':>13}"
    for k, mode in modes:
        if mode.kind == "oscillation":
            yield f"{k + 1:>4}{mode.frequency:>14.7g}{mode.omega:>15.7g}{1 / mode.frequency:>13.6g}"
        elif mode.kind == "one way":
            yield f"{k + 1:>4}{mode.frequency:>14.7g}{mode.omega:>15.7g}   one way: it does not swing through"
        elif mode.kind == "rigid body":
            yield f"{k + 1:>4}{0:>14g}{0:>15g}   rigid-body motion: nothing brings it back"
        else:
            yield f"{k + 1:>4}   runs away as exp({mode.growth:.7g} t): the equilibrium is unstable"


def _damped(modes: "Modes", way: str) -> Iterator[str]:
    head = "eigenvalues " if not len(modes) else "with damping" if modes.has_damping else "gyroscopic  "
    yield f"{head}{'f [Hz]':>14}{'omega [rad/s]':>15}{'|s| [rad/s]':>13}{'zeta':>12}"
    for item in [item for item in modes.damped[:_MOST_ROWS] if item.way == way]:
        if item.eigenvalue.imag > 0:
            zeta = item.damping_ratio if abs(item.damping_ratio) > _UNDAMPED else 0.0
            yield f"{'':12}{item.frequency:>14.7g}{item.damped_omega:>15.7g}{item.omega:>13.7g}{zeta:>12.5g}"
        elif item.eigenvalue == 0:
            yield f"{'':12}{0:>14g}{0:>15g}{0:>13g}"
        else:
            yield f"{'':12}   no oscillation: {item.motion} as exp({item.eigenvalue.real:.7g} t)"


def response_text(response: "Response") -> str:
    """Peaks and ends of each curve, by magnitude and phase."""
    f = response.frequencies
    lines = [f"{response.name}: frequency response, {f.size} frequencies from {f[0]:.4g} to {f[-1]:.4g} Hz"]
    phase = response.phase
    s = response.linearization.eigenvalues
    unbounded = s.imag[np.abs(s.real) <= _UNDAMPED * np.abs(s)] / (2 * np.pi)
    for y, u, i, j in response.pairs():
        unit = response.unit(i, j)
        curve = response.magnitude[:, i, j]
        lines.append(f"{y} / {u} [{unit}]")
        marks = [("lowest", 0), *(("peak", int(k)) for k in _peaks(curve)), ("highest", f.size - 1)]
        for what, k in marks:
            if what == "peak" and (np.abs(unbounded - f[k]) <= 1e-3 * f[k]).any():
                lines.append(f"  {what:8}{f[k]:>12.6g} Hz   no bound: resonance without damping")
            else:
                lines.append(f"  {what:8}{f[k]:>12.6g} Hz   magnitude {curve[k]:>12.6g}   phase {phase[k, i, j] + 0.0:>9.4g} deg")
    return "\n".join([*lines, *map(_note, response.linearization.notes)])


def _peaks(curve: Matrix) -> list[int]:
    inner = np.flatnonzero((curve[1:-1] > curve[:-2]) & (curve[1:-1] >= curve[2:])) + 1
    return [int(k) for k in inner[:8]]


def _complex(x: complex) -> str:
    return f"{x.real + 0.0:.6g}" if x.imag == 0 else f"{x.real + 0.0:.6g} +- {abs(x.imag):.6g}i"


def _shown(x: float) -> str:
    return f"{unrounded(x):.7g}"
