"""Another clone of the project, of another commit: what it does in an environment of its own."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Sequence
from pathlib import Path

from lexstack.errors import ConfigurationError

_OURS = (
    *("PYTHONPATH", "LD_LIBRARY_PATH", "AMENT_PREFIX_PATH", "CMAKE_PREFIX_PATH"),
    *("LEXSTACK_ROOT", "VIRTUAL_ENV", "_ROS_WHEELS_BOOTSTRAP_COMPLETE"),
)
_IN_ITS_ENVIRONMENT = '. "$0/.venv/environment.sh" && exec python "$@"'
_RESOLVE = """
import sys
from pathlib import Path
from {module} import load_scenario
print(load_scenario(Path(sys.argv[1]), Path(sys.argv[2])).to_yaml(), end="")
"""
_LOADS = (
    ("lexstack_testing", "system_load", "lexstack_config.resolved"),
    ("lexstack_ros", "system_load", "lexstack_core.config.resolved"),  # before the house was built
)
"""Package and module of the load, and the module that resolves scenarios; the newest first."""


class Clone:
    """A clone that was set up.

    Attributes:
        root: its folder.
        load: the module of its load for ``bench system``.
    """

    def __init__(self, root: Path) -> None:
        """Look at a folder; raises ConfigurationError for one that is no clone, or not set up."""
        self.root = root.resolve()
        if not (self.root / ".venv/environment.sh").is_file():
            raise ConfigurationError(f"{root}: no clone that was set up (./scripts/setup)")
        for package, module, resolved in _LOADS:
            if (self.root / f"ros2_ws/src/{package}/{package}/{module}.py").is_file():
                self.load, self._resolved = f"{package}.{module}", resolved
                return
        raise ConfigurationError(f"{root}: has no bench of the whole system")

    def python(self, *words: str, timeout: float) -> subprocess.CompletedProcess[str]:
        """Return what its Python did with arguments, in at most ``timeout`` [s]."""
        environment = {name: value for name, value in os.environ.items() if name not in _OURS}
        command: Sequence[str] = ["sh", "-c", _IN_ITS_ENVIRONMENT, str(self.root), *words]
        return subprocess.run(
            command, check=False, capture_output=True, text=True, timeout=timeout, env=environment
        )

    def resolved(self, scenario: Path) -> str:
        """Return a scenario with its own robots and stacks, as text; raises ConfigurationError."""
        program = _RESOLVE.format(module=self._resolved)
        words = "-c", program, str(scenario), str(self.root / "config")
        done = self.python(*words, timeout=60.0)
        if done.returncode:
            raise ConfigurationError(f"{self.root}: {done.stderr.strip()[-500:]}")
        return done.stdout
