"""Checks with deptry that each of our packages declares what it imports, and nothing else.

``setup.py`` names what pip installs, ``package.xml`` what comes with ROS; the two together are what
a package declares. Without arguments every package of ros2_ws/src is looked at.
"""

from __future__ import annotations

import ast
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SOURCES = ROOT / "ros2_ws" / "src"


def packages() -> list[Path]:
    """Return the folders of our Python packages."""
    return sorted(path.parent for path in SOURCES.glob("*/setup.py"))


def pip_requirements(package: Path) -> tuple[list[str], list[str]]:
    """Return what ``setup.py`` requires, and what for its extras, but for tests."""
    for node in ast.walk(ast.parse((package / "setup.py").read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "setup":
            given = {entry.arg: entry.value for entry in node.keywords}
            plain = ast.literal_eval(given.get("install_requires", ast.List([])))
            extras = ast.literal_eval(given.get("extras_require", ast.Dict([], [])))
            return plain, [line for key, lines in extras.items() if key != "test" for line in lines]
    raise ValueError(f"{package / 'setup.py'}: no call of setup")


def ros_dependencies(package: Path) -> list[str]:
    """Return the names that ``package.xml`` lists, but for tests."""
    kinds = ("depend", "exec_depend", "build_depend", "build_export_depend")
    tree = ET.parse(package / "package.xml")
    return [str(entry.text) for kind in kinds for entry in tree.iter(kind)]


def declared(package: Path) -> list[str]:
    """Return both as lines of a requirements file; keys of pip packages stand in setup.py too."""
    plain, extras = pip_requirements(package)
    ours = {line.replace("-", "_") for line in plain}
    ros = [name for name in ros_dependencies(package) if not name.startswith("python3-")]
    return [*plain, *extras, *(name for name in ros if name not in ours)]


def check(package: Path) -> str:
    """Return what deptry says against a package; empty: nothing."""
    sources = [each for each in (package / package.name, package / "launch") if each.exists()]
    with tempfile.NamedTemporaryFile("w", suffix=".txt") as file:
        file.write("\n".join(declared(package)))
        file.flush()
        done = subprocess.run(
            [
                *(sys.executable, "-m", "deptry", *sources),
                *("--config", ROOT / "pyproject.toml", "--requirements-files", file.name),
                *("--known-first-party", package.name, "--no-ansi"),
            ],
            cwd=package,
            capture_output=True,
            text=True,
            check=False,
        )
    return done.stdout + done.stderr if done.returncode else ""


def main() -> int:
    """Check the packages that are named, or all; return the exit code."""
    chosen = [SOURCES / name for name in sys.argv[1:]] or packages()
    found = [text for text in map(check, chosen) if text]
    print("\n".join(found), end="")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
