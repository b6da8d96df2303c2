"""The set-up: what makes it do its work again."""

from pathlib import Path

import pytest

from workspace.ros import Ros
from workspace.stamps import Stamp, digest, environment_stamp, workspace_stamp


@pytest.fixture
def clone(tmp_path):
    """Return a clone with one package of messages."""
    package = tmp_path / "ros2_ws/src/interfaces"
    (package / "msg").mkdir(parents=True)
    (package / "msg/Chi.msg").write_text("float64[] chi\n")
    (package / "package.xml").write_text("<package/>\n")
    (tmp_path / "requirements.lock").write_text("numpy==2.4.6\n")
    return tmp_path


def stamps(clone, ros=None, python="3.11"):
    """Return the digests of both stamps."""
    environment = environment_stamp(clone, ros or Ros(), python)
    return environment.digest, workspace_stamp(clone, environment).digest


def test_stamp_is_current_only_while_written_from_the_same_inputs(tmp_path):
    stamp = Stamp(tmp_path / "stamp", "new")
    assert not stamp.is_whole()
    Stamp(tmp_path / "stamp", "old").write()
    assert stamp.is_whole()
    assert not stamp.is_current()
    stamp.write()
    assert stamp.is_current()
    stamp.clear()
    assert not stamp.is_whole()


def test_digest_tells_where_a_part_ends():
    assert digest(["ab", "c"]) != digest(["a", "bc"])
    assert digest(["ab"]) == digest([b"ab"])


def test_nothing_changed_means_nothing_to_do(clone):
    assert stamps(clone) == stamps(clone)


def test_lock_python_and_ros_make_both_anew(clone):
    before = stamps(clone)
    variants = [stamps(clone, python="3.12"), stamps(clone, ros=Ros(Path("/opt/ros/jazzy")))]
    (clone / "requirements.lock").write_text("numpy==2.4.7\n")
    variants.append(stamps(clone))
    for after in variants:
        assert before[0] != after[0]
        assert before[1] != after[1]


@pytest.mark.parametrize("name", ["msg/Chi.msg", "msg/New.msg", "package.xml", "setup.py"])
def test_package_files_make_the_workspace_anew(clone, name):
    before = stamps(clone)
    (clone / "ros2_ws/src/interfaces" / name).write_text("changed\n")
    after = stamps(clone)
    assert before[0] == after[0]
    assert before[1] != after[1]


def test_what_writes_the_environment_makes_the_workspace_anew(clone, monkeypatch):
    before = stamps(clone)
    read = Path.read_bytes
    monkeypatch.setattr(
        Path, "read_bytes", lambda path: read(path) + b" " * (path.name == "environment.py")
    )
    after = stamps(clone)
    assert before[0] == after[0], "the packages stay"
    assert before[1] != after[1]


def test_python_sources_need_no_build(clone):
    before = stamps(clone)
    (clone / "ros2_ws/src/interfaces/module.py").write_text("x = 1\n")
    assert stamps(clone) == before
