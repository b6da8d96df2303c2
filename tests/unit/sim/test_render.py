"""Pictures: the robots are in them, in their colours, and a machine without OpenGL is told so."""

from __future__ import annotations

import numpy as np
import pytest

from lexstack.robots import Pose, description_path
from lexstack_config.parts import home_of
from lexstack_sim import render
from lexstack_sim.collada import read_collada
from support.scenario import resolved, team


def is_orange(image):
    red, green, blue = (image[..., i].astype(int) for i in range(3))
    return (red > 150) & (green < 0.65 * red) & (blue < 0.35 * red)


def is_blue(image):
    red, green, blue = (image[..., i].astype(int) for i in range(3))
    return (blue > 120) & (red < 0.4 * blue) & (green < 0.75 * blue)


def test_both_robots_are_seen_where_they_are():
    home = home_of(team(), resolved())
    apart = home.copy()
    apart[1], apart[11] = -0.5, 0.5
    target = Pose(np.array([1.0, 0.0, 0.9]), np.eye(3))
    try:
        images = render.snapshots(
            resolved(), [home, apart, apart], [{}, {}, {"robot_a": target}], size=(480, 270)
        )
    except render.RenderError as error:
        pytest.skip(str(error))
    assert [image.shape for image in images] == [(270, 480, 3)] * 3
    assert all(image.dtype == np.uint8 for image in images)
    for image in images:
        assert 90 < image.mean() < 235  # neither dark nor washed out
        for color in (is_orange, is_blue):
            assert np.count_nonzero(color(image)) > 200
        left, right = (np.nonzero(color(image))[1].mean() for color in (is_orange, is_blue))
        assert left < right - 100
        for border in (image[:, 0], image[:, -1], image[-1]):  # nobody is cut off
            assert not is_orange(border).any()
            assert not is_blue(border).any()
    assert (images[0] != images[1]).any()
    assert (images[1] != images[2]).any(axis=2).sum() > 50


def test_a_machine_without_opengl_is_told_what_to_install(monkeypatch):
    monkeypatch.setattr(render, "_LIBRARIES", {"egl": "libnowhere.so.1"})
    with pytest.raises(render.RenderError, match="install libegl1"):
        render.snapshots(resolved(), [home_of(team(), resolved())])


def test_meshes_keep_their_colours_and_their_size():
    meshes = read_collada(description_path("panda_description/meshes/visual/link5.dae"))
    assert {tuple(np.round(color[:3], 2)) for color in meshes} == {(1.0,) * 3, (0.25,) * 3}
    vertices = np.concatenate([mesh.vertices for mesh in meshes.values()])
    assert 0.2 < np.ptp(vertices, axis=0).max() < 0.5
    for mesh in meshes.values():
        assert mesh.faces.max() == len(mesh.vertices) - 1
