"""Starts the live page beside a run, and the server for Foxglove in the same process."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from pathlib import Path

from lexstack_bringup.naming import Naming
from lexstack_bringup.processes import PLAIN, arguments_of
from lexstack_bringup.supervisor import Supervisor
from lexstack_ros.messages.names import FOXGLOVE, PAGE, URL
from lexstack_ros.node.readiness import READY
from lexstack_ros.view.foxglove import check_foxglove

_DEFAULT = 8765  # where Foxglove looks if nothing else is said
_TIMEOUT = 30.0  # s of wall time


def add_view_arguments(parser: argparse.ArgumentParser) -> None:
    """Add what shows a run while it is under way."""
    parser.add_argument(
        "--view", action="store_true", help="serve a page that shows the run, with buttons"
    )
    parser.add_argument(
        "--foxglove",
        nargs="?",
        const=str(_DEFAULT),
        default="",
        metavar="PORT",
        help="also serve the run to Foxglove, at a port (%(const)s); needs foxglove-sdk",
    )


@dataclass(frozen=True, slots=True)
class Views:
    """What shows a run while it is under way.

    Attributes:
        page: whether the live page does.
        foxglove: port for Foxglove, of whose markers the page's process takes care; '': none.
    """

    page: bool = False
    foxglove: str = ""

    @classmethod
    def of(cls, options: argparse.Namespace) -> Views:
        """Return what a command line asks for; raises ConfigurationError."""
        if options.foxglove:
            return cls(options.view, str(check_foxglove(options.foxglove)))
        return cls(options.view)

    def start(self, supervisor: Supervisor, scenario: Path, naming: Naming) -> None:
        """Start what is asked for, and print the addresses."""
        if not (self.page or self.foxglove):
            return
        page, foxglove = start_page(supervisor, scenario, naming, self.foxglove)
        print(f"watch it at {page}", flush=True)
        if foxglove:
            print(f"in Foxglove: open a connection to {foxglove}", flush=True)


def start_page(
    supervisor: Supervisor, scenario: Path, naming: Naming = PLAIN, foxglove: str = ""
) -> tuple[str, str]:
    """Start the process of the live page and return the page's address, and that for Foxglove.

    Args:
        supervisor: starts it.
        scenario: file of the resolved scenario.
        naming: under which names the nodes meet.
        foxglove: port for Foxglove; '': it is not served, and has no address.

    Raises:
        ChildDiedError: it ended; NotReadyError: it did not serve in time.
    """
    given = {"scenario": str(scenario)} | ({"foxglove": foxglove} if foxglove else {})
    arguments = arguments_of(PAGE, given, naming)
    child = supervisor.start(PAGE, "lexstack_ros.view.node", arguments)
    supervisor.wait_printed([PAGE], READY, _TIMEOUT)
    lines = child.log.read_text(encoding="utf-8", errors="replace").splitlines()
    page, other = (
        next((line.removeprefix(key) for line in lines if line.startswith(key)), "")
        for key in (URL, FOXGLOVE)
    )
    return page, other
