"""Which node runs where, and by which variables hosts find each other."""

import pytest
import yaml

from lexstack.errors import ConfigurationError
from lexstack_bringup.commands.bringup import _KNOWN
from lexstack_bringup.hosts import load_hosts
from support.scenario import CONFIG

FILES = sorted((CONFIG / "hosts").glob("*.yaml"))


def load(name):
    return load_hosts(CONFIG / "hosts" / f"three_hosts_{name}.yaml", _KNOWN)


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_every_file_loads_and_gives_every_node_a_host(path):
    hosts = load_hosts(path, _KNOWN)
    assert hosts.name == path.stem
    assert set(hosts.nodes) - {"discovery_server"} == set(_KNOWN) - {"discovery_server"}
    for name, host in hosts.hosts.items():
        assert hosts.share(host.nodes) == name


def test_the_variables_are_those_of_the_discovery():
    assert load("multicast").environment("robot_a") == {
        "ROS_DOMAIN_ID": "42",
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET",
    }
    assert load("peers").environment("robot_a")["ROS_STATIC_PEERS"] == "10.77.0.1;10.77.0.3"
    assert load("server").environment("robot_a")["ROS_DISCOVERY_SERVER"] == "10.77.0.1:11811"


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"domain": 233}, "domain: must be in [0, 232], got 233"),
        ({"server_port": -1}, "server_port: must be in"),
        ({"wait": 0.0}, "wait: must be finite and > 0"),
        ({"discovery": "luck"}, "discovery: 'luck' is not one of"),
        ({"discovery": "server"}, "discovery 'server' needs the node discovery_server"),
        ({"hosts": {"a": {"address": "nowhere", "nodes": ["recorder"]}}}, "expected an IP address"),
        ({"hosts": {"a": {"address": "::1", "nodes": []}}}, "at least one node"),
        ({"hosts": {"a": {"address": "::1", "nodes": ["dance"]}}}, "unknown node 'dance'"),
        (
            {"hosts": {n: {"address": "::1", "nodes": ["recorder"]} for n in "ab"}},
            "recorder runs on more than one host",
        ),
    ],
)
def test_a_wrong_file_is_refused_with_file_and_key(tmp_path, change, what):
    data = yaml.safe_load(FILES[0].read_text(encoding="utf-8")) | {"discovery": "peers"}
    path = tmp_path / "hosts.yaml"
    path.write_text(yaml.safe_dump(data | change), encoding="utf-8")
    with pytest.raises(ConfigurationError) as error:
        load_hosts(path, _KNOWN)
    assert str(error.value).startswith(f"{path}: ")
    assert what in str(error.value)


def test_a_scenario_starts_what_it_needs_and_says_what_runs_nowhere():
    hosts = load("server")
    plain = ("sim_bridge", "hqp_controller", "stack_solver", "recorder", "scenario_player")
    assert set(hosts.needed(plain, "s")) == {*plain, "discovery_server"}
    assert set(hosts.needed((*plain, "htmpc"), "s")) == {*plain, "htmpc", "discovery_server"}
    with pytest.raises(ConfigurationError, match="view runs on no host, but scenario s needs it"):
        hosts.needed((*plain, "view"), "s")
