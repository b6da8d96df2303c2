"""Joint positions at which a frame is at a pose: damped Gauss-Newton steps from several starts.

A robot that follows its tool in a straight line may come to rest at joint limits before it is
there. Whoever wants to know whether the pose can be reached at all, and by which joint positions,
asks here, and moves the joints there: by the task ``posture``, with ``point_to_point`` for its
reference.
"""

from __future__ import annotations

import numpy as np

from lexstack.limits.travel import travel_time
from lexstack.robots.kinematics import Pose
from lexstack.robots.robot import RobotModel
from lexstack.robots.spatial import log3
from lexstack.types import Matrix, Vector

_STEPS = 60  # of one start
_LONGEST = 0.5  # rad or m, of a joint in one step
_DAMPING = 1e-3  # times the squared error, added to J J^T
_TURN = 2.0 * np.pi  # rad


def inverse_kinematics(
    robot: RobotModel,
    pose: Pose,
    start: Vector,
    *,
    frame: str = "tool",
    tries: int = 24,
    seed: int = 0,
    tolerance: float = 1e-6,
) -> Vector | None:
    """Return joint positions at which a frame is at a pose, inside the limits, shape (nq,).

    Of those that are found the quickest from ``start`` on, by the joints' limits of velocity and
    acceleration; None: none was found, which is no proof that there is none. A base stays where it
    is. The same arguments give the same result.

    Args:
        robot: whose joints.
        pose: in the world frame.
        start: where the robot is, shape (nq,), and the first start of the search.
        frame: of the robot: ``tool``, or a link or joint of its description.
        tries: how many starts: where the robot is, its ``posture``, then random ones.
        seed: of the random ones.
        tolerance: of every component of the error, m and rad.

    Raises:
        ModelError: the robot has no such frame.
    """
    rng, place, arm = np.random.default_rng(seed), robot.frame(frame), robot.arm_q
    velocity, acceleration = robot.limits.velocity[robot.arm], robot.limits.acceleration[robot.arm]
    best, least = None, np.inf
    for number in range(tries):
        q = start.copy()
        if number == 1:
            q[arm] = robot.posture
        elif number:
            q[arm] = _anywhere(robot, start, rng)
        if not _solve(robot, place, pose, q, tolerance):
            continue
        q = _unwound(robot, q, start)
        time = travel_time((q - start)[arm], velocity, acceleration).max(initial=0.0)
        if time < least and np.abs(_error(robot, place, pose, q)[0]).max() <= tolerance:
            best, least = q, time
    return best


def _anywhere(robot: RobotModel, start: Vector, rng: np.random.Generator) -> Vector:
    """Return random positions of the arm inside its limits; within half a turn without limits."""
    lower, upper = _ends(robot)
    lower = np.maximum(lower, start[robot.arm_q] - 0.5 * _TURN)
    upper = np.minimum(upper, start[robot.arm_q] + 0.5 * _TURN)
    return np.asarray(rng.uniform(np.minimum(lower, upper), np.maximum(lower, upper)))


def _ends(robot: RobotModel) -> tuple[Vector, Vector]:
    """Return the lower and the upper position limits of the arm, shape (n_arm,) each."""
    return robot.limits.position_lower[robot.arm], robot.limits.position_upper[robot.arm]


def _error(robot: RobotModel, place: int, pose: Pose, q: Vector) -> tuple[Vector, Matrix]:
    """Return the error of a frame, shape (6,), and its Jacobian on the arm, shape (6, n_arm)."""
    actual, jacobian = robot.at(q, place)
    turn = actual.rotation @ log3(actual.rotation.T @ pose.rotation)
    return np.concatenate((pose.position - actual.position, turn)), jacobian[:, robot.arm]


def _solve(robot: RobotModel, place: int, pose: Pose, q: Vector, tolerance: float) -> bool:
    """Move the arm in q until the frame is at the pose, in place; return whether it is there.

    Joints at a limit that a step would push further out are left out of that step.
    """
    arm, (lower, upper) = robot.arm_q, _ends(robot)
    q[arm] = np.clip(q[arm], lower, upper)
    for _ in range(_STEPS):
        error, jacobian = _error(robot, place, pose, q)
        if np.abs(error).max() <= tolerance:
            return True
        damping = _DAMPING * float(error @ error) * np.eye(6) + 1e-12 * np.eye(6)
        free = np.ones(jacobian.shape[1], dtype=np.bool_)
        for _ in range(len(free)):
            used = jacobian * free
            step = used.T @ np.linalg.solve(used @ used.T + damping, error)
            out = free & (
                (q[arm] + step < lower - 1e-12) & (q[arm] <= lower)
                | (q[arm] + step > upper + 1e-12) & (q[arm] >= upper)
            )
            if not out.any():
                break
            free &= ~out
        step *= min(1.0, _LONGEST / max(float(np.abs(step).max(initial=0.0)), 1e-12))
        q[arm] = np.clip(q[arm] + step, lower, upper)
    return False


def _unwound(robot: RobotModel, q: Vector, start: Vector) -> Vector:
    """Return q with joints turned back by whole turns, as near to ``start`` as limits let them."""
    near, ends = q.copy(), zip(*_ends(robot), strict=True)
    places = range(robot.arm_q.start, robot.arm_q.stop)
    for j, slides, (lower, upper) in zip(places, robot.prismatic[robot.arm], ends, strict=True):
        if slides:
            continue
        turns = np.round((start[j] - q[j]) / _TURN)
        for k in (turns, turns - np.sign(turns)):
            there = q[j] + k * _TURN
            if lower <= there <= upper:
                near[j] = there
                break
    return near
