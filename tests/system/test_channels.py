"""Two robots under names of their own change their stacks 0.2 s apart, through all processes."""

from dataclasses import replace

import numpy as np
import pytest

from lexstack_bag.figures.phases import find_phases
from lexstack_bag.run.reader import read_run
from lexstack_config.parts import build_team
from lexstack_config.scenario import EventConfig
from lexstack_interfaces.msg import TransitionStatus
from lexstack_testing.played_run import together
from support.runs import acceleration_ratio, read, transitions
from support.scenario import resolved

pytestmark = pytest.mark.system

LEFT, RIGHT = "left", "right"


def scenario():
    """Return the default robots as ``left`` and ``right``, each with a stack of its own."""
    base = resolved()
    single = {
        f"reach_base_{LEFT}": replace(
            base.stacks["reach_base"], name=f"reach_base_{LEFT}", robots=(LEFT,)
        ),
        f"posture_{RIGHT}": replace(
            base.stacks["posture"], name=f"posture_{RIGHT}", robots=(RIGHT,)
        ),
    }
    places = base.scenario.robots
    return replace(
        base,
        stacks={"track": base.stacks["track"], **single},
        scenario=replace(
            base.scenario,
            robots=dict(zip((LEFT, RIGHT), places.values(), strict=True)),
            base_target={LEFT: (0.0, -0.5, 0.0), RIGHT: (2.0, 0.5, 0.0)},
            ee_target={},
            events=(
                EventConfig(at=0.5, switch=f"reach_base_{LEFT}"),
                EventConfig(at=0.7, switch=f"posture_{RIGHT}"),
            ),
            duration=2.5,
        ),
    )


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    """Return the bag of one lockstep run."""
    with together(scenario(), tmp_path_factory.mktemp("run")) as run:
        run.play()
        assert run.end() == []
    return run.out / "bag"


@pytest.fixture(scope="module")
def statuses(bag):
    """Return all messages of the transitions, by tick."""
    found: dict[int, dict[tuple, TransitionStatus]] = {}
    for message in transitions(bag):
        found.setdefault(message.tick, {})[tuple(message.robots)] = message
    return found


def test_each_robot_has_its_own_alpha(statuses):
    assert set(statuses[40]) == {(LEFT, RIGHT)}, "one message while they are on one stack"
    both = statuses[100]
    assert set(both) == {(LEFT,), (RIGHT,)}
    left, right = both[LEFT,], both[RIGHT,]
    assert (left.phase, right.phase) == (TransitionStatus.BLENDING,) * 2
    assert (left.id, right.id) == (1, 2)
    assert left.alpha == pytest.approx(0.5)
    assert 0.0 < right.alpha < 0.2
    assert (left.source, right.source) == ("robot_b", "robot_b")
    assert left.reason == right.reason == ""


def test_each_adopts_alone(statuses):
    adopted = {
        message.to_stack: tick
        for tick, messages in statuses.items()
        for message in messages.values()
        if message.phase == TransitionStatus.ADOPTING
    }
    assert adopted == {f"reach_base_{LEFT}": 150, f"posture_{RIGHT}": 170}


def test_robot_b_sends_a_chi_for_each_transition_and_tick(bag):
    sent: dict[int, set[int]] = {}
    for message in read(bag, "/robot_b/chi")["/robot_b/chi"]:
        assert message.transition_id not in sent.setdefault(message.tick, set())
        sent[message.tick].add(message.transition_id)
    assert {tick for tick, ids in sent.items() if ids == {1}} == set(range(50, 70))
    assert {tick for tick, ids in sent.items() if ids == {1, 2}} == set(range(70, 151))
    assert {tick for tick, ids in sent.items() if ids == {2}} == set(range(151, 171))


def test_the_command_keeps_its_limits_and_the_bag_knows_the_phases(bag):
    limits = build_team(scenario()).limits
    assert acceleration_ratio(bag, limits.acceleration, 0.01) <= 1.0 + 1e-9
    run = read_run(bag)
    first, left, right = find_phases(run)
    assert (first.stack, first.robots, first.end) == ("track", (), pytest.approx(0.5))
    assert (left.stack, left.robots) == (f"reach_base_{LEFT}", (LEFT,))
    assert (right.stack, right.robots) == (f"posture_{RIGHT}", (RIGHT,))
    assert (left.adopted, right.adopted) == (pytest.approx(1.5), pytest.approx(1.7))
    assert left.end == right.end, "neither ends the other"
    assert set(run.chi) == {"robot_a", "robot_b"}
    assert np.isfinite(run.chi["robot_a"].chi).all()
