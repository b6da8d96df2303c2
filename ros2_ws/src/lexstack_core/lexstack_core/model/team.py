"""All robots of a scenario, stacked in the configured order: what chi is about."""

from __future__ import annotations

import numpy as np

from lexstack_core.bounds import JointLimits
from lexstack_core.config.resolved import ResolvedScenario
from lexstack_core.errors import ConfigurationError
from lexstack_core.linear import Vector
from lexstack_core.model.kinematics import Kinematics, Pose
from lexstack_core.model.robot import RobotModel
from lexstack_core.state import RobotState


class Team:
    """The robots, and which part of chi belongs to whom.

    Attributes:
        robots: in the configured order.
        names: their names.
        slices: each robot's part of chi.
        n: length of chi.
        limits: of all joints, shape (n,) each.
    """

    def __init__(self, robots: tuple[RobotModel, ...]) -> None:
        """Stack the robots; their names must differ."""
        self.robots = robots
        self.names = tuple(robot.name for robot in robots)
        if len(set(self.names)) != len(robots):
            raise ConfigurationError(f"robots: names must differ, got {', '.join(self.names)}")
        ends = np.cumsum([robot.n for robot in robots])
        self.slices = tuple(
            slice(int(end) - robot.n, int(end)) for end, robot in zip(ends, robots, strict=True)
        )
        self.n = int(ends[-1])
        self.limits = JointLimits(
            *(
                np.concatenate([getattr(robot.limits, name) for robot in robots])
                for name in (
                    "position_lower",
                    "position_upper",
                    "velocity",
                    "acceleration",
                    "jerk",
                )
            )
        )

    @classmethod
    def from_scenario(cls, resolved: ResolvedScenario) -> Team:
        """Return the team of a scenario."""
        return cls(
            tuple(
                RobotModel(name, resolved.robots[place.model])
                for name, place in resolved.scenario.robots.items()
            )
        )

    def index(self, name: str) -> int:
        """Return a robot's place in the order; raises ConfigurationError listing the known."""
        if name not in self.names:
            raise ConfigurationError(f"unknown robot {name!r}; known: {', '.join(self.names)}")
        return self.names.index(name)

    def home(self, resolved: ResolvedScenario) -> Vector:
        """Return the configuration at which the scenario starts, shape (n,)."""
        return np.concatenate(
            [robot.home(resolved.scenario.robots[robot.name].base) for robot in self.robots]
        )

    def tools(self, q: Vector) -> tuple[Pose, ...]:
        """Return each robot's tool pose at the stacked configuration q, shape (n,)."""
        return tuple(
            robot.tool(q[part])[0] for robot, part in zip(self.robots, self.slices, strict=True)
        )

    def kinematics(self, state: RobotState) -> Kinematics:
        """Return poses and Jacobians at the measured configuration of ``state``."""
        results = [
            robot.tool(state.q[part]) for robot, part in zip(self.robots, self.slices, strict=True)
        ]
        return Kinematics(
            state, tuple(pose for pose, _ in results), tuple(jacobian for _, jacobian in results)
        )
