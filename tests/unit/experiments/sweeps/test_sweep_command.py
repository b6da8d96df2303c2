"""The command: what is kept, how it goes on, and what it says."""

import numpy as np
import pytest
from pyarrow import parquet

from lexstack.errors import ConfigurationError
from lexstack.limits import viable_bounds
from lexstack_experiments.commands import sweep as command
from lexstack_experiments.sweeps.execution import ERROR
from lexstack_experiments.sweeps.kinds import KINDS
from lexstack_experiments.sweeps.storage import RUNS
from lexstack_experiments.sweeps.summary import limits_kept
from lexstack_experiments.sweeps.sweep_file import load_sweep

TEXT = """
name: small
description: "A few short runs."
run: promises
grid: {{duration: [0.05, 0.2]}}
random: {{requests: {{low: 1, high: 3, of: integers}}}}
runs: 3
limits: {{acceleration_ratio: {{most: {most}}}, level_1_above_best: {{most: 1.0e-8}}}}
"""


@pytest.fixture
def small(tmp_path):
    path = tmp_path / "small.yaml"
    path.write_text(TEXT.format(most=1.000000001), encoding="utf-8")
    return path


def run(path, tmp_path, *more):
    out = tmp_path / "out"
    code = command.main([str(path), "--out", str(out), "--workers", "1", "--batch", "2", *more])
    return code, out


def test_a_sweep_goes_on_where_it_ended_and_gives_the_same_as_at_once(small, tmp_path, capsys):
    assert run(small, tmp_path, "--first", "3")[0] == 0
    code, out = run(small, tmp_path, "--strict")
    assert code == 0
    assert "6 runs, 3 of them done before" in capsys.readouterr().err
    in_parts = parquet.read_table(out / RUNS)
    again = tmp_path / "again"
    assert command.main([str(small), "--out", str(again), "--workers", "1"]) == 0
    assert parquet.read_table(again / RUNS).equals(in_parts)
    assert in_parts["run"].to_pylist() == list(range(6))
    assert "level_1_above_best" in (out / "report.html").read_text(encoding="utf-8")


def test_a_broken_limit_is_counted_and_the_run_named(small, tmp_path, capsys):
    small.write_text(TEXT.format(most=0.5), encoding="utf-8")
    code, out = run(small, tmp_path, "--strict")
    assert code == 1
    said = capsys.readouterr().out
    table = parquet.read_table(out / RUNS)
    worst = int(np.argmax(table["acceleration_ratio"].to_numpy()))
    assert "acceleration_ratio <= 0.5: broken in 6 of 6 runs" in said
    assert f"run {worst}" in said.splitlines()[0]
    assert "level_1_above_best <= 1e-08: broken in 0 of 6 runs; chance <= 0.46 at" in said


def test_a_promise_that_does_not_hold_is_seen(small, tmp_path, monkeypatch):
    monkeypatch.setattr(
        "lexstack.limits.limits_in_force.viable_bounds",
        lambda q, limits, dt, applied, *_: viable_bounds(q, limits, 1e3 * dt, applied),
    )
    sweep = load_sweep(small)
    ratios = [
        KINDS["promises"](command_config(), "", sweep.values(i))["acceleration_ratio"]
        for i in range(3)
    ]
    assert max(ratios) > 1.1


def test_a_run_that_cannot_be_done_is_told_and_the_others_go_on(small, tmp_path, monkeypatch):
    from lexstack.errors import LexstackError

    def sometimes(config, of, values):
        if values["seed"] % 2:
            raise LexstackError("the bag cannot\nbe read")
        return {"acceleration_ratio": 0.5}

    monkeypatch.setitem(KINDS, "promises", sometimes)
    code, out = run(small, tmp_path)
    assert code == 0
    table = parquet.read_table(out / RUNS)
    odd = [seed % 2 == 1 for seed in table["seed"].to_pylist()]
    assert [text == "the bag cannot be read" for text in table[ERROR].to_pylist()] == odd
    kept = limits_kept(table, load_sweep(small))
    assert kept[0].runs == 6 - sum(odd)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ("seed: 1\n", "has runs of another sweep"),
        ("random: {other: {low: 0, high: 1}}\n", "other"),
        ("random: {stacks: {type: one_of, values: [[]]}}\n", "stacks: at least one stack"),
    ],
)
def test_another_sweep_or_an_unknown_value_is_refused(small, tmp_path, capsys, change, told):
    text = small.read_text(encoding="utf-8")
    if change.startswith("seed"):
        assert run(small, tmp_path, "--first", "1")[0] == 0
        small.write_text(text + change, encoding="utf-8")
    else:
        kept = [line for line in text.splitlines() if not line.startswith("random")]
        small.write_text("\n".join(kept) + "\n" + change, encoding="utf-8")
    assert run(small, tmp_path)[0] == 2
    error = [line for line in capsys.readouterr().err.splitlines() if line.startswith("error: ")]
    assert len(error) == 1
    assert told in error[0]


@pytest.mark.parametrize("address", ["here", "ray", "127.0.0.1:80"])
def test_an_address_of_no_cluster_is_refused(small, tmp_path, capsys, address):
    assert run(small, tmp_path, "--cluster", address)[0] == 2
    assert "--cluster: expected" in capsys.readouterr().err


def command_config():
    from support.scenario import CONFIG

    return CONFIG


@pytest.mark.parametrize("figure", ["acceleration", "stacks"])
def test_a_limit_that_judges_nothing_is_told(small, tmp_path, capsys, figure):
    text = small.read_text(encoding="utf-8").replace("acceleration_ratio", figure)
    small.write_text(text, encoding="utf-8")
    code, _ = run(small, tmp_path, "--strict", "--first", "2")
    assert code == 1
    assert f"{figure} <= 1: not judged, no run has this figure" in capsys.readouterr().out


def test_a_limit_on_a_text_is_not_judged(small, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(KINDS, "promises", lambda *_: {"acceleration_ratio": "fast"})
    assert run(small, tmp_path)[0] == 0
    assert "acceleration_ratio <= 1: not judged" in capsys.readouterr().out


@pytest.mark.parametrize("figure", [np.inf, np.nan])
def test_a_figure_that_is_not_finite_breaks_its_limit(small, tmp_path, monkeypatch, capsys, figure):
    monkeypatch.setitem(KINDS, "promises", lambda *_: {"acceleration_ratio": figure})
    assert run(small, tmp_path, "--strict")[0] == 1
    assert "acceleration_ratio <= 1: broken in 6 of 6 runs" in capsys.readouterr().out


def test_a_run_whose_arithmetic_fails_takes_no_other_with_it(small, tmp_path, monkeypatch):
    def sometimes(config, of, values):
        return {"acceleration_ratio": 1.0 / (values["duration"] - 0.2)}

    monkeypatch.setitem(KINDS, "promises", sometimes)
    assert run(small, tmp_path)[0] == 0
    table = parquet.read_table(tmp_path / "out" / RUNS)
    assert table[ERROR].to_pylist() == [""] * 3 + ["ZeroDivisionError: float division by zero"] * 3


@pytest.mark.parametrize("batch", ["1", "3", "6"])
def test_values_of_several_types_are_kept(small, tmp_path, monkeypatch, batch):
    text = small.read_text(encoding="utf-8").replace("[0.05, 0.2]", "[auto, 3, 0.5, null, true]")
    small.write_text(text, encoding="utf-8")
    monkeypatch.setitem(KINDS, "promises", lambda *_: {"acceleration_ratio": 1})
    assert run(small, tmp_path, "--batch", batch)[0] == 0
    kept = parquet.read_table(tmp_path / "out" / RUNS)["duration"].to_pylist()
    in_words = ("auto", "3", "0.5", None, "True")
    assert kept == [text for text in in_words for _ in range(3)]


def test_a_part_that_is_cut_short_is_named(small, tmp_path, capsys):
    assert run(small, tmp_path, "--first", "3")[0] == 0
    part = sorted((tmp_path / "out" / "parts").glob("*.parquet"))[0]
    part.write_bytes(part.read_bytes()[:-20])
    assert run(small, tmp_path)[0] == 1
    error = capsys.readouterr().err.splitlines()[-1]
    assert error.startswith(f"error: {part}: cannot be read; delete it to run it again: ")
    part.unlink()
    assert run(small, tmp_path)[0] == 0


@pytest.mark.parametrize("values", [{"ticks": 3}, {"cases": 3}])
def test_a_fault_has_no_other_values(values):
    with pytest.raises(ConfigurationError, match="a fault has only seed and case"):
        KINDS["fault"](command_config(), "x", {"seed": 1, **values})
