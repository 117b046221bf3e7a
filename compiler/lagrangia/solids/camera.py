"""A stage, seen from far away -> strokes on paper: what is nearer hides what is behind it."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lagrangia.draw.page import Page, build_page, view_of, weight_of
from lagrangia.draw.strokes import Shape, Spot, Stroke
from lagrangia.solids.stage import Body, Stage, matrices

Vector = NDArray[np.float64]
_FRONT = 1e-9  # how far a face has to look towards the eye
_PIECE = 4  # segments of a line that lie together


@dataclass(frozen=True)
class Camera:
    """Far away, to look along -`forth`: by its azimuth about `up` and its elevation, rad."""

    azimuth: float
    elevation: float
    up: Vector

    @cached_property
    def axes(self) -> Vector:
        """To the right, upwards on paper, and towards the eye: the rows of a matrix (3, 3)."""
        up = self.up / np.linalg.norm(self.up)
        east = np.eye(3)[int(np.argmin(np.abs(up)))]
        east = east - (east @ up) * up
        east /= np.linalg.norm(east)
        north = np.cross(up, east)
        level = np.cos(self.azimuth) * east + np.sin(self.azimuth) * north
        forth = np.cos(self.elevation) * level + np.sin(self.elevation) * up
        right = np.cross(up, level)
        return np.array([right, np.cross(forth, right), forth])

    def seen(self, points: Vector) -> Vector:
        """(n, 3) -> on paper and towards the eye, (n, 3), m."""
        found: Vector = points @ self.axes.T
        return found


def usual(up: Vector) -> Camera:
    """From the front, a little from the right and from above, as drawings are made."""
    return Camera(np.deg2rad(-60.0), np.deg2rad(22.0), up)


def strokes_at(stage: Stage, moment: int, camera: Camera) -> list[Stroke]:
    """From behind to in front, in layers of their own."""
    found: list[tuple[float, list[Stroke]]] = [_body(body, moment, camera) for body in stage.bodies]
    for line in stage.lines:
        points = line.at(moment)
        if np.isfinite(points).all():
            seen = camera.seen(points)
            for k in range(0, len(seen) - 1, _PIECE):
                part = seen[k : k + _PIECE + 1]
                found.append((float(part[:, 2].mean()) + 1e-6 * stage.symbol, [Stroke(part[:, :2], 0, line.line)]))
    found.sort(key=lambda pair: pair[0])
    strokes = [stroke for _, parts in found for stroke in parts]
    return [Stroke(s.points, k, s.line, s.fill, s.is_closed, s.radius) for k, s in enumerate(strokes)]


def _body(body: Body, moment: int, camera: Camera) -> tuple[float, list[Stroke]]:
    """Its outline, filled, and the edges that are seen."""
    pose = body.poses[moment]
    if not np.isfinite(pose).all():
        return 0.0, []
    turn = matrices(pose[3:])
    seen = camera.seen(body.solid.vertices @ turn.T + pose[:3])
    if body.solid.radius:
        at = seen.mean(axis=0)
        return float(at[2]), [Stroke(at[None, :2], 0, "normal", body.shade, True, body.solid.radius)]
    front = (body.solid.normals @ turn.T) @ camera.axes[2] > _FRONT
    strokes = [Stroke(_hull(seen[:, :2]), 0, "normal", body.shade, True)]
    strokes += [Stroke(seen[[*edge[:2]], :2], 0, "thin") for edge in body.solid.edges
                if front[edge[2]] and front[edge[3]] and body.solid.is_sharp(edge)]
    return float(seen[:, 2].mean()), strokes


def _hull(points: Vector) -> Vector:
    """The convex hull, counter-clockwise (Andrew, 1979)."""
    order = points[np.lexsort((points[:, 1], points[:, 0]))]

    def half(row: Vector) -> list[Vector]:
        kept: list[Vector] = []
        for p in row:
            while len(kept) > 1:
                (ax, ay), (bx, by) = kept[-1] - kept[-2], p - kept[-2]
                if ax * by - ay * bx > 0:
                    break
                kept.pop()
            kept.append(p)
        return kept[:-1]

    return np.array([*half(order), *half(order[::-1])])


def page_at(stage: Stage, moment: int, camera: Camera, title: str = "", whole: bool = False) -> Page:
    """A picture of one moment; `whole`: with the room that all moments need, so that pictures of a film are alike."""
    strokes = strokes_at(stage, moment, camera)
    traces = [camera.seen(points[: moment + 1])[:, :2] for _, points in stage.traces]
    strokes += [Stroke(way, len(strokes), "thin") for way in traces if len(way) > 1 and np.isfinite(way).all()]
    view = view_of([Stroke(_room(stage, camera), 0)] if whole else strokes, np.inf)
    shapes = [(Shape(strokes), None)]
    spots = [(Shape([], Spot(camera.seen(c.at[moment][None])[0, :2], np.array([0.6, 0.8]))), c.words) for c in stage.captions
             if np.isfinite(c.at[moment]).all() and not whole]
    return build_page([*shapes, *spots], view, title, weight_of(view.scale * stage.symbol))


def _room(stage: Stage, camera: Camera) -> Vector:
    low, high = stage.corners
    corners = np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(-1, 3)
    return camera.seen(corners)[:, :2]
