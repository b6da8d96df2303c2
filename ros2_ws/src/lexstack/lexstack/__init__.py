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
        Lockstep,
        StackSolver,
        make_controller,
        make_stack_solver,
    )
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
        Htmpc,
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
        DifferentialConfig,
        Kinematics,
        ObstacleConfig,
        Obstacles,
        Pose,
        RobotConfig,
        RobotModel,
        Team,
        mobile_manipulator,
        robot_from_urdf,
    )
    from lexstack.tasks import (
        TASKS,
        Level,
        LevelConfig,
        Stack,
        StackConfig,
        Task,
        TaskConfig,
        build_stack,
        register_task,
    )
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
            "control": "Command Controller ExactPlant Lockstep StackSolver "
            "make_controller make_stack_solver",
            "errors": "ConfigurationError InputError LexstackError ModelError",
            "hqp": "SOLVERS HqpProblem HqpSolver Solution Status describe "
            "explain_unmet_levels make_solver register_solver",
            "limits": "Bounds JointLimits LimitOptions LimitsInForce viable_bounds",
            "mpc": "DEFAULT_HTMPC HT_ARCH ST_ARCH Htmpc HtmpcConfig Objective OtherRobot "
            "Plan SequenceRunner SequenceTask Start CollisionScene",
            "references": "MotionLimits ReferenceSchedule References Spline Target Trajectory "
            "Twist Waypoints base_spline timed_waypoints",
            "robots": "BaseConfig DifferentialConfig Kinematics ObstacleConfig Obstacles Pose "
            "RobotConfig RobotModel Team mobile_manipulator robot_from_urdf",
            "tasks": "TASKS Level LevelConfig Stack StackConfig Task TaskConfig build_stack "
            "register_task",
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
    "BaseConfig",
    "Bounds",
    "CollisionScene",
    "Command",
    "ConfigurationError",
    "Controller",
    "DifferentialConfig",
    "ExactPlant",
    "HqpProblem",
    "HqpSolver",
    "Htmpc",
    "HtmpcConfig",
    "InputError",
    "JointLimits",
    "Kinematics",
    "Level",
    "LevelConfig",
    "LexstackError",
    "LimitOptions",
    "LimitsInForce",
    "LinearTask",
    "Lockstep",
    "Matrix",
    "ModelError",
    "MotionLimits",
    "Objective",
    "ObstacleConfig",
    "Obstacles",
    "OtherRobot",
    "Phase",
    "Plan",
    "Pose",
    "ReferenceSchedule",
    "References",
    "RobotConfig",
    "RobotModel",
    "RobotState",
    "SequenceRunner",
    "SequenceTask",
    "Solution",
    "SourceSample",
    "SourceSchedule",
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
    "Trajectory",
    "Transition",
    "TransitionConfig",
    "TransitionOptions",
    "TransitionState",
    "Twist",
    "Vector",
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
    "timed_waypoints",
    "viable_bounds",
]
