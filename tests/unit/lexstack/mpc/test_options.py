"""The files of the HTMPC load, hold what the authors used, and mistakes are named."""

import pytest
import yaml

from lexstack.errors import ConfigurationError
from lexstack.mpc import HtmpcConfig
from lexstack_config.reader import build
from lexstack_config.resolved import load_htmpc
from lexstack_experiments.baselines.htidkc import load_htidkc
from support.scenario import CONFIG

FOLDER = CONFIG / "htmpc"


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.yaml")), ids=lambda p: p.stem)
def test_every_file_loads(path):
    assert load_htmpc(path).name == path.stem


@pytest.mark.parametrize(
    "path", sorted((FOLDER / "baselines").glob("*.yaml")), ids=lambda p: p.stem
)
def test_every_baseline_loads(path):
    assert load_htidkc(path).name == path.stem


def test_the_authors_values_are_theirs():
    own = load_htmpc(FOLDER / "authors.yaml")
    assert (own.horizon, own.step, own.iterations, own.lexicographic) == (10, 0.1, 1, "axis")
    assert own.early_stop_ratio == 0.0
    assert (own.ee.stage, own.ee.terminal, own.base.stage, own.base.terminal) == (1, 10, 1, 10)
    effort = own.effort
    assert (effort.base_velocity, effort.arm_velocity) == (0.1, 0.1)
    assert (effort.base_input, effort.arm_input) == (0.1, 0.02)
    assert (effort.base_change, effort.arm_change) == (0.1, 0.0)
    assert (own.limits.mu, own.limits.zeta) == (1e-3, 5e-3)
    assert (own.collision.mu, own.collision.margin) == (1e-4, 0.05)
    search = own.line_search
    assert (search.descent, search.beta, search.trials) == (0.05, 0.5, 10)
    ours = (own.second_order_correction, own.restart_from_previous, own.hard_limits)
    assert ours == (False, False, False)


def test_both_gain_sets_of_htidkc_are_there():
    theirs = load_htidkc(FOLDER / "baselines" / "htidkc-authors.yaml")
    assert (theirs.rate, theirs.ee_gain, theirs.base_gain, theirs.damping) == (50, 0.5, 0.3, 0.01)
    tuned = load_htidkc(FOLDER / "baselines" / "htidkc-tuned.yaml")
    assert (tuned.ee_gain, tuned.base_gain) == (12.8, 1.21)


MISTAKES = {
    "horizon: must be in": {"horizon": 1},
    "step: must be finite and > 0": {"step": 0.0},
    "iterations: must be >= 1, got 0": {"iterations": 0},
    "early_stop_ratio: must be finite and >= 0": {"early_stop_ratio": -0.01},
    "lexicographic: 'best' is not one of": {"lexicographic": "best"},
    "second_order_correction: needs lexicographic: axis": {
        "second_order_correction": True,
        "lexicographic": "sum",
    },
    "unknown key 'horizont'": {"horizont": 10},
    "ee: terminal: must be finite and > 0": {"ee": {"terminal": 0.0}},
    "ee: tolerance: must be finite and >= 0": {"ee": {"tolerance": -0.1}},
    "effort: arm_input: must be finite and > 0": {"effort": {"arm_input": 0.0}},
    "limits: zeta: must be finite and > 0": {"limits": {"zeta": 0.0}},
    "line_search: beta: must be in": {"line_search": {"beta": 1.0}},
    "line_search: trials: must be >= 1, got 0": {"line_search": {"trials": 0}},
}


@pytest.mark.parametrize(("message", "change"), MISTAKES.items())
def test_a_mistake_is_named(message, change):
    data = yaml.safe_load((FOLDER / "lexstack.yaml").read_text(encoding="utf-8"))
    for key, value in change.items():
        data[key] = {**data[key], **value} if isinstance(value, dict) else value
    with pytest.raises(ConfigurationError, match=message):
        build(HtmpcConfig, data, "lexstack.yaml")


def test_a_file_bears_its_name(tmp_path):
    path = tmp_path / "other.yaml"
    path.write_text((FOLDER / "authors.yaml").read_text(encoding="utf-8"), encoding="utf-8")
    with pytest.raises(ConfigurationError, match="name: expected 'other', got 'authors'"):
        load_htmpc(path)
