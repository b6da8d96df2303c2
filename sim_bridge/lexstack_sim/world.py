"""The MuJoCo world, generated in memory from the robots' pinocchio models.

Nothing goes through XML, whose rounding costs nine digits: kinematics, mass matrix and gravity of
the two models agree to 1e-9 (they are one model, written down twice).
"""

from __future__ import annotations

import mujoco
import numpy as np
import pinocchio as pin

from lexstack.errors import ModelError
from lexstack.robots import BASE_JOINTS, RobotModel, Team, along_axes, slides
from lexstack.types import Vector
from lexstack_sim.contacts import add_contacts, add_self_contacts, compiled
from lexstack_sim.coordinates import following, joint_name
from lexstack_sim.obstacles import add_obstacles
from lexstack_sim.visuals import add_scene, add_visuals

PHYSICS_PERIOD = 0.001
"""Length of a physics step [s]: T(40) runs at 1 kHz."""

STOP_MARGIN = np.deg2rad(1.0)
"""How far the stops of joints that turn lie outside their position limits [rad] (assumed)."""

SLIDE_STOP_MARGIN = 0.002
"""The same of prismatic joints [m] (assumed)."""

MASSLESS = 1e-14
"""Mass [kg] and inertia [kg m2] of a body in whose place the URDF has none: MuJoCo asks for some.

It is far below the rounding of any mass matrix; what keeps such a joint's own motion well posed is
its armature, without which a robot is refused.
"""

_LEAST = 1e-9  # kg m2, kg: what a joint must move at least, armature included
_RIGID = (0.9999, 0.9999, 0.001, 0.5, 2.0)  # solimp of what mimics: as stiff as MuJoCo has it


def build_world(team: Team, *, visuals: bool = False) -> mujoco.MjModel:
    """Return the world of a team and its obstacles; ``Coordinates`` says where its joints are.

    Controls are in the order of q.

    Args:
        team: the robots.
        visuals: add what only the eye needs (floor, lights, detailed meshes); the motion is the
            same with and without.

    Raises:
        ModelError: a joint is not one of one coordinate, or moves no mass and has no armature.
    """
    spec = mujoco.MjSpec()
    _set_options(spec, team.robots[0].pinocchio)
    for i, robot in enumerate(team.robots):
        _check_mass(robot)
        bodies = _add_bodies(spec, robot)
        contacts = add_contacts(spec, robot, bodies, i)
        add_self_contacts(spec, robot, contacts)
        if visuals:
            add_visuals(spec, robot, bodies, i)
        _add_actuators(spec, robot)
        _add_mimics(spec, robot)
    add_obstacles(spec, team.obstacles)
    if visuals:
        add_scene(spec)
    model = compiled(spec, team)
    _set_unusual_inertias(model, team)
    return model


def body_name(robot: RobotModel, joint: int) -> str:
    """Return the name of the body that moves with a pinocchio joint: its first link's."""
    model = robot.pinocchio
    for frame in model.frames:
        if frame.parentJoint == joint and frame.type == pin.FrameType.BODY:
            return f"{robot.name}/{frame.name}"
    return f"{robot.name}/{model.names[joint]}"


def _check_mass(robot: RobotModel) -> None:
    """Raise ModelError unless the mass matrix at home is positive definite."""
    mass = robot.mass_matrix(robot.home())
    for name, moved in zip(robot.joints, np.diag(mass), strict=True):
        if moved < _LEAST:
            raise ModelError(
                f"robot {robot.name}: joint {name}: moves no mass and has no armature, "
                "so it cannot be simulated"
            )
    least, vectors = np.linalg.eigh(mass)
    if least[0] <= 0.0:
        name = robot.joints[int(np.abs(vectors[:, 0]).argmax())]
        raise ModelError(
            f"robot {robot.name}: joint {name}: the inertias of the links that it moves are "
            "impossible: the mass matrix is not positive definite"
        )


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
    """Add one body per pinocchio joint; return them by joint number, that of the ground at 0.

    A platform's x and y, which carry no link, become further joints of the body that yaws: MuJoCo
    applies a body's joints in order, slides before the hinge move along the world's axes.
    """
    model = robot.pinocchio
    ground = spec.worldbody
    if not robot.has_base:
        ground = ground.add_body(name=f"{robot.name}/mounting")  # contacts tell robots by bodies
    bodies: dict[int, mujoco.MjsBody] = {0: ground}
    sliding: list[int] = []
    armature = _armatures(robot)
    for joint in range(1, model.njoints):
        if model.names[joint] in BASE_JOINTS[:2] and robot.has_base:
            sliding.append(joint)
            continue
        first = sliding[0] if sliding else joint
        place = model.jointPlacements[first]
        body = bodies[model.parents[first]].add_body(
            name=body_name(robot, joint), pos=place.translation, quat=wxyz(place.rotation)
        )
        for each in (*sliding, joint):
            _add_joint(body, robot, each, armature[each - 1])
        _set_inertia(body, model.inertias[joint])
        bodies[joint] = body
        sliding = []
    return bodies


def _armatures(robot: RobotModel) -> Vector:
    """Return the armature of each joint of the pinocchio model, kg m2 or kg.

    A joint shares its own with those that mimic it, as their ratios reflect it: the mass matrix of
    the controlled joints is the same, and none of them is almost massless by itself, with which
    MuJoCo's constraints would not hold it well.
    """
    armature = np.array(robot.pinocchio.armature)
    if robot.map is None:
        return armature
    matrix, names = robot.map.matrix, list(robot.pinocchio.names[1:])
    for i, name in enumerate(robot.coordinates):
        own = names.index(name)
        moved = [row for row in np.flatnonzero(matrix[:, i]) if row != own]
        share = armature[own] / (1 + len(moved))
        for row in moved:
            armature[row] = share / matrix[row, i] ** 2
            armature[own] -= share
    return armature


def _add_joint(body: mujoco.MjsBody, robot: RobotModel, joint: int, armature: float) -> None:
    """Add one joint; a controlled one has mechanical stops where it has position limits."""
    model, name = robot.pinocchio, robot.pinocchio.names[joint]
    kind, axis = _motion(robot, joint)
    added = body.add_joint(name=joint_name(robot, name), type=kind, axis=axis, armature=armature)
    if name not in robot.joints:
        return  # it mimics one that has them, or is a base's
    index = robot.joints.index(name)
    lower, upper = robot.limits.position_lower[index], robot.limits.position_upper[index]
    if np.isfinite(lower) and np.isfinite(upper):
        added.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        margin = SLIDE_STOP_MARGIN if slides(model, joint) else STOP_MARGIN
        added.range = lower - margin, upper + margin


def _motion(robot: RobotModel, joint: int) -> tuple[mujoco.mjtJoint, Vector]:
    """Return whether a joint slides or turns, and its axis in its own frame."""
    model = robot.pinocchio
    if model.joints[joint].nq != 1:
        kind = model.joints[joint].shortname()
        raise ModelError(f"robot {robot.name}: joint {model.names[joint]}: no {kind} here")
    # In the joint's own frame its Jacobian is its axis, without any rounding.
    jacobian = pin.computeJointJacobian(model, model.createData(), pin.neutral(model), joint)
    motion = jacobian[:, model.joints[joint].idx_v]
    if slides(model, joint):
        return mujoco.mjtJoint.mjJNT_SLIDE, motion[:3]
    return mujoco.mjtJoint.mjJNT_HINGE, motion[3:]


def _set_inertia(body: mujoco.MjsBody, inertia: pin.Inertia) -> None:
    """Copy mass, centre of mass and inertia (about the centre of mass, body axes)."""
    body.explicitinertial = True
    if not _usual(inertia):
        body.mass, body.ipos = MASSLESS, (0.0, 0.0, 0.0)
        body.fullinertia = [MASSLESS, MASSLESS, MASSLESS, 0.0, 0.0, 0.0]
        return
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


def _usual(inertia: pin.Inertia) -> bool:
    """Return whether MuJoCo's compiler takes an inertia: a body of some size can have it."""
    moments = np.linalg.eigvalsh(inertia.inertia)
    return bool(
        inertia.mass >= MASSLESS
        and moments[0] >= MASSLESS
        and moments[0] + moments[1] >= moments[2] * (1.0 + 1e-9)
    )


def _set_unusual_inertias(world: mujoco.MjModel, team: Team) -> None:
    """Write into a compiled world the inertias that its compiler refuses.

    Point masses, and what URDFs have that no body can have: the mass matrix of all decides whether
    they can be simulated, and it was checked.
    """
    changed = False
    for robot in team.robots:
        for joint in range(1 + 2 * robot.has_base, robot.pinocchio.njoints):
            inertia = robot.pinocchio.inertias[joint]
            if not _usual(inertia) and (inertia.mass or inertia.inertia.any()):
                set_inertia(world, world.body(body_name(robot, joint)).id, inertia)
                changed = True
    if changed:
        mujoco.mj_setConst(world, mujoco.MjData(world))


def set_inertia(world: mujoco.MjModel, body: int, inertia: pin.Inertia) -> None:
    """Give a body of a compiled world another inertia; ``mj_setConst`` is to be called then."""
    moments, axes = np.linalg.eigh(inertia.inertia)
    if np.linalg.det(axes) < 0.0:
        axes[:, 0] *= -1.0
    world.body_mass[body] = inertia.mass
    world.body_ipos[body] = inertia.lever
    world.body_iquat[body] = wxyz(axes)
    world.body_inertia[body] = moments


def _add_actuators(spec: mujoco.MjSpec, robot: RobotModel) -> None:
    """Add velocity servos with force limits to the base, plain torques to the arm."""
    base, arm = robot.config.base, robot.config.arm
    gains = () if base is None else along_axes(base.servo_gain)
    forces = (*(() if base is None else along_axes(base.servo_force)), *arm.torque)
    for i, joint in enumerate(robot.coordinates):
        name = joint_name(robot, joint)
        actuator = spec.add_actuator(
            name=name,
            target=name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            forcelimited=mujoco.mjtLimited.mjLIMITED_TRUE,
            forcerange=(-forces[i], forces[i]),
        )
        if i < len(gains):
            actuator.set_to_velocity(kv=gains[i])
        else:
            actuator.set_to_motor()


def _add_mimics(spec: mujoco.MjSpec, robot: RobotModel) -> None:
    """Let mimicking joints follow: by a constraint on forces; the plant keeps positions exact."""
    if robot.map is None:
        return
    for row in following(robot):
        (leader,) = np.flatnonzero(robot.map.matrix[row])
        equality = spec.add_equality(
            name=joint_name(robot, robot.pinocchio.names[1 + row]),
            type=mujoco.mjtEq.mjEQ_JOINT,
            objtype=mujoco.mjtObj.mjOBJ_JOINT,
            name1=joint_name(robot, robot.pinocchio.names[1 + row]),
            name2=joint_name(robot, robot.coordinates[leader]),
            solref=(2.0 * PHYSICS_PERIOD, 1.0),
            solimp=_RIGID,
        )
        equality.data[:2] = robot.map.offset[row], robot.map.matrix[row, leader]


def wxyz(rotation: Vector) -> Vector:
    """Return a rotation matrix as a quaternion in MuJoCo's order."""
    x, y, z, w = pin.Quaternion(rotation).coeffs()
    return np.array([w, x, y, z])
