"""The programme of docs/library.md, as a user types it, and what it promises on the way."""

import re
import shutil
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

import lexstack as lx
from lexstack.robots import description_path

ROOT = Path(__file__).resolve().parents[2]
PROGRAMME = """
import lexstack as lx
robot = lx.Robot.from_urdf("my_arm.urdf", base="fixed")
tool = lx.FramePose("tool0", gain=3.0)
stack = lx.Stack([[tool], [lx.VelocityDamping()]])
tool.set_target(pose)                                   # or a trajectory
v = lx.solve_hqp(robot.configuration(q), stack, dt=0.01).velocity
run = lx.Lockstep(robot, stack, dt=0.01)                # A, B, MPC, ideal plant: one process
run.switch(lx.Stack([[tool], [lx.Posture(q_mid)]]), duration=1.0)
"""
PLAN = """
plan = lx.Htmpc(robot).solve(robot.configuration(q), [lx.track("tool0", pose), lx.track_base([1, 0])])
"""  # noqa: E501  # as it stands in the issue
Q = np.array([0.3, -1.2, 1.5, -0.5, 1.0, 0.2])
Q_MID = np.array([0.0, -1.0, 1.2, 0.0, 1.0, 0.0])


@pytest.fixture
def my_arm(tmp_path, monkeypatch):
    """Return the folder with the URDF of an arm of a user's own, as the present one."""
    shutil.copy(description_path("ur_description/urdf/ur10_robot.urdf"), tmp_path / "my_arm.urdf")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def arm(**options):
    """Return an arm that starts away from its singularities."""
    home = dict(
        zip(("shoulder_lift_joint", "elbow_joint", "wrist_2_joint"), (-1.0, 1.5, 1.0), strict=True)
    )
    return lx.Robot.from_urdf("ur_description/urdf/ur10_robot.urdf", home=home, **options)


def beside(point, x, y, z):
    """Return a point that is so far from another one."""
    return point + np.array([x, y, z])


@pytest.mark.parametrize("base", ["fixed", "holonomic"])
def test_the_programme_runs_as_it_is_written(my_arm, base):
    q = Q if base == "fixed" else np.concatenate((np.zeros(3), Q))
    pose = pin.SE3(np.eye(3), np.array([0.5, 0.3, 0.6]))
    names = {"pose": pose, "q": q, "q_mid": Q_MID}
    exec(PROGRAMME.replace("fixed", base) + PLAN * (base != "fixed"), names)
    run, tool = names["run"], names["tool"]
    assert np.isfinite(names["v"]).all()
    assert np.linalg.norm(names["v"]) > 0.1
    command = run.until(8.0)
    assert command.stack == "stack 2"
    at = run.configuration.frame("tool0").pose
    np.testing.assert_allclose(at.position, pose.translation, atol=1e-5)
    assert tool.goal.position is not pose.translation
    record = run.record()
    assert (record.velocity >= record.lower - 1e-12).all()
    assert (record.velocity <= record.upper + 1e-12).all()
    assert (np.abs(record.acceleration) <= run.team.limits.acceleration + 1e-6).all()
    if base != "fixed":
        assert names["plan"].solved


def test_the_documents_show_this_programme():
    text = (ROOT / "docs/library.md").read_text()
    for line in PROGRAMME.strip().splitlines()[2:5]:
        assert line.split("#")[0].strip() in text


def test_the_mpc_leads_any_frame_and_joints_of_an_arm_on_a_table():
    robot = arm()
    wrist = robot.configuration(robot.home).frame("wrist_1_link").pose
    goals = [
        lx.track("wrist_1_link", beside(wrist.position, 0.0, 0.1, 0.0)),
        lx.track_joints([0.3, 0.2], ("wrist_1_joint", "wrist_2_joint")),
    ]
    htmpc, q, v = lx.Htmpc(robot), robot.home, np.zeros(6)
    for k in range(40):
        plan = htmpc.solve(robot.configuration(q, v, time=0.1 * k), goals)
        q, v, _ = plan.sample(0.1 * (k + 1))
    at = robot.configuration(q).frame("wrist_1_link").pose.position
    np.testing.assert_allclose(at, goals[0].goal, atol=2e-3)
    np.testing.assert_allclose(q[3:5], [0.3, 0.2], atol=5e-3)
    with pytest.raises(lx.InputError, match="has no base"):
        htmpc.solve(robot.configuration(q), [lx.track_base([1, 0])])


def test_all_forms_of_a_pose_are_the_same_target():
    tool, pose = lx.FramePose("tool0"), pin.SE3.Random()
    quaternion = pin.Quaternion(pose.rotation).coeffs()
    forms = [
        pose,
        pose.homogeneous,
        (pose.translation, pose.rotation),
        (list(pose.translation), quaternion),
        lx.Pose(pose.translation, pose.rotation),
    ]
    for form in forms:
        tool.set_target(form)
        np.testing.assert_allclose(tool.goal.position, pose.translation)
        np.testing.assert_allclose(tool.goal.rotation, pose.rotation, atol=1e-12)


def test_a_task_keeps_its_target_in_every_stack_and_others_have_their_own():
    robot = arm()
    home = robot.configuration(robot.home).frame("tool0").pose
    one, other = lx.FramePosition("tool0"), lx.FramePosition("tool0")
    one.set_target(beside(home.position, 0.0, 0.0, 0.1))
    other.set_target(beside(home.position, 0.0, 0.1, 0.0))
    run = lx.Lockstep(robot, lx.Stack([one, lx.VelocityDamping()]), dt=0.01)

    def moved():
        return run.configuration.frame("tool0").pose.position - home.position

    run.until(4.0)
    np.testing.assert_allclose(moved(), [0.0, 0.0, 0.1], atol=1e-5)
    run.switch(lx.Stack([other, lx.Posture()]), duration=0.5)
    run.until(8.0)
    np.testing.assert_allclose(moved(), [0.0, 0.1, 0.0], atol=1e-5)
    run.switch(lx.Stack([one, lx.Posture()]), duration=0.5)
    run.until(12.0)
    np.testing.assert_allclose(moved(), [0.0, 0.0, 0.1], atol=1e-5)


def test_a_task_without_a_target_holds_its_frame_and_a_first_target_does_not_jump():
    robot = arm()
    tool = lx.FramePose("tool0")
    run = lx.Lockstep(robot, lx.Stack([tool, lx.VelocityDamping()]), dt=0.01)
    home = run.configuration.frame("tool0").pose
    run.until(0.5)
    np.testing.assert_allclose(run.record().velocity, 0.0, atol=1e-9)
    tool.set_target((beside(home.position, 0.0, 0.0, 0.2), home.rotation))
    run.until(0.55)
    assert np.abs(run.record().velocity).max() < 0.01, "the way of 0.5 s has only just begun"
    run.until(5.0)
    goal = beside(home.position, 0.0, 0.0, 0.2)
    np.testing.assert_allclose(run.configuration.frame("tool0").pose.position, goal, atol=1e-5)


def test_a_posture_given_later_is_led_to_and_ends_where_it_is():
    robot = arm()
    posture = lx.Posture()
    run = lx.Lockstep(robot, lx.Stack([posture]), dt=0.01)
    posture.set_target(robot.home + 0.2)
    run.until(10.0)
    np.testing.assert_allclose(run.state.q, robot.home + 0.2, atol=1e-4)
    run.switch(lx.Stack([lx.Posture(robot.home)]), duration=1.0)
    run.until(20.0)
    np.testing.assert_allclose(run.state.q, robot.home, atol=1e-4)


def test_levels_are_inserted_removed_and_swapped_while_it_runs():
    robot = arm()
    home = robot.configuration(robot.home).frame("tool0").pose
    place, turn, rest = lx.FramePosition("tool0"), lx.FrameOrientation("tool0"), lx.Posture()
    place.set_target(beside(home.position, 0.1, 0.1, -0.1))
    turn.set_target(home.rotation)
    stack = lx.Stack([place, rest])
    run = lx.Lockstep(robot, stack, dt=0.01)
    for changed, at in (
        (stack.inserted(1, turn), 1.0),
        (stack.inserted(0, turn).swapped(0, 1), 2.5),
        (stack.inserted(1, turn).removed(rest), 4.0),
        (stack.replaced(rest, lx.VelocityDamping()).added(0, turn), 5.5),
    ):
        run.until(at)
        run.switch(changed, duration=1.0)
    run.until(10.0)
    pose = run.configuration.frame("tool0").pose
    np.testing.assert_allclose(pose.position, beside(home.position, 0.1, 0.1, -0.1), atol=1e-5)
    np.testing.assert_allclose(pose.rotation, home.rotation, atol=1e-5)
    bound = run.team.limits.acceleration
    assert (np.abs(run.record().acceleration) <= bound + 1e-6).all()


def test_limits_of_a_run_hold_for_all_later_stacks():
    robot = arm()
    tool = lx.FramePosition("tool0")
    run = lx.Lockstep(robot, lx.Stack([tool, lx.VelocityDamping()]), dt=0.01)
    home = run.configuration.frame("tool0").pose.position
    tool.set_target(beside(home, 0.3, 0.3, -0.4))
    run.until(0.6)
    assert np.abs(run.record().velocity).max() > 0.1
    run.limits(velocity=0.05)
    run.switch(lx.Stack([tool, lx.Posture()]))
    run.until(2.0)
    late = run.record().velocity[150:]
    assert 0.049 < np.abs(late).max() <= 0.05 + 1e-9
    run.limits(["elbow_joint"], position=(-3.0, 1.4))
    run.until(6.0)
    assert run.state.q[2] <= 1.4 + 1e-9
    assert np.abs(run.record().velocity[150:]).max() <= 0.05 + 1e-9, "as it was asked before"
    assert (np.abs(run.record().acceleration) <= run.team.limits.acceleration + 1e-6).all()


def test_two_robots_and_tasks_that_name_theirs():
    one = arm(name="left", place=(0.0, 0.5, 0.0, 0.0))
    two = arm(name="right", place=(0.0, -0.5, 0.0, 0.0))
    hold = lx.RelativePose("right", robot="left")
    lift = lx.FramePose("tool0", robot="left")
    run = lx.Lockstep([one, two], lx.Stack([hold, lift, lx.VelocityDamping()]), dt=0.01)

    def places():
        at = run.configuration
        return [at.frame("tool0", name).pose for name in ("left", "right")]

    before = places()
    lift.set_target((beside(before[0].position, 0.0, 0.0, 0.15), before[0].rotation))
    run.until(4.0)
    for was, now in zip(before, places(), strict=True):
        up = now.position - was.position
        np.testing.assert_allclose(up, [0.0, 0.0, 0.15], atol=1e-4)


def test_a_twist_moves_a_frame_until_it_is_late():
    robot = arm()
    tool = lx.FramePose("tool0")
    run = lx.Lockstep(robot, lx.Stack([tool, lx.VelocityDamping()]), dt=0.01)
    home = run.configuration.frame("tool0").pose.position
    for _ in range(100):
        tool.set_target(lx.Twist([0.0, 0.0, -0.1, 0.0, 0.0, 0.0]))
        run.step()
    run.until(2.0)
    went = run.configuration.frame("tool0").pose.position - home
    np.testing.assert_allclose(went[:2], 0.0, atol=1e-3)
    assert -0.125 < went[2] < -0.09


def test_a_sequence_of_the_mpc_in_the_same_process():
    robot = arm(base="holonomic")
    run = lx.Lockstep(robot, lx.Stack([lx.FramePose("tool0"), lx.VelocityDamping()]), dt=0.02)
    home = run.configuration.frame("tool0").pose.position
    goal = beside(home, 0.4, 0.2, 0.0)
    tasks = [
        lx.track("tool0", goal).task("reach", tolerance=0.02),
        lx.track_base([0.5, 0.5]).task("park", tolerance=0.05),
    ]
    run.sequence(tasks, duration=0.5)
    while not (run.progress and run.progress["robot"].sequence.done):
        run.step()
        assert run.time < 15.0
    np.testing.assert_allclose(run.state.q[:2], [0.5, 0.5], atol=0.06)
    run.switch(run.stack, duration=0.5)
    run.until(run.time + 2.0)
    assert (np.abs(run.record().acceleration) <= run.team.limits.acceleration + 1e-6).all()


def test_an_own_task_is_a_function_of_the_configuration():
    def height(at):
        pose, jacobian = at.frame("tool0")
        return jacobian[2:3], 2.0 * (1.1 - pose.position[2:3])

    one, two = arm(name="one"), arm(name="two", place=(2.0, 0.0, 0.2, 1.0))
    level = lx.OwnTask("height", height)
    run = lx.Lockstep([one, two], lx.Stack([level, lx.Posture()]), dt=0.01)
    run.until(6.0)
    for name in ("one", "two"):
        at = run.configuration.frame("tool0", name).pose.position[2]
        np.testing.assert_allclose(at, 1.1, atol=1e-4)


def test_solve_hqp_says_what_it_could_not_meet_and_what_held_it():
    robot = arm()
    tool = lx.FramePosition("tool0", gain=10.0, max_linear=5.0)
    stack = lx.Stack([tool, lx.VelocityDamping()])
    home = robot.configuration(robot.home).frame("tool0").pose.position
    assert lx.solve_hqp(robot.configuration(robot.home), stack, dt=0.01).unmet == ""
    tool.set_target(beside(home, 0.0, 0.5, 0.2))
    still = robot.configuration(robot.home, np.zeros(6))
    found = lx.solve_hqp(still, stack, dt=0.01)
    assert found.residuals[0] > 1.0
    assert found.at_limits
    assert re.match(
        r"level 1: robot/frame_position\(tool0\) row \d misses by .*, held by ", found.unmet
    )
    reach = robot.limits.acceleration * 0.01
    assert (np.abs(found.velocity) <= reach + 1e-12).all()
    assert (
        np.abs(lx.solve_hqp(robot.configuration(robot.home), stack, dt=0.01).velocity).max()
        > reach.max()
    )


def wrong_stacks():
    """Return what may be wrong, and the line that says so."""
    tool, rest = lx.FramePose("tool0"), lx.VelocityDamping()
    return {
        "no level": (lambda: lx.Stack([]), "stack: it needs at least one level"),
        "no task": (
            lambda: lx.Stack([[tool], ["x"]]),
            r"levels\[1\]\[0\]: expected a task, got str",
        ),
        "twice": (
            lambda: lx.Stack([tool, tool]),
            r"stack: FramePose\('tool0'\) stands in it twice",
        ),
        "gain": (
            lambda: lx.FramePose("tool0", gain=-1.0),
            "FramePose: gain: must be finite and > 0",
        ),
        "mask": (lambda: lx.FramePose(mask=[False] * 6), "FramePose: mask: it leaves no axis"),
        "weight": (
            lambda: lx.Posture(weight=0.0),
            "Posture: weight: must be finite and > 0, got 0",
        ),
        "absent": (
            lambda: lx.Stack([rest]).removed(tool),
            "is not in it; there is: VelocityDamping",
        ),
        "place": (lambda: lx.Stack([rest]).inserted(3, tool), r"must be in \[0, 1\]"),
        "target": (
            lambda: tool.set_target([1.0]),
            r"FramePose\('tool0'\): target: expected a Pose",
        ),
        "quaternion": (
            lambda: tool.set_target((np.zeros(3), [0.0, 0.0, 0.0, 2.0])),
            "quaternion: its length must be 1",
        ),
        "base": (
            lambda: lx.BasePose().set_target([1.0, 2.0]),
            "BasePose: target: expected 3 finite",
        ),
        "no frame": (
            lambda: lx.Lockstep(arm(), lx.Stack([lx.FramePose("toll0")]), dt=0.01),
            r"stack 'stack 1': level 1: FramePose\('toll0'\): frame: .*'toll0'; there is: tool0",
        ),
        "no robot": (
            lambda: lx.Lockstep(arm(), lx.Stack([lx.FramePose(robot="b")]), dt=0.01),
            "unknown robot 'b'; known: robot",
        ),
        "no base": (
            lambda: lx.Lockstep(arm(), lx.Stack([lx.BasePose()]), dt=0.01),
            "level 1: BasePose: robot robot: has no base",
        ),
        "q": (lambda: arm().configuration([0.0]), r"configuration: q: expected 6 finite numbers"),
        "dt": (lambda: lx.Lockstep(arm(), lx.Stack([rest]), dt=0.0), "dt: must be finite and > 0"),
        "base type": (lambda: arm(base="hover"), "robot robot: base: type: 'hover' is not one of"),
        "mpc frame": (
            lambda: lx.Htmpc(arm(base="holonomic")).solve(
                arm(base="holonomic").configuration(np.zeros(9)),
                [lx.track("foream_link", [1, 0, 1])],
            ),
            "no frame 'foream_link'; there is: forearm_link",
        ),
        "duration": (
            lambda: lx.Lockstep(arm(), lx.Stack([rest]), dt=0.01).switch(lx.Stack([rest]), 100.0),
            r"switch: duration: must be in \[0, 60\] s",
        ),
        "limit": (
            lambda: lx.Lockstep(arm(), lx.Stack([rest]), dt=0.01).limits(velocity=99.0),
            "limits.robot.shoulder_pan_joint: velocity: 99.0 is beyond the robot's own",
        ),
        "rows": (
            lambda: lx.Lockstep(
                arm(), lx.Stack([lx.OwnTask("own", lambda _at: (np.zeros((1, 5)), [0.0]))]), dt=0.01
            ).step(),
            r"OwnTask\('own'\): rows: expected shapes \(m, 6\), \(m,\), got \(1, 5\), \(1,\)",
        ),
    }


@pytest.mark.parametrize("case", wrong_stacks())
def test_what_is_wrong_is_one_line_that_says_what_and_where(case):
    make, text = wrong_stacks()[case]
    with pytest.raises(lx.LexstackError, match=text) as error:
        make()
    assert "\n" not in str(error.value)


def test_a_task_without_a_target_holds_where_it_is_when_its_stack_comes_back():
    robot = arm(base="holonomic")
    tool, base, rest = lx.FramePose("tool0"), lx.BasePose(), lx.VelocityDamping()
    hold = lx.Stack([tool, base, rest])
    lead = lx.FramePosition("tool0")
    run = lx.Lockstep(robot, hold, dt=0.01)
    home = run.configuration.frame("tool0").pose.position
    lead.set_target(beside(home, 0.4, 0.4, 0.0))
    run.switch(lx.Stack([lead, rest]), duration=0.3)
    run.until(4.0)
    there = run.state.q
    run.switch(hold, duration=0.3)
    run.until(8.0)
    np.testing.assert_allclose(run.state.q, there, atol=1e-3)


def test_tasks_with_equal_fields_are_two_tasks():
    one, other = lx.FramePose("tool0"), lx.FramePose("tool0")
    assert one != other
    assert len({one, other}) == 2
    assert [task is one for task in lx.Stack([one, other]).removed(other).tasks] == [True]
