"""The compiled chains: pinocchio's poses and Jacobians, to the bit."""

from types import SimpleNamespace

import numpy as np
import pinocchio as pin
import pytest

from lexstack.robots.chains import Chains
from lexstack.robots.kernel import chain

KINDS = [getattr(pin, f"JointModel{kind}{axis}") for kind in "PR" for axis in "XYZ"]


def turn(rng):
    """Return a random rotation."""
    quaternion = rng.normal(size=4)
    return pin.Quaternion(quaternion / np.linalg.norm(quaternion)).matrix()


def robot(rng, kinds=KINDS):
    """Return a chain of joints with random places, as far as ``Chains`` looks at a robot."""
    model, parent, n = pin.Model(), 0, int(rng.integers(1, 9))
    for joint in range(n):
        place = pin.SE3(turn(rng), rng.normal(size=3))
        parent = model.addJoint(parent, kinds[rng.integers(len(kinds))](), place, f"joint{joint}")
    model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "beside")
    end = pin.SE3(turn(rng), rng.normal(size=3))
    tool = model.addFrame(pin.Frame("tool", parent, 0, end, pin.FrameType.OP_FRAME))
    sizes = {"n": n + 1, "nq": n + 1, "map": None, "differential": False}
    return SimpleNamespace(pinocchio=model, frame=lambda _name: tool, **sizes)


def test_poses_and_jacobians_are_those_of_pinocchio():
    rng = np.random.default_rng(0)
    for _ in range(100):
        robots = [robot(rng) for _ in range(rng.integers(1, 4))]
        q = 2.0 * rng.normal(size=sum(one.n for one in robots))
        poses, jacobians = Chains.of(robots).tools(q, chain)
        parts = np.split(q, np.cumsum([one.n for one in robots])[:-1])
        for one, part, pose, jacobian in zip(robots, parts, poses, jacobians, strict=True):
            data, tool = one.pinocchio.createData(), one.frame("tool")
            wanted = pin.computeFrameJacobian(
                one.pinocchio, data, part, tool, pin.LOCAL_WORLD_ALIGNED
            )
            place = pin.updateFramePlacement(one.pinocchio, data, tool)
            np.testing.assert_array_equal(pose.position, place.translation)
            np.testing.assert_array_equal(pose.rotation, place.rotation)
            np.testing.assert_array_equal(jacobian, wanted)
            assert jacobian.flags.f_contiguous
    assert len(chain.tools.signatures) == 1


@pytest.mark.parametrize(
    "other", [{"map": object()}, {"differential": True}, {"kinds": [pin.JointModelRUBX]}]
)
def test_robots_with_other_joints_are_left_to_pinocchio(other):
    rng = np.random.default_rng(1)
    one = robot(rng, other.pop("kinds", KINDS))
    for name, value in other.items():
        setattr(one, name, value)
    assert Chains.of([robot(rng), one]) is None
