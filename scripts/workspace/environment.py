"""The environment variables in which lexstack's commands run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from shlex import quote

from workspace.ros import Ros


def build_variables(root: Path, ros: Ros, environ: Mapping[str, str]) -> dict[str, str]:
    """Return the variables in which the packages are installed and built."""
    venv = str(root / ".venv")
    variables = {
        **environ,
        "VIRTUAL_ENV": venv,
        "PATH": f"{venv}/bin:{environ.get('PATH', '')}",
        "COLCON_HOME": str(root / "build/colcon"),
    }
    if ros.prefix is None:
        for name in ("PYTHONPATH", "PYTHONHOME", "COLCON_PREFIX_PATH", "LD_LIBRARY_PATH"):
            variables.pop(name, None)
        variables |= {"AMENT_PREFIX_PATH": venv, "CMAKE_PREFIX_PATH": venv}
    return variables


def shell_script(root: Path, ros: Ros, python: str) -> str:
    """Return a sh script that enters the environment.

    It does at once what sourcing the workspace does, and is quick.

    Args:
        root: The clone.
        ros: Where ROS comes from.
        python: Name of the library folder, e.g. `python3.11`.
    """
    install = root / "ros2_ws/install"
    site = root / ".venv/lib" / python / "site-packages"
    sources = [setup.parent.resolve() for setup in _found(root, "ros2_ws/src/*/setup.py")]
    prefixes = [package.parents[2] for package in _found(install, "*/share/*/package.xml")]
    modules = [init.parents[1] for init in _found(install, f"*/lib/{python}/*/*/__init__.py")]
    libraries = [library.parent for library in _found(install, "*/lib/*.so")]
    paths: dict[str, list[Path]] = {
        "PATH": [root / ".venv/bin"],
        "AMENT_PREFIX_PATH": prefixes,
        "CMAKE_PREFIX_PATH": prefixes,
        "PYTHONPATH": [*sources, *modules],
        "LD_LIBRARY_PATH": libraries,
    }
    lines = [
        "# Written by scripts/setup: the environment of this clone, to be sourced by sh or bash.",
        f"export LEXSTACK_ROOT={quote(str(root))}",
        f"export VIRTUAL_ENV={quote(str(root / '.venv'))}",
        'export ROS_AUTOMATIC_DISCOVERY_RANGE="${ROS_AUTOMATIC_DISCOVERY_RANGE:-LOCALHOST}"',
        "# The matrices are small: threads would only cost time, and change the last bits.",
        'export OPENBLAS_NUM_THREADS="${OPENBLAS_NUM_THREADS:-1}"',
        'export OMP_NUM_THREADS="${OMP_NUM_THREADS:-1}"',
        "unset PYTHONHOME",
        "# ROS writes its logs below the home folder, and ends at once where that is not possible:",
        "# in a container, for an account that it does not know.",
        'if [ ! -d "${HOME:-}" ] || [ ! -w "${HOME:-}" ]; then',
        '  export HOME="${TMPDIR:-/tmp}/lexstack-home-$(id -u)"',
        '  mkdir -p -m 700 "$HOME" 2>/dev/null && [ -w "$HOME" ] || HOME="$(mktemp -d)"',
        "fi",
    ]
    if ros.prefix is None:
        paths["AMENT_PREFIX_PATH"].append(root / ".venv")
        paths["CMAKE_PREFIX_PATH"].append(root / ".venv")
        paths["LD_LIBRARY_PATH"] += [root / ".venv/lib", *_found(site, "ros_*.libs")]
        lines += [
            "export RMW_IMPLEMENTATION=rmw_fastrtps_cpp",
            "export _ROS_WHEELS_BOOTSTRAP_COMPLETE=1  # LD_LIBRARY_PATH is complete",
            "unset AMENT_PREFIX_PATH CMAKE_PREFIX_PATH",
        ]
    else:
        lines.append('export RMW_IMPLEMENTATION="${RMW_IMPLEMENTATION:-rmw_fastrtps_cpp}"')
    lines += [_prepend(name, folders) for name, folders in paths.items()]
    return "\n".join(lines) + "\n"


def _found(folder: Path, pattern: str) -> list[Path]:
    """Return what matches the pattern, sorted."""
    return sorted(folder.glob(pattern))


def _prepend(name: str, folders: list[Path]) -> str:
    """Return the line that puts folders before what a path variable holds."""
    unique = ":".join(dict.fromkeys(map(str, folders)))
    return f'export {name}={quote(unique)}"${{{name}:+:${name}}}"'
