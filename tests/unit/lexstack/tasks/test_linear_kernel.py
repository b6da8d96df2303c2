"""The compiled base and posture errors: the bits of the plain forms."""

import numpy as np
import pytest

from lexstack.control.kernels import load_kernels
from lexstack.references import measured
from lexstack.robots import wrap
from lexstack.tasks import TASKS, base_pose, posture
from lexstack.tasks.kernel import linear
from lexstack_config.parts import build_team
from support.scenario import resolved

RNG = np.random.default_rng(0)


def test_errors_of_bases_and_postures_have_the_bits_of_the_plain_forms(monkeypatch):
    load_kernels()
    team = build_team(resolved())
    tasks = [TASKS["base"](team, 1, {}, ""), TASKS["posture"](team, 1, {}, "")]
    for _ in range(300):
        q = 10.0 ** RNG.uniform(-3.0, 2.0) * RNG.normal(size=team.nq)
        goals = measured(team, RNG.normal(size=team.nq))
        kinematics = team.kinematics(team.at_rest(q))
        found = [task.linearise(kinematics, goals).lower for task in tasks]
        with monkeypatch.context() as without:
            for module in (base_pose, posture):
                without.setattr(module, "kernel", lambda _name: None)
            plain = [task.linearise(kinematics, goals).lower for task in tasks]
        for one, other in zip(found, plain, strict=True):
            np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize(
    "angle", [0.0, -0.0, np.pi, -np.pi, 1e-300, -1e-18, 7.0, -7.0, 1e9, np.nan]
)
def test_an_angle_is_wrapped_as_python_does(angle):
    target = np.empty(3)
    linear.towards(np.array([0.0, 0.0, angle]), np.zeros(5), 1, 1.0, 2, target)
    np.testing.assert_array_equal(target[2], wrap(angle))


def test_a_goal_that_does_not_fit_is_refused():
    for start in (-1, 3):
        with pytest.raises(ValueError, match="fit"):
            linear.towards(np.zeros(3), np.zeros(5), start, 1.0, 2, np.empty(3))
