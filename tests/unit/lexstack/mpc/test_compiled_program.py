"""Costs by compiled code: those of the plain form, for every robot, task and scene."""

import dataclasses
import hashlib
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from lexstack.mpc import COLUMNS, CollisionScene, Htmpc, Objective, Start, Task, htmpc
from lexstack.mpc.barriers import LimitBarrier
from lexstack.mpc.htmpc import frames_of
from lexstack.mpc.stage.arrays import Costs
from lexstack.mpc.stage.kernel import chain, condensing, curvature, driving, evaluation
from lexstack.mpc.stage.model import CompiledStageModel
from lexstack.robots import from_rpy, to_quaternion
from support.htmpc import config, random_objectives, random_start, robot
from support.scenario import CONFIG

ALL = sorted(path.stem for path in (CONFIG / "robots").glob("*.yaml"))
TOLERANCE = 1e-12  # of the largest number of an array
MOVES = ("all", "arm", "base")
ENTRIES = (
    chain.place_all,
    chain.slopes_all,
    evaluation.evaluate,
    curvature.curve,
    condensing.condense_gradient,
    condensing.condense_rows,
    condensing.condense_hessian,
    driving.drive_slopes,
)

DIGEST = """
from test_compiled_program import digest
print(digest())
"""

LOADED = """
import sys
import numpy as np
from support.htmpc import config, random_objectives, random_start, robot
from lexstack.mpc import Htmpc
solver, rng = Htmpc(robot(), config()), np.random.default_rng(0)
start = random_start(rng)
objectives, before = random_objectives(rng, start, solver), set(sys.modules)
solver.solve(start, objectives)
print([name for name in set(sys.modules) - before if "kernel" in name or "numba" in name])
"""


def same(found, expected, what):
    found, expected = np.asarray(found), np.asarray(expected)
    assert found.shape == expected.shape, what
    if expected.size:
        off = np.abs(found - expected).max() / max(np.abs(expected).max(), 1e-300)
        assert off < TOLERANCE, (what, off)


def state_of(model, rng):
    spread = rng.uniform(-0.6, 0.6, model.nq)
    speeds = rng.uniform(-0.6, 0.6, model.n) * model.limits.velocity
    return Start(0.0, model.home((0.4, -0.3, 1.2)) + spread, speeds)


def objectives_of(model, stages, rng):
    """Return a task of every kind that a robot can have, each with other joints that move."""
    kinds = [kind for kind in COLUMNS if model.has_base or not kind.startswith("base")]
    result = []
    for i, kind in enumerate(kinds):
        columns = COLUMNS[kind] or len(model.config.arm.joints)
        reference = 2.0 * rng.normal(size=(stages, columns))
        moves = MOVES[i % 3] if model.has_base else "all"
        result.append(Objective(f"{kind} {i}", kind, reference, moves))
    return result


def scene_of(rng, stages):
    return CollisionScene(rng.uniform(-1.2, 1.2, (stages, 4, 3)), rng.uniform(0.1, 0.3, 4))


def programs_of(model, own, objectives, start, around):
    """Return program and tasks, plain and compiled."""
    for form in ("plain", "compiled"):
        solver = Htmpc(model, dataclasses.replace(own, evaluation=form))
        lead = solver._lead
        tasks = [Task(each, solver.config, model, lead, (start.q, start.v)) for each in objectives]
        yield solver.program(start, None, around, frames_of(tasks), tasks), tasks


def compare(model, own, objectives, start, around, u):
    """Compare all that a level takes of an iterate."""
    plain, compiled = programs_of(model, own, objectives, start, around)
    (program, tasks), (other, others) = plain, compiled
    expected, found = program.iterate(u), other.iterate(u)
    same(found.q, expected.q, "q")
    same(found.v, expected.v, "v")
    same(found.shared_cost, expected.shared_cost, "shared cost")
    same(found.at.centers, expected.at.centers, "centres")
    same(found.at.slopes, expected.at.slopes, "slopes of centres")
    same(other.kinematics(u).centers, program.kinematics(u).centers, "centres of kinematics")
    for task, mine in zip(tasks, others, strict=True):
        name = task.objective.name
        same(mine.error(found.at), task.error(expected.at), f"{name}: error")
        same(other.cost(found, mine), program.cost(expected, task), f"{name}: cost")
        same(mine.jacobian(found.at), task.jacobian(expected.at), f"{name}: jacobian")
        wanted, got = program.quadratic(expected, task), other.quadratic(found, mine)
        same(got.gradient, wanted.gradient, f"{name}: gradient")
        same(got.coupled, wanted.coupled, f"{name}: Hessian by q")
        for one, another in zip(got.barriers, wanted.barriers, strict=True):
            same(one, another, f"{name}: barriers")
        same(got.hessian, wanted.hessian, f"{name}: Hessian")
        slopes = mine.jacobian(found.at)
        rows, others_rows = wanted.sensitivity.rows(slopes), got.sensitivity.rows(slopes)
        same(others_rows, rows, f"{name}: rows")


@pytest.mark.parametrize("parameters", ["authors", "lexstack"])
@pytest.mark.parametrize("which", ALL)
def test_costs_and_derivatives_are_those_of_the_plain_form(which, parameters):
    model, own = robot(which), config(parameters, horizon=6)
    rng = np.random.default_rng(len(which))
    for around in (None, scene_of(rng, 6), scene_of(rng, 6)):
        start = state_of(model, rng)
        u = rng.normal(size=(6, model.n)) * model.limits.acceleration
        compare(model, own, objectives_of(model, 6, rng), start, around, u)


@pytest.mark.parametrize("which", ALL)
def test_frames_all_over_a_robot_are_those_of_pinocchio(which):
    model = robot(which)
    names = tuple(frame.name for frame in list(model.pinocchio.frames)[1::5])
    stages = CompiledStageModel(model, 2, (), names)
    q = np.array([state_of(model, np.random.default_rng(seed)).q for seed in (1, 2)])
    at = stages.at(q)
    for name in names:
        for k in range(2):
            pose, jacobian = model.at(q[k], model.frame(name))
            np.testing.assert_allclose(at.frames[name].position[k], pose.position, atol=1e-12)
            np.testing.assert_allclose(at.frames[name].rotation[k], pose.rotation, atol=1e-12)
            if not model.differential:  # there it is by chi
                np.testing.assert_allclose(at.frames[name].jacobian[k], jacobian, atol=1e-12)


@pytest.mark.parametrize("room", [0.02, 50.0])
def test_logarithms_of_many_small_or_large_rooms(room):
    model, own = robot(), config(horizon=40)
    most = np.full(model.n, room)
    costs = []
    for form in ("plain", "compiled"):
        solver = Htmpc(model, dataclasses.replace(own, evaluation=form), ())
        barrier = LimitBarrier(own.limits, (-most, most), most, most)
        solver._costs = Costs.of(own, barrier, solver._costs.effort)
        program = solver.program(Start(0.0, np.zeros(model.n), np.zeros(model.n)))
        costs.append(program.iterate(np.zeros((40, model.n))).shared_cost)
    assert costs[0] == pytest.approx(-own.limits.mu * 40 * 54 * np.log(room), rel=1e-12)
    assert costs[1] == pytest.approx(costs[0], rel=1e-12)


@pytest.mark.parametrize("stages", [2, 30])
def test_short_and_long_horizons_condense_alike(stages):
    rng = np.random.default_rng(stages)
    model, own = robot(), config(horizon=stages)
    start, u = state_of(model, rng), rng.normal(size=(stages, model.n))
    compare(model, own, objectives_of(model, stages, rng), start, scene_of(rng, stages), u)


def test_a_thing_in_a_sphere_s_centre_and_one_out_of_reach():
    model, own = robot(), config(horizon=3)
    start = Start(0.0, model.home(), np.zeros(model.n))
    u = np.zeros((3, model.n))
    tool = Objective("tool", "ee_position", np.zeros((3, 3)))
    (program, _), _ = programs_of(model, own, [tool], start, None)
    centers = program.iterate(u).at.centers
    around = CollisionScene(np.stack((centers[:, 4], centers[:, 2] + 50.0), 1), np.full(2, 0.1))
    compare(model, own, [tool], start, around, u)


@pytest.mark.parametrize("off", [0.0, 1e-9, 9e-5, 1e-3, 3.0, np.pi - 1e-3, np.pi - 1e-7, np.pi])
def test_rotations_near_nothing_and_near_half_a_turn(off):
    model, own = robot(), config(horizon=2)
    start = Start(0.0, model.home(), np.zeros(model.n))
    turned = from_rpy((off, 0.0, 0.0)) @ model.tool(start.q)[0].rotation
    reference = np.tile(to_quaternion(turned), (2, 1))
    tasks = [
        Objective("pose", "ee_pose", np.concatenate((np.zeros((2, 3)), reference), axis=1)),
        Objective("orientation", "ee_orientation", 3.0 * reference),
    ]
    plain, compiled = programs_of(model, own, tasks, start, None)
    iterates = [program.iterate(np.zeros((2, model.n))) for program, _ in (plain, compiled)]
    for task, mine in zip(plain[1], compiled[1], strict=True):
        expected, found = task.error(iterates[0].at), mine.error(iterates[1].at)
        # At half a turn both signs of the axis are right.
        sign = np.sign(np.vdot(expected[:, -3:], found[:, -3:])) if off == np.pi else 1.0
        near = 5e-15 if off < 1.0 else 1e-12
        np.testing.assert_allclose(sign * found[:, -3:], expected[:, -3:], rtol=0.0, atol=near)
        if off < np.pi:
            same(mine.jacobian(iterates[1].at), task.jacobian(iterates[0].at), "jacobian")
            quadratics = [
                program.quadratic(iterate, each)
                for (program, _), iterate, each in zip(
                    (plain, compiled), iterates, (task, mine), strict=True
                )
            ]
            same(quadratics[1].coupled, quadratics[0].coupled, "Hessian by q")


def test_an_iterate_whose_numbers_are_not_finite_costs_no_finite_number():
    model, own = robot(), config(horizon=3)
    start = Start(0.0, model.home(), np.zeros(model.n))
    tool = Objective("tool", "ee_position", np.zeros((3, 3)))
    for program, tasks in programs_of(model, own, [tool], start, None):
        iterate = program.iterate(np.full((3, model.n), np.nan))
        assert not np.isfinite(program.cost(iterate, tasks[0]))


@pytest.mark.parametrize("which", ["ur10_ridgeback", "panda_summit", "tiago"])
def test_plans_of_a_closed_loop_are_those_of_the_plain_form(which):
    model = robot(which)
    rng = np.random.default_rng(5)
    plain, compiled = (Htmpc(model, config(evaluation=each)) for each in ("plain", "compiled"))
    start = Start(0.0, model.home(), np.zeros(model.n))
    around = scene_of(rng, plain.config.horizon)
    around = CollisionScene(around.centers * 0.2 + np.array([1.8, 0.0, 0.8]), around.radii)
    objectives = random_objectives(rng, start, plain, far=0.2)
    before = None
    for step in range(15):
        expected = plain.solve(start, objectives, before, around)
        found = compiled.solve(start, objectives, before, around)
        for one, other in zip(found.levels, expected.levels, strict=True):
            assert (one.outcome, one.steps, one.iterations) == (
                other.outcome,
                other.steps,
                other.iterations,
            ), step
            assert one.cost == pytest.approx(other.cost, rel=1e-9, abs=1e-9)
        np.testing.assert_allclose(found.u, expected.u, atol=1e-7)
        before = expected
        start = Start(0.1 * (step + 1), expected.q[1], expected.v[1])


def test_kinematics_of_arrays_that_cannot_be_written_or_are_not_in_order():
    model = robot()
    stages = CompiledStageModel(model, 2, (0, 3))
    q = np.asfortranarray(np.random.default_rng(0).normal(size=(2, model.nq)))
    q.setflags(write=False)
    at = stages.at(q)
    np.testing.assert_array_equal(at.q, q)
    np.testing.assert_array_equal(at.centers, stages.at(np.array(q, order="C")).centers)


def test_nothing_is_compiled_in_a_solve():
    solver = Htmpc(robot(), config())
    rng = np.random.default_rng(0)
    start = random_start(rng)
    solver.solve(start, random_objectives(rng, start, solver))
    assert [len(each.signatures) for each in ENTRIES] == [1] * len(ENTRIES)


def test_nothing_is_loaded_in_a_solve():
    assert python(LOADED) == "[]\n"


def test_without_numba_the_plain_form_plans_and_it_is_told(monkeypatch):
    monkeypatch.setattr(htmpc, "available", lambda: False)
    with pytest.warns(UserWarning, match="numba is not installed: the MPC's costs"):
        solver = Htmpc(robot(), config())
    rng = np.random.default_rng(0)
    start = random_start(rng)
    objectives = random_objectives(rng, start, solver)
    plain = Htmpc(robot(), config(evaluation="plain"))
    expected = plain.solve(start, objectives).u
    np.testing.assert_array_equal(solver.solve(start, objectives).u, expected)


def digest():
    """Return the hash of costs and derivatives, of every kind of task and two robots."""
    found = hashlib.sha256()
    for which in ("ur10_ridgeback", "tiago"):
        rng = np.random.default_rng(7)
        model, own = robot(which), config(horizon=4)
        start, around = state_of(model, rng), scene_of(rng, 4)
        objectives = objectives_of(model, 4, rng)
        _, (program, tasks) = programs_of(model, own, objectives, start, around)
        iterate = program.iterate(rng.normal(size=(4, model.n)))
        for task in tasks:
            found.update(np.float64(program.cost(iterate, task)).tobytes())
            quadratic = program.quadratic(iterate, task)
            found.update(quadratic.coupled.tobytes())
            found.update(quadratic.gradient.tobytes())
            found.update(quadratic.hessian.tobytes())
    return found.hexdigest()


def python(script, **variables):
    """Return what a process of its own prints."""
    path = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    return subprocess.run(
        [sys.executable, "-c", script],
        env={**os.environ, **variables, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    ).stdout


def test_the_source_as_python_has_the_same_bits():
    assert python(DIGEST, NUMBA_DISABLE_JIT="1") == f"{digest()}\n"


@pytest.mark.slow
def test_processors_agree_to_the_bit(tmp_path):
    # The generic processor has no fused multiply-add and no wide vectors.
    other = python(
        DIGEST, NUMBA_CPU_NAME="generic", NUMBA_CPU_FEATURES="", XDG_CACHE_HOME=str(tmp_path)
    )
    assert other == f"{digest()}\n"
