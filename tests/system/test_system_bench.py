"""Bench system, shortened: every process has its share, and the times are those of the bag."""

import json

import numpy as np
import pytest

from lexstack_experiments.benches import system
from lexstack_experiments.commands import bench

pytestmark = [pytest.mark.system, pytest.mark.alone]


def test_the_whole_system_is_measured(tmp_path, monkeypatch):
    monkeypatch.setattr(system, "_SHORT", 2.0)
    assert bench.main(["system", "--cases", "1", "--out", str(tmp_path / "out")]) == 0
    content = json.loads((tmp_path / "out" / "results.json").read_text(encoding="utf-8"))
    rows = content["tables"][0]["rows"]
    assert [row["phase"] for row in rows] == list(system._WHOM.values())
    nodes = ("CPU % of a core: bridge", "controller", "solver", "HTMPC", "recorder")
    for row in rows:
        assert row["ticks/s"] > 10.0
        assert row["in its best second"] >= 0.8 * row["ticks/s"]
        assert 0.0 < row["state to command p50 ms"] <= row["p99 ms"]
        assert row["missing %"] == 0.0, "lockstep waits"
        shares = [row[node] for node in nodes]
        assert min(shares) > 0.0
        assert sum(shares) < 210.0, "of two cores"
    alone, followed, planned = rows
    assert followed["solver"] > alone["solver"], "it solves"
    assert planned["HTMPC"] > alone["HTMPC"], "it plans"


def test_memory_that_grows_is_told():
    flat = {"memory": {"a": [100, 101, 100, 101] * 4, "b": list(range(0, 160, 10))}}
    slopes = system._slopes([flat])
    assert abs(slopes["a"]) < 60.0
    assert slopes["b"] == pytest.approx(600.0), "10 kB a second"


def test_late_ticks_count_apart_where_the_host_left_the_machine_alone():
    second = 10**9
    at = np.arange(400) * (second // 100)
    late = np.cumsum((at >= second) & (at < 2 * second)) + (at >= 3 * second)  # all of second 1
    ticks = np.stack([at, late], axis=1)
    kept = [(k * second, 0.3 if k > 1 else 0.0) for k in range(5)]
    assert system._undisturbed(ticks, kept[1:]) == (200, 1), "seconds 2 and 3 are left"
    assert system._undisturbed(ticks, [(at, 0.0) for at, _ in kept[1:]]) == (300, 101)
    assert system._undisturbed(ticks, [(k * second, 0.3 * k) for k in range(5)]) == (0, 0)
