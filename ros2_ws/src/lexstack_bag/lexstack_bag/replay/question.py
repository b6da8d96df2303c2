"""What a replay is asked."""

from __future__ import annotations

from dataclasses import dataclass

from lexstack_bag.replay.changes import Changes
from lexstack_bag.run.run import Run
from lexstack_bag.storage.container import Progress
from lexstack_config.resolved import ResolvedScenario


@dataclass(frozen=True, slots=True)
class Question:
    """What to replay.

    Attributes:
        run: the recorded run.
        changes: what shall be other than it was.
        resolved: the scenario with the changes made.
        progress: told how much is done, from 0 to 1.
    """

    run: Run
    changes: Changes
    resolved: ResolvedScenario
    progress: Progress = lambda _part: None
