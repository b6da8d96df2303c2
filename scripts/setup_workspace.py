"""Makes the virtual environment and builds the workspace; called by scripts/setup."""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import subprocess
import sys
import sysconfig
from pathlib import Path

from workspace import environment, ros, stamps
from workspace.errors import SetupError
from workspace.steps import Steps

ROOT = Path(__file__).resolve().parents[1]
BASE_PYTHON = os.path.realpath(getattr(sys, "_base_executable", sys.executable))
VERSION = "{}.{}".format(*sys.version_info)
NOT_CURRENT = 3


class Setup:
    """The set-up of this clone with this Python and that ROS."""

    def __init__(self, found: ros.Ros) -> None:
        """Work out what the finished set-up would look like."""
        self._ros = found
        self._venv = ROOT / ".venv"
        self._python = self._venv / "bin/python"
        self._environment = stamps.environment_stamp(ROOT, found, f"{BASE_PYTHON} {VERSION}")
        self._workspace = stamps.workspace_stamp(ROOT, self._environment)

    def is_current(self, *, packages: bool = False) -> bool:
        """Return whether there is nothing to do; ``packages``: for the environment alone."""
        return self._environment.is_current() and (packages or self._workspace.is_current())

    def clear(self) -> None:
        """Forget what is done, so that everything is made anew."""
        self._environment.clear()
        self._workspace.clear()

    def make(self, *, packages: bool = False) -> None:
        """Do what is not done yet; ``packages``: the environment alone."""
        variables = environment.build_variables(ROOT, self._ros, os.environ)
        new = not self._environment.is_current()
        steps = Steps(3 * new + (not packages), ROOT / "build/setup.log", variables)
        if new:
            self.clear()
            self._make_environment(steps)
        if not packages:
            self._build_workspace(steps)

    def _make_environment(self, steps: Steps) -> None:
        """Make the virtual environment from nothing."""
        lock = ros.select_packages((ROOT / "requirements.lock").read_text(), self._ros)
        with steps.step("make .venv"):
            shutil.rmtree(self._venv, ignore_errors=True)
            native = ["--system-site-packages"] if self._ros.prefix else []
            steps.run(BASE_PYTHON, "-m", "venv", *native, self._venv)
        with steps.step(
            "install the packages of requirements.lock", "the package registry must be reachable"
        ):
            self._install(steps, ros.split_lock(lock)["setuptools"])
            self._install(steps, lock)
        with steps.step("adapt the packages' CMake files"):
            self._patch_cmake()
        self._environment.write()

    def _install(self, steps: Steps, lock: str) -> None:
        """Install what a lock file names; setuptools comes first, to build what has no wheel."""
        chosen = ROOT / "build/requirements.lock"
        chosen.write_text(lock)
        pip = (self._python, "-m", "pip", "--disable-pip-version-check", "--no-input", "install")
        source = ("--only-binary", ":all:", "--no-binary", "empy", "--no-build-isolation")
        show = ("--progress-bar", "off")
        steps.run(*pip, *source, *show, "--no-deps", "--require-hashes", "-r", chosen)

    def _patch_cmake(self) -> None:
        """Put this machine's include paths into the wheels' CMake files."""
        ask = "import numpy; print(numpy.get_include())"
        numpy_include = subprocess.check_output([self._python, "-c", ask], text=True).strip()
        for file in self._venv.glob("share/*/cmake/*.cmake"):
            text = file.read_text()
            patched = ros.patch_cmake(text, sysconfig.get_path("include"), numpy_include)
            if patched != text:
                file.write_text(patched)

    def _build_workspace(self, steps: Steps) -> None:
        """Build the workspace: from nothing when the last build did not end well."""
        workspace = ROOT / "ros2_ws"
        with steps.step("build ros2_ws"):
            if not self._workspace.is_whole():
                for folder in ("build", "install"):
                    shutil.rmtree(workspace / folder, ignore_errors=True)
            self._workspace.clear()
            colcon = (self._python, "-m", "colcon", "--log-base", ROOT / "build/log", "build")
            cmake = ("-DBUILD_TESTING=OFF", f"-DPython3_EXECUTABLE={self._python}", "-Wno-dev")
            show = ("--event-handlers", "console_direct+")
            own = ros.brought_along(self._ros)
            skip = ("--packages-skip", *own) if own else ()
            steps.run(
                *colcon, "--symlink-install", *skip, *show, "--cmake-args", *cmake, cwd=workspace
            )
            library = workspace / "src/lexstack"
            steps.run(self._python, "-m", "lexstack.compiled", cwd=library)
            script = environment.shell_script(ROOT, self._ros, f"python{VERSION}")
            (self._venv / "environment.sh").write_text(script)
        self._workspace.write()


def probe() -> int:
    """Print this Python's path if it fits, and return the exit code."""
    try:
        versions = ros.find_ros(os.environ).pythons
    except SetupError:
        versions = ros.SUPPORTED
    if sys.version_info[:2] not in versions:
        return 1
    print(BASE_PYTHON)
    return 0


def main() -> int:
    """Run the set-up and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--probe", action="store_true", help="print this Python if it fits")
    parser.add_argument("--current", action="store_true", help="only tell if all is done")
    parser.add_argument("--clean", action="store_true", help="start from nothing")
    parser.add_argument("--quiet", action="store_true", help="say nothing if all is done")
    parser.add_argument("--packages", action="store_true", help="make the environment alone")
    arguments = parser.parse_args()
    if arguments.probe:
        return probe()
    found = ros.find_ros(os.environ)
    setup = Setup(found)
    packages = arguments.packages
    if arguments.current and (arguments.clean or not setup.is_current(packages=packages)):
        return NOT_CURRENT
    if arguments.clean:
        setup.clear()
    if not setup.is_current(packages=packages):
        setup.make(packages=packages)
    if not arguments.quiet:
        source = found.prefix or "wheels"
        what = "the packages are" if packages else "lexstack is"
        print(f"{what} set up: Python {VERSION}, ROS 2 Jazzy from {source}")
    return 0


def interrupt(*_: object) -> None:
    """Turn SIGTERM into the same orderly end as Ctrl-C."""
    raise KeyboardInterrupt


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, interrupt)
    try:
        sys.exit(main())
    except SetupError as error:
        sys.exit(f"lexstack: {error}")
    except KeyboardInterrupt:
        print("\nlexstack: interrupted; run ./scripts/setup again", file=sys.stderr)
        sys.exit(130)
