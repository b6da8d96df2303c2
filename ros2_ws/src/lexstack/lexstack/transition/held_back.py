"""Whether the target stack asks for more than the velocity limits allow: reported once.

A level may be regular, and solved strictly, and still ask for joint velocities beyond the limits,
because a direction that it needs is nearly lost. The source's chi is then cut off at the velocity
limits. When it leaves them its acceleration jumps, and the command follows within its own limits.
"""

from __future__ import annotations

import numpy as np

from lexstack.hqp import NEAR
from lexstack.hqp.rank_revealing_qr import factorise
from lexstack.transition.robot_group import RobotGroup
from lexstack.types import LinearTask, Vector

HELD_BACK = 0.25
"""m or 1: with a smaller singular value, a level that is cut off by velocity limits is reported."""

_AT_LIMIT = 1.0 - 1e-6  # of a velocity limit
_RANK = 1e-8  # of a level's norm, as in the solver
_PART = 0.3  # of the unit vector of a weak direction: joints that have less are not named


def at_velocity_limit(group: RobotGroup, chi: Vector, velocity: Vector) -> bool:
    """Return whether a joint of some robots is at its velocity limit in a chi of shape (n,).

    Args:
        group: the robots.
        chi: of a source.
        velocity: the limits, shape (n,).
    """
    mine = group.columns
    return bool((np.abs(chi[mine]) >= _AT_LIMIT * velocity[mine]).any())


def held_back(
    group: RobotGroup, levels: tuple[tuple[LinearTask, ...], ...], velocity: Vector
) -> str:
    """Return which level asks for more than the velocity limits near a singularity, or ''.

    Of each level the smallest singular value counts in the directions that the levels above leave
    free, and the optimum without any limits. Inequality rows are left out.

    Args:
        group: the robots that the levels move.
        levels: of the stack, the highest first.
        velocity: the limits, shape (n,).
    """
    mine, names = group.columns, group.team.joint_names
    joints = np.arange(group.team.n)[mine]
    free, chi = np.eye(joints.size), np.zeros(joints.size)
    for k, level in enumerate(levels):
        equal = [(task, task.lower == task.upper) for task in level]
        rows = np.concatenate([task.matrix[kept][:, mine] for task, kept in equal])
        target = np.concatenate([task.lower[kept] for task, kept in equal])
        norm = float(np.linalg.norm(rows))
        if not norm or not free.shape[1]:
            continue
        reduced = rows.dot(free)
        factor = factorise(reduced, _RANK * norm)
        chi = chi + free.dot(factor.solve(target - rows.dot(chi)))
        if len(rows) <= free.shape[1]:
            _, sigma, right = np.linalg.svd(reduced, full_matrices=False)
            weak = np.abs(right[sigma < HELD_BACK].dot(free.T)) >= _PART
            over = np.where(weak.any(axis=0), np.abs(chi) / velocity[mine], 0.0)
            place = int(over.argmax())
            if over[place] > 1.0:
                joint = joints[place]
                robot = next(one for one in group.team.slices if one.start <= joint < one.stop)
                which = " + ".join(task.name for task in level if task.matrix[:, robot].any())
                least = sigma[weak[:, place].argmax() + np.count_nonzero(sigma >= HELD_BACK)]
                return (
                    f"{NEAR}: level {k + 1}: {which} (sigma {least:.2g}) asks for "
                    f"{over[place]:.2g} times the velocity limit of {names[joint]}, "
                    "so this transition may need all acceleration that the limits allow"
                )
        free = free.dot(factor.null)
    return ""
