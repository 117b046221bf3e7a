"""Work against precision as a picture: error to the right is smaller, time upwards is longer, both logarithmic."""

from collections.abc import Sequence
from pathlib import Path

from lagrangia.bench.measure import Point
from lagrangia.bench.table import by_solver
from lagrangia.view.curves import own_style, require_format, save

_MARKERS = "osD^v<>pP*Xhd"


@own_style()
def draw_points(title: str, points: Sequence[Point], ours: Sequence[str], floor: float, path: Path) -> None:
    """Ours with strong lines; the grey area lies below the reference's own error. Raises LagError L0004."""
    from matplotlib.figure import Figure

    require_format(path)
    figure = Figure(figsize=(8, 5.4), layout="constrained")
    axis = figure.subplots()
    for k, (name, group) in enumerate(by_solver(points).items()):
        shown = [p for p in group if p.error < 1.0]
        is_ours = name in ours
        axis.loglog([max(p.error, 1e-17) for p in shown], [p.seconds for p in shown], label=name,
                    marker=_MARKERS[k % len(_MARKERS)], markersize=5 if is_ours else 3.5, linewidth=2.4 if is_ours else 1.0,
                    color=f"C{k % 10}", linestyle="-" if k < 10 else "--", zorder=3 if is_ours else 2)
    axis.invert_xaxis()
    if axis.get_xlim()[1] < floor:
        axis.axvspan(floor, axis.get_xlim()[1], color="0.9", zorder=0)
    axis.set_xlabel("largest error of a coordinate, relative")
    axis.set_ylabel("processor time of one run [s]")
    axis.set_title(title, fontsize=11)
    axis.grid(True, which="major", alpha=0.3)
    axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    save(figure, path)
