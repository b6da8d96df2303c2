"""The controller, the stack solver, and both with a plant: one tick as a library call."""

from typing import TYPE_CHECKING

from lexstack import on_demand

if TYPE_CHECKING:
    from lexstack.control.controller import Command, Controller
    from lexstack.control.factory import make_controller, make_stack_solver
    from lexstack.control.lockstep import ExactPlant, Link, Lockstep, Plant
    from lexstack.control.stack_solver import StackSolver, share
else:
    __getattr__ = on_demand(
        __name__,
        {
            "controller": "Command Controller",
            "factory": "make_controller make_stack_solver",
            "lockstep": "ExactPlant Link Lockstep Plant",
            "stack_solver": "StackSolver share",
        },
    )

__all__ = [
    "Command",
    "Controller",
    "ExactPlant",
    "Link",
    "Lockstep",
    "Plant",
    "StackSolver",
    "make_controller",
    "make_stack_solver",
    "share",
]
