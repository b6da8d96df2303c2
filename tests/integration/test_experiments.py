"""Every experiment and bench in a shortened form: it ends, and its figures are numbers."""

import json
import math

import pytest

from lexstack_experiments.benches import BENCHES, speed
from lexstack_experiments.commands import bench, experiment
from lexstack_experiments.experiment import Experiment
from lexstack_experiments.experiments import EXPERIMENTS, method_cases, transition_methods
from lexstack_experiments.experiments.method_runs import Play
from lexstack_experiments.methods import METHODS
from lexstack_experiments.results import Figure
from lexstack_experiments.runs import never_switched
from support.results import numbers
from support.scenario import CONFIG


def results_of(main, name, folder, *arguments):
    """Run a command and return its results.json."""
    assert main([name, "--out", str(folder), "--cases", "1", *arguments]) == 0
    content = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    assert content["name"] == name
    assert content["figures"]
    assert content["tables"][0]["rows"]
    found = list(numbers(content))
    assert len(found) > 20
    assert all(math.isfinite(number) for number in found)
    return content


def figures(content):
    """Return the value of every figure by its name."""
    return {figure["name"]: figure["value"] for figure in content["figures"]}


@pytest.fixture
def few_methods(monkeypatch):
    """Compare few methods on one short case."""
    monkeypatch.setattr(transition_methods, "METHODS", ("bridge", "t37", "instant_limited"))
    every = transition_methods.cases
    monkeypatch.setattr(transition_methods, "cases", lambda *arguments: every(*arguments)[3:4])


def test_the_list_of_experiments_is_tested_here():
    assert set(EXPERIMENTS) >= {
        "transition-sequence",
        "transition-methods",
        "computation",
        "robots",
    }
    assert set(BENCHES) >= {"transition"}


def test_transition_sequence(tmp_path):
    content = results_of(experiment.main, "transition-sequence", tmp_path)
    found = figures(content)
    assert found["End-effector error after (A)"] <= 2.0
    assert found["Peak acceleration of the command / limit"] <= 1.0
    assert found["Final end-effector error"] is None, "the run ends after (A)"
    assert {file.name for file in tmp_path.glob("*.png")} == {"fig5.png", "fig6.png"}
    assert all(file.stat().st_size < 150_000 for file in tmp_path.glob("*.png"))


def test_obstacle(tmp_path):
    content = results_of(experiment.main, "obstacle", tmp_path)
    rows = {row["way"]: row for row in content["tables"][0]["rows"]}
    assert list(rows) == ["nothing", "base task", "distance task"]
    assert rows["nothing"]["clearance mm"] < -5.0
    assert rows["nothing"]["touching, ticks"] > 100
    for way in ("base task", "distance task"):
        assert rows[way]["clearance mm"] > 40.0
        assert rows[way]["touching, ticks"] == 0
        assert rows[way]["EE peak mm"] < 5.0
    assert rows["distance task"]["acc. ratio"] <= 1.0 + 1e-9
    assert (tmp_path / "obstacle-clearance.png").stat().st_size < 150_000


def test_peers(tmp_path):
    content = results_of(experiment.main, "peers", tmp_path)
    assert not any(value for name, value in figures(content).items() if name.startswith("ticks"))
    rows = [row for row in content["tables"][0]["rows"] if row["law"] == "lexstack, by joints"]
    assert [row["robot"] for row in rows] == ["panda", "panda", "ur10", "ur10", "xarm7", "xarm7"]
    assert all(row["reached %"] == 100.0 and row["median s"] < 3.0 for row in rows)
    assert all(row["most x"] <= 1.0 + 1e-6 for row in rows if row["limits"] == "acceleration")
    assert (tmp_path / "peers.png").stat().st_size < 150_000


def test_transition_methods(tmp_path, few_methods):
    content = results_of(experiment.main, "transition-methods", tmp_path)
    rows = {row["method"]: row for row in content["tables"][0]["rows"]}
    assert list(rows) == ["no switch", "bridge", "t37", "instant_limited"]
    assert rows["bridge"]["acc. ratio"] < rows["instant_limited"]["acc. ratio"] <= 1.0 + 1e-9
    assert rows["bridge"]["excess"] < 1e-6
    # Two levels a tick; those of the own optimum too, while it takes over from a late solver.
    assert 2.0 < rows["bridge"]["QPs"] < 3.0
    assert (tmp_path / "methods.png").stat().st_size < 150_000


def test_the_comparison_is_against_t34_in_its_stronger_reading_too():
    """With the acceleration limits of T(31) in its boxes, as the sudden limits have it."""
    case = method_cases.cases(CONFIG, 0)[0]
    still = Play(never_switched(case), "bridge")
    found = {name: Play(case, name) for name in ("t34", "t34_limited")}
    assert set(found) < set(METHODS)
    for row in case.rows:
        loose, limited = (play.figures(row, still) for play in found.values())
        assert limited.acceleration <= 1.0 + 1e-9
        assert limited.acceleration <= loose.acceleration
        assert limited.empty == 0
        assert limited.excess < 1e-9
    assert loose.acceleration > 5.0, "at (C) the other reading goes far beyond the limits"


def test_sudden_limits(tmp_path):
    content = results_of(experiment.main, "sudden-limits", tmp_path)
    rows = {row["law"]: row for row in content["tables"][0]["rows"]}
    assert rows["ours"]["empty"] == rows["ours"]["late ticks"] == 0
    assert rows["ours"]["acc. ratio"] <= 1.0 + 1e-9
    assert rows["T(31), brake"]["outside s"] is None, "it never comes inside"
    assert min(row["empty"] for name, row in rows.items() if name.startswith("T")) > 10
    assert (tmp_path / "fig1.png").stat().st_size < 150_000


def test_computation(tmp_path):
    content = results_of(experiment.main, "computation", tmp_path)
    rows = [row["us p50"] for row in content["tables"][0]["rows"]]
    assert all(10.0 < row < 1e6 for row in rows)
    assert (tmp_path / "fig9.png").is_file()


def test_bench_transition(tmp_path):
    content = results_of(bench.main, "transition", tmp_path)
    assert figures(content)["Replayed chi against recorded"] == 0.0
    assert len(content["tables"]) == 2
    assert {row["state"] for row in content["tables"][0]["rows"]} == {"idle", "blending"}


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_bench_tick(tmp_path):
    content = results_of(bench.main, "tick", tmp_path)
    ratios, rows = (table["rows"] for table in content["tables"])
    kinds = {"track", "reach_base", "posture", "blend", "out of reach"}
    for table in (ratios, rows):
        keys = {(row["robots"], row["tick"]) for row in table}
        assert keys == {(n, k) for n in (1, 2) for k in kinds}
    assert all(row["us p99"] >= row["us p50"] >= row["us p50, quiet"] > 0.0 for row in rows)
    assert all(row["p50 over the cascade"] < 1.0 for row in ratios), "the kernel is compiled"
    assert content["quiet"]["spread"] >= 1.0


def test_bench_speed_shows_the_goals_of_the_benches_it_ran(tmp_path, monkeypatch):
    def scaled(options):
        return options.results("scaling", [Figure("whole tick, 32 robots over 2", 9.0, "x")])

    parts = {
        "transition": BENCHES["transition"],
        "scaling": Experiment("robots", "passes", 200, scaled),
    }
    monkeypatch.setattr(speed, "_PARTS", parts)
    assert bench.main(["speed", "--out", str(tmp_path), "--cases", "1"]) == 0
    content = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    rows = content["tables"][0]["rows"]
    assert [row["bench"] for row in rows] == ["transition", "transition", "scaling"]
    assert rows[-1]["ours"] == "9"
    assert [figure["reached"] for figure in content["figures"]][-1] is True
    for name, cases in (("transition", 1), ("scaling", 2)):
        part = json.loads((tmp_path / name / "results.json").read_text(encoding="utf-8"))
        assert (part["name"], part["cases"]) == (name, cases)
        assert part["quiet"]["spread"] >= 1.0


def test_robots(tmp_path):
    content = results_of(experiment.main, "robots", tmp_path)
    rows = content["tables"][0]["rows"]
    assert [(row["robots"], row["switch"], row["channels"]) for row in rows] == [
        (2, "at once", 1),
        (2, "one by one", 2),
    ]
    found = figures(content)
    assert found["Robots that have not adopted their stack"] == 0.0
    assert found["chi off the dense solution"] <= 1e-6
    assert found["Tick of 8 robots over that of 2, at once"] is None, "it was not run"
