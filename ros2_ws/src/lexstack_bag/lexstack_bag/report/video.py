"""The run as a film, ``video.mp4``: rendered offscreen from the recorded positions."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lexstack.types import Vector
from lexstack_bag.errors import BagError
from lexstack_bag.figures.phases import Phase
from lexstack_bag.figures.series import TimeSeries
from lexstack_bag.run.run import Run

_FPS = 25
_SIZE = (960, 544)  # pixels; a codec's blocks have 16
_SAMPLES = 60  # configurations by which the camera is placed
_INK, _PLATE = (29, 39, 51), (255, 255, 255)


def write_video(
    path: Path,
    run: Run,
    time_series: TimeSeries,
    phases: Sequence[Phase],
    progress: Callable[[float], None] = lambda _part: None,
) -> int:
    """Render a run in real time at 25 pictures a second and return how many pictures it has.

    Args:
        path: of the mp4 file (H.264), overwritten.
        run: the run.
        time_series: its references.
        phases: its stacks, written into the picture.
        progress: told the part that is done, 0 to 1.

    Raises:
        RenderError: nothing on this machine renders offscreen; the text says what to install.
        BagError: the encoder is missing, or failed.
    """
    try:
        from imageio_ffmpeg import write_frames  # noqa: PLC0415 - only here, and slow to load

        from lexstack_sim.render import Renderer  # noqa: PLC0415 - optional, and slow to load
    except ImportError as error:
        raise BagError(f"no video: {error}; run ./scripts/setup") from error
    rows = _rows(time_series.time)
    with Renderer(run.team(), _SIZE, fast=True) as renderer:
        seen = rows[np.linspace(0, len(rows) - 1, _SAMPLES).astype(int)]
        poses = [pose for row in seen for pose in time_series.references[row].ee]
        renderer.frame([run.plant.q[row] for row in seen], poses)
        # Without yuv420p browsers show nothing.
        film = write_frames(str(path), _SIZE, fps=_FPS, pix_fmt_out="yuv420p", quality=7)
        film.send(None)
        try:
            for done, image in enumerate(_pictures(renderer, run, time_series, phases, rows), 1):
                film.send(np.ascontiguousarray(image))
                progress(done / len(rows))
        except OSError as error:
            raise BagError(f"{path}: the encoder failed: {' '.join(str(error).split())}") from error
        finally:
            film.close()
    return len(rows)


def _rows(time: Vector) -> Any:
    """Return the rows of the plant's states that are shown."""
    count = max(1, int((time[-1] - time[0]) * _FPS) + 1)
    shown = np.searchsorted(time, time[0] + np.arange(count) / _FPS - 1e-9)
    return np.minimum(shown, len(time) - 1)


def _pictures(
    renderer: Any, run: Run, time_series: TimeSeries, phases: Sequence[Phase], rows: Any
) -> Iterator[Any]:
    """Yield the pictures with time and stack written into them."""
    starts = np.array([phase.start for phase in phases])
    for row in rows:
        time = float(time_series.time[row])
        targets = dict(zip(run.robots, time_series.references[row].ee, strict=True))
        image = renderer.picture(run.plant.q[row], targets, time)
        phase = phases[max(0, int(np.searchsorted(starts, time + 1e-6, "right")) - 1)]
        yield _labelled(image, f"{time:.2f} s   {phase.stack}")


def _labelled(image: Any, text: str) -> Any:
    """Return the picture with a line of text."""
    from PIL import Image, ImageDraw  # noqa: PLC0415 - only here

    picture = Image.fromarray(image)
    draw = ImageDraw.Draw(picture)
    draw.rectangle((12, 12, 260, 38), fill=_PLATE)
    draw.text((20, 16), text, fill=_INK, font_size=16)
    return np.asarray(picture)
