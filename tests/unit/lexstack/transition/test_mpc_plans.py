"""Plans as the controller samples them: only what is fresh and still holds."""

import numpy as np
import pytest

from lexstack.transition import HeardPlan
from lexstack.transition.sources.mpc_plans import MpcPlans
from lexstack_config.parts import transition_options
from support.scenario import changed, team

TIMES = np.array([0.0, 0.1, 0.2])


def plan(tick, robot=0, slope=1.0):
    velocities = slope * TIMES[:, None] * np.arange(1, 11)
    return HeardPlan(robot, tick, TIMES, velocities)


def book(mode="lockstep"):
    return MpcPlans(team(), transition_options(changed(mode=mode).scenario))


def test_the_velocity_is_that_at_the_end_of_the_tick():
    plans = book()
    plans.hear(plan(10))
    chi = plans.sample([0], 12)
    assert np.allclose(chi[:10], 0.03 * np.arange(1, 11))
    assert not chi[10:].any()


@pytest.mark.parametrize("robots", [[1], [0, 1]])
def test_without_a_plan_of_every_robot_there_is_nothing(robots):
    plans = book()
    plans.hear(plan(10))
    assert plans.sample(robots, 10) is None


def test_two_robots_have_their_parts():
    plans = book()
    plans.hear(plan(10))
    plans.hear(plan(10, robot=1, slope=2.0))
    chi = plans.sample([0, 1], 10)
    assert np.allclose(chi[10:], 2.0 * chi[:10])
    assert chi[0] > 0.0


def test_in_lockstep_only_the_plan_that_is_due_counts():
    plans = book()  # one plan every 5 ticks
    plans.hear(plan(10))
    assert plans.sample([0], 14) is not None
    assert plans.sample([0], 15) is None
    assert plans.sample([0], 9) is None, "a plan of the future"


def test_in_realtime_a_plan_serves_until_it_is_stale_or_over():
    plans = book("realtime")
    plans.hear(plan(10))
    assert plans.sample([0], 28) is not None
    assert plans.sample([0], 30) is None, "its horizon of 0.2 s is over"
    long = HeardPlan(0, 10, 10.0 * TIMES, plan(10).velocities)
    plans.hear(long)
    assert plans.sample([0], 35) is not None
    assert plans.sample([0], 36) is None, "older than 0.25 s"


def test_an_older_plan_does_not_replace_a_newer_one():
    plans = book("realtime")
    plans.hear(plan(20, slope=2.0))
    plans.hear(plan(15))
    assert plans.sample([0], 20)[0] == pytest.approx(0.02)
