"""Giving up: which transitions a cancellation ends, and in which words it is told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from lexstack.tasks.stack import Stack
from lexstack.transition.channels.channel import Channel
from lexstack.transition.requests import SwitchRequest


@dataclass(frozen=True, slots=True)
class Cancellation:
    """What is given up.

    Attributes:
        channels: of all robots; those concerned report it once.
        back: the stacks to go back to, of the blends that were under way.
        why: the reason of that.
        done: what is given up, for who asked.
    """

    channels: tuple[Channel, ...]
    back: tuple[Stack, ...]
    why: str
    done: str

    @classmethod
    def of(
        cls, channels: Sequence[Channel], dropped: Sequence[SwitchRequest]
    ) -> Cancellation | None:
        """Return what a cancellation gives up; None: there is nothing.

        Args:
            channels: of all robots.
            dropped: the requests that have not begun.
        """
        blends = [channel for channel in channels if channel.blend is not None]
        if not dropped and not blends:
            return None
        gone = dict.fromkeys(channel.id for channel in blends)
        gone = gone or dict.fromkeys(request.id for request in dropped[-3:])
        plural = "s" if len(gone) > 1 else ""
        what = f"transition{plural} {', '.join(map(str, gone))}"
        if not blends and len(dropped) > len(gone):
            what = f"{len(dropped)} transitions, the last of them {', '.join(map(str, gone))},"
        why = f"{what} {'were' if plural else 'was'} cancelled"
        told = tuple(
            replace(each, aborted=why) if each.blend is not None or not blends else each
            for each in channels
        )
        back = tuple(stack for channel in blends for stack in channel.adopted)
        done = f"{what} {'are' if plural else 'is'} cancelled"
        return cls(told, back, f"{why}; going back", done)
