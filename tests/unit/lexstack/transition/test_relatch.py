"""What comes in mid-blend: targets at different ticks, losses again and again, two at one tick."""

import dataclasses

import numpy as np
import pytest

from lexstack.references import Target
from lexstack.robots import Pose
from lexstack.transition import Phase, Source, TransitionConfig
from lexstack.transition.relatch import LOSSES
from lexstack_config.parts import build_references
from lexstack_experiments.links import Delayed
from support.channels import loop
from support.scenario import home, team

MOVES = [(0.1, 0.0, 0.0), (0.0, 0.1, 0.05), (-0.1, 0.05, 0.0)]


def blend(mode, late=0, lag=0, *, named=False, move=(0.1, 0.0, 0.0), at=150, base=None):
    """Return a run with a switch at tick 100 and a target at the controller's tick ``at``.

    Args:
        mode: lockstep or realtime.
        late: by how many ticks the solver's answers are late.
        lag: how many ticks later the solver has the target.
        named: whether revisions are known.
        move: of robot a's tool [m].
        at: the tick of the target.
        base: where robot a's base shall be, in place of the tool.
    """
    run = loop(transition=TransitionConfig(duration=1.0), mode=mode)
    run.link = Delayed(late) if late else run.link
    run.solver_references = build_references(run.resolved, run.parts.team)
    both = (run.controller.references, run.solver_references)
    if not named:
        ask = run.ask_solver
        run.ask_solver = lambda *args: dataclasses.replace(ask(*args), revision=None)
    run.controller.transition.ask("reach_base", 0.0, "", 100)
    tool = team().tools(home())[0]
    target = Target(0.0, 0, ee=Pose(tool.position + np.array(move), tool.rotation))
    if base is not None:
        target = Target(0.0, 0, base=np.array(base))
    for tick in range(330):
        for schedule, due in zip(both, (at, at + lag), strict=True):
            if tick == due:
                schedule.add(target)
        run.step()
    return run


def steps(run):
    """Return the accelerations over their limits, shape (ticks, n)."""
    chi = np.array([command.chi for command in run.record.commands])
    return np.abs(np.diff(chi, axis=0)) / (run.parts.dt * team().limits.acceleration)


def bends(run):
    """Return the jerks over their limits, shape (ticks, n)."""
    chi = np.array([command.chi for command in run.record.commands])
    return np.abs(np.diff(chi, n=2, axis=0)) / (run.parts.dt**2 * team().limits.jerk)


@pytest.mark.parametrize("move", MOVES)
@pytest.mark.parametrize(("late", "lag", "named"), [(1, 0, True), (1, 0, False), (1, 1, False)])
def test_a_target_in_mid_blend_is_as_smooth_with_a_late_b_as_in_lockstep(move, late, lag, named):
    """What the target moves in the solver's chi was taken for acceleration: 1.0 times its limit."""
    ideal = steps(blend("lockstep", move=move))[148:].max()
    assert ideal < 0.3
    found = blend("realtime", late, lag, named=named, move=move)
    assert steps(found)[148:].max() <= 1.1 * ideal
    assert found.record.commands[150 + lag + 1].transition.alpha == 0.0, (
        "latched for the solver's jump"
    )


@pytest.mark.parametrize(
    ("at", "move"),
    [
        (193, (0.0346, 0.0934, 0.009)),
        (199, (0.022, 0.0943, 0.0249)),
        (199, (0.0069, 0.0923, 0.0379)),
    ],
)
def test_a_target_at_the_end_of_a_blend_is_as_smooth_with_a_late_b_as_in_lockstep(at, move):
    """To take over from a late chi added 2 % of the limit to the acceleration there: 1.18."""
    ideal = steps(blend("lockstep", move=move, at=at))[at - 2 :].max()
    assert ideal < 0.3
    found = steps(blend("realtime", 1, named=True, move=move, at=at))[at - 2 :].max()
    assert found <= 1.1 * ideal


@pytest.mark.parametrize("late", [0, 1])
def test_a_target_of_the_base_in_mid_blend_is_bridged_too(late):
    """It moves no row of level 1, the solver's chi alone: that jumped at full acceleration."""
    mode = "realtime" if late else "lockstep"
    assert steps(blend(mode, late, base=(0.3, 0.4, 0.2)))[148:].max() < 0.4


def test_where_revisions_are_known_the_second_latch_has_no_kink():
    ideal = bends(blend("lockstep"))[147:160].max()
    assert bends(blend("realtime", 1, named=True))[147:160].max() <= 1.2 * ideal


def test_a_target_while_a_takes_over_has_the_time_of_the_request():
    run = loop(transition=TransitionConfig(duration=1.0), mode="realtime")
    run.link = Delayed(3)
    run.controller.transition.ask("reach_base", 0.0, "", 2)
    while "blends on to its own" not in run.step().transition.reason:
        pass
    taking = run.record.commands[-1].transition
    assert taking.source is Source.LOCAL
    assert taking.duration < 0.5
    run.run(2)
    tool = team().tools(home())[0]
    pose = Pose(tool.position + np.array([0.1, 0.0, 0.0]), tool.rotation)
    run.add_target(Target(0.0, 0, ee=pose))
    start = run.step()
    assert start.transition.alpha == 0.0
    assert start.transition.duration == 1.0
    run.run(120)
    assert [c.transition.phase for c in run.record.commands].count(Phase.IDLE) < 30
    assert steps(run)[start.tick - 1 :].max() < 0.3, "1.0 where it faded in 0.12 s"


@pytest.mark.parametrize("on_loss", ["local", "minimum_velocity"])
def test_after_three_losses_a_stays_with_its_own_to_the_end(on_loss):
    run = loop(transition=TransitionConfig(duration=1.0, on_loss=on_loss))
    run.controller.transition.ask("reach_base", 0.0, "", 2)
    run.solver_answers = lambda tick: tick < 20 or tick % 10 < 5
    run.run(46)
    told = [command.transition for command in run.record.commands]
    lost = [k for k in range(3, 46) if told[k].source is not told[k - 1].source]
    assert lost == [25, 30, 35, 40, 45], "lost, back, lost, back, lost"
    assert told[45].source is Source(on_loss)
    assert (
        f"it is loss {LOSSES} of this blend, so the solver is not followed again" in told[45].reason
    )
    assert not run.controller.transition.awaits(46), "nobody is waited for"
    run.run(110)
    later = [command.transition for command in run.record.commands[46:]]
    assert {t.source for t in later if t.source is not Source.NONE} == {Source(on_loss)}
    assert later[-1].phase is Phase.IDLE
    assert run.record.commands[146].transition.source is Source.NONE, "1.0 s after the last loss"
    assert max(run.record.sources) <= 46, "B is told that it is no longer needed"


def test_losses_of_the_blend_before_do_not_count():
    run = loop(transition=TransitionConfig(duration=1.0))
    run.controller.transition.ask("reach_base", 0.0, "", 2)
    run.controller.transition.ask("posture", 0.0, "", 50)
    run.solver_answers = lambda tick: tick < 20 or tick % 10 < 5
    run.run(51)
    assert run.record.commands[-1].transition.source is Source.SOLVER


def test_two_requests_at_one_tick_carry_no_motion_that_was_not_there():
    """The first one is given up before its first tick: it has no tick before to compare with."""
    twice, once = (loop(transition=TransitionConfig(duration=1.0)) for _ in range(2))
    for run in (twice, once):
        run.controller.transition.ask("reach_base", 0.0, "", 10)
    twice.controller.transition.ask("track", 0.0, "", 40)  # of robot a for no tick at all
    once.controller.transition.ask("track", 0.0, "", 40, ["robot_b"])
    for run in (twice, once):
        run.controller.transition.ask("posture", 0.0, "", 40, ["robot_a"])
        run.run(100)
    found, single = (np.array([c.chi for c in run.record.commands]) for run in (twice, once))
    assert np.abs(found - single).max() < 1e-3
