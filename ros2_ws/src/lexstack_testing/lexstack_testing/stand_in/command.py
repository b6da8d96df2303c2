"""``python -m lexstack_testing.stand_in.command``: stands in for the robots of a plant file."""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

from lexstack.errors import ConfigurationError
from lexstack_bringup.commands.demo import add_run_arguments, resolve_scenario
from lexstack_bringup.processes import arguments_of
from lexstack_bringup.real_plant import real_plant
from lexstack_config.own_folder import own_config, own_root
from lexstack_testing.stand_in.habits import Habits, parse_habits
from lexstack_testing.stand_in.node import main as run


def main(arguments: list[str] | None = None) -> int:
    """Run the stand-in until Ctrl-C; returns 0, or 2 for bad arguments."""
    config = own_config()
    try:
        options = _parser(config).parse_args(arguments)
        resolved = resolve_scenario(config, options)
        real = real_plant(own_root(), options, resolved)
        assert real is not None
        parse_habits(options.habits)
    except ConfigurationError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory(prefix="lexstack-stand-in-") as folder:
        path = Path(folder) / "scenario.yaml"
        path.write_text(real.applied(resolved).to_yaml(), encoding="utf-8")
        given = {"scenario": str(path), "plant": str(real.path)}
        if options.habits:
            given["habits"] = f'"{options.habits}"'
        sys.argv = [sys.argv[0], *arguments_of("stand_in", given)]
        return run()


def _parser(config: Path) -> argparse.ArgumentParser:
    """Return the command line."""
    parser = argparse.ArgumentParser(
        prog="./scripts/stand_in",
        description="Put the robots of a scenario in MuJoCo behind the topics of a plant file, "
        "with the habits of hardware.",
    )
    add_run_arguments(parser, config)
    parser.add_argument("--plant", required=True, metavar="FILE", help="a plant file, or its name")
    known = ", ".join(Habits.__dataclass_fields__)
    parser.add_argument("--habits", default="", help=f"all, or NAME=VALUE,...; known: {known}")
    parser.set_defaults(enable=False)
    return parser


if __name__ == "__main__":
    sys.exit(main())
