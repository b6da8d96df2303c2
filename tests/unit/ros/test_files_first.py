"""A wrong file ends demo and bringup with one line and 2, before a process is started."""

import signal

import pytest

from lexstack_bringup.commands import bringup, demo
from support.stack_files import LEVELS, folder

# What is written, into which file, and what the line must name.
SEQUENCE = (
    "sequences: {go: {robot: robot_a, tasks: "
    "[{name: up, kind: ee_position, points: [[0.5, 0.0, 4.0]]}]}}\n"
)
CASES = {
    "scenario": ("scenarios/mine.yaml", "mode: fast\n", "scenarios/mine.yaml: mode: 'fast'"),
    "stack it names": (
        "stacks/track.yaml",
        "speed: 1\n",
        "stacks/track.yaml: unknown key 'speed'",
    ),
    "stack it names, task": (
        "stacks/track.yaml",
        "limits: {robot_a: {base_x: {velocity: 99.0}}}\n",
        "stacks/track.yaml: limits.robot_a.base_x: velocity",
    ),
    "robot": ("robots/panda_summit.yaml", "colour: red\n", "robots/panda_summit.yaml: unknown key"),
    "MPC parameters": ("htmpc/lexstack.yaml", "depth: 3\n", "htmpc/lexstack.yaml: unknown key"),
    "sequence": (
        "scenarios/mine.yaml",
        SEQUENCE,
        "scenarios/mine.yaml: sequences.go: task 'up': points[0]: out of reach",
    ),
}


@pytest.fixture
def root(tmp_path, monkeypatch):
    """Return a clone's root with a scenario ``mine``; signals are as before afterwards."""
    path = folder(tmp_path)
    text = (path.parent / "by-hand.yaml").read_text(encoding="utf-8")
    for line in ("mode: realtime\n", "name: by-hand"):
        assert line in text
    text = text.replace("mode: realtime\n", "").replace("name: by-hand", "name: mine")
    (path.parent / "mine.yaml").write_text(text, encoding="utf-8")
    monkeypatch.setenv("LEXSTACK_ROOT", str(tmp_path))
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield tmp_path
    for number, handler in before.items():
        signal.signal(number, handler)


COMMANDS = {
    "demo": (demo, ["mine"]),
    "bringup": (
        bringup,
        ["mine", "--only", "hqp_controller", "--host-config", "three_hosts_peers"],
    ),
}


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("case", CASES)
def test_a_wrong_file_is_one_line_with_file_and_key_before_anything_starts(
    root, capsys, case, command
):
    name, more, message = CASES[case]
    file = root / "config" / name
    file.write_text(file.read_text(encoding="utf-8") + more, encoding="utf-8")
    module, arguments = COMMANDS[command]
    assert module.main(arguments) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("error: ")
    assert printed.err.count("\n") == 1
    assert message in printed.err
    assert str(root / "config" / name) in printed.err
    assert not (root / "runs").exists(), "nothing was begun"


def test_a_stack_of_the_users_own_that_is_wrong_is_a_note_and_no_end(root, capsys, monkeypatch):
    file = root / "config/stacks/own.yaml"
    file.write_text(f"name: own\ndescription: d\nspeed: 1\n{LEVELS}", encoding="utf-8")
    seen = []

    def run(resolved, *_arguments, **_options):
        seen.append(resolved)
        demo.tell_unfit(resolved)
        return 0

    monkeypatch.setattr(demo, "_run", run)
    assert demo.main(["mine"]) == 0
    assert "track" in seen[0].stacks
    printed = capsys.readouterr().out.splitlines()
    assert len(printed) == 1, "stacks that are made for other robots are no news"
    assert printed[0].startswith("note: stack 'own' cannot be asked for in this run: config/stacks")
    assert "unknown key 'speed'" in printed[0]
