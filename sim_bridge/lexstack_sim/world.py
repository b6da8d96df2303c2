"""The MuJoCo world, generated in memory from the robots' pinocchio models.

Nothing goes through XML, whose rounding costs nine digits: kinematics, mass matrix and gravity of
the two models agree to 1e-9 (they are one model, written down twice).
"""

from __future__ import annotations

import mujoco
import numpy as np
import pinocchio as pin

from lexstack.errors import ModelError
from lexstack.robots import RobotModel, Team
from lexstack.types import Vector
from lexstack_sim.contacts import add_contacts, add_self_contacts
from lexstack_sim.obstacles import add_obstacles
from lexstack_sim.visuals import add_scene, add_visuals

PHYSICS_PERIOD = 0.001
"""Length of a physics step [s]: T(40) runs at 1 kHz."""

STOP_MARGIN = np.deg2rad(1.0)
"""How far the stops of joints that turn lie outside their position limits [rad] (assumed)."""

SLIDE_STOP_MARGIN = 0.002
"""The same of prismatic joints [m] (assumed)."""

_AXES: dict[str, tuple[mujoco.mjtJoint, Vector]] = {
    f"JointModel{kind}{axis}": (joint, np.eye(3)[i])
    for kind, joint in (
        ("P", mujoco.mjtJoint.mjJNT_SLIDE),
        ("R", mujoco.mjtJoint.mjJNT_HINGE),
    )
    for i, axis in enumerate("XYZ")
}


def build_world(team: Team, *, visuals: bool = False) -> mujoco.MjModel:
    """Return the world of a team and its obstacles; joints and controls are in chi's order.

    Args:
        team: the robots.
        visuals: add what only the eye needs (floor, lights, detailed meshes); the motion is the
            same with and without.

    Raises:
        ModelError: a model has a joint that is neither prismatic nor revolute about x, y or z.
    """
    spec = mujoco.MjSpec()
    _set_options(spec, team.robots[0].pinocchio)
    for i, robot in enumerate(team.robots):
        bodies = _add_bodies(spec, robot)
        contacts = add_contacts(spec, robot, bodies, i)
        add_self_contacts(spec, contacts)
        if visuals:
            add_visuals(spec, robot, bodies, i)
        _add_actuators(spec, robot)
    add_obstacles(spec, team.obstacles)
    if visuals:
        add_scene(spec)
    model = spec.compile()
    _check_order(model, team)
    return model


def joint_name(robot: RobotModel, joint: str) -> str:
    """Return a joint's name in the world; actuators bear their joint's name."""
    return f"{robot.name}/{joint}"


def body_name(robot: RobotModel, joint: int) -> str:
    """Return the name of the body that moves with a pinocchio joint: its first link's."""
    model = robot.pinocchio
    for frame in model.frames:
        if frame.parentJoint == joint and frame.type == pin.FrameType.BODY:
            return f"{robot.name}/{frame.name}"
    raise ModelError(f"robot {robot.name}: joint {model.names[joint]} moves no link")


def _set_options(spec: mujoco.MjSpec, model: pin.Model) -> None:
    """Set time step, integrator and gravity; inertias come from pinocchio, never from geometry."""
    spec.option.timestep = PHYSICS_PERIOD
    # Stiff velocity servos need velocity-implicit integration.
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    # MuJoCo 4.0.0 has a bug in the sparse Cholesky factorisation.
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    # A diverged simulation must be seen, not silently start again.
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    spec.option.gravity = model.gravity.linear
    spec.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE
    spec.compiler.degree = False
    spec.visual.global_.offwidth, spec.visual.global_.offheight = 1920, 1080


def _add_bodies(spec: mujoco.MjSpec, robot: RobotModel) -> dict[int, mujoco.MjsBody]:
    """Add one body per pinocchio joint that carries mass; return them by joint number.

    Massless joints (the base's x and y) become further joints of the next body: MuJoCo applies a
    body's joints in order, slides before the hinge move along the world's axes.
    """
    model = robot.pinocchio
    bodies: dict[int, mujoco.MjsBody] = {0: spec.worldbody}
    massless: list[int] = []
    for joint in range(1, model.njoints):
        parent = model.parents[joint]
        if model.inertias[joint].mass == 0.0:
            massless.append(joint)
            continue
        root = model.parents[massless[0]] if massless else parent
        place = model.jointPlacements[massless[0] if massless else joint]
        body = bodies[root].add_body(
            name=body_name(robot, joint), pos=place.translation, quat=wxyz(place.rotation)
        )
        for each in (*massless, joint):
            _add_joint(body, robot, each)
        _set_inertia(body, model.inertias[joint])
        bodies[joint] = body
        massless = []
    return bodies


def _add_joint(body: mujoco.MjsBody, robot: RobotModel, joint: int) -> None:
    """Add one joint with armature and, where there are position limits, mechanical stops."""
    model = robot.pinocchio
    shortname = model.joints[joint].shortname()
    if shortname not in _AXES:
        raise ModelError(f"robot {robot.name}: joint {model.names[joint]}: no {shortname} here")
    kind, axis = _AXES[shortname]
    index = model.joints[joint].idx_v
    lower, upper = robot.limits.position_lower[index], robot.limits.position_upper[index]
    added = body.add_joint(
        name=joint_name(robot, robot.joints[index]),
        type=kind,
        axis=axis,
        armature=model.armature[index],
    )
    if np.isfinite(lower) and np.isfinite(upper):
        added.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        margin = SLIDE_STOP_MARGIN if robot.prismatic[index] else STOP_MARGIN
        added.range = lower - margin, upper + margin


def _set_inertia(body: mujoco.MjsBody, inertia: pin.Inertia) -> None:
    """Copy mass, centre of mass and inertia (about the centre of mass, body axes)."""
    matrix = inertia.inertia
    body.mass = inertia.mass
    body.ipos = inertia.lever
    body.fullinertia = [
        matrix[0, 0],
        matrix[1, 1],
        matrix[2, 2],
        matrix[0, 1],
        matrix[0, 2],
        matrix[1, 2],
    ]
    body.explicitinertial = True


def _add_actuators(spec: mujoco.MjSpec, robot: RobotModel) -> None:
    """Add velocity servos with force limits to the base, plain torques to the arm."""
    base, arm = robot.config.base, robot.config.arm
    forces = (*base.servo_force, *arm.torque)
    for i, joint in enumerate(robot.joints):
        name = joint_name(robot, joint)
        actuator = spec.add_actuator(
            name=name,
            target=name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            forcelimited=mujoco.mjtLimited.mjLIMITED_TRUE,
            forcerange=(-forces[i], forces[i]),
        )
        if i < len(base.servo_gain):
            actuator.set_to_velocity(kv=base.servo_gain[i])
        else:
            actuator.set_to_motor()


def _check_order(model: mujoco.MjModel, team: Team) -> None:
    """Raise ModelError unless joints and actuators are chi's, in its order."""
    names = [joint_name(robot, joint) for robot in team.robots for joint in robot.joints]
    joints = [model.joint(i).name for i in range(model.njnt)]
    actuators = [model.actuator(i).name for i in range(model.nu)]
    if joints != names or actuators != names:
        raise ModelError(f"the world's joints {joints} are not chi's: {names}")


def wxyz(rotation: Vector) -> Vector:
    """Return a rotation matrix as a quaternion in MuJoCo's order."""
    x, y, z, w = pin.Quaternion(rotation).coeffs()
    return np.array([w, x, y, z])
