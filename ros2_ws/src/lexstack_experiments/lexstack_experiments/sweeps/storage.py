"""What a sweep leaves: parts as they come, one Parquet file at the end, and what is still to do."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pyarrow as pa
from pyarrow import parquet

from lexstack.errors import ConfigurationError
from lexstack_bag.errors import BagError
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
        with writing(self.path):
            begun = kept.read_bytes() if kept.is_file() else None
            other = begun is None and self.path.is_dir() and any(self.path.iterdir())
        if begun is not None and begun != text.encode():
            raise ConfigurationError(
                f"--out: {self.path} has runs of another sweep, see {kept}; name another folder"
            )
        if other:
            raise ConfigurationError(f"--out: {self.path} is not empty; name another folder")
        with writing(self.path / PARTS, make=True):
            kept.write_text(text, encoding="utf-8")

    def done(self) -> frozenset[int]:
        """Return the numbers of the runs that are done."""
        return frozenset(
            index for part in self._parts() for index in _read(part, [INDEX])[INDEX].to_pylist()
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
        tables = _alike([_read(part) for part in self._parts()])
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
    return pa.table({name: _column([row.get(name) for row in listed]) for name in names})


def _column(cells: list[Any]) -> list[Any]:
    """Return the cells of a column: as text where their types do not go together."""
    types = {type(each) for each in cells if each is not None}
    if types == {int, float}:
        return [each if each is None else float(each) for each in cells]
    if len(types) < 2:
        return cells
    return [_text(each) for each in cells]


def _alike(tables: list[pa.Table]) -> list[pa.Table]:
    """Return tables in which a column that is text in one, or of several kinds, is text in all."""
    kinds: dict[str, set[str]] = {}
    for table in tables:
        for field in table.schema:
            kinds.setdefault(field.name, set()).add(_kind(field.type))
    mixed = {name for name, found in kinds.items() if len(found - {"null"}) > 1}
    return [_as_text(table, mixed) for table in tables]


def _as_text(table: pa.Table, names: Iterable[str]) -> pa.Table:
    """Return a table with some of its columns as text."""
    for place, name in enumerate(table.column_names):
        if name in names:
            cells = [_text(each) for each in table[name].to_pylist()]
            table = table.set_column(place, name, pa.array(cells, pa.string()))
    return table


def _text(cell: Any) -> str | None:
    """Return a cell as text; an integer that became a float beside others as the integer."""
    if cell is None:
        return None
    return str(cell).removesuffix(".0") if isinstance(cell, float) else str(cell)


def _kind(kind: pa.DataType) -> str:
    """Return what goes together in one column: numbers, or cells of one type."""
    number = pa.types.is_integer(kind) or pa.types.is_floating(kind)
    return "number" if number else str(kind)


def _read(part: Path, columns: list[str] | None = None) -> pa.Table:
    """Return a part; raises BagError for one that cannot be read."""
    try:
        return parquet.read_table(part, columns=columns)
    except (OSError, KeyError, pa.ArrowException) as error:
        why = " ".join(str(error).split())
        raise BagError(f"{part}: cannot be read; delete it to run it again: {why}") from error
