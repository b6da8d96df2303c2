"""What a tick decides of requests, once: who begins, within which limits, and who is dropped."""

import numpy as np
import pytest

import lexstack_experiments.methods  # noqa: F401 - brings interpolation
from lexstack.hqp import Solution, Status
from lexstack.transition import HeardPlan, SourceSample, TransitionConfig
from support.channels import loop, parts
from support.scenario import home, team


def plan(tick):
    """Return a plan of robot a that moves its first joint slowly."""
    times = np.arange(0.0, 1.05, 0.1)
    velocities = np.zeros((times.size, 10))
    velocities[:, 3] = 0.1
    return HeardPlan(0, tick, times, velocities)


@pytest.mark.parametrize("mode", ["lockstep", "realtime"])
def test_a_plan_is_known_when_the_limits_of_its_first_tick_are_worked_out(mode):
    """`bridge_jerk` limits jerk from the first tick on; in realtime it did one tick late."""
    run = loop(mode=mode)
    transition = run.controller.transition
    assert transition.ask("plan_robot_a", 0.5, "bridge_jerk", 5, ["robot_a"]).accepted
    seen = {}
    decide = transition.limits
    transition.limits = lambda due: seen.setdefault(due.tick, decide(due))
    for _ in range(7):
        run.controller.transition.hear_plan(plan(run.plant.state().tick // 5 * 5))
        run.step()
    assert [seen[tick][1] for tick in (3, 4, 5, 6)] == [False, False, True, True]


def test_all_of_a_tick_uses_one_decision():
    """Who begins is asked of the sources once, however often it is needed."""
    run = loop(mode="realtime")
    transition = run.controller.transition
    transition.ask("reach_base", 0.0, "", 3)
    asked = []
    first = transition._sources.first
    transition._sources.first = lambda *args: asked.append(args) or first(*args)
    run.run(4)
    assert len(asked) == 1


def test_a_request_that_is_dropped_changes_no_limits():
    run = loop(transition=TransitionConfig(duration=0.2))
    transition = run.controller.transition
    assert transition.ask("confined", 0.0, "", 50, ["robot_b"]).accepted
    assert transition.ask("carry", 0.0, "", 10).accepted
    run.run(50)
    due = transition.due(50)
    assert [request.stack for request, _ in due.dropped] == ["confined"]
    limits, _ = transition.limits(due)
    assert limits is parts().team.limits
    run.step()
    reason = run.record.commands[-1].transition.reason
    assert reason.startswith("transition 1 to 'confined' is dropped: the task ")


# ---- auxiliary solutions that fail


class Failing:
    """A solver that fails where it is told to."""

    name = "failing"

    def __init__(self, inner):
        self.inner = inner
        self.fails = False

    def solve(self, problem, warm=None):
        solution = self.inner.solve(problem, warm)
        if not self.fails or warm is not None:
            return solution
        empty = np.zeros(solution.chi.size, np.int8)
        reason = "level 1: failing: no answer"
        return Solution(solution.chi * 0.0 + 0.3, np.zeros(1), Status.FAILED, reason, empty, 0.0)


def moving(method="bridge"):
    """Return a run whose robots are on their way, and its solver."""
    run = loop(transition=TransitionConfig(duration=0.5, method=method))
    run.controller.transition.ask("reach_base", 0.0, "", 2)
    run.run(80)
    solver = run.controller._solver = Failing(run.controller._solver)
    return run, solver


def test_a_latch_does_not_use_a_solution_that_failed():
    """It latched whatever a failed solver left: here 0.3 of every unit there is."""
    run, solver = moving()
    run.controller.transition.ask("posture", 0.0, "", 80)
    before, solver.fails = run.record.commands[-1].chi, True
    command = run.step()
    assert command.fallback == (
        "auxiliary problem: level 1: failing: no answer: the last command is held"
    )
    np.testing.assert_allclose(command.chi, before, atol=5e-3)
    solver.fails = False
    assert run.step().fallback == ""
    assert np.abs(run.record.commands[-1].chi - before).max() < 1e-2


def test_a_method_that_solves_the_old_stack_beside_holds_the_command_too():
    run, solver = moving("interpolation")
    run.controller.transition.ask("posture", 0.0, "", 80)
    run.run(5)
    solver.fails = True
    command = run.step()
    assert "auxiliary problem: level 1: failing" in command.fallback
    before = run.record.commands[-2].chi
    reach = run.parts.dt * team().limits.acceleration
    assert (np.abs(command.chi - before) <= reach + 1e-12).all()


def test_a_stack_that_a_cannot_solve_itself_holds_the_command_and_is_told():
    run = loop(transition=TransitionConfig(duration=0.5))
    run.controller.transition.ask("reach_base", 0.0, "", 2)
    run.solver_answers = lambda tick: tick < 30
    run.run(30)
    local = run.controller.transition._sources._local
    solve = local.solve
    local.solve = lambda *args: Solution(
        np.zeros(20), np.zeros(1), Status.FAILED, "level 0: no", np.zeros(20, np.int8), 0.0
    )
    held = run.record.commands[-1].chi
    command = run.step()
    assert command.fallback == "stack 'reach_base': level 0: no: the last command is held"
    blend = run.controller.transition._channels[0].blend
    np.testing.assert_array_equal(blend.source_chi, held, "zero was followed, in silence")
    local.solve = solve
    assert run.step().fallback == ""


def test_a_sample_for_a_transition_that_nobody_asked_for_is_harmless():
    run = loop()
    run.controller.transition.hear(SourceSample(99, 0, home() * 0.0, solved=True))
    assert run.step().transition.reason == ""
