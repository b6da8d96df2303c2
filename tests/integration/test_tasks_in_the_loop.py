"""Tasks on frames in the closed loop: they reach what they ask for, and inequalities are kept."""

import numpy as np
import pinocchio as pin
import pytest

from lexstack.control import ExactPlant, Lockstep, make_controller, make_stack_solver
from lexstack.references import ReferenceSchedule, Target
from lexstack.robots import Pose
from lexstack.tasks import LevelConfig, StackConfig, TaskConfig, build_stack
from lexstack.transition import TransitionConfig, TransitionOptions
from support.scenario import home, team

HAND, ELBOW = "panda_hand", "panda_link4"


def run_of(*levels):
    """Return a run of robot A on levels of one task: kinds with their parameters."""
    tasks = [LevelConfig((TaskConfig(kind, "robot_a", 1.0, p),)) for kind, p in levels]
    both = LevelConfig((TaskConfig("minimum_velocity"),))
    stacks = {"all": build_stack(StackConfig("all", "", (*tasks, both)), team())}
    references = ReferenceSchedule.at_home(team(), home(), lead_in=0.5)
    options = TransitionOptions("all", TransitionConfig(1.0))
    controller = make_controller(team(), stacks, options, references)
    plant = ExactPlant(home(), team().dt)
    return Lockstep(team(), controller, make_stack_solver(team(), stacks), plant)


def frame(q, name):
    return team().robots[0].at(q[:10], team().robots[0].frame(name))[0]


def after(run, ticks, look=lambda q, chi: None):
    for _ in range(ticks):
        command = run.step()
        assert not command.fallback
        look(run.plant.state().q, command.chi)
    return run.plant.state().q


@pytest.mark.parametrize("axes", ["world", "local", ELBOW])
def test_a_frame_reaches_the_axes_that_are_kept(axes):
    mask = [True, True, True, False, True, True]
    gains = [2.0, 3.0, 4.0, 2.0, 3.0, 4.0]
    parameters = {"frame": HAND, "axes": axes, "mask": mask, "gain": gains}
    run, here = run_of(("frame_pose", parameters)), frame(home(), HAND)
    turn = pin.exp3(np.array([0.0, 0.2, 0.1]))
    goal = Pose(here.position + np.array([0.2, 0.1, 0.05]), turn @ here.rotation)
    run.controller.references.add(Target(0.0, 0, ee=goal, frame=HAND))
    q = after(run, 600)
    np.testing.assert_allclose(frame(q, HAND).position, goal.position, atol=1e-4)


def test_an_elbow_that_is_sent_out_of_reach_comes_to_rest():
    run, here = run_of(("frame_position", {"frame": ELBOW})), frame(home(), ELBOW)
    goal = Pose(here.position + np.array([0.0, 0.0, 1.0]), here.rotation)
    run.controller.references.add(Target(0.0, 0, ee=goal, frame=ELBOW))
    speeds = []
    after(run, 1200, lambda _q, chi: speeds.append(np.abs(chi).max()))
    assert max(speeds[1000:]) < 1e-2


def test_the_hand_looks_at_a_point_while_the_base_drives():
    point = [2.0, 0.5, 0.3]
    run = run_of(("look_at", {"frame": HAND, "point": point}), ("base", {}))
    run.controller.references.add(Target(0.0, 0, base=home()[:3] + np.array([0.5, 0.3, 0.4])))
    apart = []

    def look(q, _chi):
        pose = frame(q, HAND)
        line = np.array(point) - pose.position
        cosine = pose.rotation[:, 2] @ line / np.linalg.norm(line)
        apart.append(float(np.arccos(np.clip(cosine, -1.0, 1.0))))

    q = after(run, 800, look)
    assert apart[0] > 0.3
    assert max(apart[500:]) < 2e-3
    np.testing.assert_allclose(q[:3], home()[:3] + np.array([0.5, 0.3, 0.4]), atol=2e-3)


def test_half_space_cone_and_velocity_limit_are_kept_above_a_pose_that_breaks_them():
    here = frame(home(), "tool")
    wall = float(here.position[2]) - 0.1
    down = (here.rotation[:, 2]).tolist()
    run = run_of(
        ("half_space", {"normal": [0.0, 0.0, 1.0], "offset": wall}),
        ("cone", {"angle": 0.3, "direction": down}),
        ("frame_velocity_limit", {"linear": [0.1, 0.1, 0.1]}),
        ("ee_pose", {}),
    )
    turn = pin.exp3(np.array([0.6, 0.0, 0.0]))
    goal = Pose(here.position + np.array([0.3, 0.0, -0.3]), turn @ here.rotation)
    run.controller.references.add(Target(0.0, 0, ee=goal))
    heights, angles, speeds, last = [], [], [], [here.position]

    def look(q, _chi):
        pose = frame(q, "tool")
        heights.append(pose.position[2])
        angles.append(np.arccos(min(1.0, pose.rotation[:, 2] @ np.array(down))))
        speeds.append(np.abs(pose.position - last[-1]).max() / team().dt)
        last.append(pose.position)

    after(run, 800, look)
    assert min(heights) > wall - 1e-3
    assert heights[-1] < wall + 2e-3
    assert max(angles) < 0.3 + 1e-3
    assert angles[-1] > 0.29
    assert max(speeds) < 0.1 + 2e-3


def test_the_centre_of_mass_and_a_coupling_reach_their_values():
    model = team().robots[0]
    goal = model.centre_of_mass(home()[:10])[0] + np.array([0.1, -0.1, 0.0])
    joints = {"panda_joint1": 1.0, "panda_joint3": 2.0}
    run = run_of(
        ("centre_of_mass", {"target": goal.tolist()}),
        ("joint_coupling", {"joints": joints, "value": 0.4}),
    )
    q = after(run, 800)
    np.testing.assert_allclose(model.centre_of_mass(q[:10])[0][:2], goal[:2], atol=1e-3)
    assert q[3] + 2.0 * q[5] == pytest.approx(0.4, abs=1e-3)
