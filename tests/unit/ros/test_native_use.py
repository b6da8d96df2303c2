"""What users of a native ROS 2 expect: ros2 run, ros2 launch, configuration in share."""

from __future__ import annotations

from pathlib import Path

import pytest

from lexstack_bringup.processes import MODULES, executable_of, nodes_of
from lexstack_config import own_folder
from lexstack_config.resolved import ResolvedScenario
from support.launch_file import IS_HERE, loaded, stand_in
from support.scenario import CONFIG, ROOT

# ---- configuration


def installed(prefix: Path, *, indexed: bool = True) -> Path:
    """Install a configuration as colcon does, and return its folder."""
    folder = prefix / "share/lexstack_config/config"
    (folder / "scenarios").mkdir(parents=True)
    if indexed:
        marker = prefix / "share/ament_index/resource_index/packages/lexstack_config"
        marker.parent.mkdir(parents=True)
        marker.touch()
    return folder


def test_configuration_is_the_clones_and_else_the_installed_one(tmp_path, monkeypatch):
    share = installed(tmp_path / "one")
    installed(tmp_path / "zero", indexed=False)
    prefixes = f"{tmp_path / 'zero'}:{tmp_path / 'nothing'}:{tmp_path / 'one'}"
    monkeypatch.setenv("AMENT_PREFIX_PATH", prefixes)
    (tmp_path / "empty").mkdir()
    monkeypatch.chdir(tmp_path / "empty")
    monkeypatch.delenv("LEXSTACK_ROOT")
    assert own_folder.own_config() == share
    monkeypatch.chdir(ROOT)
    assert own_folder.own_config() == CONFIG
    monkeypatch.setenv("LEXSTACK_ROOT", str(tmp_path / "empty"))
    assert own_folder.own_config() == tmp_path / "empty/config", "what is named is meant"
    monkeypatch.delenv("LEXSTACK_ROOT")
    monkeypatch.setenv("AMENT_PREFIX_PATH", "")
    monkeypatch.chdir(tmp_path / "empty")
    assert own_folder.own_config() == tmp_path / "empty/config"


# ---- launch


@pytest.fixture
def launch_file(monkeypatch):
    """Return the launch file as a module, loaded with a stand-in for launch."""
    stand_in(monkeypatch)
    return loaded()


def test_launch_takes_the_file_or_is_not_installed():
    """Of the two the one that is so here; what the file starts is tested below in any case."""
    if IS_HERE:
        described = loaded().generate_launch_description()
        assert len(described.entities) == len(loaded().ARGUMENTS) + 1
    else:
        with pytest.raises(ModuleNotFoundError, match="No module named 'launch"):
            loaded()


@pytest.mark.parametrize("scenario", ["by-hand", "eight_robots"])
def test_the_launch_file_starts_the_nodes_of_a_scenario(launch_file, tmp_path, scenario):
    given = {"scenario": scenario, "namespace": "cell1", "out": str(tmp_path / "run"), "mode": ""}
    assert set(given) == set(launch_file.ARGUMENTS)
    assert len(launch_file.generate_launch_description().arguments[0]) == len(given) + 1
    nodes = launch_file.start(given)
    text = (tmp_path / "run/scenario.yaml").read_text(encoding="utf-8")
    resolved = ResolvedScenario.from_yaml(text, "run")
    assert tuple(node.name for node in nodes) == nodes_of(resolved.scenario)
    for node in nodes:
        assert (node.package, node.executable) == executable_of(node.name)
        assert node.namespace == "cell1"
        (parameters,) = node.parameters
        assert set(parameters["peers"].split(",")) == {n.name for n in nodes} - {node.name}
        assert ("output" in parameters) == (node.name == "recorder")
        assert parameters.get("number", 1) in range(1, 9)


# ---- ros2 run


@pytest.mark.parametrize("node", MODULES)
def test_every_node_is_an_executable_of_its_package(node):
    package, name = executable_of(node)
    text = (ROOT / "ros2_ws/src" / package / "setup.py").read_text(encoding="utf-8")
    assert f'"{name} = {MODULES[node]}:main"' in text
