"""Links, oracle, probes, recording: what experiments measure with."""

import numpy as np
import pytest
from scipy.optimize import minimize

from lexstack.limits import Bounds
from lexstack.transition import SourceSample, TransitionConfig
from lexstack.types import LinearTask
from lexstack_bag.figures.series import measure
from lexstack_config.parts import Parts, build_controller
from lexstack_experiments.ideal import IdealPlant
from lexstack_experiments.links import Delayed, Frozen, Lost
from lexstack_experiments.loop import Loop
from lexstack_experiments.oracle import level_excess
from lexstack_experiments.probes import Stopwatch, counting_controller, timed_parts
from lexstack_experiments.recording import recorded
from lexstack_experiments.replay import Tape
from support.scenario import changed, resolved, team


def sample(tick):
    """Return a message whose chi tells its tick."""
    return SourceSample(1, tick, np.full(2, float(tick)), True)


def heard(link, ticks):
    """Return the chi that arrives at each tick, None where nothing does."""
    arrived = [link(sample(tick)) for tick in ticks]
    return [None if a is None else (a.tick, a.chi[0]) for a in arrived]


def test_a_delayed_message_arrives_with_its_old_tick():
    assert heard(Delayed(2), range(5)) == [None, None, (0, 0.0), (1, 1.0), (2, 2.0)]


def test_a_delay_of_nothing_changes_nothing():
    assert heard(Delayed(0), range(2)) == [(0, 0.0), (1, 1.0)]


def test_messages_do_not_outlive_a_pause_of_their_sender():
    link = Delayed(2)
    assert heard(link, [0, 1]) == [None, None]
    assert heard(link, [10, 11, 12]) == [None, None, (10, 10.0)]


def test_lost_messages_do_not_arrive():
    assert heard(Lost(2), range(4)) == [(0, 0.0), (1, 1.0), None, None]


def test_a_frozen_chi_looks_new():
    assert heard(Frozen(2), range(4)) == [(0, 0.0), (1, 1.0), (2, 1.0), (3, 1.0)]


def level(rng, rows=4, n=6):
    """Return one random equality task."""
    return (LinearTask.equality("task", rng.normal(size=(rows, n)), rng.normal(size=rows)),)


@pytest.mark.parametrize("seed", range(8))
def test_the_excess_is_what_a_general_solver_finds(seed):
    rng = np.random.default_rng(seed)
    tasks = level(rng)
    lower = -rng.uniform(0.05, 0.3, size=6)
    bounds = Bounds(lower, lower + 0.35)
    chi = rng.uniform(bounds.lower, bounds.upper)

    def cost(x):
        return float(np.sum(tasks[0].residual(x) ** 2))

    box = list(zip(bounds.lower, bounds.upper, strict=True))
    found = minimize(cost, chi, bounds=box, method="L-BFGS-B", options={"ftol": 1e-15})
    expected = np.linalg.norm(tasks[0].residual(chi)) - np.sqrt(found.fun)
    assert level_excess(tasks, chi, bounds) == pytest.approx(expected, abs=1e-5)
    assert level_excess(tasks, found.x, bounds) == pytest.approx(0.0, abs=1e-5)


def test_a_met_level_has_no_excess():
    rng = np.random.default_rng(0)
    tasks = level(rng)
    chi = np.linalg.lstsq(tasks[0].matrix, tasks[0].lower, rcond=None)[0]
    assert level_excess(tasks, chi, Bounds(chi - 0.1, chi + 0.1)) < 1e-12


def test_pinned_joints_are_no_freedom():
    tasks = (LinearTask.equality("task", np.eye(2), np.ones(2)),)
    bounds = Bounds(np.array([0.0, 0.0]), np.array([0.0, 1.0]))
    assert level_excess(tasks, np.zeros(2), bounds) == pytest.approx(np.sqrt(2.0) - 1.0)
    nothing = Bounds(np.zeros(2), np.zeros(2))
    assert level_excess(tasks, np.zeros(2), nothing) == pytest.approx(0.0)


def short(**values):
    """Return the default scenario up to the middle of its first blend."""
    events = resolved().scenario.events[:1]
    return changed(**{"events": events, "duration": 1.5, **values})


def loop(scenario, controller=None):
    """Return a closed loop in the ideal plant."""
    return Loop(scenario, IdealPlant(scenario, team()), controller)


def chi_of(run):
    """Return all commands, shape (T, n)."""
    return np.array([command.chi for command in run.record.commands])


def test_probes_count_and_time_and_change_nothing():
    scenario = short()
    plain = loop(scenario)
    plain.run()
    kinematics, tasks = Stopwatch(), Stopwatch()
    parts = timed_parts(Parts.of(scenario), kinematics, tasks)
    controller, tally = counting_controller(scenario, parts)
    probed = loop(scenario, controller)
    probed.run()
    np.testing.assert_array_equal(chi_of(probed), chi_of(plain))
    assert tally.problems == 151, "one a tick, and the old stack once at the trigger"
    assert tally.levels == 302, "track and the bridge have two levels"
    assert min(tally.seconds, kinematics.seconds, tasks.seconds) > 0.0


def test_a_recorded_loop_is_what_a_bag_gives():
    run = loop(short())
    run.run()
    value = recorded(run)
    measures = measure(value)
    assert value.plant.q.shape == (150, run.parts.team.n)
    np.testing.assert_array_equal(value.chi["robot_a"].chi, chi_of(run))
    assert [str(stack) for stack in value.chi["robot_a"].stack[[0, -1]]] == ["track", "reach_base"]
    limits = run.parts.team.limits.acceleration
    steps = np.abs(np.diff(chi_of(run), axis=0)) / (run.parts.dt * limits)
    np.testing.assert_allclose(measures.acceleration_ratio[1:], steps, atol=1e-12)
    assert measures.ee_error.max() < 1.0


def test_targets_of_a_recorded_loop_hold_from_their_time():
    run = loop(resolved())
    run.run(3)
    kinds = [(target.robot, target.kind, target.time) for target in recorded(run).targets]
    assert kinds == [("robot_a", "ee", 17.0), ("robot_b", "ee", 17.0)]


def test_a_replayed_tape_gives_the_same_chi():
    scenario = short()
    tape = Tape.of(scenario)
    times, apart = tape.play(build_controller(scenario, Parts.of(scenario)))
    assert apart == 0.0
    assert times.shape == (150,)
    assert (times > 0.0).all()
    assert sum(tape.blending) == 50


def test_a_tape_notices_another_controller():
    scenario = short()
    other = changed(events=(), duration=1.5)
    _, apart = Tape.of(scenario).play(build_controller(other, Parts.of(other)))
    assert apart == 0.0, "the tape hands the events over"
    slower = short(transition=TransitionConfig(duration=0.7))
    _, apart = Tape.of(scenario).play(build_controller(slower, Parts.of(slower)))
    assert apart > 1e-3
