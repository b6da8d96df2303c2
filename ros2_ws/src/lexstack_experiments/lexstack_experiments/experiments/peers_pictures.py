"""The picture of the reaches: which share has arrived by when, law by law."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from lexstack_experiments.experiments.peers_runs import Run
from lexstack_experiments.pictures import COLOURS, legend_beside, picture


def draw(path: Path, runs: Mapping[tuple[str, str, str], Sequence[Run]], seconds: float) -> None:
    """Draw a panel for each robot and each set of limits.

    Args:
        path: of the picture.
        runs: by robot, limits and law.
        seconds: that a reach may take.
    """
    robots, limits = (list(dict.fromkeys(key[i] for key in runs)) for i in (0, 1))
    with picture(path, len(limits), len(robots), (9.0, 2.3 * len(limits))) as panels:
        for i, kept in enumerate(limits):
            names = dict.fromkeys(name for _, those, name in runs if those == kept)
            colours = dict(zip(names, COLOURS, strict=False))
            for j, robot in enumerate(robots):
                panel = panels[i * len(robots) + j]
                for (one, those, name), found in runs.items():
                    if (one, those) != (robot, kept):
                        continue
                    times = sorted(each.time for each in found if each.time is not None)
                    share = 100.0 * np.arange(len(times) + 1) / len(found)
                    style = "-" if name.startswith("lexstack") else "--"
                    panel.step([0.0, *times, seconds], [*share, share[-1]], style, where="post",
                               color=colours[name], label=name)  # fmt: skip
                panel.set(xlim=(0.0, 6.0), ylim=(0.0, 102.0), title=f"{robot}, limits up to {kept}")
                panel.set_xlabel("time [s]")
                if not j:
                    panel.set_ylabel("reached [%]")
            legend_beside(panels[(i + 1) * len(robots) - 1])
