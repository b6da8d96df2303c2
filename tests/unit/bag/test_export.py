"""Tables of a run: the same bits come back, and every number has its unit."""

from __future__ import annotations

import csv
import re

import numpy as np
import pytest
from pyarrow import parquet

from lexstack_bag.commands import analyze
from lexstack_bag.figures.export import tables, write_csv, write_parquet
from lexstack_bag.figures.series import measure
from lexstack_bag.run.reader import read_run

NAMES = {"plant", "errors", "robot_a_chi", "robot_b_chi", "transition", "targets"}
WITHOUT_UNIT = re.compile(
    "tick|stack|from_stack|to_stack|id|transition_id|source|method|phase|alpha|reason|status|robot|"
    "kind|empty_bounds|late_ticks|missing_ticks|slack/level_.|quaternion/."
)


@pytest.fixture(scope="module")
def run(synthetic):
    return read_run(synthetic.folder)


@pytest.fixture(scope="module")
def time_series(run):
    return measure(run)


def read_csv(path):
    with path.open(encoding="utf-8", newline="") as stream:
        head, *rows = csv.reader(stream)
    return {name: [row[i] for row in rows] for i, name in enumerate(head)}


def test_every_column_has_a_unit_or_needs_none(run, time_series):
    found = tables(run, time_series)
    assert set(found) == NAMES
    for columns in found.values():
        assert len({len(column) for column in columns.values()}) == 1
        for name in columns:
            assert re.search(r"\[(m|m/s|rad|rad/s|mm|mrad|s|m/s, rad/s)\]$", name) or (
                WITHOUT_UNIT.fullmatch(name)
            ), name


def test_csv_gives_the_same_bits(run, time_series, tmp_path):
    paths = write_csv(tmp_path, run, time_series, lambda _part: None)
    assert {path.name for path in paths} == {f"{name}.csv" for name in NAMES}
    plant = read_csv(tmp_path / "plant.csv")
    assert [int(tick) for tick in plant["tick"]] == run.plant.tick.tolist()
    for name, column in (("q/robot_b/base_y [m]", 11), ("q/robot_a/panda_joint7 [rad]", 9)):
        np.testing.assert_array_equal(np.array(plant[name], float), run.plant.q[:, column])
    chi = read_csv(tmp_path / "robot_a_chi.csv")
    values = np.array(chi["chi/robot_a/base_x [m/s]"], float)
    np.testing.assert_array_equal(values, run.chi["robot_a"].chi[:, 0])
    assert chi["reason"][60] == "braking"
    assert read_csv(tmp_path / "targets.csv")["kind"] == ["ee", "base", "ee"]


def test_parquet_gives_the_same_bits(run, time_series, tmp_path):
    write_parquet(tmp_path, run, time_series, lambda _part: None)
    assert {path.stem for path in tmp_path.iterdir()} == NAMES
    for name, columns in tables(run, time_series).items():
        table = parquet.read_table(tmp_path / f"{name}.parquet")
        assert table.column_names == list(columns)
        for key, column in columns.items():
            np.testing.assert_array_equal(table[key].to_numpy(), column, strict=False)


def test_the_command_writes_both(synthetic, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(analyze, "write_report", lambda *_arguments: None)
    arguments = [str(synthetic.folder), "--out", str(tmp_path)]
    arguments += ["--csv", str(tmp_path / "c"), "--parquet", str(tmp_path / "p")]
    assert analyze.main(arguments) == 0
    assert len(list((tmp_path / "c").iterdir())) == len(list((tmp_path / "p").iterdir())) == 6
    assert "plant.csv" in capsys.readouterr().out


def test_two_bags_are_compared(synthetic, tmp_path, capsys):
    arguments = [str(synthetic.folder), str(synthetic.folder), "--out", str(tmp_path)]
    assert analyze.main(arguments) == 0
    assert (tmp_path / "comparison.json").is_file()
    assert "figures are the same" in capsys.readouterr().out
    assert analyze.main([*arguments, "--csv", str(tmp_path)]) == 2
    assert analyze.main([str(synthetic.folder), "nowhere"]) == 2
    assert capsys.readouterr().err.splitlines()[-1].endswith("nowhere: no such file or folder")


def test_without_pyarrow_it_says_so(run, time_series, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pyarrow.parquet", None)
    with pytest.raises(analyze.BagError, match="pyarrow is not installed"):
        write_parquet(tmp_path, run, time_series, lambda _part: None)
