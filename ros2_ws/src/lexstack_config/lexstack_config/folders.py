"""Where configuration files lie: folders of the user's own, the scenario's, then lexstack's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

KINDS = ("robots", "stacks", "htmpc", "plants")
"""The folders of a configuration folder whose files a scenario names."""


@dataclass(frozen=True, slots=True)
class Folders:
    """Configuration folders, searched in their order: the first that has a file wins.

    A folder has its files in ``robots/``, ``stacks/``, ``htmpc/`` and ``plants/``, or beside each
    other.

    Attributes:
        folders: the last one is where a file is missed that no folder has.
        scenario: a file that is no robot, stack or parameters whatever its name.
    """

    folders: tuple[Path, ...]
    scenario: Path | None = None

    @classmethod
    def around(
        cls, scenario: Path, first: Sequence[Path] = (), last: Path | None = None
    ) -> Folders:
        """Return the folders of a scenario.

        Args:
            scenario: its file; of a configuration folder's ``scenarios/``, or in a folder that has
                what it names.
            first: folders that go before all others.
            last: lexstack's own; None: the folder above the scenario's.
        """
        path = scenario.resolve()
        own = path.parent.parent if path.parent.name == "scenarios" else path.parent
        last = path.parent.parent if last is None else last
        same = {last.resolve(): last}  # as it was given: texts of errors name it
        found = [same.get(each.resolve(), each) for each in (*first, own, last)]
        return cls(tuple(dict.fromkeys(found)), path)

    @property
    def last(self) -> Path:
        """Lexstack's own folder, or the only one."""
        return self.folders[-1]

    def find(self, kind: str, name: str) -> Path:
        """Return the first file of a kind with a name; where there is none, a path of no file."""
        file = f"{name}.yaml"
        for folder in self.folders:
            for path in (folder / kind / file, folder / file):
                if _is_file(path) and path.resolve() != self.scenario:
                    return path
        return self.last / kind / file

    def all(self, kind: str, named: Sequence[str] = ()) -> dict[str, Path]:
        """Return all files of the folders of a kind by name, and the ``named`` ones beside them."""
        names = {path.stem for folder in self.folders for path in (folder / kind).glob("*.yaml")}
        return {name: self.find(kind, name) for name in sorted(names.union(named))}


def _is_file(path: Path) -> bool:
    """Return whether a file is there; a name that cannot be one's is none."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False
