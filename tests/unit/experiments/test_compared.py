"""What ours is compared with: not the library's, but there by name for whoever lists it."""

import subprocess
import sys
from pathlib import Path

from lexstack_experiments.methods import COMPARED, METHODS
from lexstack_experiments.runs import with_method
from support.scenario import resolved

TESTS = Path(__file__).resolve().parents[2]


def test_the_methods_to_compare_with_are_not_there_until_they_are_asked_for():
    """In a process of its own: here other tests may have asked for them."""
    code = """
import sys
from support.scenario import changed
from lexstack_config.extensions import load_extensions
from lexstack.hqp import SOLVERS
from lexstack.transition import METHODS
print(*METHODS, *SOLVERS)
load_extensions(changed(extensions=("lexstack_experiments.methods",)).scenario)
print(*METHODS)
load_extensions(changed(extensions=("lexstack_experiments.solvers",)).scenario)
print(*SOLVERS, "scipy.optimize" in sys.modules)
"""
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=TESTS, capture_output=True, text=True, check=True
    )
    own = "bridge bridge_jerk t37 t34 t34_limited"
    assert done.stdout.splitlines() == [
        f"{own} kernel daqp proxqp",
        f"{own} instant instant_limited interpolation activation weights",
        "kernel daqp proxqp quadprog oracle False",
    ]


def test_a_scenario_with_such_a_method_lists_what_brings_it():
    """So its bag can be replayed."""
    for method in METHODS:
        extensions = with_method(resolved(), method).scenario.extensions
        assert extensions == (("lexstack_experiments.methods",) if method in COMPARED else ())
    twice = with_method(with_method(resolved(), "weights"), "instant")
    assert twice.scenario.extensions == ("lexstack_experiments.methods",)
