"""What each joint of a robot moves, from which the gains of its torque loop follow."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from lexstack.robots.mimics import followed
from lexstack.robots.urdf import Description
from lexstack.types import Vector

BANDWIDTH = 30.0
"""Of the torque loop by default [rad/s]: K_qp = m BANDWIDTH^2, with m of ``joint_inertias``."""

DAMPING_RATIO = 1.0
"""By default K_qd = 2 DAMPING_RATIO sqrt(K_qp m)."""

_LEAST = 1e-6  # kg m2, kg: of a joint that moves next to nothing


def joint_inertias(
    urdf: Description,
    home: Mapping[str, float],
    fixed: Mapping[str, float],
    armature: Mapping[str, float],
) -> dict[str, float]:
    """Return what each controlled joint moves at home while the others are free, kg m2 or kg.

    That is m_j = 1 / (M^-1)_jj of the mass matrix M, armatures included. Since the trace of
    M^-1 diag(m) is n, a damping of 2 w m_j stays stable in a loop of period T if w n T < 1, however
    the joints are coupled; with the diagonal of M in place of m_j it need not.

    Args:
        urdf: the whole description.
        home: of the controlled joints, rad or m.
        fixed: where the others are held, but for those that follow one.
        armature: of the controlled joints, kg m2 or kg.
    """
    model, joints = urdf.model, list(home)
    held = {**fixed, **home}
    mimics = {name: mimic for name, mimic in urdf.mimics.items() if name not in fixed}
    q, slopes = pin.neutral(model), np.zeros((model.nv, len(joints)))
    for i in range(1, model.njoints):
        name, at = model.names[i], model.joints[i].idx_v
        if name in mimics:
            leader = followed(name, mimics)
            q[at] = leader.multiplier * held[leader.joint] + leader.offset
            name, ratio = leader.joint, leader.multiplier
        else:
            q[at], ratio = held[name], 1.0
        if name in home:
            slopes[at, joints.index(name)] = ratio
    upper = np.triu(pin.crba(model, model.createData(), q))
    full = upper + np.triu(upper, 1).T
    mass = slopes.T @ full @ slopes + np.diag([max(armature[name], _LEAST) for name in joints])
    moved: Vector = 1.0 / np.diag(np.linalg.inv(mass))
    return dict(zip(joints, np.maximum(moved, _LEAST).tolist(), strict=True))
