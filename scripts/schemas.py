"""Writes the JSON Schemas of all configuration files, which editors use: config/schema/."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from lexstack.mpc import HtmpcConfig
from lexstack.robots import RobotFile
from lexstack.tasks import StackConfig
from lexstack_bringup.hosts import HostsConfig
from lexstack_config.json_schema import json_schema
from lexstack_config.plant_file import PlantFile
from lexstack_config.scenario import ScenarioConfig
from lexstack_experiments.baselines.htidkc import HtidkcConfig
from lexstack_experiments.sweeps.sweep_file import SweepFile

CONFIG = Path(__file__).resolve().parent.parent / "config"
KINDS = {
    "robots": RobotFile,
    "stacks": StackConfig,
    "scenarios": ScenarioConfig,
    "htmpc": HtmpcConfig,
    "htmpc/baselines": HtidkcConfig,
    "hosts": HostsConfig,
    "plants": PlantFile,
    "sweeps": SweepFile,
}
"""What the YAML files of each folder of the configuration become."""


def schema_of(folder: str) -> Path:
    """Return where the schema of a folder's files is kept."""
    return CONFIG / "schema" / f"{Path(folder).name}.json"


def made(folder: str) -> str:
    """Return the schema of a folder's files as text."""
    schema = json_schema(KINDS[folder], f"lexstack: config/{folder}")
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


def main() -> int:
    """Write the schemas; with --check say which differ. Return 0, or 1 where one differs."""
    parser = argparse.ArgumentParser(prog="scripts/schemas", description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing, say which are old")
    check, old = parser.parse_args().check, 0
    for folder in KINDS:
        path, text = schema_of(folder), made(folder)
        if path.exists() and path.read_text(encoding="utf-8") == text:
            continue
        old += 1
        print(f"{path.relative_to(CONFIG.parent)}: {'differs' if check else 'written'}")
        if not check:
            path.parent.mkdir(exist_ok=True)
            path.write_text(text, encoding="utf-8")
    return int(check and old > 0)


if __name__ == "__main__":
    sys.exit(main())
