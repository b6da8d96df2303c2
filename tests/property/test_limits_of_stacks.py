"""The limits in force are those of the stacks in effect, robot by robot, whatever came before."""

import dataclasses

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from lexstack.errors import ModelError
from lexstack.tasks import joined
from lexstack.transition import Phase
from lexstack_config.resolved import load_scenario
from lexstack_experiments.ideal import IdealPlant
from lexstack_experiments.loop import Loop
from support.channels import ROBOTS, parts
from support.scenario import CONFIG, team

FIELDS = ("position_lower", "position_upper", "velocity", "acceleration", "jerk")
NOT_YET = (Phase.REQUESTED, Phase.PREPARING)
ASKED = st.tuples(
    st.integers(1, 120),
    st.sampled_from(["confined", "confined", "track", "posture"]),
    st.sampled_from([0.05, 0.2, 0.6]),  # s
    st.sampled_from([[], ["robot_a"], ["robot_b"]]),
)


def sudden_limits():
    """Return the scenario's closed loop, without its events."""
    base = load_scenario(CONFIG / "scenarios" / "sudden-limits.yaml")
    scenario = dataclasses.replace(base.scenario, events=())
    changed = dataclasses.replace(base, scenario=scenario)
    return Loop(changed, IdealPlant(changed, team()), parts=parts())


def in_effect(command):
    """Return the name of each robot's stack at a tick, from what the controller told."""
    now = {}
    for state in command.transitions:
        names = state.to_stack if state.phase not in NOT_YET else command.stack
        now |= dict.fromkeys(state.robots, names)
    return now


def check(run, seen):
    """Compare the limits that were asked for with those of the stacks, at every tick."""
    for command in run.record.commands:
        limits = seen[command.tick]
        for robot, name in in_effect(command).items():
            if " + " in name:
                continue  # while a request is still to come, chi names all stacks in effect
            own = parts().stacks[name].limits or team().limits
            mine = team().slices[team().index(robot)]
            for field in FIELDS:
                np.testing.assert_array_equal(
                    getattr(limits, field)[mine], getattr(own, field)[mine], f"{robot} {name}"
                )


def watched(run):
    """Return a dictionary that keeps the limits of every tick."""
    seen, decide = {}, run.controller.transition.limits

    def limits(due):
        seen[due.tick], jerk = decide(due)
        return seen[due.tick], jerk

    run.controller.transition.limits = limits
    return seen


def test_the_limits_of_a_stack_outlive_the_merging_of_its_robots():
    """From tick 31 on the robots' own limits were in force."""
    run = sudden_limits()
    seen, transition = watched(run), run.controller.transition
    assert transition.ask("confined", 0.2, "", 5, ["robot_a"]).accepted
    run.run(10)
    assert transition.ask("confined", 0.2, "", 10, ["robot_b"]).accepted
    run.run(400)
    (merged,) = run.record.commands[-1].transitions
    assert merged.robots == ROBOTS
    assert seen[409].position_lower[6] == -2.0
    check(run, seen)
    q = run.plant.state().q
    confined = parts().stacks["confined"].limits
    assert (q >= confined.position_lower - 1e-6).all()
    assert (q <= confined.position_upper + 1e-6).all()


@settings(max_examples=25, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(st.lists(ASKED, min_size=1, max_size=8), st.sampled_from([0, 0, 60, 90]))
def test_the_limits_in_force_are_those_of_the_stacks_in_effect(requests, cancel):
    run = sudden_limits()
    seen = watched(run)
    for tick, stack, duration, robots in requests:
        run.controller.transition.ask(stack, duration, "", tick, robots)
    for tick in range(200):
        if tick == cancel > 0:
            run.controller.transition.cancel()
        run.step()
    assert all(command.bounds.empty == 0 for command in run.record.commands)
    check(run, seen)


def test_stacks_with_different_limits_are_joined_robot_by_robot():
    confined, track = parts().stacks["confined"], parts().stacks["track"]
    both = joined([confined.of((0,)), track.of((1,))], team())
    one, other = team().slices
    for field in FIELDS:
        found = getattr(both.limits, field)
        np.testing.assert_array_equal(found[one], getattr(confined.limits, field)[one])
        np.testing.assert_array_equal(found[other], getattr(team().limits, field)[other])
    same = joined([confined.of((0,)), confined.of((1,))])
    assert same.limits is confined.limits, "limits are told apart by identity"
    with pytest.raises(ModelError, match="different limits"):
        joined([confined.of((0,)), track.of((1,))])


def test_a_joined_stack_follows_a_plan_where_all_do():
    one, other = parts().stacks["plan_robot_a"], parts().stacks["plan_robot_b"]
    assert joined([one, other]).planned
    assert not joined([one, parts().stacks["track"].of((1,))]).planned


def test_a_switch_of_one_robot_holds_up_no_limits_of_another_one():
    """Limits that move in a given time began again for every robot at every switch of any."""
    base = sudden_limits().resolved
    transition = dataclasses.replace(base.scenario.transition, limits_move=1.0)
    scenario = dataclasses.replace(base.scenario, transition=transition)
    found = {}
    for others in (False, True):
        changed = dataclasses.replace(base, scenario=scenario)
        run = Loop(changed, IdealPlant(changed, team()), parts=parts())
        run.controller.transition.ask("confined", 0.1, "", 5)
        for k in range(8 if others else 0):
            name = ["track", "confined"][k % 2]
            run.controller.transition.ask(name, 0.1, "", 20 + 20 * k, ["robot_b"])
        found[others] = [run.step() and run.controller._box._at(run.plant.state().tick - 1)
                         for _ in range(200)]  # fmt: skip
    mine = team().slices[0]
    for alone, busy in zip(found[False], found[True], strict=True):
        for field in FIELDS:
            np.testing.assert_array_equal(getattr(busy, field)[mine], getattr(alone, field)[mine])
    confined = parts().stacks["confined"].limits
    np.testing.assert_array_equal(
        found[True][110].position_lower[mine], confined.position_lower[mine]
    )
