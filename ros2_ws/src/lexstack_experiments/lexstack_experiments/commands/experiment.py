"""``scripts/experiment NAME``: a table or picture of the papers, or one of ours."""

from __future__ import annotations

import sys

from lexstack_experiments.commands.command import run_command
from lexstack_experiments.experiments import EXPERIMENTS


def main(arguments: list[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    return run_command("experiment", EXPERIMENTS, arguments)


if __name__ == "__main__":
    sys.exit(main())
