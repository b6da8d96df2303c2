"""``ros2 run lexstack_bringup find_plant``: a plant file from the controllers that run now."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import rclpy
import yaml
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.node import Node

from lexstack.errors import ConfigurationError
from lexstack_bringup.commands.demo import add_scenario_arguments, named_scenario
from lexstack_bringup.real_plant import robots_domain
from lexstack_config.own_folder import own_config
from lexstack_config.plant_file import PlantFile, check_plant
from lexstack_config.reader import build
from lexstack_config.resolved import ResolvedScenario
from lexstack_plant.finding.endpoints import told
from lexstack_plant.finding.graph import find_endpoints
from lexstack_plant.finding.manager import find_controllers
from lexstack_plant.finding.matching import Found, Wanted, find_plant_content

_MOST = 1e4  # s, Hz
_PATIENCE = 3.0  # s of wall time


def main(arguments: list[str] | None = None) -> int:
    """Print a plant file; returns 0, 1 where it is not complete, 2 for bad arguments."""
    config = own_config()
    try:
        options = _parser(config).parse_args(arguments)
        resolved = named_scenario(config, options)
        domain = robots_domain()
    except ConfigurationError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    with _node(domain) as (node, executor):
        found = find(node, executor, resolved, options)
    wrong = incomplete(found, resolved)
    notes = (*found.notes, wrong) if wrong else found.notes
    print("".join(f"# {note}\n" for note in notes) + _text(found))
    for note in notes:
        print(f"note: {note}", file=sys.stderr)
    return 1 if wrong else 0


def find(
    node: Node, executor: Executor, resolved: ResolvedScenario, options: argparse.Namespace
) -> Found:
    """Return what runs now of the robots of a scenario."""
    endpoints = find_endpoints(node, executor, options.wait)
    controllers, notes = find_controllers(node, executor)
    scenario = resolved.scenario
    rate = options.rate or scenario.rate
    found = find_plant_content(
        options.name, wanted_of(resolved), told(endpoints, controllers), rate
    )
    return Found(found.content, (*notes, *found.notes))


def wanted_of(resolved: ResolvedScenario) -> list[Wanted]:
    """Return the robots of a scenario as they are looked for."""
    return [
        Wanted(
            name,
            place.model,
            tuple(resolved.robots[place.model].arm.joints),
            resolved.robots[place.model].base is not None,
        )
        for name, place in resolved.scenario.robots.items()
    ]


def incomplete(found: Found, resolved: ResolvedScenario) -> str:
    """Return why what was found is no plant file yet, or ''."""
    try:
        check_plant(build(PlantFile, found.content, "the file"), resolved, "the file")
    except ConfigurationError as error:
        return f"not complete: {error}"
    return ""


def _text(found: Found) -> str:
    """Return the file."""
    return yaml.safe_dump(found.content, sort_keys=False, width=100)


@contextmanager
def _node(domain: int) -> Iterator[tuple[Node, Executor]]:
    """Yield a node that looks around, and what works for it."""
    rclpy.init(args=[], domain_id=domain)
    executor = SingleThreadedExecutor()
    node = rclpy.create_node("find_plant")
    executor.add_node(node)
    try:
        yield node, executor
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown()


def _parser(config: Path) -> argparse.ArgumentParser:
    """Return the command line."""
    parser = argparse.ArgumentParser(
        prog="find_plant",
        description="Print a plant file for the robots of a scenario, from the controllers, joints "
        "and topics that are there now. Nothing is sent to them.",
    )
    add_scenario_arguments(parser, config)
    parser.add_argument("--name", default="found", help="of the file (default: %(default)s)")
    parser.add_argument("--rate", type=_number, help="Hz (default: the scenario's)")
    parser.add_argument(
        "--wait",
        type=_number,
        default=_PATIENCE,
        metavar="SECONDS",
        help="for topics to be discovered, and as long for joint states (default: %(default)g)",
    )
    return parser


def _number(text: str) -> float:
    """Return a time or rate of an argument, above 0."""
    number = float(text)
    if not 0.0 < number <= _MOST:
        raise argparse.ArgumentTypeError(f"must be above 0 and at most {_MOST:g}, got {text!r:.40}")
    return number


if __name__ == "__main__":
    sys.exit(main())
