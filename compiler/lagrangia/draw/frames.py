"""Pictures of moments -> GIF, WebP or MP4: one grey one after another."""

import math
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from lagrangia.base.result_files import Target
from lagrangia.draw.animation import speed_of
from lagrangia.draw.page import Page
from lagrangia.draw.raster import rasterise

Vector = NDArray[np.float64]
Picture = Callable[[int], Page]
_MOST = 150  # pictures of a GIF or WebP
_RATE = 25  # pictures a second of an MP4
_SCALE = 8.0  # pixels a mm
_SHORTEST = 20  # ms that viewers keep to


def save_frames(t: Vector, picture: Picture, path: Path, tell: Callable[[int, int], None] | None) -> None:
    """Writes the file: `picture` makes pages of one size of the moments t (T,), s; `tell` hears how many of how many are made.
    Raises LagError L0004."""
    length = float(t[-1] - t[0])
    seen = (t - t[0]) / speed_of(length)  # s
    with Target(path, binary=True) as target:
        if path.suffix.lower() == ".mp4":
            target.stream.write(_mp4(picture, seen, tell))
            return
        kept = np.unique(np.linspace(0, len(seen) - 1, min(len(seen), _MOST)).round().astype(int))
        first, *others = _pictures(picture, kept.tolist(), tell)
        gaps = np.diff(seen[kept]) * 1000
        each = [max(_SHORTEST, round(x)) for x in (*gaps, gaps.mean() if gaps.size else 1000.0)]
        first.save(target.stream, format=path.suffix[1:].upper(), save_all=True, append_images=others, duration=each, loop=0)


def _pictures(picture: Picture, moments: list[int], tell: Callable[[int, int], None] | None) -> Iterator[Image.Image]:
    for k, moment in enumerate(moments):
        page = picture(moment)
        yield rasterise(page, _SCALE, size=(_even(page.width), _even(page.height)))
        if tell is not None:
            tell(k + 1, len(moments))


def _even(length: float) -> int:
    """Pixels: MP4 takes even numbers of them."""
    return 2 * math.ceil(length * _SCALE / 2)


def _mp4(picture: Picture, seen: Vector, tell: Callable[[int, int], None] | None) -> bytes:
    """At an even rate: each picture shows the row that is nearest to its time."""
    import imageio_ffmpeg

    times = np.arange(1 + round(float(seen[-1]) * _RATE)) / _RATE
    moments = np.searchsorted((seen[1:] + seen[:-1]) / 2, times).tolist()
    with tempfile.TemporaryDirectory(prefix="lagrangia-") as folder:
        made = Path(folder) / "film.mp4"
        writer = None
        for image in _pictures(picture, moments, tell):
            if writer is None:
                writer = imageio_ffmpeg.write_frames(str(made), image.size, pix_fmt_in="gray", fps=_RATE, codec="libx264",
                                                     macro_block_size=2, quality=None, output_params=["-crf", "20"])
                writer.send(None)
            writer.send(image.tobytes())
        if writer is not None:
            writer.close()
        return made.read_bytes()
