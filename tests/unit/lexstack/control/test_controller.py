"""The controller through all phases of a transition, with the solver well, late, lost and back."""

import numpy as np
import pytest

from lexstack.control.controller import checked
from lexstack.hqp import Solution, Status
from lexstack.limits import Bounds
from lexstack.references import Target
from lexstack.transition import Phase, Source, SourceSample, TransitionConfig
from lexstack_experiments.ideal import IdealPlant
from lexstack_experiments.loop import Loop
from support.scenario import changed, home, resolved

SHORT = TransitionConfig(duration=0.1)  # 10 ticks


def loop(**values):
    """Return a closed loop without events, and with a short transition."""
    scenario = changed(**{"events": (), "transition": SHORT, **values})
    result = Loop(scenario)
    result.plant = IdealPlant(scenario, result.parts.team)
    return result


def phases(run, ticks):
    """Return the phase of each of the next ticks."""
    return [run.step().transition.phase for _ in range(ticks)]


def goes_on_evenly(run, gap):
    """Return whether the last command goes on with the acceleration that there was."""
    bends = np.abs(np.diff([command.chi for command in run.record.commands[-4:]], n=2, axis=0))
    return bends[-1].max() < 2.0 * bends[-2].max() + 1e-4 * gap


def test_the_phases_of_a_transition():
    run = loop()
    assert run.controller.transition.ask("reach_base", 0.0, "", 3).accepted
    seen = phases(run, 16)
    assert seen[:3] == [Phase.REQUESTED] * 3
    assert seen[3:13] == [Phase.BLENDING] * 10
    assert seen[13:] == [Phase.ADOPTING, Phase.IDLE, Phase.IDLE]
    alphas = [c.transition.alpha for c in run.record.commands[3:14]]
    assert alphas[0] == 0.0
    assert alphas[-1] == 1.0
    assert sorted(run.record.sources) == list(range(3, 14)), "B works no longer than needed"
    assert run.record.commands[-1].stack == "reach_base"
    assert run.record.commands[-1].transition.reason == ""


def test_a_request_for_now_begins_at_the_next_tick():
    run = loop()
    phases(run, 5)
    run.controller.transition.ask("posture", 0.0, "", 0)
    assert run.step().transition.phase is Phase.BLENDING


def test_after_adoption_a_alone_gives_what_b_gave():
    run = loop()
    run.controller.transition.ask("reach_base", 0.0, "", 1)
    phases(run, 150)
    state = run.plant.state()
    own = run.step().chi
    kinematics = run.parts.team.kinematics(state)
    other = run.solver.solve("reach_base", kinematics, run.solver_references.at(state.stamp)).chi
    np.testing.assert_allclose(own, other, atol=1e-6)


def test_at_the_end_a_may_stay_with_b():
    run = loop(transition=TransitionConfig(duration=0.1, at_end="stay"))
    run.controller.transition.ask("reach_base", 0.0, "", 1)
    assert set(phases(run, 30)[1:]) == {Phase.BLENDING}
    assert run.record.commands[-1].transition.alpha == 1.0
    assert max(run.record.sources) == 29


@pytest.mark.parametrize("on_loss", ["local", "minimum_velocity"])
def test_loss_of_b_while_it_blends(on_loss):
    run = loop(transition=TransitionConfig(duration=0.5, on_loss=on_loss))
    run.solver_answers = lambda tick: tick < 20
    run.controller.transition.ask("reach_base", 0.0, "", 1)
    phases(run, 20)
    lost = run.step().transition
    assert lost.source is Source(on_loss)
    assert lost.phase is Phase.BLENDING
    assert lost.alpha == 0.0, "latched anew"
    assert lost.reason.startswith("the solver lost at tick 20, last heard tick 19: ")
    seen = phases(run, 60)
    assert (Phase.ABORTED in seen) == (on_loss == "minimum_velocity")
    last = run.record.commands[-1]
    assert last.transition.phase is Phase.IDLE
    assert "the solver lost" in last.transition.reason
    if on_loss == "minimum_velocity":
        # The tools' last errors fade with exp(-gain t).
        assert np.abs(last.chi).max() < 1e-3, "at rest"
        assert last.stack == "reach_base at rest"
    else:
        assert np.abs(last.chi).max() > 0.01, "on its way"


def test_b_comes_back():
    run = loop(transition=TransitionConfig(duration=0.5))
    run.solver_answers = lambda tick: tick < 20 or tick >= 30
    run.controller.transition.ask("reach_base", 0.0, "", 1)
    phases(run, 30)
    back = run.step().transition
    assert back.source is Source.SOLVER
    assert back.reason == "the solver is back at tick 30"


def test_b_never_answers():
    run = loop()
    run.solver_answers = lambda _tick: False
    run.controller.transition.ask("reach_base", 0.0, "", 5)
    phases(run, 5)
    first = run.step().transition
    assert first.source is Source.LOCAL
    assert first.reason.startswith("the solver sent no chi by tick 5")
    assert phases(run, 15)[-1] is Phase.IDLE
    assert run.record.commands[-1].stack == "reach_base"


def test_in_lockstep_a_waits_for_the_tick_that_it_needs():
    transition = loop().controller.transition
    assert not transition.awaits(3)
    transition.ask("reach_base", 0.0, "", 3)
    assert not transition.awaits(2)
    assert transition.awaits(3)
    chi = np.zeros(20)
    for sample in (
        SourceSample(2, 3, chi, solved=True),  # another transition
        SourceSample(1, 2, chi, solved=True),  # another tick
        SourceSample(1, 3, chi, solved=False),
    ):
        transition.hear(sample)
        assert transition.awaits(3)
    transition.hear(SourceSample(1, 3, chi, solved=True))
    assert not transition.awaits(3)


def test_in_realtime_a_takes_the_newest_and_waits_for_nobody():
    run = loop(mode="realtime")
    transition = run.controller.transition
    run.solver_answers = lambda _tick: False
    transition.ask("reach_base", 0.0, "", 2)
    assert not transition.awaits(2)
    assert phases(run, 5)[2:] == [Phase.PREPARING] * 3
    chi = np.zeros(20)
    transition.hear(SourceSample(1, 3, chi, solved=True))  # two ticks old
    assert run.step().transition.phase is Phase.BLENDING
    stale = round(resolved().scenario.timeouts.source_stale * resolved().scenario.rate)
    seen = [run.step().transition.source for _ in range(stale)]
    assert seen[stale - 3] is Source.SOLVER, "tick 3 is fresh until tick 3 + stale"
    assert seen[stale - 2] is Source.LOCAL


def test_in_realtime_a_does_not_wait_for_ever():
    run = loop(mode="realtime")
    run.solver_answers = lambda _tick: False
    run.controller.transition.ask("reach_base", 0.0, "", 2)
    patience = round(resolved().scenario.timeouts.source_patience * resolved().scenario.rate)
    seen = phases(run, patience + 3)
    assert seen[patience + 1] is Phase.PREPARING
    assert seen[patience + 2] is Phase.BLENDING
    assert run.record.commands[-1].transition.source is Source.LOCAL


def test_while_preparing_the_references_of_before_hold():
    run = loop(mode="realtime")
    run.solver_answers = lambda _tick: False
    phases(run, 2)
    still = run.record.commands[-1].chi
    goal = run.parts.team.tools(home())[0]
    moved = type(goal)(goal.position + np.array([0.3, 0.0, 0.0]), goal.rotation)
    run.controller.references.add(Target(0.02, 0, ee=moved))
    run.controller.transition.ask("track", 0.0, "", 2)
    phases(run, 3)
    np.testing.assert_allclose(run.record.commands[-1].chi, still, atol=1e-9)


def test_preemption_goes_on_from_where_it_is():
    run = loop(transition=TransitionConfig(duration=0.5))
    transition = run.controller.transition
    transition.ask("reach_base", 0.0, "", 1)
    transition.ask("posture", 0.0, "", 20)
    phases(run, 20)
    before, after = run.record.commands[-1], run.step()
    assert before.transition.to_stack == "reach_base"
    assert after.transition.to_stack == after.stack == "posture"
    assert after.transition.reason == "pre-empted transition 1"
    assert after.transition.alpha == 0.0
    gap = np.abs(after.chi - run.record.sources[20]).max()
    assert np.abs(after.chi - before.chi).max() > 0.005 * gap, "it is under way"
    assert goes_on_evenly(run, gap)
    assert phases(run, 60)[-1] is Phase.IDLE
    assert run.record.commands[-1].stack == "posture"


def test_cancel_while_it_blends_goes_back_smoothly():
    run = loop(transition=TransitionConfig(duration=0.5))
    transition = run.controller.transition
    transition.ask("posture", 0.0, "", 1)
    phases(run, 30)
    answer = transition.cancel()
    assert answer.accepted
    assert "transition 1 is cancelled" in answer.message
    aborted = run.step().transition
    assert aborted.phase is Phase.ABORTED
    assert aborted.reason == "transition 1 was cancelled"
    seen = phases(run, 80)
    assert seen[0] is Phase.BLENDING
    assert seen[-1] is Phase.IDLE
    assert run.record.commands[-1].stack == "track"


def test_cancel_before_it_begins():
    run = loop()
    transition = run.controller.transition
    transition.ask("posture", 0.0, "", 50)
    phases(run, 3)
    assert transition.cancel().accepted
    assert phases(run, 60) == [Phase.ABORTED] + [Phase.IDLE] * 59
    assert run.record.commands[-1].stack == "track"
    assert not run.record.sources


def test_cancel_without_a_transition_is_refused():
    answer = loop().controller.transition.cancel()
    assert not answer.accepted
    assert answer.message == "there is no transition to cancel"


def test_a_stream_of_small_steps_does_not_hold_a_transition_up():
    run = loop(transition=TransitionConfig(duration=0.3))
    run.controller.transition.ask("reach_base", 0.0, "", 1)
    start = run.parts.team.tools(home())[0]
    for k in range(1, 20):
        moved = type(start)(start.position + np.array([0.002 * k, 0.0, 0.0]), start.rotation)
        for schedule in (run.controller.references, run.solver_references):
            schedule.add(Target(0.05 * k, 0, ee=moved))
    assert Phase.ADOPTING in phases(run, 40)
    assert run.record.commands[-1].stack == "reach_base"


def test_after_a_late_step_b_goes_on_although_it_was_told_its_end():
    run = loop(transition=TransitionConfig(duration=0.3))
    run.controller.transition.ask("reach_base", 0.0, "", 1)
    goal = run.parts.team.tools(home())[0]
    moved = type(goal)(goal.position + np.array([0.3, 0.0, 0.0]), goal.rotation)
    for schedule in (run.controller.references, run.solver_references):
        schedule.add(Target(0.31, 0, ee=moved))  # the last tick of the blend
    seen = phases(run, 100)
    assert seen.count(Phase.ADOPTING) == 1
    assert {c.transition.source for c in run.record.commands[1:60]} == {Source.SOLVER}
    assert max(run.record.sources) == 61


def test_a_request_by_topic_is_answered_in_the_state():
    run = loop()
    assert not run.controller.transition.request("dance").accepted
    assert run.step().transition.reason.startswith("refused: unknown stack 'dance'")
    assert run.controller.transition.request("posture").accepted
    assert run.step().transition.reason == ""


def test_a_reference_step_while_it_blends_is_bridged():
    run = loop(transition=TransitionConfig(duration=0.5))
    run.controller.transition.ask("reach_base", 0.0, "", 1)
    goal = run.parts.team.tools(home())[0]
    moved = type(goal)(goal.position + np.array([0.3, 0.0, 0.0]), goal.rotation)
    for schedule in (run.controller.references, run.solver_references):
        schedule.add(Target(0.2, 0, ee=moved))
    phases(run, 20)
    after = run.step()
    assert after.transition.alpha == 0.0
    gap = np.abs(after.chi - run.record.sources[20]).max()
    assert gap > 0.3
    assert goes_on_evenly(run, gap)


def test_what_holds_a_level_back_is_told_by_name():
    run = loop()
    assert run.controller.obstructed() == "", "nothing was asked yet"
    phases(run, 2)
    assert run.controller.obstructed() == ""
    goal = run.parts.team.tools(home())[1]
    far = type(goal)(goal.position + np.array([2.0, 0.0, 0.0]), goal.rotation)
    run.controller.references.add(Target(0.02, 1, ee=far))
    command = run.step()
    said = run.controller.obstructed()
    assert said.startswith("level 1: robot_b/ee_pose row 1 misses by ")
    at_bounds = np.flatnonzero(
        (command.chi == command.bounds.lower) | (command.chi == command.bounds.upper)
    )
    names = run.parts.team.joint_names
    assert any(f"bound of {names[i]} (" in said for i in at_bounds)
    assert "robot_a/" not in said


# ---- what the solver may do wrong


BOUNDS = Bounds(np.array([-1.0, 0.2, -1.0]), np.array([1.0, 1.0, -0.5]))


def solution(chi, status=Status.SOLVED, reason=""):
    return Solution(np.array(chi), np.zeros(1), status, reason, np.zeros(3, np.int8), 0.0)


def test_a_good_solution_is_sent_as_it_is():
    chi, reason = checked(solution([0.5, 0.5, -0.7]), BOUNDS)
    np.testing.assert_array_equal(chi, [0.5, 0.5, -0.7])
    assert reason == ""


@pytest.mark.parametrize(
    ("bad", "word"),
    [
        (solution([0.0, 0.5, -0.7], Status.FAILED, "level 2: daqp: cycling"), "level 2: daqp"),
        (solution([np.nan, 0.5, -0.7]), "not finite"),
        (solution([1.1, 0.5, -0.7]), "left the bounds by 0.1"),
    ],
)
def test_a_bad_solution_becomes_braking(bad, word):
    chi, reason = checked(bad, BOUNDS)
    np.testing.assert_array_equal(chi, [0.0, 0.2, -0.5])
    assert word in reason


def test_rounding_is_clipped():
    chi, reason = checked(solution([1.0 + 1e-9, 0.2, -0.5]), BOUNDS)
    assert reason == ""
    assert chi[0] == 1.0


def test_the_controller_brakes_when_its_solver_fails():
    run = loop()
    run.controller.transition.ask("reach_base", 0.0, "", 1)
    phases(run, 100)

    class Broken:
        name = "broken"

        def solve(self, problem, warm=None):
            return solution(np.zeros(20), Status.FAILED, "level 1: broken")

    moving = run.record.commands[-1].chi
    assert np.abs(moving).max() > 0.1
    run.controller._solver = Broken()
    command = run.step()
    assert command.fallback == "braking: level 1: broken"
    assert np.abs(command.chi).max() < np.abs(moving).max()
    phases(run, 100)
    assert np.abs(run.record.commands[-1].chi).max() == 0.0


def test_the_same_run_twice_is_the_same_to_the_bit():
    one, two = (Loop(resolved()).run(200) for _ in range(2))
    for a, b in zip(one.commands, two.commands, strict=True):
        assert a.chi.tobytes() == b.chi.tobytes()


def test_a_state_of_rest_stays_at_rest():
    run = loop()
    phases(run, 3)
    assert np.abs(run.record.commands[-1].chi).max() < 1e-9
    np.testing.assert_allclose(run.plant.state().q, home(), atol=1e-9)


def test_time_optimal_is_as_fast_as_the_limits_allow():
    """It uses the acceleration limits where the quintic of 1 s leaves most of them unused."""

    def blend(config):
        run = loop(transition=config)
        run.controller.transition.ask("reach_base", 0.0, "", 1)
        phases(run, 130)
        chi = np.array([command.chi for command in run.record.commands])
        steps = np.abs(np.diff(chi, axis=0)) / (0.01 * run.parts.team.limits.acceleration)
        ticks = [c.transition.phase for c in run.record.commands].count(Phase.BLENDING)
        assert run.record.commands[-1].stack == "reach_base"
        return ticks, steps.max()

    slow, slow_ratio = blend(TransitionConfig(duration=1.0))
    fast, fast_ratio = blend(TransitionConfig(duration=1.0, profile="time_optimal"))
    assert slow == 100
    assert fast < 30
    assert slow_ratio < 0.2
    assert 0.7 < fast_ratio <= 1.0 + 1e-9


def test_a_robot_that_is_named_twice_is_refused():
    answer = loop().controller.transition.ask("track", 0.0, "", 0, ["robot_a", "robot_a"])
    assert not answer.accepted
    assert answer.message == "robots: a name stands in it twice"


def test_a_cancellation_says_how_many_scheduled_transitions_it_drops():
    transition = loop().controller.transition
    for tick in range(100, 110):
        assert transition.ask("reach_base", 0.0, "", tick).accepted
    message = transition.cancel().message
    assert message == "10 transitions, the last of them 8, 9, 10, are cancelled before it began"
