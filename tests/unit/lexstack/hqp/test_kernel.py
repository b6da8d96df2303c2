"""The compiled kernel: the same numbers as its source, compiled once, and never in a tick."""

import os
import subprocess
import sys

import numpy as np
import pytest

from lexstack import compiled
from lexstack.errors import InputError
from lexstack.hqp import DaqpCascade, HqpProblem, KernelSolver
from lexstack.hqp.kernel import solver as module
from lexstack.hqp.kernel.exchange import solve
from lexstack.limits import Bounds
from lexstack.types import LinearTask
from support.problems import KINDS, problem

DIGEST = """
import hashlib
from lexstack.hqp import KernelSolver
from support.problems import problem
found = hashlib.sha256()
for seed in range(40):
    for kind in ("nominal", "tight", "deficient"):
        found.update(KernelSolver().solve(problem(kind, seed, 14, 3, True)).chi.tobytes())
print(found.hexdigest())
"""


def digest(**variables):
    """Return the hash of 120 solutions by a process of its own."""
    done = subprocess.run(
        [sys.executable, "-c", DIGEST],
        env={**os.environ, **variables, "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    return done.stdout


class Nobody:
    """A solver that must not be asked."""

    name = "nobody"

    def solve(self, problem, warm=None):
        raise AssertionError("the kernel left a problem to the solver behind it")


def test_arrays_in_any_order_of_memory_are_the_same_problem():
    """Clusters of large problems give matrices by columns, and users transposed or sliced ones."""
    given = problem("nominal", 3, 14, 3)
    low, high = (np.repeat(end, 2)[::2] for end in (given.bounds.lower, given.bounds.upper))
    levels = tuple(
        tuple(
            LinearTask(task.name, np.asfortranarray(task.matrix), task.lower, task.upper)
            for task in level
        )
        for level in given.levels
    )
    found = KernelSolver(Nobody()).solve(HqpProblem(levels, Bounds(low, high)))
    assert (found.chi == KernelSolver(Nobody()).solve(given).chi).all()


def test_problems_of_robots_are_solved_by_the_kernel_alone():
    solver, second = KernelSolver(Nobody()), DaqpCascade()
    for seed in range(20):
        given = problem("nominal", seed, 14, 3)
        expected = second.solve(given)
        warm = None
        for _ in range(2):  # cold, then warm
            warm = solver.solve(given, warm)
            np.testing.assert_allclose(warm.chi, expected.chi, atol=1e-12)
            np.testing.assert_allclose(warm.slacks, expected.slacks, atol=1e-12)
            np.testing.assert_array_equal(warm.active, expected.active)
            np.testing.assert_array_equal(warm.rows, expected.rows)


@pytest.mark.parametrize("writeable", [True, False])
def test_nothing_is_compiled_at_a_call(writeable):
    before = len(solve.signatures)
    bounds = Bounds(np.full(3, -1.0), np.full(3, 1.0))
    matrix = np.asfortranarray(np.arange(6.0).reshape(2, 3))
    for array in (bounds.lower, bounds.upper, matrix):
        array.setflags(write=writeable)
    task = LinearTask("rows", matrix, np.array([0.0, -1.0]), np.array([0.5, np.inf]))
    whole = LinearTask.equality("integers", np.eye(3, dtype=int), np.ones(3, dtype=int))
    assert KernelSolver(Nobody()).solve(HqpProblem(((task,), (whole,)), bounds)).solved
    assert len(solve.signatures) == before == 1


def test_what_the_kernel_leaves_goes_to_the_cascade():
    rows = LinearTask.equality("small", np.array([[1e-9, 2e-9, 0.0]]), np.array([1e-9]))
    given = HqpProblem(((rows,),), Bounds(np.full(3, -1.0), np.full(3, 1.0)))
    with pytest.raises(AssertionError, match="left a problem"):
        KernelSolver(Nobody()).solve(given)
    np.testing.assert_array_equal(KernelSolver().solve(given).chi, DaqpCascade().solve(given).chi)


def test_without_numba_the_cascade_solves_and_it_is_told(monkeypatch):
    monkeypatch.setattr(module, "available", lambda: False)
    with pytest.warns(UserWarning, match="numba is not installed: daqp_cascade in its place"):
        solver = KernelSolver()
    given = problem("tight", 1, 10, 2)
    np.testing.assert_array_equal(solver.solve(given).chi, DaqpCascade().solve(given).chi)


def test_another_source_is_another_folder(monkeypatch, tmp_path):
    first = compiled.folder()
    (tmp_path / "kernel").mkdir()
    (tmp_path / "kernel/lq.py").write_text("# another kernel\n", encoding="utf-8")
    monkeypatch.setattr(compiled, "HERE", tmp_path)
    other = compiled.folder.__wrapped__()
    assert other.name != first.name
    assert other.parent == tmp_path / "__pycache__"


@pytest.mark.slow
def test_processes_and_processors_agree_to_the_bit(tmp_path):
    # The generic processor has no fused multiply-add and no wide vectors.
    generic = digest(NUMBA_CPU_NAME="generic", NUMBA_CPU_FEATURES="", XDG_CACHE_HOME=str(tmp_path))
    assert digest() == generic


@pytest.mark.parametrize("kind", KINDS)
def test_the_source_as_python_has_the_same_bits(kind):
    # Without numba the loops of the source are what runs: the compiled code computes nothing else.
    script = f"""
from lexstack.hqp import KernelSolver
from support.problems import problem
for seed in range(2):
    print(KernelSolver().solve(problem({kind!r}, seed, 10, 3)).chi.tobytes().hex())
"""
    found = [
        subprocess.run(
            [sys.executable, "-c", script],
            env={**os.environ, **extra, "PYTHONPATH": os.pathsep.join(sys.path)},
            capture_output=True,
            text=True,
            check=True,
            timeout=120,
        ).stdout
        for extra in ({}, {"NUMBA_DISABLE_JIT": "1"})
    ]
    assert found[0]
    assert found[0] == found[1]


@pytest.mark.parametrize("solver", [KernelSolver, DaqpCascade])
@pytest.mark.parametrize("shape", [(2,), (4,), (3, 1), ()])
def test_bounds_whose_ends_do_not_fit_are_refused(solver, shape):
    task = LinearTask("t", np.eye(3), np.zeros(3), np.zeros(3))
    with pytest.raises(InputError, match="bounds: lower"):
        solver().solve(HqpProblem(((task,),), Bounds(-np.ones(3), np.ones(shape))))
