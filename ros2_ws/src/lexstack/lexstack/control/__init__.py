"""The controller, the stack solver, and both with a plant: one tick as a library call."""

from typing import TYPE_CHECKING

from lexstack import on_demand

if TYPE_CHECKING:
    from lexstack.control.command_in_force import CommandRules
    from lexstack.control.controller import Command, Controller
    from lexstack.control.factory import make_controller, make_stack_solver
    from lexstack.control.lockstep import ExactPlant, Link, Lockstep, Plant
    from lexstack.control.planning import Track, track, track_base, track_joints
    from lexstack.control.record import Record
    from lexstack.control.solve import HqpController, HqpResult, solve_hqp
    from lexstack.control.stack_solver import StackSolver, share
else:
    __getattr__ = on_demand(
        __name__,
        {
            "command_in_force": "CommandRules",
            "controller": "Command Controller",
            "factory": "make_controller make_stack_solver",
            "lockstep": "ExactPlant Link Lockstep Plant",
            "planning": "Track track track_base track_joints",
            "record": "Record",
            "solve": "HqpController HqpResult solve_hqp",
            "stack_solver": "StackSolver share",
        },
    )

__all__ = [
    "Command",
    "CommandRules",
    "Controller",
    "ExactPlant",
    "HqpController",
    "HqpResult",
    "Link",
    "Lockstep",
    "Plant",
    "Record",
    "StackSolver",
    "Track",
    "make_controller",
    "make_stack_solver",
    "share",
    "solve_hqp",
    "track",
    "track_base",
    "track_joints",
]
