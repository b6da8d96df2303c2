"""A stack that asks for too much where the robots are is told: in the status and in the report."""

from functools import cache

import numpy as np

from lexstack.transition import Phase, TransitionConfig
from lexstack.transition.held_back import at_velocity_limit, held_back
from lexstack_bag.figures.goals import summary_lines
from lexstack_experiments.ideal import IdealPlant
from lexstack_experiments.loop import Loop
from lexstack_experiments.runs import analysed
from support.scenario import changed, home, state_at, team

BACK = 700  # the tick of the third switch


@cache
def once_more_round(posture):
    """Return a run from base targets to a posture and back to the base targets."""
    resolved = changed(events=(), transition=TransitionConfig(duration=1.0))
    run = Loop(resolved, IdealPlant(resolved, team()))
    for tick, stack in ((10, "reach_base"), (250, posture), (BACK, "reach_base")):
        run.controller.transition.ask(stack, 0.0, "", tick)
    run.run(BACK + 120)
    return run


def peak(run):
    """Return the largest change of the command in a tick after the third switch."""
    chi = np.array([command.chi for command in run.record.commands[BACK:]])
    return (np.abs(np.diff(chi, axis=0)) / (run.parts.dt * team().limits.acceleration)).max()


def test_a_switch_from_the_shoulder_singularity_is_told_in_the_status():
    """Mid-range of a Panda has joint 2 at 0: the switch used all acceleration, untold."""
    run = once_more_round("posture_mid_range")
    assert peak(run) > 0.99
    told = {
        c.transition.reason for c in run.record.commands if c.transition.phase is not Phase.IDLE
    }
    (reason,) = told - {""}
    assert reason.startswith("near a singularity: level 2: robot_a/base (sigma 0.1")
    assert "times the velocity limit of robot_a/panda_joint" in reason
    after = [command.transition.reason for command in run.record.commands[BACK + 1 :]]
    assert after[0] == reason, "at the first tick, while there is time to cancel"


def test_it_is_told_in_the_report_with_its_stack_and_time():
    metrics = analysed(once_more_round("posture_mid_range")).metrics
    (line,) = [text for text in metrics.singular if "velocity limit" in text]
    assert line.startswith("reach_base: near a singularity: level 2: robot_a/base (sigma 0.1")
    assert line.endswith(f", from {BACK / 100:.2f} s on")
    assert line in summary_lines(metrics)


def test_nothing_is_told_of_a_posture_that_is_not_singular():
    run = once_more_round("posture")
    assert peak(run) < 0.5
    assert {command.transition.reason for command in run.record.commands} == {""}
    assert analysed(run).metrics.singular == ()


def test_velocity_limits_alone_are_no_singularity():
    """A far base target is cut off by the limits too, and away from singularities it is usual."""
    run = once_more_round("posture")
    kinematics = team().kinematics(state_at(home()))
    references = run.controller.references.at(0.0)
    levels = run.parts.stacks["reach_base"].linearise(kinematics, references)
    (group,) = {channel.group for channel in run.controller.transition._channels}
    velocity = team().limits.velocity
    assert held_back(group, levels, velocity) == ""
    assert held_back(group, levels, 1e-3 * velocity) == ""
    assert at_velocity_limit(group, velocity, velocity)
    assert not at_velocity_limit(group, 0.99 * velocity, velocity)
