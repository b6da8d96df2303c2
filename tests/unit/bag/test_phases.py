"""Phases from what the controller says of its transitions, also where they do not go as planned."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from lexstack_bag.figures.phases import Phase, find_phases
from lexstack_bag.run.reader import read_run
from lexstack_bag.run.run import Run, TransitionPhase, TransitionStream

IDLE, REQUESTED, PREPARING, BLENDING, ADOPTING, ABORTED = TransitionPhase


@pytest.fixture(scope="module")
def run(synthetic) -> Run:
    return read_run(synthetic.folder)


def told(run: Run, *entries: tuple[float, int, str, TransitionPhase, float]) -> tuple[Phase, ...]:
    """Return the phases where the controller said (stamp, id, to_stack, phase, alpha)."""
    stamp, id_, to_stack, phase, alpha = map(np.array, zip(*entries, strict=True))
    nothing = np.zeros(len(entries))
    text = np.array([""] * len(entries))
    stream = TransitionStream(
        tick=np.round(100 * stamp).astype(int),
        stamp=stamp,
        id=id_,
        from_stack=text,
        to_stack=to_stack,
        source=text,
        method=text,
        phase=phase,
        alpha=alpha,
        duration=nothing,
        gap=nothing,
        reason=text,
    )
    return find_phases(replace(run, transition=stream))


def test_the_trigger_is_when_the_request_takes_effect(run):
    phases = find_phases(run)
    assert phases == (
        Phase("track", 0.0, 1.0, None),
        Phase("reach_base", 1.0, pytest.approx(4.0), 2.0),
    )
    assert phases[0].ticks(run.plant.stamp).sum() == 100
    assert phases[1].ticks(run.plant.stamp).sum() == 300


def test_a_pre_empted_switch_is_never_adopted(run):
    _, first, second = told(
        run,
        (1.0, 1, "posture", BLENDING, 0.0),
        (1.4, 1, "posture", BLENDING, 0.4),
        (1.5, 2, "track", BLENDING, 0.0),
        (2.5, 2, "track", ADOPTING, 1.0),
        (2.6, 2, "track", IDLE, 1.0),
    )
    assert first == Phase("posture", 1.0, 1.5, None)
    assert (second.stack, second.start, second.adopted) == ("track", 1.5, 2.5)


def test_an_aborted_switch_is_never_adopted(run):
    phases = told(
        run,
        (1.0, 1, "posture", PREPARING, 0.0),
        (1.5, 1, "posture", BLENDING, 0.5),
        (2.0, 1, "posture", ABORTED, 1.0),
        (2.1, 1, "posture at rest", IDLE, 1.0),
    )
    assert phases[1].adopted is None


def test_a_blend_without_adoption_ends_where_alpha_is_one(run):
    phases = told(
        run,
        (1.0, 1, "posture", BLENDING, 0.0),
        (2.0, 1, "posture", BLENDING, 1.0),
        (3.0, 1, "posture", BLENDING, 1.0),
    )
    assert phases[1].adopted == 2.0


def test_a_request_that_is_cancelled_before_it_begins_is_no_phase(run):
    phases = told(run, (1.0, 1, "posture", REQUESTED, 0.0), (1.5, 0, "track", IDLE, 1.0))
    assert [phase.stack for phase in phases] == ["track"]
