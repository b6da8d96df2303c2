"""Where ROS 2 Jazzy comes from, and what follows from it."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from workspace.errors import SetupError

Version = tuple[int, int]

STANDINS = ("control_msgs", "tf2_msgs")
"""Packages of ROS in the workspace, as there are no wheels of them."""

SUPPORTED: tuple[Version, ...] = ((3, 11), (3, 12), (3, 13))


@dataclass(frozen=True)
class Ros:
    """ROS 2 Jazzy: from wheels, or a native installation.

    Attributes:
        prefix: Installation that holds rclpy; None: from wheels.
        pythons: Versions of Python that work with it.
    """

    prefix: Path | None = None
    pythons: tuple[Version, ...] = SUPPORTED


def find_ros(environ: Mapping[str, str]) -> Ros:
    """Return the ROS to use, judged by what the shell has sourced.

    Raises:
        SetupError: Another distribution is sourced, or Jazzy is incomplete.
    """
    distro = environ.get("ROS_DISTRO", "")
    if not distro:
        return Ros()
    if distro != "jazzy":
        raise SetupError(
            f"ROS 2 {distro} is sourced, lexstack needs jazzy: "
            "open a shell without it (ROS comes from wheels then), or source jazzy"
        )
    for prefix in filter(None, environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)):
        for rclpy in Path(prefix).glob("lib/python3.*/site-packages/rclpy"):
            version = python_version(rclpy.parents[1].name)
            if version in SUPPORTED:
                return Ros(Path(prefix), (version,))
    raise SetupError(
        "ROS_DISTRO is jazzy, but no rclpy for Python 3.11 to 3.13 is on AMENT_PREFIX_PATH: "
        "source the setup.bash of Jazzy, or unset ROS_DISTRO to take ROS from wheels"
    )


def brought_along(ros: Ros) -> tuple[str, ...]:
    """Return the workspace's packages that a native ROS has itself: they are not built then."""
    if ros.prefix is None:
        return ()
    return tuple(name for name in STANDINS if (ros.prefix / "share" / name).is_dir())


def python_version(name: str) -> Version:
    """Return the version in a name such as `python3.12`."""
    major, minor = name.removeprefix("python").split(".")[:2]
    return int(major), int(minor)


def split_lock(lock: str) -> dict[str, str]:
    """Return the lock file's entries, each with its hashes, by package."""
    return dict(lock_entries(lock))


def lock_entries(lock: str) -> list[tuple[str, str]]:
    """Return package and entry of each pin; a package may have one for each Python."""
    entries = re.split(r"^(?=[A-Za-z0-9])", lock, flags=re.MULTILINE)
    return [(entry.split("==")[0], entry) for entry in entries if "==" in entry]


def select_packages(lock: str, ros: Ros) -> str:
    """Return the lock file's text without what a native ROS brings itself."""
    entries = lock_entries(lock)
    native = ros.prefix is not None
    return "".join(text for name, text in entries if not (native and name.startswith("ros-")))


def patch_cmake(text: str, python_include: str, numpy_include: str) -> str:
    """Return a wheel's CMake file with this machine's include paths.

    The wheels carry those of the machine that built them.
    """
    text = re.sub(r"/opt/python/[^;\"]*/numpy/_core/include", lambda _: numpy_include, text)
    return re.sub(r"/opt/python/[^;\"/]+/include/python[0-9.]+", lambda _: python_include, text)
