"""Sequences: the window, completion, holding, moving targets, insertion and cancellation."""

import numpy as np
import pytest

from lexstack.errors import InputError
from lexstack.mpc import HT_ARCH, ST_ARCH, RobotPose, Sequence, SequenceTask
from lexstack.robots import Pose

LINE = SequenceTask("line", "base_position", ((2.0, 0.0),), speed=0.5, tolerance=0.05)
HAND = SequenceTask("hand", "ee_position", ((2.0, 1.0, 0.8),), tolerance=0.02, dwell=1.0)
BACK = SequenceTask("back", "base_pose", ((0.0, 0.0, 3.0),), speed=0.5, turn=1.0)
TASKS = (LINE, HAND, BACK)


def at(stamp, base=(0.0, 0.0, 0.0), tool=(0.0, 0.0, 1.0)):
    return RobotPose(stamp, np.array(base), Pose(np.array(tool), np.eye(3)))


def names(sequence):
    return [task.name for task in sequence.window]


def begin(architecture=HT_ARCH, tasks=TASKS):
    return Sequence.begin(tasks, architecture, at(0.0))


def test_the_window_has_as_many_tasks_as_levels_and_moves_on():
    sequence = begin()
    assert names(sequence) == ["line", "hand"]
    assert names(begin(ST_ARCH)) == ["line"]
    arrived = sequence.advanced(at(4.0, base=(2.0, 0.0, 0.0)))
    assert names(arrived) == ["hand", "back"]
    assert arrived.first == 1
    assert sequence.first == 0, "the value of before has not changed"


def test_a_task_is_not_done_before_its_trajectory_has_ended():
    sequence = begin().advanced(at(1.0, base=(2.0, 0.0, 0.0)))
    assert sequence.first == 0
    assert sequence.advanced(at(4.0, base=(2.0, 0.0, 0.0))).first == 1


def test_dwell_counts_from_when_the_error_became_small_and_starts_again():
    hand = (2.0, 1.0, 0.8)
    sequence = begin().advanced(at(4.0, base=(2.0, 0.0, 0.0)))
    sequence = sequence.advanced(at(5.0, tool=hand))
    sequence = sequence.advanced(at(5.9, tool=hand))
    assert sequence.first == 1
    sequence = sequence.advanced(at(5.95, tool=(2.0, 1.0, 0.83)))
    assert sequence.within is None
    sequence = sequence.advanced(at(6.0, tool=hand))
    assert sequence.advanced(at(6.9, tool=hand)).first == 1
    assert sequence.advanced(at(7.0, tool=hand)).first == 2


def test_a_held_task_waits_for_its_release():
    held = SequenceTask("held", "ee_position", ((0.0, 0.0, 1.0),), held=True)
    sequence = begin(tasks=(held, LINE))
    for stamp in (0.0, 10.0, 100.0):
        sequence = sequence.advanced(at(stamp))
        assert sequence.first == 0
    sequence = sequence.release("held")
    assert sequence.advanced(at(100.1)).first == 1
    far = begin(tasks=(held, LINE)).release("held").advanced(at(1.0, tool=(9.0, 0.0, 0.0)))
    assert far.first == 0, "released, but not there"


def test_trajectories_start_anew_from_the_present_pose_when_the_window_moves():
    sequence = begin().advanced(at(7.0, base=(1.98, 0.01, 0.5)))
    back = sequence.trajectories[1]
    np.testing.assert_allclose(back.at(np.array([7.0]))[0], [1.98, 0.01, 0.5])
    assert back.end > 7.0


def test_a_target_moves():
    sequence = begin().retarget("hand", ((5.0, 0.0, 1.0),), at(1.0))
    np.testing.assert_array_equal(sequence.trajectories[1].goal, [5.0, 0.0, 1.0])
    np.testing.assert_array_equal(sequence.trajectories[0].goal, LINE.points[0])
    near = begin().advanced(at(5.0, base=(2.0, 0.0, 0.0))).advanced(at(6.0, tool=HAND.points[0]))
    assert near.within == 6.0
    assert near.retarget("hand", ((5.0, 0.0, 1.0),), at(6.1)).within is None
    later = begin(ST_ARCH).retarget("back", ((1.0, 1.0, 0.0),), at(1.0))
    assert later.tasks[2].points == ((1.0, 1.0, 0.0),)
    assert len(later.trajectories) == 1


def test_tasks_are_inserted_and_cancelled():
    extra = SequenceTask("extra", "base_position", ((9.0, 9.0),))
    sequence = begin().insert(1, extra, at(1.0))
    assert names(sequence) == ["line", "extra"]
    assert names(sequence.cancel("line", at(1.0))) == ["extra", "hand"]
    assert names(sequence.cancel("extra", at(1.0))) == ["line", "hand"]
    assert names(begin().insert(3, extra, at(1.0))) == ["line", "hand"]
    with pytest.raises(InputError, match="place 4 to insert at"):
        begin().insert(4, extra, at(0.0))
    with pytest.raises(InputError, match="two tasks have the name 'hand'"):
        begin().insert(1, HAND, at(0.0))


def test_when_all_is_done_the_last_task_is_held():
    sequence = begin(tasks=(LINE,)).advanced(at(4.0, base=(2.0, 0.0, 0.0)))
    assert sequence.done
    assert names(sequence) == ["line"]
    objective = sequence.objectives(np.arange(5.0, 6.0, 0.1))[0]
    np.testing.assert_allclose(objective.reference, np.tile([2.0, 0.0], (10, 1)))
    assert sequence.advanced(at(9.0)) is sequence


def test_the_single_task_architecture_moves_base_or_arm():
    times = np.arange(1, 11) * 0.1
    assert [o.moves for o in begin().objectives(times)] == ["all", "all"]
    sequence = begin(ST_ARCH)
    assert [o.moves for o in sequence.objectives(times)] == ["base"]
    moved = sequence.advanced(at(4.0, base=(2.0, 0.0, 0.0)))
    assert [o.moves for o in moved.objectives(times)] == ["arm"]


def test_orientations_and_yaw_count_for_poses():
    back = begin(tasks=(BACK,))
    assert not back.advanced(at(50.0, base=(0.0, 0.0, 0.0))).done
    assert back.advanced(at(50.0, base=(0.0, 0.0, 3.0 - 2 * np.pi))).done
    pose = SequenceTask("pose", "ee_pose", ((0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0),))
    assert not begin(tasks=(pose,)).advanced(at(0.0)).done
    same = SequenceTask("pose", "ee_pose", ((0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -1.0),))
    assert begin(tasks=(same,)).advanced(at(0.0)).done


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"kind": "fly"}, "kind: 'fly' is not one of"),
        ({"points": ()}, "points: at least one"),
        ({"points": ((1.0, 2.0, 3.0),)}, r"points\[0\]: expected 2 finite numbers"),
        ({"points": ((1.0, float("nan")),)}, r"points\[0\]: expected 2 finite numbers"),
        ({"speed": 0.0}, "speed: must be finite and > 0"),
        ({"turn": -1.0}, "turn: must be finite and > 0"),
        ({"tolerance": 0.0}, "tolerance: must be > 0"),
        ({"dwell": -1.0}, "dwell: must be finite and >= 0"),
    ],
)
def test_what_cannot_be_a_task_is_named(values, message):
    good = {"name": "line", "kind": "base_position", "points": ((2.0, 0.0),)}
    with pytest.raises(InputError, match=f"task 'line': {message}"):
        SequenceTask(**(good | values))


def test_unknown_and_finished_names_are_refused():
    sequence = begin().advanced(at(4.0, base=(2.0, 0.0, 0.0)))
    with pytest.raises(InputError, match="unknown task 'x'; known: line, hand, back"):
        sequence.release("x")
    with pytest.raises(InputError, match="task 'line' is done"):
        sequence.retarget("line", ((0.0, 0.0),), at(5.0))
    with pytest.raises(InputError, match="task 'line' is done"):
        sequence.cancel("line", at(5.0))
    with pytest.raises(InputError, match="'hand' is the only one"):
        begin(tasks=(HAND,)).cancel("hand", at(0.0))
    with pytest.raises(InputError, match="at least one task"):
        begin(tasks=())
