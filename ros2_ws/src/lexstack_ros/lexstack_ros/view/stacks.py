"""Which stacks there are, also those that users send, and which frames those in effect move."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from lexstack.errors import ConfigurationError
from lexstack.references import TOOL, Frame
from lexstack.robots import Team
from lexstack.tasks import AT_REST, Stack, StackConfig
from lexstack_config.sent_stacks import fit_stack, read_stack
from lexstack_interfaces.msg import TransitionStatus

_LEAVES = (TransitionStatus.REQUESTED, TransitionStatus.PREPARING, TransitionStatus.BLENDING)
"""In these phases the stack before is in effect still."""


class Stacks:
    """The stacks of a run, by name.

    Attributes:
        names: of all, in their order.
    """

    def __init__(self, team: Team, configured: Mapping[str, StackConfig]) -> None:
        """Know those of the configuration."""
        self._team = team
        self._configs = dict(configured)
        self._frames: dict[str, tuple[Frame, ...]] = {}  # of the stacks that were asked for
        self.names = tuple(sorted(self._configs))

    def learn(self, text: str) -> None:
        """Know a stack that was sent as text; one that does not fit is left out."""
        try:
            config = read_stack(text)
        except ConfigurationError:
            return  # the controller has told why
        if self._configs.get(config.name) != config:  # after a reset a name may stand for another
            self._configs[config.name] = config
            self._frames.pop(config.name, None)
            self.names = tuple(sorted(self._configs))

    def frames(self, statuses: Iterable[TransitionStatus]) -> tuple[Frame, ...]:
        """Return the frames, other than the default tools, whose targets have an effect now."""
        found: dict[Frame, None] = {}
        for status in statuses:
            names = [status.to_stack, *([status.from_stack] if status.phase in _LEAVES else [])]
            robots = {self._team.names.index(n) for n in status.robots if n in self._team.names}
            for name in names:
                found |= dict.fromkeys(f for f in self._moved(name) if f[0] in robots)
        return tuple(found)

    def _moved(self, name: str) -> tuple[Frame, ...]:
        """Return the frames that the tasks of a stack bring to targets; none of an unknown one."""
        name = name.removesuffix(AT_REST)
        if name not in self._frames and name in self._configs:
            try:
                stack = fit_stack(self._configs[name], self._team)
            except ConfigurationError:
                return ()
            self._frames[name] = tuple(moved_frames(stack))
        return self._frames.get(name, ())


def moved_frames(stack: Stack) -> Iterator[Frame]:
    """Yield the frames, other than the default tools, that tasks of a stack bring to targets."""
    for level in stack.levels:
        for task in level.tasks:
            frame = getattr(task, "reference", TOOL)
            if isinstance(frame, str) and frame != TOOL:
                yield task.robots[0], frame
