"""What a sweep file says: combinations, random values, and what is refused."""

from pathlib import Path

import numpy as np
import pytest

from lexstack.errors import ConfigurationError
from lexstack_config.reader import build
from lexstack_experiments.sweeps.sweep_file import LimitConfig, SweepFile, load_sweep
from support.scenario import CONFIG

SWEEP = {
    "name": "s",
    "description": "d",
    "run": "scenario",
    "grid": {"a": [1, 2], "b": ["x", "y", "z"]},
    "random": {
        "c": {"low": 0.1, "high": 10.0, "of": "logarithms"},
        "d": {"low": 1, "high": 3, "of": "integers"},
        "e": {"type": "one_of", "values": [0, 5]},
    },
    "runs": 50,
    "seed": 4,
}


def sweep(**changes):
    return build(SweepFile, {**SWEEP, **changes}, "here")


def test_every_combination_has_all_runs_and_the_last_key_changes_fastest():
    given = sweep()
    assert given.size == 300
    assert [given.values(50 * i)["b"] for i in range(6)] == ["x", "y", "z"] * 2
    assert [given.values(50 * i)["a"] for i in range(6)] == [1, 1, 1, 2, 2, 2]


def test_combinations_are_compared_over_the_same_cases():
    given = sweep()
    for number in (0, 7, 49):
        drawn = [given.values(50 * i + number) for i in range(6)]
        for key in ("c", "d", "e", "seed"):
            assert len({values[key] for values in drawn}) == 1
    assert len({given.values(i)["seed"] for i in range(50)}) == 50


def test_random_values_are_in_their_ranges_and_fill_them():
    values = [sweep().values(i) for i in range(50)]
    logs = np.log10([each["c"] for each in values])
    assert -1.0 <= logs.min() < -0.5
    assert 0.5 < logs.max() <= 1.0
    assert {each["d"] for each in values} == {1, 2, 3}
    assert {each["e"] for each in values} == {0, 5}
    assert sweep(seed=5).values(0)["c"] != values[0]["c"]


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"grid": {"a": []}}, "here: grid.'a': no values"),
        ({"grid": {"c": [1]}}, "here: random.'c': is in the grid too"),
        ({"runs": 0}, "runs"),
        ({"run": "unknown"}, "run"),
        ({"random": {"c": {"low": 2.0, "high": 1.0}}}, "high: must be at least low"),
        ({"random": {"c": {"low": 0, "high": 1, "of": "logarithms"}}}, "no logarithm"),
        ({"random": {"c": {"low": 0.5, "high": 1, "of": "integers"}}}, "must be integers"),
        ({"random": {"c": {"type": "one_of", "values": []}}}, "at least one value"),
        ({"random": {"c": {"low": 0, "high": 1e300, "of": "integers"}}}, "within 2^53"),
        ({"random": {"c": {"low": -1e308, "high": 1e308}}}, "too wide"),
        ({"grid": {"seed": [1, 2]}}, "here: seed: every run has its own"),
        ({"random": {"seed": {"low": 0, "high": 1}}}, "here: seed: every run has its own"),
        ({"grid": {letter: [*range(10)] for letter in "fghijklmno"}}, "grid: 500000000000 runs"),
        ({"grid": {str(i): [*range(10)] for i in range(30)}}, "runs in all, at most 10000000"),
        ({"limits": {"x": {}}}, "least or most is needed"),
    ],
)
def test_what_makes_no_sense_is_refused(changes, told):
    with pytest.raises(ConfigurationError, match=r"here: .*") as error:
        sweep(**changes)
    assert told in str(error.value)
    assert "\n" not in str(error.value)


def test_a_figure_that_is_not_a_number_breaks_every_limit():
    kept = LimitConfig(least=0.0, most=1.0).kept(np.array([0.0, 1.0, 1.1, -0.1, np.nan]))
    assert kept.tolist() == [True, True, False, False, False]


@pytest.mark.parametrize("path", sorted((Path(CONFIG) / "sweeps").glob("*.yaml")), ids=str)
def test_the_shipped_sweeps_can_be_read(path):
    assert load_sweep(path).size > 1
