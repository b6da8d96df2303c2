"""Plans and sequences of the HTMPC between messages and library, checked on their way in."""

from __future__ import annotations

from typing import Any

import numpy as np
from builtin_interfaces.msg import Duration
from geometry_msgs.msg import Pose
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from lexstack import mpc as core
from lexstack.errors import InputError
from lexstack.mpc import COLUMNS, Plan, Progress, SequenceTask
from lexstack.options import shown
from lexstack.robots import BASE_JOINTS, DRIVE, TOOL, Team, from_rpy, to_quaternion
from lexstack.transition import HeardPlan
from lexstack.types import Matrix, RobotState
from lexstack_interfaces.msg import Sequence, SequenceStatus
from lexstack_interfaces.msg import SequenceTask as TaskMessage
from lexstack_ros.messages.conversions import stamped, to_array, to_seconds, to_vector

PLAN = "/htmpc/plan"
_MOST_POINTS = 1000  # of a plan or of a task
_MOST_TASKS = 1000
_MOST_JOINTS = 1000
_LONGEST_NAME = 100  # characters
_OFF_TICK = 1e-3  # of a tick, by which a plan's stamp may be off


def joint_names(team: Team, robot: int) -> list[str]:
    """Return the names of a robot's joints in a plan: prefixed by the robot."""
    return list(team.joint_names[team.slices[robot]])


def plan_message(plan: Plan, names: list[str]) -> JointTrajectory:
    """Return a plan as a message: states 0 to N, with the input that begins at each.

    Joints without a position, v and w of a differential base, have 0 for one.
    """
    message = stamped(JointTrajectory(joint_names=names), plan.stamp)
    positions, inputs = positions_of(plan), inputs_of(plan)
    for k in range(len(plan.q)):
        nanoseconds = round(1e9 * k * plan.step)
        message.points.append(
            JointTrajectoryPoint(
                positions=to_array(positions[k]),
                velocities=to_array(plan.v[k]),
                accelerations=to_array(inputs[k]),
                time_from_start=Duration(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9),
            )
        )
    return message


def positions_of(plan: Plan) -> Matrix:
    """Return the positions of a plan as they stand in a message, shape (N + 1, n)."""
    if plan.q.shape[1] == plan.v.shape[1]:
        return plan.q
    without = np.zeros((len(plan.q), len(DRIVE)))
    return np.concatenate((without, plan.q[:, len(BASE_JOINTS) :]), axis=1)


def inputs_of(plan: Plan) -> Matrix:
    """Return the input that begins at each state, none at the last one, shape (N + 1, n)."""
    return np.concatenate((plan.u, np.zeros((1, plan.u.shape[1]))))


def to_plan(message: Any, team: Team, rate: float) -> HeardPlan:
    """Return a plan for the controller, ``rate`` in ticks per second; raises InputError."""
    robot = robot_of(message.joint_names, team)
    if not 2 <= len(message.points) <= _MOST_POINTS:
        raise InputError(f"{PLAN}: points: expected 2 to {_MOST_POINTS}, got {len(message.points)}")
    n = len(message.joint_names)
    velocities = np.array(
        [
            to_vector(point.velocities, n, f"{PLAN}: points[{k}].velocities")
            for k, point in enumerate(message.points)
        ]
    )
    times = np.array([to_seconds(point.time_from_start) for point in message.points])
    if times[0] < 0.0 or (np.diff(times) <= 0.0).any():
        raise InputError(f"{PLAN}: points: time_from_start: must increase from 0 on")
    tick = to_seconds(message.header.stamp) * rate
    if tick < 0.0 or abs(tick - round(tick)) > _OFF_TICK:
        raise InputError(f"{PLAN}: header.stamp: {tick / rate:g} s is not the stamp of a tick")
    return HeardPlan(robot, round(tick), times, velocities)


def robot_of(names: Any, team: Team) -> int:
    """Return whose joints these are, all and in order; raises InputError."""
    for robot in range(len(team.robots)):
        if list(names) == joint_names(team, robot):
            return robot
    known = ", ".join(f"{name}/..." for name in team.names)
    raise InputError(
        f"{PLAN}: joint_names: expected all joints of one robot ({known}), in their order, "
        f"got {shown(list(names))}"
    )


def task_message(task: SequenceTask) -> TaskMessage:
    """Return a task of a sequence as a message."""
    joints = task.kind == "joint_positions"
    return TaskMessage(
        name=task.name,
        kind=task.kind,
        frame=task.frame,
        joints=list(task.joints),
        positions=[float(value) for point in task.points for value in point] if joints else [],
        points=[_pose(task.kind, point) for point in task.points],
        speed=task.speed or 0.0,
        turn=task.turn or 0.0,
        tolerance=task.tolerance,
        tolerance_angle=task.tolerance_angle,
        dwell=task.dwell,
        held=task.held,
    )


def to_task(message: TaskMessage, where: str) -> SequenceTask:
    """Return a message as a task; raises InputError."""
    if not 0 < len(message.name) <= _LONGEST_NAME or not message.name.isprintable():
        raise InputError(f"{where}: name: expected 1 to {_LONGEST_NAME} printable characters")
    if message.kind not in COLUMNS:
        raise InputError(f"{where}: kind: {shown(message.kind)} is not one of {', '.join(COLUMNS)}")
    numbers = ("speed", "turn", "tolerance", "tolerance_angle", "dwell")
    values = to_vector([getattr(message, name) for name in numbers], 5, f"{where}: {numbers}")
    speed, turn, tolerance, angle, dwell = (float(value) for value in values)
    for name, value in zip(numbers, values, strict=True):
        if value < 0.0:
            raise InputError(f"{where}: {name}: must be >= 0, got {value:g}")
    return SequenceTask(
        message.name,
        message.kind,
        to_points(message, message.kind, where),
        speed or None,
        turn or None,
        tolerance or SequenceTask.__dataclass_fields__["tolerance"].default,
        angle or SequenceTask.__dataclass_fields__["tolerance_angle"].default,
        dwell,
        bool(message.held),
        message.frame or TOOL,
        tuple(message.joints),
    )


def to_points(message: Any, kind: str, where: str) -> tuple[tuple[float, ...], ...]:
    """Return the coordinates that a kind of task has of a message's points; raises InputError."""
    count = len(message.points)
    if not 1 <= count <= _MOST_POINTS:
        raise InputError(f"{where}: points: expected 1 to {_MOST_POINTS}, got {count}")
    if kind == "joint_positions":
        return _to_positions(message, where)
    points = []
    for i, pose in enumerate(message.points):
        place, turn = pose.position, pose.orientation
        raw = [place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w]
        x, y, z, *quaternion = to_vector(raw, 7, f"{where}: points[{i}]")
        qx, qy, qz, qw = quaternion
        yaw = float(np.arctan2(2.0 * (qw * qz + qx * qy), 1.0 - 2.0 * (qy * qy + qz * qz)))
        columns = {
            "ee_position": (x, y, z),
            "ee_pose": (x, y, z, *quaternion),
            "ee_orientation": quaternion,
            "base_position": (x, y),
            "base_pose": (x, y, yaw),
        }[kind]
        points.append(tuple(float(value) for value in columns))
    return tuple(points)


def _to_positions(message: Any, where: str) -> tuple[tuple[float, ...], ...]:
    """Return the positions of a task of joints, point by point; raises InputError."""
    size, count = len(message.positions), len(message.points)
    columns = len(message.joints) or size // count
    if not columns or size != columns * count or size > _MOST_POINTS * _MOST_JOINTS:
        raise InputError(
            f"{where}: positions: expected one per joint and point, got {size} for {count} points"
        )
    values = to_vector(message.positions, size, f"{where}: positions").reshape(count, columns)
    return tuple(tuple(float(value) for value in row) for row in values)


def to_tasks(messages: Any, where: str) -> tuple[SequenceTask, ...]:
    """Return the tasks of a goal; raises InputError."""
    if not 1 <= len(messages) <= _MOST_TASKS:
        raise InputError(f"{where}: tasks: expected 1 to {_MOST_TASKS}, got {len(messages)}")
    return tuple(to_task(message, f"{where}: tasks[{i}]") for i, message in enumerate(messages))


def status_message(
    progress: Progress, state: RobotState, robot: str, architecture: str
) -> SequenceStatus:
    """Return where a sequence stands as a message."""
    sequence, plan = progress.sequence, progress.plan
    message = SequenceStatus(
        tick=state.tick,
        robot=robot,
        architecture=architecture,
        index=sequence.first,
        count=len(sequence.tasks),
        task=sequence.window[0].name,
        error=progress.errors[0],
        error_angle=progress.errors[1],
        window=[task.name for task in sequence.window],
        errors=list(progress.tracking),
        levels=[level.text for level in plan.levels],
        solved=plan.solved,
        solve_time=plan.solve_time,
    )
    return stamped(message, state.stamp)


def sequence_message(
    sequence: core.Sequence | None,
    state: RobotState,
    robot: tuple[str, str],
    event: str,
    changed: str = "",
) -> Sequence:
    """Return a sequence as it begins or changes.

    Args:
        sequence: as it is now; None: it is over.
        state: at which that happened.
        robot: its name, and its architecture.
        event: what happened, see the message.
        changed: name of the task that a change is about.
    """
    name, architecture = robot
    message = Sequence(
        tick=state.tick, robot=name, architecture=architecture, event=event, changed=changed
    )
    if sequence is not None:
        message.tasks = [task_message(task) for task in sequence.tasks]
        points = (point for task in sequence.tasks for point in task.points)
        message.coordinates = [float(value) for point in points for value in point]
        message.index = sequence.first
        message.released = sorted(sequence.released)
    return stamped(message, state.stamp)


def _pose(kind: str, point: tuple[float, ...]) -> Pose:
    """Return a point of a task as a pose."""
    pose = Pose()
    place, turn = pose.position, pose.orientation
    if kind == "joint_positions":
        return pose
    if kind == "ee_orientation":
        turn.x, turn.y, turn.z, turn.w = point
        return pose
    place.x, place.y = point[0], point[1]
    if kind.startswith("ee"):
        place.z = point[2]
    if kind == "ee_pose":
        turn.x, turn.y, turn.z, turn.w = point[3:]
    if kind == "base_pose":
        turn.x, turn.y, turn.z, turn.w = map(float, to_quaternion(from_rpy((0.0, 0.0, point[2]))))
    return pose
