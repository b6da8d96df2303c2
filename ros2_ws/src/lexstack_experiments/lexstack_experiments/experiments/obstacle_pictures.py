"""Pictures of what passes: the clearance over time, and the robots at three instants."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from lexstack.types import Vector
from lexstack_experiments.loop import Loop
from lexstack_experiments.pictures import COLOURS, few_ticks, legend_beside, picture
from lexstack_sim.render import Renderer, RenderError

_INSTANTS = (6.4, 8.0, 13.0)  # s
_SIZE = (560, 420)  # pixels of one instant
_QUALITY = 85  # of the JPEG
_MARGIN = 0.05  # m


def draw_clearance(runs: Sequence[tuple[str, str, Vector, Vector]], out: Path) -> None:
    """Write obstacle-clearance.png: a panel for each case, a curve for each way.

    Args:
        runs: case, way, time [s] and clearance [m] of each run.
        out: the folder.
    """
    names = list(dict.fromkeys(case for case, *_ in runs))
    variants = list(dict.fromkeys(variant for _, variant, *_ in runs))
    size = (7.0, 1.5 * len(names) + 0.3)
    with picture(out / "obstacle-clearance.png", len(names), 1, size) as axes:
        for panel, name in zip(axes, names, strict=True):
            for case, variant, time, clearance in runs:
                if case == name:
                    panel.plot(
                        time, 1e3 * clearance, color=COLOURS[variants.index(variant)], label=variant
                    )
            panel.axhline(0.0, color="black", linewidth=0.8)
            panel.axhline(1e3 * _MARGIN, color="#555555", linewidth=0.8, linestyle=":")
            panel.set_ylim(-50.0, 450.0)
            panel.set_title(f"{name}: clearance [mm], dotted: margin", loc="left")
            legend_beside(panel)
            few_ticks(panel)
        axes[-1].set_xlabel("time [s]")


def render_passing(loop: Loop, path: Path) -> str:
    """Write the robots at three instants side by side; return why not, if so."""
    record = loop.record
    rate = loop.resolved.scenario.rate
    states = [record.states[min(round(at * rate), len(record.states) - 1)] for at in _INSTANTS]
    try:
        with Renderer(loop.parts.team, _SIZE) as renderer:
            renderer.frame([state.q for state in states], azimuth=-70.0, elevation=-25.0)
            images = [renderer.picture(state.q, stamp=state.stamp) for state in states]
    except RenderError as error:
        return f"no picture of the robots: {error}"
    Image.fromarray(np.concatenate(images, axis=1)).save(path, "JPEG", quality=_QUALITY)
    return ""
