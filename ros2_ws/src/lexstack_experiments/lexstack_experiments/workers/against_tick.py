"""A whole tick of a source tree's controller, on its own closed loop of the paper's sequence."""

from __future__ import annotations

import os
from pathlib import Path
from time import thread_time

import numpy as np
from layouts import first_of
from serving import serve

Tape = first_of("lexstack_experiments.replay:Tape")
scenario_of = first_of("lexstack_experiments.runs:scenario_of")
Parts = first_of("lexstack_config.parts:Parts", "lexstack_core.build:Parts")
build_controller = first_of(
    "lexstack_config.parts:build_controller", "lexstack_core.build:build_controller"
)


class Ticks:
    """The recorded closed loop, to be served again and again."""

    def __init__(self) -> None:
        """Record it on the first turn."""
        self._resolved = scenario_of(Path(os.environ["LEXSTACK_ROOT"]) / "config")
        self._tape = Tape.of(self._resolved)

    def turn(self) -> dict[str, list[float]]:
        """Return the thread's processor time of every tick [us], by stack and blend."""
        controller = build_controller(self._resolved, Parts.of(self._resolved))
        times, apart = self._tape.play(controller, clock=thread_time)
        if apart:
            raise ValueError(f"the replayed chi is {apart:g} off the recorded one")
        keys = [
            f"{command.stack}, {'blending' if blending else 'idle'}"
            for command, blending in zip(self._tape.commands, self._tape.blending, strict=True)
        ]
        return {
            key: (1e6 * np.array(times)[[each == key for each in keys]]).tolist()
            for key in dict.fromkeys(keys)
        }


if __name__ == "__main__":
    serve({"turn": Ticks().turn})
