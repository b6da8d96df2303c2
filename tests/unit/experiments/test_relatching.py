"""The random trains of events by command: those of the tests, with ways and end times."""

from lexstack_experiments.commands.command import run_command
from lexstack_experiments.experiment import Options
from lexstack_experiments.experiments import EXPERIMENTS
from support.scenario import CONFIG
from support.trains import path_lengths, random_train, run


def test_a_train_is_named_by_its_seed_and_run_with_and_without_a_perfect_b(tmp_path):
    results = EXPERIMENTS["relatching"].run(Options(CONFIG, tmp_path, 2, 1))
    assert results.all_reached, results.figures
    (table,) = results.tables
    row = dict(zip(table.columns, table.rows[0], strict=True))
    train = random_train(2, 400)
    assert (row["seed"], row["mode"], row["targets"]) == (2, "lockstep", len(train.targets))
    assert row["way m"] in path_lengths(run(train)).tolist()
    assert row["way with solver m"] in path_lengths(run(train, perfect=True)).tolist()
    assert 0.0 <= row["over after s"] <= row["promised s"]


def test_the_command_takes_seed_and_number(tmp_path, capsys):
    arguments = ["relatching", "--seed", "2", "--cases", "1", "--out", str(tmp_path / "out")]
    assert run_command("experiment", EXPERIMENTS, arguments) == 0
    assert "relatching: 1 cases, seed 2" in capsys.readouterr().out
