"""The experiments of paper H in a shortened form: they end, and their figures make sense."""

import json
import math

import pytest

from lexstack_experiments.benches import htmpc as bench
from lexstack_experiments.benches import htmpc_peers as peers
from lexstack_experiments.commands import bench as bench_command
from lexstack_experiments.commands import experiment
from lexstack_experiments.experiments import EXPERIMENTS, delivery, htmpc_tuning
from support.results import numbers

NAMES = {
    "lexicographic-constraints",
    "square-wave",
    "waypoint-path",
    "delivery",
    "reactivity",
    "htmpc-computation",
    "oracle",
    "tune-htmpc",
}


def results_of(name, folder, cases):
    """Run an experiment; return its figures by name, its tables, and itself."""
    assert experiment.main([name, "--out", str(folder), "--cases", str(cases)]) == 0
    content = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    assert (content["name"], content["cases"]) == (name, cases)
    assert all(math.isfinite(number) for number in numbers(content))
    for picture in folder.glob("*.png"):
        assert picture.stat().st_size < 150_000
    figures = {figure["name"]: figure["value"] for figure in content["figures"]}
    return figures, [table["rows"] for table in content["tables"]], content


def test_all_of_them_are_registered():
    assert set(EXPERIMENTS) >= NAMES


def test_lexicographic_constraints(tmp_path):
    figures, (rows,), _ = results_of("lexicographic-constraints", tmp_path, 1)
    assert figures["Ours: EE error, mean"] <= 1.0
    assert figures["Ours: EE error, peak"] <= 10.0
    assert figures["Ours: failed solves"] == 0.0
    assert rows[0]["constraint"] == "H(12)"
    assert (tmp_path / "fig5.png").is_file()


def test_square_wave(tmp_path):
    _, (rows, cases), _ = results_of("square-wave", tmp_path, 1)
    found = {row["controller"]: row for row in rows}
    assert len(found) == len(cases) == 6
    assert found["HTMPC"]["part 2"] < 0.5 * found["HTIDKC authors"]["part 2"]
    assert found["HTMPC"]["part 2"] < found["HTMPC_WPT"]["part 2"], "foresight"
    assert all(row["part 1 - optimum"] > 0.0 for row in rows)
    assert {file.name for file in tmp_path.glob("*.png")} == {
        f"fig{number}.png" for number in (3, 4, 6, 7)
    }


def test_the_hierarchical_way_is_shorter_than_the_one_with_a_predefined_distance(tmp_path):
    figures, (rows,), _ = results_of("waypoint-path", tmp_path, 1)
    (row,) = rows
    assert row["least m"] < row["HT path m"] < row["ST path m"]
    assert row["HT s"] < row["ST s"]
    assert figures["Trips that were not completed"] == 0.0
    assert row["HT nearest m"] <= row["reach m"] + 0.01, "the tool cannot reach further"
    assert (tmp_path / "fig8.png").is_file()


def test_one_round_of_deliveries(tmp_path, monkeypatch):
    first = delivery.layouts()[:1]
    monkeypatch.setattr(delivery, "layouts", lambda: first)
    figures, (rows,), _ = results_of("delivery", tmp_path, 1)
    assert figures["Sequences that were not completed"] == 0.0
    for row in rows:
        assert 1.5 < row["ST / HT"] < 5.0
        assert row["HT base s"] + row["HT tool s"] == pytest.approx(row["HT s"])
        # Nobody is faster than the base's plan, whose end may be cut by the tolerance.
        assert row["HT s"] >= (row["line m"] - 4 * delivery.TOLERANCE) / 0.5
    assert (tmp_path / "fig9.png").is_file()


def test_reactions_to_a_release_a_moved_target_and_a_jump(tmp_path):
    figures, (rows,), _ = results_of("reactivity", tmp_path, 3)
    assert [row["what"] for row in rows] == ["held", "next moves", "jump"]
    assert figures["Targets not reached"] == 0.0
    assert figures["Failed solves"] == 0.0
    for row in rows:
        assert row["EE held mm"] < 10.0, "the base stopped in time"
        assert 0.9 < row["arm / reach"] < 1.01, "and not long before"
    assert rows[2]["back within 20 mm s"] < 2.0
    assert rows[0]["back within 20 mm s"] is None


def test_the_gap_to_the_converged_optimum(tmp_path):
    figures, (rows,), _ = results_of("oracle", tmp_path, 6)
    assert figures["States where IPOPT did not converge"] == 0.0
    assert len(rows) == 8
    level = {(row["level"], row["guess"], row["iterations"]): row for row in rows}
    assert level[1, "cold", 3]["gap p50"] < level[1, "cold", 1]["gap p50"]
    assert all(row["gap worst"] >= row["gap p50"] for row in rows if row["states"])


def test_computation(tmp_path, monkeypatch):
    monkeypatch.setattr(bench, "ROBOTS", ("panda_summit",))
    monkeypatch.setattr(bench, "HORIZONS", (10,))
    figures, (rows, htidkc), _ = results_of("htmpc-computation", tmp_path, 2)
    assert figures["Solves with a failed level"] == 0.0
    assert {row["spheres"] for row in rows} == {0, 10}
    assert all(0.1 < row["ms mean"] < 1e3 for row in [*rows, *htidkc])
    ratios = [row["paper over ours"] for row in rows if row["parameters"] == "authors"]
    assert min(ratios) > 1.0


def test_peers_on_one_level_take_the_same_step(tmp_path, monkeypatch):
    monkeypatch.setattr(peers, "ROBOTS", ("panda_summit",))
    monkeypatch.setattr(peers, "HORIZONS", (10,))
    command = ["htmpc-peers", "--out", str(tmp_path), "--cases", "3"]
    assert bench_command.main(command) == 0
    content = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    rows = {row["solver"]: row for row in content["tables"][0]["rows"]}
    steps = [rows[name] for name in ("lexstack", "the paper's way, OSQP", "HPIPM through CasADi")]
    gaps = [float(row["gap, mean"]) for row in steps]
    assert gaps[1:] == pytest.approx([gaps[0]] * 2, rel=0.2, abs=1e-5)
    assert float(rows["lexstack, to the end"]["gap, mean"]) <= gaps[0] + 1e-6
    assert sum(row["failed"] for row in rows.values()) == 0
    assert any("crocoddyl" in note for note in content["notes"]), "how to have it is said"


def test_tuning_gives_every_controller_as_many_trials(tmp_path, monkeypatch):
    monkeypatch.setattr(htmpc_tuning, "PEAKS", 1)
    figures, (rows,), _ = results_of("tune-htmpc", tmp_path, 3)
    counts = [sum(row["controller"] == name for row in rows) for name in ("lexstack", "waypoints")]
    assert counts == [3, 3]
    for name in ("lexstack", "waypoints", "htidkc-tuned"):
        assert figures[f"{name}: score"] <= figures[f"{name}: score of the first trial"]
        assert (tmp_path / f"{name}.yaml").is_file()
