"""Targets that move, from the messages of ROS: twists, timed poses, paths and joint trajectories.

Every field is checked on its way in, as in ``conversions``. Times of a trajectory count from its
stamp, or where that is 0 from the first tick at which it can take effect.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Path
from std_msgs.msg import Header
from trajectory_msgs.msg import JointTrajectory, MultiDOFJointTrajectory

from lexstack.errors import InputError
from lexstack.references import (
    BaseTwist,
    Hold,
    Spline,
    Target,
    Twist,
    Waypoints,
    base_spline,
    path_at_speed,
)
from lexstack_ros.messages.conversions import placed, to_place, to_pose, to_stamp, to_vector
from lexstack_ros.messages.target_points import (
    Reading,
    check_few,
    check_inside,
    check_order,
    check_speeds,
    check_under_way,
    duration_of,
    first_or_now,
    frame_of,
    made,
    order_of,
    poses_of,
    room_for_rates,
    times_of,
    to_twist_vector,
    turned,
    until_first,
)

_OFF_THE_FLOOR = 1e-3  # m/s, rad/s, that are left out: frames are measured


def to_twist(message: TwistStamped, reading: Reading) -> Iterator[Target]:
    """Yield the twist of a frame; raises InputError, also where it is late already."""
    where, options = reading.where, reading.options
    stamp = _fresh(message.header, reading)
    value = to_twist_vector(message.twist, where)
    origin = reading.placing(message.header, where)
    twist = Twist(
        value if origin is None else turned(origin, value),
        options.twist_timeout,
        options.twist_linear,
        options.twist_angular,
    )
    begin = reading.begin(reading.frame)
    yield Target(stamp, reading.robot, ee=twist, frame=reading.frame, begin=begin)


def to_base_twist(message: TwistStamped, reading: Reading) -> Iterator[Target]:
    """Yield the twist of a base, in its own axes if the header says so; raises InputError."""
    where, options = reading.where, reading.options
    name = reading.model.name
    if not reading.model.has_base:
        raise InputError(f"{where}: robot {name} has no base")
    stamp = _fresh(message.header, reading)
    value = to_twist_vector(message.twist, where)
    own = message.header.frame_id.lstrip("/") in (f"{name}/base", f"{name}/base_link")
    origin = None if own else reading.placing(message.header, where)
    if origin is not None:
        value = turned(origin, value)
    if np.abs(value[[2, 3, 4]]).max() > _OFF_THE_FLOOR:
        raise InputError(f"{where}: twist: a base moves on the floor: x, y and about z alone")
    twist = BaseTwist(
        value[[0, 1, 5]],
        own,
        options.twist_timeout,
        options.twist_linear,
        options.twist_angular,
    )
    yield Target(stamp, reading.robot, base=twist)


def _fresh(header: Header, reading: Reading) -> float:
    """Return the stamp of a twist; raises InputError where it is late already."""
    stamp, where = to_stamp(header, reading.where), reading.where
    age, most = reading.now - stamp, reading.options.twist_timeout
    if stamp and age > most:
        raise InputError(
            f"{where}: header.stamp: it is {age:.3f} s old, at most {most:g} s; stamp 0 means now"
        )
    return stamp


def to_way(message: MultiDOFJointTrajectory, reading: Reading) -> Iterator[Target]:
    """Yield a target of each frame that timed poses are for; raises InputError."""
    where = reading.where
    stamp = to_stamp(message.header, where)
    frames = [frame_of(name, reading) for name in message.joint_names] or [reading.frame]
    if len(set(frames)) != len(frames):
        raise InputError(f"{where}: joint_names: a frame stands in it twice")
    times = times_of(message, stamp, reading)
    origin = reading.placing(message.header, where)
    for k, frame in enumerate(frames):
        if not len(times):
            yield Target(stamp, reading.robot, ee=Hold(), frame=frame)
            continue
        poses, twists = poses_of(message, k, len(frames), origin, where)
        begin = reading.begin(frame)
        if len(times) == 1:
            duration = duration_of(message)
            yield Target(stamp, reading.robot, poses[0], None, None, frame, begin, duration)
        else:
            check_speeds(times, np.array([pose.position for pose in poses]), f"{where}: points")
            way = made(where, lambda p=poses, t=twists: Waypoints(times, p, t))  # type: ignore[misc]
            led = until_first(times, stamp, reading.now)
            yield Target(stamp, reading.robot, way, frame=frame, begin=begin, duration=led)


def to_path(message: Path, reading: Reading) -> Iterator[Target]:
    """Yield the way of a base through places, at their stamps or at the speed of the options."""
    where = reading.where
    stamp = to_stamp(message.header, where)
    if not reading.model.has_base:
        raise InputError(f"{where}: robot {reading.model.name} has no base")
    check_few(message.poses, f"{where}: poses")
    if not message.poses:
        yield Target(stamp, reading.robot, base=Hold())
        return
    origin = reading.placing(message.header, where)
    places, stamps = [], []
    for k, entry in enumerate(message.poses):
        place = f"{where}: poses[{k}]"
        if entry.header.frame_id not in ("", message.header.frame_id):
            raise InputError(f"{place}: frame_id: expected that of the path, or none")
        places.append(to_place(placed(origin, to_pose(entry.pose, place), place), place))
        stamps.append(to_stamp(entry.header, place))
    if len(places) == 1:
        yield Target(stamp or stamps[0], reading.robot, base=places[0])
        return
    times = np.array(stamps)
    if times.any():
        check_under_way(times, reading)
        check_order(times, f"{where}: poses")
        check_speeds(times, np.array(places)[:, :2], f"{where}: poses")
        spline = made(where, lambda: base_spline(times, np.array(places)))
    else:
        options, start = reading.options, max(stamp, reading.now)
        speeds = options.path_speed, options.path_turn
        spline = made(where, lambda: path_at_speed(start, np.array(places), *speeds))
        times = spline.times
    at = stamp or first_or_now(times, reading.now)
    led = until_first(times, at, reading.now)
    yield Target(at, reading.robot, base=spline, duration=led)


def to_posture(message: JointTrajectory, reading: Reading) -> Iterator[Target]:
    """Yield the target of an arm's joints, in any order; raises InputError."""
    where, model = reading.where, reading.model
    stamp = to_stamp(message.header, where)
    times = times_of(message, stamp, reading)
    if not len(times):
        yield Target(stamp, reading.robot, posture=Hold())
        return
    joints = model.joints[model.arm]
    order = order_of(message.joint_names, joints, model.name, where)
    n = len(joints)
    values, rates = np.empty((len(times), n)), room_for_rates(message, (len(times), n), n, where)
    for k, point in enumerate(message.points):
        place = f"{where}: points[{k}]"
        values[k, order] = to_vector(point.positions, n, f"{place}.positions")
        if rates is not None:
            rates[k, order] = to_vector(point.velocities, n, f"{place}.velocities")
    check_inside(values, model, where)
    begin = None
    if reading.state is not None:
        begin = reading.state.q_star[reading.team.q_slices[reading.robot]][-n:]
    if len(times) == 1:
        duration = duration_of(message)
        yield Target(stamp, reading.robot, posture=values[0], begin=begin, duration=duration)
        return
    check_speeds(times, values, f"{where}: points")
    spline = made(where, lambda: Spline(times, values, rates))
    led = until_first(times, stamp, reading.now)
    yield Target(stamp, reading.robot, posture=spline, begin=begin, duration=led)
