"""What RViz and Foxglove draw of a picture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from rclpy.serialization import serialize_message
from rosbags.typesys import Stores, get_typestore
from visualization_msgs.msg import Marker

from lexstack.references import Motion
from lexstack.robots import ObstacleConfig
from lexstack.types import PlantStatus
from lexstack_config.parts import build_references, build_team
from lexstack_ros.view.markers import Markers
from lexstack_ros.view.picture import Picture
from support.scenario import changed, home, random_q, resolved


def group_with_a_ball():
    return build_team(changed(obstacles={"ball": ObstacleConfig((1.0, 2.0, 0.5), 0.2)}))


TEAM = group_with_a_ball()


def picture(time=1.0, q=None, **values):
    references = build_references(resolved(), TEAM).at(0.0)
    return Picture(
        time, 0, home() if q is None else q, PlantStatus.FOLLOWING, "", "idle", 0.0, "", "",
        (), {}, references, references, TEAM.obstacles.at(time), **values,
    )  # fmt: skip


def by_name(message):
    found = {}
    for marker in message.markers:
        found.setdefault(marker.ns, {})[marker.id] = marker
    return found


def xyz(point):
    return [point.x, point.y, point.z]


def test_spheres_are_those_that_distances_are_measured_from():
    q = random_q(np.random.default_rng(2))
    markers = by_name(Markers(TEAM).message(picture(q=q)))
    spheres = TEAM.spheres(q)
    count = 0
    for robot, name in enumerate(TEAM.names):
        for i, marker in markers[f"spheres of {name}"].items():
            assert spheres.owners[i] == robot
            assert np.allclose(xyz(marker.pose.position), spheres.centers[i])
            assert np.isclose(marker.scale.x, 2.0 * spheres.radii[i])
            assert 0.0 < marker.color.a < 1.0
            count += 1
    assert count == len(spheres.radii)


def test_obstacles_and_references_are_drawn():
    markers = by_name(Markers(TEAM).message(picture()))
    (ball,) = markers["obstacles"].values()
    assert xyz(ball.pose.position) == [1.0, 2.0, 0.5]
    assert ball.scale.x == 0.4
    references = build_references(resolved(), TEAM).at(0.0)
    for robot, pose in enumerate(references.ee):
        points = np.array([xyz(point) for point in markers["tool references"][robot].points])
        assert np.allclose(points[::2], pose.position)
        assert np.allclose((points[1::2] - points[::2]).T / 0.16, pose.rotation)
        arrow = markers["base references"][robot]
        assert np.allclose(xyz(arrow.pose.position)[:2], references.base[robot][:2])


def test_paths_grow_and_begin_again_after_a_reset():
    markers = Markers(TEAM)
    assert by_name(markers.message(picture(0.0)))["paths"][0].action == Marker.DELETE
    moved = home()
    moved[0] += 0.5
    path = by_name(markers.message(picture(0.1, moved)))["paths"][0]
    points = [xyz(point) for point in path.points]
    assert np.allclose(points, [TEAM.tools(q)[0].position for q in (home(), moved)])
    assert path.action == Marker.ADD
    assert by_name(markers.message(picture(0.0)))["paths"][0].action == Marker.DELETE


def test_a_path_has_an_end():
    markers = Markers(TEAM)
    for step in range(3000):
        q = home()
        q[0] += 0.01 * (step % 50)
        message = markers.message(picture(0.01 * step, q)) if step % 500 == 499 else None
        markers._go_on(picture(0.01 * step, q))
        if message is not None:
            assert len(by_name(message)["paths"][0].points) <= 1000


def test_a_horizon_is_drawn_and_taken_away():
    markers = Markers(TEAM)
    points = np.array([[0.0, 0.0, 1.0], [0.1, 0.0, 1.0]])
    line = by_name(markers.message(picture(horizons={1: points})))["horizons"]
    assert [xyz(point) for point in line[1].points] == points.tolist()
    assert line[0].action == Marker.DELETE
    assert by_name(markers.message(picture()))["horizons"][1].action == Marker.DELETE


def test_references_of_further_frames_come_and_go():
    markers, frame = Markers(TEAM), (1, "panda_link5")
    pose = TEAM.tools(home())[1]
    known = picture().references
    framed = replace(known, motion=Motion(frames={frame: pose}))
    (axes,) = by_name(markers.message(replace(picture(), references=framed)))[
        "reference of robot_b/panda_link5"
    ].values()
    assert np.allclose(xyz(axes.points[0]), pose.position)
    (gone,) = by_name(markers.message(picture()))["reference of robot_b/panda_link5"].values()
    assert (gone.action, gone.id) == (Marker.DELETE, axes.id)
    assert "reference of robot_b/panda_link5" not in by_name(markers.message(picture()))


def test_every_marker_has_one_name_and_stands_in_the_world():
    message = Markers(TEAM).message(picture(2.5))
    names = [(marker.ns, marker.id) for marker in message.markers]
    assert len(set(names)) == len(names)
    assert {marker.header.frame_id for marker in message.markers} == {"world"}
    assert {marker.header.stamp.nanosec for marker in message.markers} == {500_000_000}
    store = get_typestore(Stores.ROS2_JAZZY)
    heard = store.deserialize_cdr(serialize_message(message), "visualization_msgs/msg/MarkerArray")
    assert len(heard.markers) == len(message.markers)


def test_a_moving_obstacle_is_where_it_is_at_that_time():
    moving = {"ball": ObstacleConfig((1.0, 0.0, 0.5), 0.2, velocity=(0.5, 0.0, 0.0))}
    group = build_team(changed(obstacles=moving))
    shown = replace(picture(2.0), obstacles=group.obstacles.at(2.0))
    (ball,) = by_name(Markers(group).message(shown))["obstacles"].values()
    assert xyz(ball.pose.position) == [2.0, 0.0, 0.5]
