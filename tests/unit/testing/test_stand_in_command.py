"""``./scripts/stand_in``: what its command line becomes, and what it refuses."""

from __future__ import annotations

from pathlib import Path

import pytest

from lexstack_config.resolved import ResolvedScenario
from lexstack_testing.stand_in import command


@pytest.fixture
def started(monkeypatch):
    """Return the arguments that the node is started with, and its scenario."""
    found = {}

    def run():
        for word in command.sys.argv:
            name, equals, value = word.partition(":=")
            if equals:
                found[name] = value
        found["resolved"] = ResolvedScenario.from_yaml(
            Path(found["scenario"]).read_text("utf-8"), "scenario"
        )
        return 0

    monkeypatch.setattr(command, "run", run)
    monkeypatch.setattr(command.sys, "argv", ["stand_in"])
    return found


def test_a_scenario_and_a_plant_by_their_names_start_the_node(started):
    arguments = ["deliver-one", "--plant", "two_pandas", "--habits", "all,drop=0.1"]
    assert command.main(arguments) == 0
    assert started["plant"].endswith("config/plants/two_pandas.yaml")
    assert started["habits"] == '"all,drop=0.1"'
    scenario = started["resolved"].scenario
    assert (scenario.name, scenario.mode, scenario.rate) == ("deliver-one", "realtime", 100.0)


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (["deliver-one", "--plant", "nobody"], "nobody"),
        (["delivery", "--plant", "two_pandas"], "panda_summit"),
        (["deliver-one", "--plant", "two_pandas", "--habits", "haste"], "unknown habit 'haste'"),
    ],
)
def test_what_is_wrong_is_one_line(arguments, what, capsys):
    assert command.main(arguments) == 2
    error = capsys.readouterr().err
    assert what in error
    assert error.count("\n") == 1
