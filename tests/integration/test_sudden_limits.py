"""The scenario sudden-limits without ROS: no empty box, in time, judged by the limits in force."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog

from lexstack.limits import JointLimits, Motion
from lexstack_bag.figures.limits import limits_in_force
from lexstack_bag.figures.series import COMMANDER
from lexstack_experiments.experiments.sudden_limits_cases import cases, laws
from lexstack_experiments.experiments.sudden_limits_least import least_ticks
from lexstack_experiments.experiments.sudden_limits_runs import Play
from lexstack_experiments.runs import analysed, changed, never_switched
from support.scenario import CONFIG

ALL = {case.name: case for case in cases(CONFIG, 0)}


def played(name, law="ours"):
    case = ALL[name]
    return Play(case, next(one for one in laws(case) if one.name == law))


@pytest.mark.parametrize("name", ALL)
def test_ours_keeps_what_it_promises(name):
    play = played(name)
    found = play.figures(Play(never_switched(ALL[name]), laws(ALL[name])[0]))
    assert found.empty == 0
    assert found.acceleration <= 1.0 + 1e-6
    assert found.velocity <= 1.0 + 1e-9
    assert found.least > 0.2
    assert found.late == 0
    assert found.violation == 0.0
    if ALL[name].jerk:
        assert found.jerk <= 1.0 + 1e-6
    assert not [c.fallback for c in play.loop.record.commands if c.fallback]
    state = play.loop.record.states[-1]
    limits = play.law.limits[-1]
    assert (state.q_star >= limits.position_lower - 1e-9).all()
    assert (state.q_star <= limits.position_upper + 1e-9).all()


@pytest.mark.parametrize("law", ["T(31), brake", "T(31), give way", "T(34) old limits, give way"])
def test_the_printed_boxes_are_empty(law):
    assert len(played("in motion", law).empty_ticks()) > 10


@pytest.mark.parametrize("name", ["in motion", "slower joints too", "pre-empted", "jerk limits"])
def test_the_analysis_finds_the_limits_that_were_in_force(name):
    play = played(name)
    measured = analysed(play.loop)
    found = limits_in_force(measured.run, play.loop.parts.team, COMMANDER)
    assert len(found) == len(play.law.limits)
    for mine, theirs in zip(found, play.law.limits, strict=True):
        for field in ("position_lower", "position_upper", "velocity", "acceleration"):
            np.testing.assert_array_equal(getattr(mine, field), getattr(theirs, field))
    assert measured.metrics.peak_acceleration_ratio <= 1.0 + 1e-6
    assert measured.metrics.empty_bounds == 0


def one_by_one():
    """Return the case with a stack for each robot alone, the second one a little later."""
    case = ALL["in motion"]
    stacks = dict(case.resolved.stacks)
    goes, trigger = case.resolved.scenario.events
    events = [goes]
    for k, robot in enumerate(case.resolved.scenario.robots):
        whole = stacks["confined"]
        name = f"confined {robot}"
        limits = {robot: whole.limits[robot]}
        stacks[name] = replace(whole, name=name, robots=(robot,), limits=limits)
        events.append(replace(trigger, at=trigger.at + 0.1 * k, switch=name))
    resolved = changed(replace(case.resolved, stacks=stacks), events=tuple(events))
    return replace(case, resolved=resolved)


def test_each_robot_has_the_limits_of_its_own_stack():
    case = one_by_one()
    play = Play(case, laws(case)[0])
    assert not play.empty_ticks()
    assert play.loop.record.commands[-1].stack == "confined robot_a + confined robot_b"
    second = play.trigger + 10
    out = play.outside()
    first, other = play.loop.parts.team.slices
    least = play.least()[first]
    assert [int(np.flatnonzero(column)[-1]) + 1 for column in out[:, first].T if column.any()] == [
        ticks for ticks in least.tolist() if ticks
    ]
    assert not out[-1].any()
    own = play.loop.parts.team.limits
    before, after = play.law.limits[second - 1], play.law.limits[-1]
    np.testing.assert_array_equal(before.position_lower[other], own.position_lower[other])
    np.testing.assert_array_equal(after.position_lower, play.new.position_lower)
    measured = analysed(play.loop)
    found = limits_in_force(measured.run, play.loop.parts.team, COMMANDER)
    for mine, theirs in zip(found, play.law.limits, strict=True):
        for field in ("position_lower", "position_upper", "velocity", "acceleration"):
            np.testing.assert_array_equal(getattr(mine, field), getattr(theirs, field))


def test_smaller_accelerations_count_once_they_are_in_force():
    """A robot that keeps only its own limits is found out by the analysis."""
    play = played("slower joints too")
    case = replace(ALL["slower joints too"], resolved=ALL["in motion"].resolved)
    careless = Play(case, laws(case)[0])
    careless.loop.resolved = play.loop.resolved
    assert analysed(careless.loop).metrics.peak_acceleration_ratio > 1.5


# ---- the least time


def nearest(ticks, out, speed, limits, dt):
    """Return how far out a joint is after some ticks at the least, by a linear program."""
    velocity, reach = limits.velocity.item(), limits.acceleration.item() * dt
    adds = np.tril(np.ones((ticks, ticks)))
    found = linprog(
        dt * adds.sum(axis=0),
        A_ub=-adds,
        b_ub=np.full(ticks, velocity + speed),
        bounds=[(-reach, reach)] * ticks,
    )
    return out + dt * ticks * speed + found.fun


@pytest.mark.parametrize("seed", range(20))
def test_the_least_time_is_that_of_a_linear_program(seed):
    rng = np.random.default_rng(seed)
    dt, wall = 0.02, rng.uniform(-1.0, 1.0)
    values = (wall - 9.0, wall, rng.uniform(0.5, 2.0), rng.uniform(3.0, 20.0), np.inf)
    limits = JointLimits(*(np.atleast_1d(value) for value in values))
    out, speed = rng.uniform(0.0, 0.5), rng.uniform(-1.0, 1.0) * values[2]
    motion = Motion(np.array([wall + out]), np.array([speed]), dt)
    ticks = least_ticks(motion, limits).item()
    assert ticks > 0
    assert nearest(ticks, out, speed, limits, dt) <= 1e-8
    if ticks > 1:
        assert nearest(ticks - 1, out, speed, limits, dt) > 0.0
    # Jerk that is no limit, and jerk that is.
    free, soft = (replace(limits, jerk=np.array([jerk])) for jerk in (1e6, 10.0 * values[3]))
    moving = replace(motion, acceleration=np.zeros(1))
    assert least_ticks(moving, free).item() == ticks
    assert least_ticks(moving, soft).item() >= ticks
