"""Results that documents quote: ``docs/results/NAME.json``, a run's ``results.json`` reduced."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lexstack.errors import ConfigurationError

_KEPT = ("name", "seed", "cases", "commit", "machine", "setup", "figures", "tables")
# Tables that no document quotes are left out, by their places.
_QUOTED_TABLES = {"transition-methods": slice(1, None), "reactivity": slice(0, 0)}
_DIGITS = 6  # significant ones: more than documents show, so nothing is rounded twice


@dataclass(frozen=True, slots=True)
class Quoted:
    """The results of one run.

    Attributes:
        name: of the experiment or bench.
        content: of its results file.
    """

    name: str
    content: dict[str, Any]

    def figure(self, name: str) -> dict[str, Any]:
        """Return a figure by its name; raises ConfigurationError for one that is not there."""
        for entry in self.content["figures"]:
            if entry["name"] == name:
                return dict(entry)
        raise ConfigurationError(f"docs/results/{self.name}.json: no figure {name!r}")

    def rows(self, table: int = 0) -> list[dict[str, Any]]:
        """Return the rows of a table, by its place; each has the columns as keys."""
        return list(self.content["tables"][table]["rows"])

    def row(self, column: str, value: str, table: int = 0) -> dict[str, Any]:
        """Return the row that has a value in a column; raises ConfigurationError."""
        for row in self.rows(table):
            if row[column] == value:
                return row
        raise ConfigurationError(f"docs/results/{self.name}.json: no row with {column} {value!r}")


class Store:
    """The results files of a repository."""

    def __init__(self, root: Path) -> None:
        """Use ``docs/results`` below the repository's root."""
        self._folder = root / "docs" / "results"
        self._read: dict[str, Quoted] = {}

    def __getitem__(self, name: str) -> Quoted:
        """Return the results of an experiment; raises ConfigurationError without its file."""
        if name not in self._read:
            path = self._folder / f"{name}.json"
            try:
                content = json.loads(path.read_text(encoding="utf-8"))
            except (OSError, ValueError) as error:
                raise ConfigurationError(f"{path}: cannot be read: {error}") from error
            self._read[name] = Quoted(name, content)
        return self._read[name]

    def take(self, run: Path) -> Path:
        """Keep what a run's ``results.json`` says, and return the file; raises ConfigurationError.

        Only a whole run counts: its shortened kin show other figures.
        """
        path = run / "results.json" if run.is_dir() else run
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
            kept = {key: _short(content[key]) for key in _KEPT}
            if content.get("quiet"):  # of benches alone
                kept["quiet"] = _short(content["quiet"])
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise ConfigurationError(f"{path}: no results of an experiment: {error}") from error
        kept["tables"] = kept["tables"][_QUOTED_TABLES.get(kept["name"], slice(None))]
        target = self._folder / f"{kept['name']}.json"
        self._folder.mkdir(parents=True, exist_ok=True)
        text = json.dumps(kept, indent=1, allow_nan=False, ensure_ascii=False)
        target.write_text(f"{text}\n", encoding="utf-8")
        self._read.pop(str(kept["name"]), None)
        return target


def _short(value: Any) -> Any:
    """Return a value of a results file with all its numbers rounded."""
    if isinstance(value, float):
        return float(f"{value:.{_DIGITS}g}")
    if isinstance(value, dict):
        return {key: _short(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [_short(entry) for entry in value]
    return value
