"""What a margin covers is regular: with memory the same rows are found as without."""

from dataclasses import replace

import numpy as np
import pytest

from lexstack.hqp import Damper, HqpProblem
from lexstack.hqp.bend import Bend
from lexstack.hqp.groups import groups_of
from lexstack.hqp.margin import Margin
from lexstack.limits import target_bounds
from lexstack.references import References
from lexstack.robots import Pose
from lexstack.tasks import LevelConfig, StackConfig, TaskConfig, build_stack
from support.scenario import home, random_q, state_at, team

STACKS = {
    "pose": ("ee_pose", "velocity_damping"),
    "position": ("ee_position", "velocity_damping"),
    "base below": ("ee_pose", "base", "velocity_damping"),
    "posture below": ("ee_pose", "posture"),
    "base above": ("base", "ee_pose", "velocity_damping"),
    "three levels": ("ee_position", "base", "posture"),
}


def stack_of(kinds, weight):
    levels = tuple(LevelConfig((TaskConfig(kind, weight=weight),)) for kind in kinds)
    return build_stack(StackConfig("s", "", levels), team())


def problem_at(stack, q, aims, bases):
    kinematics = team().kinematics(state_at(q))
    poses = tuple(
        Pose(tool.position + aim, tool.rotation)
        for tool, aim in zip(team().tools(q), aims, strict=True)
    )
    places = tuple(q[s][:3] + b for s, b in zip(team().slices, bases, strict=True))
    references = References(poses, places)
    levels = stack.linearise(kinematics, references)
    return HqpProblem(levels, target_bounds(q, team().limits, team().dt)), kinematics


def rows_of(damped):
    added = [len(level) for level in damped.problem.levels]
    entries = [(e.level, e.tasks, e.sigma, e.rows) for e in damped.near]
    return damped.problem is damped.given, added, entries


@pytest.mark.parametrize("weight", [1.0, 4.0])
@pytest.mark.parametrize("kinds", STACKS.values(), ids=STACKS)
def test_what_is_remembered_changes_no_row(kinds, weight, monkeypatch):
    stack, covered = stack_of(kinds, weight), []
    covers = Margin.covers

    def counted(self, problem):
        covered.append(covers(self, problem))
        return covered[-1]

    monkeypatch.setattr(Margin, "covers", counted)
    for seed in range(12):
        rng = np.random.default_rng(seed)
        damper = Damper(team(), team().dt)
        q = home() if seed % 3 == 0 else random_q(rng)
        direction, size = rng.normal(size=q.size), 10.0 ** rng.uniform(-5.0, -1.5)
        for _ in range(12):
            aims = rng.normal(size=(2, 3)) * 10.0 ** rng.uniform(-9.0, 0.0)
            bases = rng.normal(size=(2, 3)) * 10.0 ** rng.uniform(-9.0, 0.0)
            given, kinematics = problem_at(stack, q, aims, bases)
            remembered = damper.damped(given, kinematics, team().limits)
            alone = Damper(team(), team().dt).damped(given, kinematics, team().limits)
            assert rows_of(remembered) == rows_of(alone)
            q = q + size * direction
    assert sum(covered) > 50


@pytest.mark.parametrize("steps", [2, 20, 100])
def test_an_arm_that_is_stretched_gets_its_rows(steps):
    stack, damper, rows = stack_of(STACKS["pose"], 1.0), Damper(team(), team().dt), 0
    straight = home()
    for part in team().slices:
        straight[part][3:] = [0.0, -0.2554, 0.0, -0.4670, 0.0, 3.0348, 0.0]
    aims, bases = np.tile([0.0, 0.0, 1.0], (2, 1)), np.zeros((2, 3))
    for way in np.linspace(0.0, 1.0, steps):
        given, kinematics = problem_at(stack, home() + way * (straight - home()), aims, bases)
        remembered = damper.damped(given, kinematics, team().limits)
        alone = Damper(team(), team().dt).damped(given, kinematics, team().limits)
        assert rows_of(remembered) == rows_of(alone)
        rows += sum(entry.rows for entry in alone.near)
    assert rows > 0


def test_a_bend_grows_no_faster_than_it_says():
    stack, checked = stack_of(STACKS["base below"], 1.0), 0
    for seed in range(20):
        rng = np.random.default_rng(seed)
        q = home() + 0.2 * rng.normal(size=home().size)
        for size in (1e-4, 1e-3, 1e-2):
            moved = q + size * rng.normal(size=q.size)
            bends = []
            for at in (q, moved):
                given, kinematics = problem_at(stack, at, np.zeros((2, 3)), np.ones((2, 3)))
                group = groups_of(given, team().slices)[0]
                levels = group.levels(given)
                bends.append((Bend.of(levels[:2], kinematics), levels[0].matrix))
            (before, rows), (after, others) = bends
            most = before.most(float(np.linalg.norm(others - rows)))
            assert after.inside <= most
            checked += np.isfinite(most)
    assert checked > 40


def test_numbers_that_are_none_are_never_covered():
    stack = stack_of(STACKS["pose"], 1.0)
    given, kinematics = problem_at(stack, home(), np.zeros((2, 3)), np.zeros((2, 3)))
    group = groups_of(given, team().slices)[0]
    known = Margin.of(group, group.levels(given), given, kinematics)
    assert known.covers(given)
    task = given.levels[0][0]
    broken = replace(task, matrix=np.full_like(task.matrix, np.nan))
    assert not known.covers(HqpProblem(((broken, *given.levels[0][1:]),), given.bounds))
