"""Wrong arguments of nodes and commands: one line that says what, and exit code 2."""

from __future__ import annotations

import sys

import pytest

from lexstack.transition import TransitionConfig
from lexstack_bringup.commands import find_plant
from lexstack_bringup.domain import own_domain
from lexstack_bringup.processes import NODES, RECORDER
from support.runs import short_scenario
from support.stack_files import folder

DEMO = "lexstack_bringup.commands.demo"


@pytest.fixture(autouse=True)
def domain(monkeypatch):
    """A ROS domain of this test's own, for nodes that get as far as that."""
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    with own_domain() as domain:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
        yield


@pytest.fixture
def scenario(tmp_path):
    path = tmp_path / "scenario.yaml"
    path.write_text(short_scenario().to_yaml(), encoding="utf-8")
    return path


# ---- nodes


NODE_ARGUMENTS = [
    ([], "parameter 'scenario'"),
    (["-p", "scenario:=/none.yaml"], "cannot be read"),
    (["-p", "scenario:=/"], "no regular file"),
    (["-p", "scenario:=/dev/zero"], "no regular file"),
    (["-p", "scenario:=5"], "parameter 'scenario'"),
    (["-p", "scenario"], "arguments of the node"),
    (["-p", "scenario:=[1, x"], "arguments of the node"),
    (["--nonsense"], "arguments of the node"),
    (["--params-file", "/none.yaml"], "arguments of the node"),
    (["-p", "scenario:=GOOD", "-p", "peers:=[1, 2]"], "parameter 'peers'"),
    (["-p", "scenario:=GOOD", "--", "--unknown"], "unknown '--unknown'"),
]


CASES = [
    (node, *case)
    for node in NODES
    # What comes after the first three is the same code in all nodes.
    for case in (NODE_ARGUMENTS if node == "hqp_controller" else NODE_ARGUMENTS[:3])
]


@pytest.mark.parametrize(("node", "arguments", "what"), CASES)
def test_wrong_arguments_of_a_node_are_one_line_and_exit_code_2(
    tmp_path, scenario, run_command, node, arguments, what
):
    extra = ["-p", f"output:={tmp_path / 'bag'}"] if node == RECORDER else []
    given = [argument.replace("GOOD", str(scenario)) for argument in arguments]
    done = run_command(NODES[node], "--ros-args", *extra, *given)
    assert done.returncode == 2
    lines = [line for line in done.stderr.splitlines() if line.startswith("error: ")]
    assert len(lines) == 1, done.stderr
    assert what in lines[0]
    assert "Traceback" not in done.stderr + done.stdout


@pytest.mark.parametrize("node", ["hqp_controller", "stack_solver"])
@pytest.mark.parametrize(
    ("values", "what"),
    [
        ({"extensions": ("nobody.has.this",)}, "extensions[0]: cannot import 'nobody.has.this': "),
        ({"transition": TransitionConfig(1.0, "jump")}, "transition.method: unknown method 'jump'"),
    ],
)
def test_a_name_that_no_extension_brings_is_one_line_and_exit_code_2(
    tmp_path, run_command, node, values, what
):
    path = tmp_path / "scenario.yaml"
    path.write_text(short_scenario(**values).to_yaml(), encoding="utf-8")
    done = run_command(NODES[node], "--ros-args", "-p", f"scenario:={path}")
    assert done.returncode == 2
    (line,) = [line for line in done.stderr.splitlines() if line.startswith("error: ")]
    assert line.startswith(f"error: scenario transition-sequence: {what}")
    assert "Traceback" not in done.stderr + done.stdout


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"storage_preset_profile": "zip"}, "unknown storage preset 'zip'; known: default, none"),
        ({"max_bag_size": 10}, "max_bag_size: must be 0 (no split) or at least 1024 bytes"),
        ({"max_bag_size": -5}, "max_bag_size"),
        ({"max_bag_size": "many"}, "max_bag_size"),
        ({"max_bag_duration": -1.0}, "max_bag_duration"),
        ({"regex": '"("'}, "regex: '(': missing )"),
        ({"topics": "clock"}, "topics: a topic begins with /, got 'clock'"),
        ({"expected_topics": "/a"}, "expected_topics: expected NAME:TYPE"),
    ],
)
def test_a_wrong_option_of_the_recorder_is_one_line_and_exit_code_2(
    tmp_path, scenario, run_command, values, message
):
    done = record(run_command, tmp_path, scenario, **values)
    assert done.returncode == 2
    assert message in done.stderr.strip().splitlines()[-1]
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "bag").exists()


def record(run_command, tmp_path, scenario, **values):
    """Return what a recorder did with these parameters."""
    given = {"output": tmp_path / "bag", "scenario": scenario, **values}
    pairs = [word for key, value in given.items() for word in ("-p", f"{key}:={value}")]
    return run_command(NODES[RECORDER], "--ros-args", *pairs)


def test_a_bag_is_never_overwritten(tmp_path, scenario, run_command):
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag/bag_0.mcap").write_bytes(b"precious")
    done = record(run_command, tmp_path, scenario)
    assert done.returncode == 2
    assert done.stdout == ""
    last = done.stderr.strip().splitlines()[-1]
    assert last.endswith("is not empty; a bag is never overwritten")
    assert "Traceback" not in done.stderr
    assert (tmp_path / "bag/bag_0.mcap").read_bytes() == b"precious"


def test_parameters_of_the_recorder_are_needed(run_command):
    done = run_command(NODES[RECORDER])
    assert done.returncode == 2
    assert "parameter 'output'" in done.stderr
    assert "Traceback" not in done.stderr


# ---- commands


COMMAND_ARGUMENTS = [
    ("lexstack_bringup.commands.demo", ["FILE"], "file.yaml: not valid YAML"),
    ("lexstack_bringup.commands.demo", ["FOLDER"], "unknown scenario"),
    ("lexstack_bringup.commands.demo", ["x" * 5000], "unknown scenario"),
    ("lexstack_bringup.commands.demo", ["a\0b".replace("\0", "\x01")], "unknown scenario"),
    ("lexstack_bringup.commands.demo", ["--seed", "1" * 5000], "invalid int value"),
    ("lexstack_bringup.commands.demo", ["--seed", "99999999999"], "--seed: must be in"),
    ("lexstack_bringup.commands.demo", ["--out", "x" * 5000], "--out: "),
    ("lexstack_bringup.commands.bringup", [], "required"),
    (
        "lexstack_bringup.commands.bringup",
        ["--only", "x", "--host-config", "none"],
        "cannot be read",
    ),
    (
        "lexstack_bringup.commands.bringup",
        ["--only", "x", "--host-config", "FILE"],
        "not valid YAML",
    ),
    (
        "lexstack_bringup.commands.bringup",
        ["--only", "dance", "--host-config", "three_hosts_peers"],
        "--only: unknown node 'dance'; known: sim_bridge",
    ),
    (
        "lexstack_bringup.commands.bringup",
        ["--only", "stack_solver,hqp_controller", "--host-config", "three_hosts_peers"],
        "--only: the nodes of one host are needed, got robot_a, robot_b",
    ),
    (
        "lexstack_bringup.commands.bringup",
        ["--only", ",", "--host-config", "three_hosts_peers"],
        "got no host",
    ),
    ("lexstack_bag.commands.analyze", ["FOLDER"], "holds no bag"),
    ("lexstack_bag.commands.analyze", ["FILE"], "file.yaml: "),
    ("lexstack_bag.commands.analyze", ["/none"], "/none: "),
]


@pytest.mark.parametrize(
    ("module", "arguments", "what"),
    COMMAND_ARGUMENTS,
    ids=[f"{m.rsplit('.')[-1]} {' '.join(a)[:30]!r}" for m, a, _ in COMMAND_ARGUMENTS],
)
def test_wrong_arguments_of_a_command_are_one_line_and_exit_code_2(
    tmp_path, run_command, module, arguments, what
):
    (tmp_path / "file.yaml").write_text("a: 1\na: 2\n", encoding="utf-8")
    (tmp_path / "folder").mkdir()
    places = {"FILE": tmp_path / "file.yaml", "FOLDER": tmp_path / "folder"}
    done = run_command(module, *(places.get(argument, argument) for argument in arguments))
    assert done.returncode == 2
    assert what in done.stderr
    assert "Traceback" not in done.stderr
    told = [line for line in done.stderr.splitlines() if not line.startswith(("usage", " "))]
    assert len(told) == 1, done.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nonsense"], "unknown scenario 'nonsense'; known: "),
        (["--mode", "warp"], "invalid choice"),
        (["--seed", "-1"], "--seed: must be in"),
        (["--seed", "x"], "invalid int value"),
        (["--out", "/proc/nothing/here"], "--out: "),
    ],
)
def test_bad_arguments_of_the_demo_give_one_line_and_exit_code_2(run_command, arguments, message):
    done = run_command(DEMO, *arguments)
    assert done.returncode == 2
    assert message in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("port", "message"),
    [
        ((), "error: Foxglove: the package foxglove-sdk is not there: pip install foxglove-sdk"),
        (("65536",), "error: foxglove: expected a port from 0 to 65535, got '65536'"),
    ],
)
def test_without_foxglove_or_with_no_port_nothing_starts(
    tmp_path, run_command, monkeypatch, port, message
):
    monkeypatch.setitem(sys.modules, "foxglove", None)
    done = run_command(DEMO, "--out", tmp_path / "run", "--foxglove", *port)
    assert (done.returncode, done.stderr) == (2, f"{message}\n")
    assert not (tmp_path / "run").exists()


def test_an_extension_that_is_not_there_is_told_before_anything_starts(tmp_path, run_command):
    path = folder(tmp_path)
    path.write_text(path.read_text("utf-8") + "extensions: [my_tasks]\n", encoding="utf-8")
    done = run_command(DEMO, path)
    assert done.returncode == 2
    line = f"{path}: extensions[0]: cannot import 'my_tasks': ModuleNotFoundError: "
    assert line in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_a_folder_that_holds_something_is_refused(tmp_path, run_command):
    (tmp_path / "precious").touch()
    done = run_command(DEMO, "--out", tmp_path)
    assert done.returncode == 2
    assert "is not empty" in done.stderr


@pytest.mark.parametrize("option", ["--wait", "--rate"])
@pytest.mark.parametrize("value", ["nan", "inf", "-1", "0", "x"])
def test_a_plant_is_not_searched_for_ever(option, value, capsys):
    with pytest.raises(SystemExit) as ended:
        find_plant.main(["reach", option, value])
    assert ended.value.code == 2
    assert option in capsys.readouterr().err.splitlines()[-1]
