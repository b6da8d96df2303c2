"""The kinds of runs: values reach a scenario, figures come back, unknown names are refused."""

import pytest

from lexstack.errors import ConfigurationError
from lexstack_experiments.sweeps.kinds import KINDS
from lexstack_experiments.sweeps.kinds.kind import column, with_values
from support.scenario import CONFIG, resolved


def test_values_replace_those_of_a_scenario_by_their_paths():
    changed = with_values(
        resolved(),
        {
            "transition.duration": 0.3,
            "scenario.events.0.at": 1.5,
            "stacks.track.levels.0.tasks.0.parameters.gain": 2.0,
        },
    )
    assert changed.scenario.transition.duration == 0.3
    assert changed.scenario.events[0].at == 1.5
    assert changed.stacks["track"].levels[0].tasks[0].parameters["gain"] == 2.0
    assert with_values(resolved(), {}) == resolved()


@pytest.mark.parametrize(
    "path", ["transition.speed", "events.99.at", "events.first.at", "transition.duration.s", "x"]
)
def test_a_path_that_a_scenario_has_not_is_refused(path):
    with pytest.raises(ConfigurationError, match="a scenario has no"):
        with_values(resolved(), {path: 1.0})


def test_a_scenario_gives_its_figures():
    row = KINDS["scenario"](CONFIG, "sudden-limits", {"duration": 8.0, "seed": 1})
    assert row["ticks"] == 800
    assert row["empty_boxes"] == 0
    assert 0.1 < row["acceleration_ratio"] <= 1.0 + 1e-9
    assert row["goals_missed"] == 0


@pytest.mark.parametrize("kind", ["promises", "scenario", "experiment", "fault"])
def test_an_unknown_name_is_refused(kind):
    with pytest.raises(ConfigurationError, match="nothing"):
        KINDS[kind](CONFIG, "nothing", {"seed": 0})


def test_an_experiment_gives_its_figures_and_takes_no_other_options():
    found = KINDS["experiment"](CONFIG, "relatching", {"seed": 0, "cases": 1})
    assert found["goals_reached"] in (0, 1)
    assert all(name == column(name) for name in found)
    with pytest.raises(ConfigurationError, match="only seed and cases"):
        KINDS["experiment"](CONFIG, "relatching", {"seed": 0, "rate": 2})


def test_columns_are_words():
    assert column("Peak acceleration / limit", "mm") == "peak_acceleration_limit_mm"
