"""Closed loops of one scenario in variants, and the figures that lexstack_bag takes from them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from lexstack_bag.figures.figures import Analysis
from lexstack_config.resolved import ResolvedScenario, load_scenario
from lexstack_experiments import methods
from lexstack_experiments.loop import Loop
from lexstack_experiments.recording import recorded

Case = TypeVar("Case", bound=Any)


def analysed(loop: Loop) -> Analysis:
    """Return the figures of what a loop has done so far, by the definitions of the report."""
    return Analysis.of(recorded(loop))


def scenario_of(config: Path, name: str = "transition-sequence") -> ResolvedScenario:
    """Return a scenario of the configuration folder; raises ConfigurationError."""
    return load_scenario(config / "scenarios" / f"{name}.yaml", config)


def changed(resolved: ResolvedScenario, **values: Any) -> ResolvedScenario:
    """Return a scenario with some of its values replaced."""
    return replace(resolved, scenario=replace(resolved.scenario, **values))


def with_method(resolved: ResolvedScenario, method: str, **values: Any) -> ResolvedScenario:
    """Return a scenario whose switches use a method, and other values of its transition.

    One of the methods to compare with comes with the extension that brings it.
    """
    scenario = resolved.scenario
    transition = replace(scenario.transition, method=method, **values)
    extensions = scenario.extensions
    if method in methods.COMPARED and methods.__name__ not in extensions:
        extensions = (*extensions, methods.__name__)
    return changed(resolved, transition=transition, extensions=extensions)


def never_switched(case: Case) -> Case:
    """Return a case, a dataclass with ``resolved``, with its references and without switches."""
    events = tuple(replace(event, switch="") for event in case.resolved.scenario.events)
    return replace(case, resolved=changed(case.resolved, events=events))


def run_reporting(loop: Loop, what: str, say: Callable[[str], None]) -> Loop:
    """Run a loop to the end of its scenario and say so."""
    loop.run()
    say(f"{what}: {len(loop.record.states)} ticks")
    return loop
