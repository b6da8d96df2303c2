"""The files of the meshes that the robots' descriptions name, for viewers elsewhere."""

from __future__ import annotations

import re
from contextlib import suppress
from pathlib import Path

from lexstack.errors import ModelError
from lexstack.robots import Team, description_path, is_text
from lexstack_sim.geometry import mesh_path
from lexstack_sim.urdf import robot_urdf

_NAMED = re.compile(r'<mesh[^>]*filename="([^"]+)"')


def meshes_of(team: Team) -> dict[str, Path]:
    """Return the meshes of a team by the names that /NAME/robot_description has for them.

    A name that is not among them is no mesh of the team: so nobody reads another file.
    """
    found: dict[str, Path] = {}
    for robot in team.robots:
        arm = robot.config.arm
        if not arm.description:
            continue
        folder = None if is_text(arm.description) else description_path(arm.description).parent
        for name in set(_NAMED.findall(robot_urdf(robot))):
            with suppress(ModelError):  # a mesh that is missing is not drawn
                found[name] = mesh_path(name, folder, arm.packages)
    return found
