"""A tool on a figure of eight of 0.3 by 0.2 m, at up to 0.21 m/s, in the ideal plant."""

import numpy as np
import pytest

from lexstack.references import Spline, Target, base_spline
from support.figure_of_eight import Eight, follow, lockstep
from support.plants import make_plant
from support.scenario import home, team

STACKS = {"hold": ("ee_pose", "minimum_velocity"), "rest": ("ee_pose", "posture")}
LED = 60  # ticks, of the lead-in


def eight():
    return Eight(team().tools(home())[0])


class Stepping(Eight):
    """The same as a set-point at every tick: its velocity is not known."""

    def rate(self, stamp):
        return None


def test_without_the_velocity_of_the_reference_the_tool_is_behind():
    distance, _ = follow(lockstep(STACKS, "hold"), Stepping(eight().centre), 8.0)
    assert distance[LED:].mean() > 0.04


@pytest.mark.parametrize("initial", STACKS)
def test_the_tool_is_within_a_fifth_of_a_millimetre(initial):
    distance, commands = follow(lockstep(STACKS, initial), eight(), 8.0)
    assert distance[LED:].max() < 0.2e-3
    assert distance[LED:].max() < 10e-6, "as of a command that is exact to second order"
    assert not any(command.near_singularity or command.fallback for command in commands)


@pytest.mark.parametrize(("initial", "other"), [("hold", "rest"), ("rest", "hold")])
def test_a_transition_in_the_middle_keeps_it_there(initial, other):
    def switch(tick, run):
        if tick == 300:
            assert run.controller.transition.ask(other, 1.0, "bridge", 0).accepted

    distance, commands = follow(lockstep(STACKS, initial), eight(), 6.0, at_tick=switch)
    assert commands[-1].stack == other
    assert distance[LED:].max() < 10e-6
    chi = np.array([command.chi for command in commands])
    change = np.abs(np.diff(chi[290:], axis=0)) / team().dt
    assert (change <= team().limits.acceleration + 1e-9).all()
    assert change.max() < 5.0, "no step in the command"


def test_in_mujoco_it_is_within_a_millimetre_through_a_transition():
    def switch(tick, run):
        if tick == 300:
            assert run.controller.transition.ask("rest", 1.0, "bridge", 0).accepted

    run = lockstep(STACKS, "hold")
    run.plant = make_plant()
    there = Eight(team().tools(run.plant.state().q)[0])
    distance, commands = follow(run, there, 6.0, at_tick=switch)
    assert commands[-1].stack == "rest"
    assert distance[2 * LED :].max() < 1e-3


def test_it_stays_there_while_a_switch_waits_for_the_solver():
    """The old stack goes on, and the trajectory does not stand still for it."""
    run = lockstep(STACKS, "hold", waits=False)
    run.solver_answers = lambda tick: tick > 330

    def switch(tick, run):
        if tick == 300:
            assert run.controller.transition.ask("rest", 1.0, "bridge", 0).accepted

    distance, commands = follow(run, eight(), 6.0, at_tick=switch)
    phases = [command.transition.phase.name for command in commands]
    assert phases[305:325] == ["PREPARING"] * 20
    assert commands[-1].stack == "rest"
    assert distance[LED:].max() < 10e-6


def test_base_and_posture_follow_their_trajectories_too():
    q = home()
    stacks = {"all": ("base", "posture")}
    run = lockstep(stacks, "all", lead_in=0.1)
    place = q[:3]
    way = base_spline([0.5, 2.0, 4.0], place + np.array([[0, 0, 0], [0.4, 0.1, 0.5], [0, 0, 0]]))
    arm = Spline([0.5, 2.0, 4.0], q[3:10] + np.outer([0.0, 0.3, 0.1], np.ones(7)))
    run.controller.references.add(Target(0.0, 0, base=way))
    run.controller.references.add(Target(0.0, 0, posture=arm))
    worst = 0.0
    for _ in range(420):
        state = run.plant.state()
        if state.stamp >= 0.5:
            worst = max(worst, np.abs(state.q[:3] - way.at(state.stamp)).max())
            worst = max(worst, np.abs(state.q[3:10] - arm.at(state.stamp)).max())
        run.step()
    assert worst < 1e-4
