"""``scripts/fit-spheres``: spheres that stand for a robot where distances are kept."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from lexstack.errors import ConfigurationError, LexstackError
from lexstack.robots import RobotModel
from lexstack_config.folders import Folders
from lexstack_config.resolved import load_robot
from lexstack_sim.covering import LinkSpheres, spheres_of

FAILED, BAD_ARGUMENT = 1, 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns 0, or 1 where no spheres are found, 2 for bad arguments."""
    parsed = _parser().parse_args(arguments)
    try:
        path = _robot_file(parsed.robot)
        if not 1 <= parsed.most <= 1000:
            raise ConfigurationError(f"--most: must be in [1, 1000], got {parsed.most}")
        if not 0.0 <= parsed.beyond <= 1000.0:
            raise ConfigurationError(f"--beyond: must be in [0, 1000] mm, got {parsed.beyond:g}")
        robot = RobotModel(path.stem, load_robot(path))
        print("\n".join(lines(spheres_of(robot, parsed.most, 1e-3 * parsed.beyond))))
    except LexstackError as error:
        print(f"error: {error}", file=sys.stderr)
        return BAD_ARGUMENT if isinstance(error, ConfigurationError) else FAILED
    return 0


def lines(found: Sequence[LinkSpheres]) -> list[str]:
    """Return the key ``spheres`` of a robot file; radii are rounded up."""
    number = sum(len(each.covering.radii) for each in found)
    worst = 1e3 * max(each.covering.beyond for each in found)
    out = [
        f"# {number} spheres: every point of the collision shapes (hulls of meshes) is in one,",
        f"# none stands out by more than {worst + 1.0:.0f} mm.",
        "spheres:                                  # centre in the link's frame [m], radius [m]",
    ]
    for each in found:
        for center, radius in zip(each.covering.centers, each.covering.radii, strict=True):
            xyz = ", ".join(f"{value:.4f}" for value in center)
            # The centre is rounded by up to 0.09 mm, so the radius is 0.1 mm larger.
            out.append(f"  - {{link: {each.link}, xyz: [{xyz}], radius: {radius + 1e-4:.4f}}}")
    return out


def _robot_file(named: str) -> Path:
    """Return the file of a robot: a path, or a name of config/robots."""
    path = Path(named)
    if path.suffix == ".yaml":
        return path
    root = Path(os.environ.get("LEXSTACK_ROOT", ".")).resolve()
    return Folders((root / "config",)).find("robots", named)


def _parser() -> argparse.ArgumentParser:
    """Return the command line."""
    parser = argparse.ArgumentParser(
        prog="./scripts/fit-spheres",
        description="Fit spheres to a robot's collision shapes and print them as the key "
        "'spheres' of its file. They cover every shape; what they stand out by is printed.",
    )
    parser.add_argument("robot", help="a robot file ending in .yaml, or a name of config/robots")
    parser.add_argument(
        "--beyond",
        type=float,
        default=30.0,
        metavar="MM",
        help="by how much a sphere may stand out of the shapes [mm] (default: 30); 0: as little "
        "as --most spheres allow",
    )
    parser.add_argument(
        "--most", type=int, default=30, metavar="N", help="spheres per link (default: 30)"
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
