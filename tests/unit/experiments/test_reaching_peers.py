"""The laws of the experiment ``peers``: one model for all, and what is said of a reach."""

from __future__ import annotations

from types import SimpleNamespace

import mujoco
import numpy as np
import pytest

from lexstack_experiments.experiments import peers
from lexstack_experiments.experiments.peers_cases import DT, ROBOTS, Reach, arm, random_reach
from lexstack_experiments.experiments.peers_ours import ByJoints
from lexstack_experiments.experiments.peers_runs import run
from lexstack_experiments.experiments.peers_theirs import chain
from support.scenario import CONFIG


@pytest.mark.parametrize("name", ROBOTS)
def test_the_mujoco_model_is_the_same_robot(name):
    team = arm(CONFIG, name)
    model = chain(team)
    data, limits = mujoco.MjData(model), team.limits
    np.testing.assert_array_equal(model.jnt_range[:, 0], limits.position_lower)
    np.testing.assert_array_equal(model.jnt_range[:, 1], limits.position_upper)
    rng = np.random.default_rng(0)
    for _ in range(20):
        q = rng.uniform(limits.position_lower, limits.position_upper)
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        (pose,) = team.tools(q)
        site = data.site("tool")
        np.testing.assert_allclose(site.xpos, pose.position, atol=1e-9)
        np.testing.assert_allclose(site.xmat.reshape(3, 3), pose.rotation, atol=1e-9)


@pytest.mark.parametrize("name", ROBOTS)
def test_starts_and_goals_are_inside_the_limits_and_differ_by_seed(name):
    team = arm(CONFIG, name)
    reaches = [random_reach(team, np.random.default_rng(seed)) for seed in (0, 0, 1)]
    np.testing.assert_array_equal(reaches[0].start, reaches[1].start)
    assert np.abs(reaches[0].start - reaches[2].start).max() > 0.1
    for reach in reaches:
        assert (reach.start > team.limits.position_lower).all()
        assert (reach.start < team.limits.position_upper).all()


def jumping(team, speed):
    """Return a law that moves the first joint at a speed per limit, in every second tick."""
    ticks = iter(range(10**6))

    def velocity(q, _last):
        new = np.zeros_like(q)
        new[0] = speed * team.limits.velocity[0] * (next(ticks) % 2)
        return new

    return SimpleNamespace(team=team, begin=lambda _start, _goal: None, velocity=velocity)


def test_what_is_beyond_a_limit_is_counted_with_its_size():
    team = arm(CONFIG, "panda")
    reach = random_reach(team, np.random.default_rng(0))
    found = run(jumping(team, 1.5), reach, team)
    assert found.time is None
    assert found.over[1] == found.ticks // 2
    assert found.sizes[1] == pytest.approx(1.5)
    limits = team.limits
    assert found.sizes[2] == pytest.approx(1.5 * limits.velocity[0] / DT / limits.acceleration[0])
    assert found.over[0] > 0, "it goes on until it is beyond its stop"
    assert found.sizes[0] > 0.1


def test_who_is_there_already_arrives_at_once_and_who_stands_elsewhere_never():
    team = arm(CONFIG, "panda")
    reach = random_reach(team, np.random.default_rng(0))
    still = jumping(team, 0.0)
    assert run(still, reach, team).time is None
    assert run(still, reach, team).ticks < 100, "at rest elsewhere it ends"
    assert run(still, Reach(reach.start, team.tools(reach.start)[0]), team).time == 0.0


def test_by_joints_it_takes_the_least_time_that_the_limits_allow():
    team = arm(CONFIG, "xarm7")
    reach = random_reach(team, np.random.default_rng(5))
    found = run(ByJoints(team), reach, team)
    assert found.time is not None
    assert found.time < 3.0
    assert found.over == (0, 0, 0)


def test_a_library_that_is_not_installed_is_left_out_and_told(tmp_path, monkeypatch):
    def gone(_team, _options):
        raise ImportError("No module named 'mink'", name="mink")

    monkeypatch.setattr(peers, "Mink", gone)
    monkeypatch.setattr(peers, "ROBOTS", ("xarm7",))
    options = peers.Options(CONFIG, tmp_path, 0, 1)
    results = peers.run_experiment(options)
    assert not any("mink" in str(row[2]) for row in results.tables[0].rows)
    assert results.notes == ("Not installed, so not in the table: mink.",)
