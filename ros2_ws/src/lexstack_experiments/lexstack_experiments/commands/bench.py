"""``scripts/bench NAME``: how fast, side by side with peers, in one run."""

from __future__ import annotations

import sys

from lexstack_experiments.benches import BENCHES
from lexstack_experiments.commands.command import run_command


def main(arguments: list[str] | None = None) -> int:
    """Run the command; returns its exit code."""
    return run_command("bench", BENCHES, arguments)


if __name__ == "__main__":
    sys.exit(main())
