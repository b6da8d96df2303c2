"""The solvers by name: one of the library is its file and one line here."""

from __future__ import annotations

from lexstack.errors import ConfigurationError
from lexstack.hqp.backends.daqp import DaqpCascade
from lexstack.hqp.backends.proxqp import ProxqpCascade
from lexstack.hqp.decoupled_solver import ClusteredSolver
from lexstack.hqp.fallback import FallbackSolver
from lexstack.hqp.kernel.solver import KernelSolver
from lexstack.hqp.problem import HqpSolver, SolverFactory
from lexstack.options import register, unknown

SOLVERS: dict[str, SolverFactory] = {
    "kernel": KernelSolver,
    "daqp": DaqpCascade,
    "proxqp": ProxqpCascade,
}
"""The solvers by the name that a configuration uses; others are added by ``register_solver``."""

DEFAULT_SOLVER = "kernel"
"""The solver of whoever names none."""


def register_solver(name: str, factory: SolverFactory) -> None:
    """Make a solver known by a name; ``factory`` returns a new one.

    Raises:
        ConfigurationError: it is no name, or the name of another solver.
    """
    register(SOLVERS, "solver", name, factory)


def make_solver(name: str = DEFAULT_SOLVER) -> HqpSolver:
    """Return a new solver that takes clusters apart and has another one to fall back on.

    The order of fallback: the named solver; one of another library, without guesses; and then the
    solution says that it failed, on which the controller brakes.

    Raises:
        ConfigurationError: an unknown name; it lists the known ones.
    """
    if name not in SOLVERS:
        raise ConfigurationError(f"hqp: {unknown('solver', name, SOLVERS)}")
    second = DaqpCascade if name == "proxqp" else ProxqpCascade
    return ClusteredSolver(FallbackSolver(SOLVERS[name](), second(guesses=False)))
