"""Several transitions at the same time: each as if alone, split and merged without a kink."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import lexstack_experiments.methods  # noqa: F401 - brings interpolation and weights
from lexstack.references import Target
from lexstack.transition import Phase, Source, TransitionConfig
from support.channels import BASES, ROBOTS, chi_of, loop, silent_for, state_of
from support.scenario import home, team

TICKS = 70
MANY = settings(
    max_examples=10, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck)
)
ASKED = st.tuples(
    st.integers(1, TICKS - 20),  # tick
    st.sampled_from(BASES),
    st.sampled_from([0.1, 0.3, 0.6]),  # s
    st.sampled_from(["bridge", "bridge", "bridge_jerk", "interpolation", "weights"]),
)


def moving_loop(seed, **values):
    """Return a closed loop that starts near home, with robots that move."""
    run = loop(transition=TransitionConfig(duration=0.4), **values)
    rng = np.random.default_rng(seed)
    limits = team().limits
    q = home() + rng.uniform(-0.2, 0.2, team().n)
    arms = np.isfinite(limits.position_lower)
    inside = 0.2 * (limits.position_upper - limits.position_lower)[arms]
    q[arms] = np.clip(
        q[arms], limits.position_lower[arms] + inside, limits.position_upper[arms] - inside
    )
    run.plant.put(q, rng.uniform(-0.05, 0.05, team().n))
    return run


def ask(run, requests):
    """Ask for (robot or '', tick, stack, duration, method), and return the answers."""
    return [
        run.controller.transition.ask(f"{stack}_{robot}" if robot else stack, time, method, tick)
        for robot, tick, stack, time, method in requests
    ]


def steps(run):
    """Return the command's accelerations over their limits at every tick."""
    chi = np.array([command.chi for command in run.record.commands])
    return np.abs(np.diff(chi, axis=0)) / (run.parts.dt * team().limits.acceleration)


@MANY
@given(st.integers(0, 9999), *[st.lists(ASKED, min_size=1, max_size=3)] * 2)
def test_each_robot_moves_as_if_its_transitions_were_the_only_ones(seed, first, second):
    per_robot = [
        [(robot, *entry) for entry in entries]
        for robot, entries in zip(ROBOTS, (first, second), strict=True)
    ]
    together = moving_loop(seed)
    assert all(answer.accepted for answer in ask(together, [*per_robot[0], *per_robot[1]]))
    together.run(TICKS)
    for robot, requests in zip(ROBOTS, per_robot, strict=True):
        alone = moving_loop(seed)
        ask(alone, requests)
        alone.run(TICKS)
        np.testing.assert_allclose(chi_of(together, robot), chi_of(alone, robot), atol=1e-9)
        for tick in range(TICKS):
            one, other = (state_of(run, robot, tick) for run in (together, alone))
            if Phase.BLENDING in (one.phase, other.phase):
                assert (one.alpha, one.phase) == (other.alpha, other.phase)
                assert (one.to_stack, one.source) == (other.to_stack, other.source)


@MANY
@given(
    st.integers(0, 9999),
    st.lists(st.tuples(st.sampled_from(["", *ROBOTS]), ASKED), min_size=2, max_size=6),
    st.sampled_from([0, 1, 2]),
)
def test_limits_hold_through_splits_merges_and_loss(seed, requests, lost):
    run = moving_loop(seed)
    run.link = silent_for(lost)
    ask(run, [(robot, *entry) for robot, entry in requests])
    before = run.plant.state().command
    run.run(TICKS)
    for command in run.record.commands:
        assert command.fallback == ""
        assert command.bounds.empty == 0
        names = sorted(name for state in command.transitions for name in state.robots)
        assert tuple(names) == ROBOTS, "every robot is on one channel"
    first = np.abs(run.record.commands[0].chi - before)
    assert (first <= run.parts.dt * team().limits.acceleration + 1e-9).all()
    assert steps(run).max() <= 1.0 + 1e-9


@MANY
@given(st.integers(0, 9999), st.integers(5, 40), st.sampled_from(BASES), st.sampled_from(BASES))
def test_the_rest_of_a_split_goes_on_as_it_was(seed, tick, stack, other):
    """Robot b is taken out in mid-blend: robot a does not notice."""
    whole, split = (moving_loop(seed) for _ in range(2))
    for run in (whole, split):
        run.controller.transition.ask(stack, 0.4, "", 5)
    split.controller.transition.ask(f"{other}_robot_b", 0.4, "", tick)
    for run in (whole, split):
        run.run(TICKS)
    np.testing.assert_allclose(chi_of(split, "robot_a"), chi_of(whole, "robot_a"), atol=1e-9)


def test_a_merge_in_mid_blend_has_no_kink():
    run = loop(transition=TransitionConfig(duration=0.5))
    for stack, tick in (("reach_base_robot_a", 5), ("posture_robot_b", 20), ("track", 45)):
        run.controller.transition.ask(stack, 0.0, "", tick)
    run.run(140)
    chi = np.array([command.chi for command in run.record.commands])
    jerk = np.abs(np.diff(chi, n=2, axis=0)) / (run.parts.dt**2 * team().limits.jerk)
    assert jerk[40:50].max() < 0.03
    assert len(run.record.commands[44].transitions) == 2
    (merged,) = run.record.commands[45].transitions
    assert merged.robots == ROBOTS
    assert merged.from_stack == "track"
    assert merged.reason == "pre-empted transition 1, 2"
    assert merged.phase is Phase.BLENDING
    assert run.record.commands[-1].transition.phase is Phase.IDLE


def test_a_split_with_a_bridged_level_1_slices_it():
    """At a step of both references epsilon has rows of both robots."""
    whole, split = (loop(transition=TransitionConfig(duration=0.6)) for _ in range(2))
    for run in (whole, split):
        for robot, tool in enumerate(team().tools(home())):
            moved = type(tool)(tool.position + np.array([0.2, 0.0, 0.1]), tool.rotation)
            run.add_target(Target(0.05, robot, ee=moved))
        run.controller.transition.ask("reach_base", 0.0, "", 5)
    split.controller.transition.ask("posture_robot_b", 0.0, "", 30)
    for run in (whole, split):
        run.run(100)
    np.testing.assert_allclose(chi_of(split, "robot_a"), chi_of(whole, "robot_a"), atol=1e-9)
    assert steps(split)[:60].max() < 0.6
    assert {state.phase for state in split.record.commands[-1].transitions} == {Phase.IDLE}


def test_robots_on_one_stack_again_are_one_channel():
    run = loop(transition=TransitionConfig(duration=0.2))
    run.controller.transition.ask("posture_robot_b", 0.0, "", 2)
    run.run(10)
    assert len(run.record.commands[-1].transitions) == 2
    assert run.controller.transition.cancel().accepted
    run.run(60)
    (state,) = run.record.commands[-1].transitions
    assert (state.robots, state.to_stack, state.phase) == (ROBOTS, "track", Phase.IDLE)
    assert run.record.commands[-1].stack == "track"


def test_a_scheduled_request_names_the_stack_that_it_will_leave():
    """It named the stack before: the one that the robots had come from."""
    run = loop(transition=TransitionConfig(duration=0.1))
    run.controller.transition.ask("reach_base", 0.0, "", 2)
    run.run(30)
    assert run.record.commands[-1].stack == "reach_base"
    run.controller.transition.ask("posture", 0.0, "", 40)
    run.run(15)
    told = [command.transition for command in run.record.commands[30:]]
    assert {state.phase for state in told} >= {Phase.REQUESTED, Phase.BLENDING}
    assert {(state.from_stack, state.to_stack) for state in told} == {("reach_base", "posture")}


def test_cancel_gives_every_robot_its_own_stack_back():
    run = loop(transition=TransitionConfig(duration=0.2))
    transition = run.controller.transition
    transition.ask("posture_robot_b", 0.0, "", 1)
    run.run(40)
    transition.ask("reach_base", 0.0, "", 0)
    run.run(10)
    (state,) = run.record.commands[-1].transitions
    assert state.from_stack == "track + posture_robot_b"
    answer = transition.cancel()
    assert answer.accepted
    assert "transition 2 is cancelled; transition 3 to 'track'" in answer.message
    assert "transition 4 to 'posture_robot_b'" in answer.message
    run.step()
    assert {state.phase for state in run.record.commands[-1].transitions} == {Phase.ABORTED}
    run.run(60)
    assert state_of(run, "robot_a").to_stack == "track"
    assert state_of(run, "robot_b").to_stack == "posture_robot_b"
    assert {state.phase for state in run.record.commands[-1].transitions} == {Phase.IDLE}


def test_only_the_transition_whose_answers_are_lost_is_solved_by_a():
    run = loop(transition=TransitionConfig(duration=0.4))
    run.controller.transition.ask("reach_base_robot_a", 0.0, "", 2)
    run.controller.transition.ask("posture_robot_b", 0.0, "", 10)
    run.run(20)
    run.link = silent_for(2)
    run.step()
    assert state_of(run, "robot_a").source is Source.SOLVER
    lost = state_of(run, "robot_b")
    assert lost.source is Source.LOCAL
    assert lost.reason.startswith("the solver lost at tick 20, last heard tick 19: ")
    assert state_of(run, "robot_a").reason == ""
    assert run.controller.transition.awaits(21), "robot a's transition needs its answer"


def test_in_lockstep_a_waits_for_all_that_it_follows():
    run = loop(transition=TransitionConfig(duration=0.4))
    transition = run.controller.transition
    transition.ask("reach_base_robot_a", 0.0, "", 2)
    transition.ask("posture_robot_b", 0.0, "", 4)
    run.run(6)
    state = run.plant.state()
    for announcement in transition.take_announcements():
        run.schedule.hear(announcement)
    references = run.solver_references.at(state.stamp)
    sent = [
        run.ask_solver(wanted, state, references) for wanted in run.schedule.current(state.tick)
    ]
    assert [sample.transition_id for sample in sent] == [1, 2]
    for sample in sent:
        assert transition.awaits(state.tick)
        transition.hear(sample)
    assert not transition.awaits(state.tick)


@pytest.mark.parametrize("later", [0, 40])
def test_a_task_that_couples_robots_keeps_them_together(later):
    run = loop(transition=TransitionConfig(duration=0.2))
    transition = run.controller.transition
    transition.ask("carry", 0.0, "", 3)
    if not later:
        run.run(40)
    answer = transition.ask("posture_robot_b", 0.0, "", later)
    assert not answer.accepted
    assert answer.message == (
        "stack 'posture_robot_b': the task 'robot_a/relative_pose' of 'carry' couples its robots "
        "with robot_a"
    )
    assert transition.ask("posture", 0.0, "", 60).accepted, "all of its robots may go"
    assert transition.ask("posture_robot_b", 0.0, "", 61).accepted, "then they are apart"


def test_a_request_whose_robots_have_been_coupled_meanwhile_is_dropped():
    run = loop(transition=TransitionConfig(duration=0.2))
    transition = run.controller.transition
    assert transition.ask("posture_robot_b", 0.0, "", 50).accepted
    assert transition.ask("carry", 0.0, "", 10).accepted
    run.run(60)
    (state,) = run.record.commands[-1].transitions
    assert state.to_stack == "carry"
    assert state.reason.startswith("transition 1 to 'posture_robot_b' is dropped: the task ")


def test_one_channel_in_mid_blend_does_not_slow_the_other_down():
    """Each has its own duration, and adopts alone."""
    run = loop(transition=TransitionConfig(duration=0.4))
    run.controller.transition.ask("reach_base_robot_a", 0.8, "", 2)
    run.controller.transition.ask("posture_robot_b", 0.1, "", 10)
    run.run(30)
    assert state_of(run, "robot_b").phase is Phase.IDLE
    assert state_of(run, "robot_a").phase is Phase.BLENDING
    assert run.record.commands[-1].stack == "reach_base_robot_a + posture_robot_b"
    assert max(run.record.sources) == 29
    run.run(70)
    assert max(run.record.sources) == 82, "B works no longer than needed"
