"""What a sweep leaves: parts as they come, one Parquet file at the end, and what is still to do."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import pyarrow as pa
from pyarrow import parquet

from lexstack.errors import ConfigurationError
from lexstack_bag.storage.folders import writing
from lexstack_experiments.sweeps.execution import Done
from lexstack_experiments.sweeps.kinds.kind import Row

RUNS, SWEEP, PARTS, INDEX = "runs.parquet", "sweep.yaml", "parts", "run"


class SweepFolder:
    """The folder of one sweep; several calls may fill it, one after the other.

    Attributes:
        path: the folder.
    """

    def __init__(self, path: Path, text: str) -> None:
        """Make the folder, or take up what is in it.

        Args:
            path: of the folder.
            text: of the sweep file.

        Raises:
            ConfigurationError: the folder has another sweep, or something else.
            BagError: it cannot be written.
        """
        self.path = path.resolve()
        kept = self.path / SWEEP
        if kept.is_file():
            if kept.read_text(encoding="utf-8") != text:
                raise ConfigurationError(
                    f"--out: {self.path} has runs of another sweep, see {kept}; name another folder"
                )
        elif self.path.is_dir() and any(self.path.iterdir()):
            raise ConfigurationError(f"--out: {self.path} is not empty; name another folder")
        with writing(self.path / PARTS, make=True):
            kept.write_text(text, encoding="utf-8")

    def done(self) -> frozenset[int]:
        """Return the numbers of the runs that are done."""
        return frozenset(
            index
            for part in self._parts()
            for index in parquet.read_table(part, columns=[INDEX])[INDEX].to_pylist()
        )

    def keep(self, done: Done) -> None:
        """Keep some runs; a part is there as a whole, or not at all."""
        rows = [{INDEX: i, **row} for i, row in zip(done.indices, done.rows, strict=True)]
        path = self.path / PARTS / f"{min(done.indices):08d}.parquet"
        begun = path.with_suffix(".begun")
        with writing(path):
            parquet.write_table(_table(rows), begun)
            begun.replace(path)

    def gather(self) -> pa.Table:
        """Return all runs in their order, and write them as one file; the parts stay."""
        tables = [parquet.read_table(part) for part in self._parts()]
        table = pa.concat_tables(tables, promote_options="permissive").sort_by(INDEX)
        with writing(self.path / RUNS):
            parquet.write_table(table, self.path / RUNS)
        return table

    def _parts(self) -> list[Path]:
        return sorted((self.path / PARTS).glob("*.parquet"))


def _table(rows: Iterable[Row]) -> pa.Table:
    """Return rows as a table, with every column that one of them has."""
    listed = list(rows)
    names = list(dict.fromkeys(name for row in listed for name in row))
    return pa.table({name: [row.get(name) for row in listed] for name in names})
