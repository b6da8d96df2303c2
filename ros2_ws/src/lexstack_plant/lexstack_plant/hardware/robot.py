"""One robot behind its topics: what is measured of it, and what it is sent."""

from __future__ import annotations

import numpy as np

from lexstack.limits import LIMITS, JointLimits
from lexstack.robots import RobotModel, along_axes, arc
from lexstack.types import Vector
from lexstack_config.plant_file import RobotInterfaceConfig, SafetyConfig
from lexstack_plant.hardware.base_intake import BaseIntake
from lexstack_plant.hardware.effort import EffortLoop
from lexstack_plant.hardware.joint_intake import JointIntake
from lexstack_plant.hardware.outputs import (
    ArmOutput,
    RobotCommand,
    differential_twist,
    holonomic_twist,
)
from lexstack_plant.hardware.planar import turned


class HardwareRobot:
    """The intakes and the output of one robot.

    Attributes:
        name: of the robot.
        model: of it.
        joints: what is measured of its arm.
        base: what is measured of its platform; None: it has none.
        output: what its arm is sent.
        effort: what makes the torques of an arm that takes them.
        names: of the arm's joints in messages, in the order of chi.
        unheard: which of its commands nobody hears, and what to do; '': all are heard. It is set
            by whoever sends them.
        pressed: whether its emergency stop is pressed.
    """

    def __init__(
        self,
        robot: RobotModel,
        config: RobotInterfaceConfig,
        safety: SafetyConfig,
        dt: float,
        hold: int,
        *,
        shared: bool = False,
    ) -> None:
        """Make the robot.

        Args:
            robot: its model.
            config: its topics.
            safety: tolerances.
            dt: control period [s].
            hold: ticks that a trajectory goes on alone.
            shared: whether stamps are of the local clock, as in simulated time.
        """
        self.name = robot.name
        self.config = config
        self.model = robot
        self._dt = dt
        self._safety = safety
        names = config.joint_states.names
        self.names = tuple(names.get(joint, joint) for joint in robot.joints[robot.arm])
        velocity = robot.limits.velocity
        self.joints = JointIntake(
            self.names,
            velocity[robot.arm],
            safety.position,
            stamps=config.joint_states.stamps,
            shared=shared,
        )
        self.base: BaseIntake | None = None
        if config.base is not None:
            self.base = BaseIntake(
                np.array(along_axes(tuple(velocity[robot.base].tolist()))),
                safety.position,
                origin=config.base.origin,
                frame=config.base.frame if config.base.odometry is not None else "",
                twist_in_base=config.base.twist_axes == "base",
                shared=shared,
                twist_apart=config.base.tf is not None and config.base.odometry is not None,
            )
        self.output = ArmOutput(config.arm, _part(robot.limits, robot.arm), dt, hold)
        self.effort: EffortLoop | None = None
        if config.arm.type == "effort":
            self.effort = EffortLoop(robot, holds_weight=config.arm.gravity)
        self.unheard = ""
        self.pressed = False

    def measured(self, now: float) -> tuple[Vector, Vector]:
        """Return q (nq,) and v (n,) now; NaN where nothing is known."""
        most = self._safety.stale
        arm = self.joints.at(now, most)
        if self.base is None:
            return arm, self.joints.v
        pose, velocity = self.base.at(now, most), self.base.v
        if self.model.differential:
            pose, velocity = self._driven(self.base, now - self.base.time)
        return np.concatenate([pose, arm]), np.concatenate([velocity, self.joints.v])

    def _driven(self, base: BaseIntake, elapsed: float) -> tuple[Vector, Vector]:
        """Return where a differential base is ``elapsed`` [s] later, (3,), and v and w, (2,).

        What it slides to its side is in the poses alone.
        """
        chi = turned(base.v, -float(base.q[2]))[[0, 2]]
        on = min(max(elapsed, 0.0), self._safety.stale)
        return arc(base.q, float(chi[0]), float(chi[1]), on), chi

    def stale(self, now: float) -> str:
        """Return what of the robot is not known or too old, or ''."""
        most = self._safety.stale
        missing = self.joints.missing()
        if missing:
            return (
                f"{self.name}: no state of {', '.join(missing)} on {self.config.joint_states.topic}"
            )
        age = self.joints.age(now)
        if age > most:
            return f"{self.name}: joint states are {1e3 * age:.0f} ms old, at most {1e3 * most:.0f}"
        if self.base is None:
            return ""
        age = self.base.age(now)
        if age == np.inf:
            return f"{self.name}: no {self._unknown(self.base)}"
        return (
            f"{self.name}: the base's pose is {1e3 * age:.0f} ms old, at most {1e3 * most:.0f}"
            if age > most
            else ""
        )

    def _unknown(self, base: BaseIntake) -> str:
        """Return what is not known of the platform, and where it should come from."""
        assert self.config.base is not None
        odometry, tf = self.config.base.odometry, self.config.base.tf
        if base.time > -np.inf:
            return f"velocity of its base on {odometry}"
        if tf is not None:
            return f"pose of its base: {tf.frame!r} in {tf.parent!r} on {tf.topic}"
        return f"pose of its base on {odometry}"

    def wrong(self, now: float) -> str:
        """Return why the robot may not move, as far as one looks at it alone, or ''."""
        if self.pressed:
            return f"{self.name}: the emergency stop is pressed"
        if self.unheard:
            return f"{self.name}: {self.unheard}"
        faults = [self.joints.fault, self.base.fault if self.base is not None else ""]
        fault = next((each for each in faults if each), "")
        return f"{self.name}: {fault}" if fault else self.stale(now)

    def in_flight(self, chi: Vector) -> Vector:
        """Return how far commands that were sent will still move the robot along chi, shape (n,).

        Args:
            chi: in force, shape (n,): a platform, and an arm that is led by velocities, has it
                before it for one period.
        """
        result = self._dt * chi
        result[self.model.arm] = self.output.in_flight(chi[self.model.arm])
        return result

    def forget(self) -> None:
        """Take what is measured next as the truth, whatever was before."""
        self.joints.forget()
        if self.base is not None:
            self.base.forget()

    def begin(self, q: Vector, v: Vector) -> None:
        """Begin to be commanded at q (nq,), moving at v (n,)."""
        self.output.begin(q[self.model.arm_q], v[self.model.arm])
        if self.effort is not None:
            self.effort.begin(q)

    def push(self, chi: Vector) -> None:
        """Take the command of a tick, shape (n,), whether it is sent or not."""
        self.output.push(chi[self.model.arm])

    def command(self, chi: Vector, q: Vector, due: float) -> RobotCommand:
        """Return what is to be sent for chi (n,) at the configuration q (nq,)."""
        twist, model = None, self.model
        if self.base is not None and model.differential:
            twist = differential_twist(chi[model.base])
        elif self.base is not None:
            twist = holonomic_twist(chi[model.base], float(q[2]), self._dt)
        arm = chi[model.arm]
        return RobotCommand(due, self.output.points(), self.output.values(arm), twist)


def _part(limits: JointLimits, joints: slice) -> JointLimits:
    """Return the limits of some joints."""
    return JointLimits(**{name: getattr(limits, name)[joints] for name in LIMITS})
