"""The modules that a scenario lists: they bring methods, solvers and tasks of other people."""

from __future__ import annotations

from importlib import import_module

import lexstack.hqp
import lexstack.transition
from lexstack.errors import ConfigurationError
from lexstack.options import unknown
from lexstack_config.scenario import ScenarioConfig

_LONGEST = 200  # characters of another module's error


def load_extensions(scenario: ScenarioConfig, where: str = "") -> None:
    """Import the extensions of a scenario, and check the names that may come from them.

    It is called where something is made of a scenario. To read one, as a recorder and an analysis
    do, imports nothing: they work where the extensions are not installed.

    Args:
        scenario: with its ``extensions``.
        where: the scenario's file, for errors; empty: its name.

    Raises:
        ConfigurationError: a module cannot be imported, or nobody knows the method or the solver.
    """
    where = where or f"scenario {scenario.name}"
    for i, module in enumerate(scenario.extensions):
        try:
            import_module(module)
        except (Exception, SystemExit) as error:
            line = " ".join(f"{type(error).__name__}: {error}".split())[:_LONGEST]
            raise ConfigurationError(
                f"{where}: extensions[{i}]: cannot import {module!r}: {line}"
            ) from error
    # By way of the packages, which load only now what their methods and solvers need.
    if scenario.transition.method not in lexstack.transition.METHODS:
        text = unknown("method", scenario.transition.method, lexstack.transition.METHODS)
        raise ConfigurationError(f"{where}: transition.method: {text}")
    if scenario.solver not in lexstack.hqp.SOLVERS:
        text = unknown("solver", scenario.solver, lexstack.hqp.SOLVERS)
        raise ConfigurationError(f"{where}: solver: {text}")
