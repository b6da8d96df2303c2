"""The last chi of every transition that a source has sent, in whatever order they arrived."""

from __future__ import annotations

from collections.abc import Collection

from lexstack.transition.messages import SourceSample

_KEPT = 16  # samples per transition, the last to arrive: one of the future pushes none out for long


class Inbox:
    """Finds the newest chi by the tick that it was solved for, not by when it arrived."""

    def __init__(self) -> None:
        """Start empty."""
        self._samples: dict[int, dict[int, SourceSample]] = {}  # by transition, then by tick

    def put(self, sample: SourceSample) -> None:
        """Keep a sample; of two for one tick that with the later revision, else the later one."""
        samples = self._samples.setdefault(sample.transition_id, {})
        known = samples.pop(sample.tick, None)
        samples[sample.tick] = sample if known is None or not outdated(sample, known) else known
        if len(samples) > _KEPT:
            del samples[next(iter(samples))]

    def newest(self, transition_id: int, tick: int) -> SourceSample | None:
        """Return the newest sample of a transition that is not from after ``tick``, or None."""
        samples = self._samples.get(transition_id, {})
        exact = samples.get(tick)
        if exact is not None or not samples:
            return exact
        ticks = [at for at in samples if at <= tick]
        return samples[max(ticks)] if ticks else None

    def solved_since(self, transition_id: int, tick: int, revision: int | None = None) -> bool:
        """Return whether the source has solved a transition's stack for a tick after this one.

        ``revision``: of the references that count; None: any.
        """
        known = (None, revision)
        return any(
            at > tick and sample.solved and (revision is None or sample.revision in known)
            for at, sample in self._samples.get(transition_id, {}).items()
        )

    def keep(self, transition_ids: Collection[int]) -> None:
        """Forget all other transitions."""
        self._samples = {id_: held for id_, held in self._samples.items() if id_ in transition_ids}


def outdated(one: SourceSample, other: SourceSample) -> bool:
    """Return whether the first of two samples for one tick has the older references, if known."""
    return one.revision is not None and other.revision is not None and one.revision < other.revision
