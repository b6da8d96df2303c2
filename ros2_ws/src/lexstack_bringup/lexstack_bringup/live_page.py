"""Starts the live page beside a run."""

from __future__ import annotations

from pathlib import Path

from lexstack_bringup.naming import Naming
from lexstack_bringup.processes import PLAIN, arguments_of
from lexstack_bringup.supervisor import Supervisor
from lexstack_ros.messages.names import PAGE, URL
from lexstack_ros.node.readiness import READY

_TIMEOUT = 30.0  # s of wall time


def start_page(supervisor: Supervisor, scenario: Path, naming: Naming = PLAIN) -> str:
    """Start the process of the live page and return the page's address.

    Raises:
        ChildDiedError: it ended; NotReadyError: it did not serve in time.
    """
    arguments = arguments_of(PAGE, {"scenario": str(scenario)}, naming)
    child = supervisor.start(PAGE, "lexstack_ros.view.node", arguments)
    supervisor.wait_printed([PAGE], READY, _TIMEOUT)
    lines = child.log.read_text(encoding="utf-8", errors="replace").splitlines()
    return next(line.removeprefix(URL) for line in lines if line.startswith(URL))
