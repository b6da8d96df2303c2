"""Names that files used before go on working, in files, in bags and in ``--set``."""

import pytest
import yaml

from lexstack.errors import ConfigurationError
from lexstack.mpc import HtmpcConfig
from lexstack.options import OLD_NAMES
from lexstack.tasks import TASKS, StackConfig, TaskConfig
from lexstack_bag.replay.changes import Changes
from lexstack_bag.run.reader import _since
from lexstack_config.reader import build, plain
from lexstack_config.resolved import ResolvedScenario, load_htmpc, load_scenario
from support.scenario import CONFIG

KEYS = OLD_NAMES["HtmpcConfig"]
TYPES = OLD_NAMES["TaskConfig.type"]
PLANNED = CONFIG / "scenarios" / "deliver-one.yaml"


def parameters():
    """Return the MPC's parameters and their file's content under old names."""
    path = CONFIG / "htmpc" / "lexstack.yaml"
    old = {new: name for name, new in KEYS.items()}
    content = yaml.safe_load(path.read_text(encoding="utf-8"))
    return load_htmpc(path), {old.get(key, key): value for key, value in content.items()}


def older(text):
    """Return a text with all names as they were."""
    for name, new in (*KEYS.items(), *TYPES.items()):
        text = text.replace(f"{new}:", f"{name}:").replace(f"type: {new}\n", f"type: {name}\n")
    return text


def test_old_keys_mean_what_the_new_ones_mean():
    wanted, old = parameters()
    assert set(KEYS) < set(old)
    assert build(HtmpcConfig, old, "old.yaml") == wanted


@pytest.mark.parametrize(("old", "new"), KEYS.items())
def test_a_key_under_both_names_is_refused_in_one_line(old, new):
    _, content = parameters()
    text = f"old.yaml: '{old}' is the old name of '{new}': give one of them"
    with pytest.raises(ConfigurationError, match=f"^{text}$"):
        build(HtmpcConfig, content | {new: content[old]}, "old.yaml")


@pytest.mark.parametrize(("old", "new"), TYPES.items())
def test_old_types_of_tasks_become_new_ones(old, new):
    assert new in TASKS
    assert old not in TASKS
    data = {"name": "s", "description": "", "levels": [{"tasks": [{"type": old}]}]}
    assert build(StackConfig, data, "s.yaml").levels[0].tasks[0] == TaskConfig(new)
    assert StackConfig.of_tasks("s", old) == StackConfig.of_tasks("s", new)


def test_a_bag_of_before_has_the_scenario_of_today():
    resolved = load_scenario(PLANNED)
    text = older(resolved.to_yaml())
    assert all(f"{name}:" in text for name in KEYS)
    assert all(f"type: {name}\n" in text for name in TYPES)
    assert ResolvedScenario.from_yaml(text, "bag") == resolved


def test_costs_of_older_bags_are_not_compiled():
    resolved = load_scenario(PLANNED)
    assert [each.evaluation for each in resolved.htmpc.values()] == ["compiled"]
    text = "\n".join(line for line in resolved.to_yaml().split("\n") if "evaluation:" not in line)
    read = ResolvedScenario.from_yaml(text, "bag", _since())
    assert [each.evaluation for each in read.htmpc.values()] == ["plain"]
    assert ResolvedScenario.from_yaml(resolved.to_yaml(), "bag", _since()) == resolved


def test_a_replay_takes_old_names_too():
    resolved = load_scenario(PLANNED)
    changed = Changes(("htmpc.lexstack.enough=0.5",)).applied(resolved)
    assert changed.htmpc["lexstack"].early_stop_ratio == 0.5
    assert plain(changed) != plain(resolved)
