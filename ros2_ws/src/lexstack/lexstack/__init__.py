"""Strict hierarchical QP control of teams of mobile manipulators, and smooth changes of its tasks.

``import lexstack`` gives the names below; each is loaded when it is first used, so that a program
pays for what it needs. The sub-packages have more of their subjects: ``lexstack.hqp``, ``limits``,
``robots``, ``references``, ``tasks``, ``transition``, ``mpc`` and ``control``.
"""

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import TYPE_CHECKING

__version__ = "0.1.0"


def on_demand(package: str, names: Mapping[str, str]) -> Callable[[str], object]:
    """Return the ``__getattr__`` of a package that imports its names when they are asked for.

    Args:
        package: its name.
        names: public names, with spaces between them, by the module of the package that has them.
    """
    homes = {name: module for module, several in names.items() for name in several.split()}

    def load(name: str) -> object:
        if name not in homes:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        here = import_module(package)
        value = getattr(import_module(f"{package}.{homes[name]}"), name)
        setattr(here, name, value)  # found without this function from now on
        return value

    return load


if TYPE_CHECKING:
    from lexstack.control import (
        Command,
        Controller,
        ExactPlant,
        HqpController,
        HqpResult,
        Record,
        StackSolver,
        Track,
        make_controller,
        make_stack_solver,
        solve_hqp,
        track,
        track_base,
        track_joints,
    )
    from lexstack.control.planning import Htmpc
    from lexstack.control.run import Lockstep
    from lexstack.errors import ConfigurationError, InputError, LexstackError, ModelError
    from lexstack.hqp import (
        SOLVERS,
        HqpProblem,
        HqpSolver,
        Solution,
        Status,
        describe,
        explain_unmet_levels,
        make_solver,
        register_solver,
    )
    from lexstack.limits import Bounds, JointLimits, LimitOptions, LimitsInForce, viable_bounds
    from lexstack.mpc import (
        DEFAULT_HTMPC,
        HT_ARCH,
        ST_ARCH,
        CollisionScene,
        HtmpcConfig,
        Objective,
        OtherRobot,
        Plan,
        SequenceRunner,
        SequenceTask,
        Start,
    )
    from lexstack.references import (
        MotionLimits,
        References,
        ReferenceSchedule,
        Spline,
        Target,
        Trajectory,
        Twist,
        Waypoints,
        base_spline,
        timed_waypoints,
    )
    from lexstack.robots import (
        BaseConfig,
        Configuration,
        DifferentialConfig,
        Kinematics,
        ObstacleConfig,
        Obstacles,
        Pose,
        Robot,
        RobotConfig,
        RobotModel,
        SphereConfig,
        Team,
        mobile_manipulator,
        robot_from_urdf,
    )
    from lexstack.tasks import (
        TASKS,
        JointLimitConfig,
        Level,
        LevelConfig,
        StackConfig,
        Task,
        TaskConfig,
        build_stack,
        register_task,
    )
    from lexstack.tasks.specs.bodies import (
        BasePose,
        CentreOfMass,
        JointCoupling,
        Manipulability,
        Posture,
        RelativePose,
        VelocityDamping,
    )
    from lexstack.tasks.specs.directed import (
        AxisAlignment,
        CollisionAvoidance,
        Cone,
        FrameVelocityLimit,
        HalfSpace,
        LookAt,
    )
    from lexstack.tasks.specs.frames import FrameOrientation, FramePose, FramePosition
    from lexstack.tasks.specs.own import OwnTask
    from lexstack.tasks.specs.stack import Stack
    from lexstack.transition import (
        METHODS,
        Announcement,
        Phase,
        SourceSample,
        SourceSchedule,
        Transition,
        TransitionConfig,
        TransitionOptions,
        TransitionState,
        register_method,
    )
    from lexstack.types import LinearTask, Matrix, RobotState, Vector
else:
    __getattr__ = on_demand(
        __name__,
        {
            "control": "Command Controller ExactPlant HqpController HqpResult Record StackSolver "
            "Track make_controller make_stack_solver solve_hqp track track_base "
            "track_joints",
            "control.planning": "Htmpc",
            "control.run": "Lockstep",
            "errors": "ConfigurationError InputError LexstackError ModelError",
            "hqp": "SOLVERS HqpProblem HqpSolver Solution Status describe "
            "explain_unmet_levels make_solver register_solver",
            "limits": "Bounds JointLimits LimitOptions LimitsInForce viable_bounds",
            "mpc": "DEFAULT_HTMPC HT_ARCH ST_ARCH HtmpcConfig Objective OtherRobot "
            "Plan SequenceRunner SequenceTask Start CollisionScene",
            "references": "MotionLimits ReferenceSchedule References Spline Target Trajectory "
            "Twist Waypoints base_spline timed_waypoints",
            "robots": "BaseConfig Configuration DifferentialConfig Kinematics ObstacleConfig "
            "Obstacles Pose Robot RobotConfig RobotModel SphereConfig Team mobile_manipulator "
            "robot_from_urdf",
            "tasks": "TASKS JointLimitConfig Level LevelConfig StackConfig Task TaskConfig "
            "build_stack register_task",
            "tasks.specs.bodies": "BasePose CentreOfMass JointCoupling Manipulability Posture "
            "RelativePose VelocityDamping",
            "tasks.specs.directed": "AxisAlignment CollisionAvoidance Cone FrameVelocityLimit "
            "HalfSpace LookAt",
            "tasks.specs.frames": "FrameOrientation FramePose FramePosition",
            "tasks.specs.own": "OwnTask",
            "tasks.specs.stack": "Stack",
            "transition": "METHODS Announcement Phase SourceSample SourceSchedule "
            "Transition TransitionConfig TransitionOptions TransitionState register_method",
            "types": "LinearTask Matrix RobotState Vector",
        },
    )

__all__ = [
    "DEFAULT_HTMPC",
    "HT_ARCH",
    "METHODS",
    "SOLVERS",
    "ST_ARCH",
    "TASKS",
    "Announcement",
    "AxisAlignment",
    "BaseConfig",
    "BasePose",
    "Bounds",
    "CentreOfMass",
    "CollisionAvoidance",
    "CollisionScene",
    "Command",
    "Cone",
    "Configuration",
    "ConfigurationError",
    "Controller",
    "DifferentialConfig",
    "ExactPlant",
    "FrameOrientation",
    "FramePose",
    "FramePosition",
    "FrameVelocityLimit",
    "HalfSpace",
    "HqpController",
    "HqpProblem",
    "HqpResult",
    "HqpSolver",
    "Htmpc",
    "HtmpcConfig",
    "InputError",
    "JointCoupling",
    "JointLimitConfig",
    "JointLimits",
    "Kinematics",
    "Level",
    "LevelConfig",
    "LexstackError",
    "LimitOptions",
    "LimitsInForce",
    "LinearTask",
    "Lockstep",
    "LookAt",
    "Manipulability",
    "Matrix",
    "ModelError",
    "MotionLimits",
    "Objective",
    "ObstacleConfig",
    "Obstacles",
    "OtherRobot",
    "OwnTask",
    "Phase",
    "Plan",
    "Pose",
    "Posture",
    "Record",
    "ReferenceSchedule",
    "References",
    "RelativePose",
    "Robot",
    "RobotConfig",
    "RobotModel",
    "RobotState",
    "SequenceRunner",
    "SequenceTask",
    "Solution",
    "SourceSample",
    "SourceSchedule",
    "SphereConfig",
    "Spline",
    "Stack",
    "StackConfig",
    "StackSolver",
    "Start",
    "Status",
    "Target",
    "Task",
    "TaskConfig",
    "Team",
    "Track",
    "Trajectory",
    "Transition",
    "TransitionConfig",
    "TransitionOptions",
    "TransitionState",
    "Twist",
    "Vector",
    "VelocityDamping",
    "Waypoints",
    "base_spline",
    "build_stack",
    "describe",
    "explain_unmet_levels",
    "make_controller",
    "make_solver",
    "make_stack_solver",
    "mobile_manipulator",
    "register_method",
    "register_solver",
    "register_task",
    "robot_from_urdf",
    "solve_hqp",
    "timed_waypoints",
    "track",
    "track_base",
    "track_joints",
    "viable_bounds",
]
