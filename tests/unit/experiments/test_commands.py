"""The commands around experiments: names, arguments, exit codes, what is written where."""

import json
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from lexstack.errors import ConfigurationError, ModelError
from lexstack_experiments.benches import BENCHES
from lexstack_experiments.commands.command import run_command
from lexstack_experiments.experiment import Experiment
from lexstack_experiments.experiments import EXPERIMENTS
from lexstack_experiments.results import Figure, Goal, Results


def fake(limit=1.0, error=None):
    """Return an experiment whose one figure is 0.5, or which raises."""

    def run(options):
        if error is not None:
            raise error
        options.say("at work")
        figure = Figure("error", 0.5, "mm", Goal("<=", limit))
        return Results("fake", options.seed, options.cases, (figure,))

    return {"fake": Experiment("does nothing", "rounds", 4, run)}


def run(tmp_path, known, *arguments):
    """Run the command with a folder for its results."""
    return run_command("experiment", known, ["fake", "--out", str(tmp_path / "out"), *arguments])


def test_a_run_writes_results_and_prints_the_table(tmp_path, capsys):
    assert run(tmp_path, fake(), "--seed", "7", "--cases", "2") == 0
    content = json.loads((tmp_path / "out/results.json").read_text(encoding="utf-8"))
    assert (content["name"], content["seed"], content["cases"]) == ("fake", 7, 2)
    printed = capsys.readouterr()
    assert printed.out.splitlines()[-1] == "reached 1 of 1"
    assert "at work" in printed.err, "progress stands beside the results"


@pytest.mark.parametrize(
    ("limit", "strict", "code"), [(1, 0, 0), (1, 1, 0), (0.1, 0, 0), (0.1, 1, 1)]
)
def test_only_strict_asks_for_the_goals(tmp_path, limit, strict, code):
    assert run(tmp_path, fake(limit), *["--strict"][:strict]) == code
    assert (tmp_path / "out/results.json").is_file(), "the results are there in any case"


@pytest.mark.parametrize(
    ("arguments", "word"),
    [(["--cases", "0"], "[1, 4]"), (["--cases", "5"], "rounds"), (["--seed", "-1"], "--seed")],
)
def test_bad_values_exit_with_2_and_one_line(tmp_path, capsys, arguments, word):
    assert run(tmp_path, fake(), *arguments) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ")
    assert word in error
    assert error.count("\n") == 1


@pytest.mark.parametrize("arguments", [["nothing"], [], ["fake", "--seed", "x"], ["fake", "--no"]])
def test_bad_arguments_exit_with_2_and_list_the_names(capsys, arguments):
    with pytest.raises(SystemExit) as stop:
        run_command("experiment", fake(), arguments)
    assert stop.value.code == 2
    assert "./scripts/experiment" in capsys.readouterr().err


def test_an_unknown_name_lists_the_known(capsys):
    with pytest.raises(SystemExit):
        run_command("bench", fake(), ["nothing"])
    assert "fake" in capsys.readouterr().err


def test_a_folder_with_something_in_it_is_left_alone(tmp_path, capsys):
    (tmp_path / "out").mkdir()
    (tmp_path / "out/mine.txt").write_text("keep me")
    assert run(tmp_path, fake()) == 2
    assert "is not empty" in capsys.readouterr().err
    assert [file.name for file in (tmp_path / "out").iterdir()] == ["mine.txt"]


@pytest.mark.parametrize(("error", "code"), [(ConfigurationError("a"), 2), (ModelError("b"), 1)])
def test_what_goes_wrong_is_one_line(tmp_path, capsys, error, code):
    assert run(tmp_path, fake(error=error)) == code
    assert capsys.readouterr().err == f"error: {error}\n"


def test_ctrl_c_is_130(tmp_path):
    assert run(tmp_path, fake(error=KeyboardInterrupt())) == 130


def test_the_default_folder_bears_name_and_time(tmp_path, monkeypatch):
    monkeypatch.setenv("LEXSTACK_ROOT", str(tmp_path))
    assert run_command("bench", fake(), ["fake"]) == 0
    (folder,) = (tmp_path / "runs").iterdir()
    assert folder.name.startswith("bench-fake-2")


@pytest.mark.parametrize(("kind", "known"), [("experiment", EXPERIMENTS), ("bench", BENCHES)])
def test_help_lists_every_name_with_one_line(capsys, kind, known):
    with pytest.raises(SystemExit) as stop:
        run_command(kind, known, ["--help"])
    assert stop.value.code == 0
    lines = capsys.readouterr().out.splitlines()
    for name, entry in known.items():
        assert any(name in line and entry.summary in line for line in lines)


def lasting(seen):
    """Return two experiments, one of which has a duration."""
    plain = fake()["fake"]

    def note(options):
        seen.append(options.seconds)
        return plain.run(options)

    long = replace(plain, run=note, seconds=60.0, soak=1800.0)
    return {"plain": plain, "long": long}


@pytest.mark.parametrize(
    ("arguments", "seconds"), [([], 60.0), (["--duration", "5"], 5.0), (["--soak"], 1800.0)]
)
def test_a_duration_is_handed_on(tmp_path, arguments, seconds):
    seen = []
    given = ["long", "--out", str(tmp_path / "out"), *arguments]
    assert run_command("bench", lasting(seen), given) == 0
    assert seen == [seconds]


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (["plain", "--soak"], "plain has no duration"),
        (["plain", "--duration", "5"], "plain has no duration"),
        (["long", "--duration", "0.5"], "--duration: must be in [1, 86400] s, got 0.5"),
        (["long", "--duration", "nan"], "--duration: must be in"),
    ],
)
def test_a_wrong_duration_is_one_line(tmp_path, capsys, arguments, what):
    given = [*arguments, "--out", str(tmp_path / "out")]
    assert run_command("bench", lasting([]), given) == 2
    assert what in capsys.readouterr().err


def compared(seen):
    """Return a bench that takes others, and one that does not."""
    plain = fake()["fake"]

    def note(options):
        seen.append((options.peers, options.against))
        return plain.run(options)

    return {"fake": replace(plain, run=note, peers=("placo",), against=True), "plain": plain}


def test_a_bench_gets_the_pythons_of_peers_and_the_other_clone(tmp_path, monkeypatch):
    seen, clone, python = [], tmp_path / "clone", Path(sys.executable)
    (clone / "ros2_ws/src").mkdir(parents=True)
    given = ["--peers", str(python), str(python), "--against", str(clone)]
    assert run(tmp_path, compared(seen), *given) == 0
    assert seen == [((python, python), clone)]


@pytest.mark.parametrize(
    ("name", "arguments", "word"),
    [
        ("fake", ["--against", "/nowhere"], "no clone of this project"),
        ("fake", ["--peers", "/nowhere/python"], "is no program"),
        ("plain", ["--against", "."], "not compared"),
        ("plain", ["--peers", sys.executable], "no such peers"),
    ],
)
def test_others_that_are_not_there_are_one_line(tmp_path, capsys, name, arguments, word):
    out = ["--out", str(tmp_path / "out")]
    assert run_command("bench", compared([]), [name, *out, *arguments]) == 2
    error = capsys.readouterr().err
    assert word in error
    assert error.count("\n") == 1


def test_a_bench_says_whether_the_machine_was_quiet_and_an_experiment_does_not(tmp_path, capsys):
    for kind in ("bench", "experiment"):
        folder = tmp_path / kind
        assert run_command(kind, fake(), ["fake", "--out", str(folder)]) == 0
        said = "The machine was " in capsys.readouterr().out
        content = json.loads((folder / "results.json").read_text(encoding="utf-8"))
        assert said == (content["quiet"] is not None) == (kind == "bench")
