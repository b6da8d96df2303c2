"""Pictures of the robots at the paper's instants, rendered from the recorded positions."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from lexstack_bag.figures.phases import Phase
from lexstack_bag.figures.series import TimeSeries
from lexstack_bag.report.figure import letters
from lexstack_bag.run.run import Run

_QUALITY = 88  # of the JPEG
_MOST = 8  # pictures
_CAPTION = Markup("<b>{}</b> {} s: {}")


@dataclass(frozen=True, slots=True)
class Picture:
    """One rendered instant."""

    caption: Markup
    uri: str  # data:image/jpeg;base64,...


def pictures(
    run: Run, time_series: TimeSeries, phases: Sequence[Phase]
) -> tuple[list[Picture], str]:
    """Return the pictures at every trigger and at the end, or none and the reason.

    Rendering needs the simulation package and OpenGL; whatever keeps it from working, the report
    has everything else.
    """
    instants = _instants(run, phases)[:_MOST]
    rows = [int(np.argmin(np.abs(run.plant.stamp - time))) for time, _ in instants]
    try:
        from lexstack_sim.render import snapshots  # noqa: PLC0415 - optional, and slow to load

        targets = [
            dict(zip(run.robots, time_series.references[row].ee, strict=True)) for row in rows
        ]
        stamps = [float(run.plant.stamp[row]) for row in rows]
        images = snapshots(run.resolved, [run.plant.q[row] for row in rows], targets, stamps)
        encoded = [_jpeg(image) for image in images]
    except Exception as error:  # noqa: BLE001 - drivers raise what they like
        text = " ".join(str(error).split()) or "no message"
        return [], f"{type(error).__name__}: {text}"
    return [Picture(caption, uri) for (_, caption), uri in zip(instants, encoded, strict=True)], ""


def _instants(run: Run, phases: Sequence[Phase]) -> list[tuple[float, Markup]]:
    """Return times [s] and captions of what is shown."""
    instants = []
    for label, before, after in zip(letters(phases), phases, phases[1:], strict=False):
        what = f"end of {before.stack}, {after.title} begins"
        instants.append((after.start, _CAPTION.format(label, f"{after.start:.2f}", what)))
    end = float(run.plant.stamp[-1])
    label = f"({chr(ord('A') + len(instants) % 26)})"
    instants.append((end, _CAPTION.format(label, f"{end:.2f}", "final configuration")))
    return instants


def _jpeg(image: np.ndarray) -> str:
    """Return an RGB image, shape (height, width, 3) of uint8, as a data URI."""
    from PIL import Image  # noqa: PLC0415 - only where there is something to show

    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, "JPEG", quality=_QUALITY)
    return "data:image/jpeg;base64," + base64.b64encode(buffer.getvalue()).decode("ascii")
