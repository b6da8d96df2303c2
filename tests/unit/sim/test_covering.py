"""``fit-spheres``: the spheres of real robots hold what touches, and go into a robot file."""

import numpy as np
import pytest
import yaml

from lexstack.robots import RobotModel, SphereConfig
from lexstack_bringup.commands import fit_spheres
from lexstack_config.reader import build
from lexstack_config.resolved import load_robot
from lexstack_sim.covering import shapes_by_link
from support.scenario import ROOT

FOLDER = ROOT / "examples" / "own_robot"


def test_the_printed_spheres_hold_every_corner_of_a_robot(capsys):
    path = FOLDER / "lift_arm.yaml"
    assert fit_spheres.main([str(path), "--beyond", "0", "--most", "3"]) == 0
    printed = capsys.readouterr().out
    spheres = [build(SphereConfig, each, "printed") for each in yaml.safe_load(printed)["spheres"]]
    robot = RobotModel("arm", load_robot(path))
    shapes = shapes_by_link(robot)
    assert {sphere.link for sphere in spheres} == set(shapes)
    for link, corners in shapes.items():
        own = [sphere for sphere in spheres if sphere.link == link]
        centers, radii = np.array([s.xyz for s in own]), np.array([s.radius for s in own])
        away = np.linalg.norm(np.concatenate(corners)[:, None] - centers, axis=2) - radii
        assert away.min(axis=1).max() <= 0.0, link


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["no_such_robot"], "no_such_robot.yaml"),
        (["z1", "--most", "0"], "--most: must be in [1, 1000]"),
        (["z1", "--beyond", "-1"], "--beyond: must be in [0, 1000] mm"),
        (["z1", "--beyond", "nan"], "--beyond: must be in [0, 1000] mm"),
    ],
)
def test_bad_arguments_are_told_in_one_line(arguments, told, capsys):
    assert fit_spheres.main(arguments) == 2
    error = capsys.readouterr().err
    assert told in error
    assert error.count("\n") == 1
