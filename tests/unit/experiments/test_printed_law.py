"""The paper's boxes by hand; and that they become empty where ours never is."""

import numpy as np
import pytest

from lexstack.limits import Bounds, JointLimits, LimitBlend, Motion, viable_bounds
from lexstack.types import RobotState
from lexstack_experiments.baselines.bounds import replaced, t31, t34
from lexstack_experiments.baselines.printed_law import PrintedLaw

DT = 0.1


def limits(lower=-1.0, upper=1.0):
    return JointLimits(*(np.atleast_1d(x) for x in (lower, upper, 2.0, 1.0, np.inf)))


@pytest.mark.parametrize(
    ("q", "v", "expected"),
    [
        pytest.param(0.0, 0.5, (0.4, 0.6), id="acceleration decides"),
        pytest.param(0.0, 1.95, (1.85, 2.0), id="velocity and acceleration"),
        pytest.param(0.95, 0.45, (0.35, 0.5), id="position: (1 - 0.95) / 0.1"),
        pytest.param(0.95, 0.7, (0.6, 0.5), id="too fast: empty"),
        pytest.param(1.05, 0.0, (-0.1, -0.5), id="outside: empty"),
    ],
)
def test_t31_by_hand(q, v, expected):
    box = t31(np.array([q]), limits(), DT, np.array([v]))
    assert (box.lower.item(), box.upper.item()) == pytest.approx(expected)
    assert box.empty == (expected[0] > expected[1])


def test_t34_lies_between():
    before, new = (Bounds(np.array([x]), np.array([y])) for x, y in ((-1.0, 1.0), (0.0, 0.2)))
    box = t34(before, new, 0.25)
    assert (box.lower.item(), box.upper.item()) == pytest.approx((-0.75, 0.8))
    assert t34(before, new, 1.0).upper.item() == 0.2


def middle(box):
    """Return the box with its empty intervals replaced by their middles."""
    return replaced(box, 0.5 * (box.lower + box.upper))


def test_empty_boxes_are_counted_and_can_be_replaced():
    empty = Bounds(np.array([0.0, 1.0, 2.0]), np.array([1.0, 0.5, 1.0]))
    assert (Bounds(np.zeros(3), np.ones(3)).empty, empty.empty) == (0, 2)
    repaired = middle(empty)
    np.testing.assert_array_equal(repaired.lower, [0.0, 0.75, 1.5])
    np.testing.assert_array_equal(repaired.upper, [1.0, 0.75, 1.5])


def served(law, tick, q, v, before):
    """Return the box of a joint whose upper limit jumped to 0 at tick 0, by one of the laws."""
    old, new = (t31(q, limits(upper=upper), DT, v) for upper in (1.0, 0.0))
    if law == "t31":
        return new
    return t34(old if law == "t34" else before, new, min(tick / 10, 1.0))


def sudden(law, q, v):
    """Return how often that box is empty while the joint goes where it can."""
    count, before = 0, t31(q, limits(), DT, v)
    blend = LimitBlend.begin(limits(), limits(upper=0.0), Motion(q, v, DT), 0)
    for tick in range(60):
        if law == "ours":
            box = viable_bounds(q, blend.at(tick), DT, v)
        else:
            box = served(law, tick, q, v, before)
        count += box.empty > 0
        before = middle(box)
        v = np.clip(before.upper, v - 0.1, v + 0.1)
        q = q + DT * v
    return count


@pytest.mark.parametrize("law", ["t31", "t34", "t34, of the tick before"])
def test_a_limit_that_jumps_behind_the_joint_empties_the_printed_boxes(law):
    assert sudden(law, np.array([0.5]), np.array([0.2])) > 0
    assert sudden("ours", np.array([0.5]), np.array([0.2])) == 0


def state(tick, q, v):
    q, v = np.array([q]), np.array([v])
    return RobotState(tick, DT * tick, q, v, q, v)


@pytest.mark.parametrize(
    ("reading", "repair", "expected"),
    [
        # T(31): [-0.1, 0.1] and at most -2; braking from 0.05: 0, giving way: as fast as it can
        ("T(31)", "brake", (0.0, 0.0)),
        ("T(31)", "give way", (-0.05, -0.05)),
        # T(34) at alpha = 0: the old limits still hold
        ("T(34) old limits", "brake", (-0.05, 0.15)),
        ("T(34) last box", "brake", (-0.1, 0.1)),
    ],
)
def test_a_printed_law_at_the_trigger(reading, repair, expected):
    own, new = limits(), limits(upper=0.0)
    law = PrintedLaw(own, DT, 1.0, reading, repair)
    box = law.at(state(0, 0.2, 0.0), own, None, jerk=False)[1]
    assert (box.lower.item(), box.upper.item()) == pytest.approx((-0.1, 0.1))
    at, box = law.at(state(1, 0.2, 0.05), new, None, jerk=False)
    assert at is new
    assert (box.lower.item(), box.upper.item()) == pytest.approx(expected)
    assert law.empty_ticks == ([1] if reading == "T(31)" else [])


def test_a_printed_law_blends_for_as_long_as_it_is_told():
    own, new = limits(), limits(upper=0.0)
    law = PrintedLaw(own, DT, 1.0, "T(34) old limits", "brake")
    law.at(state(0, 0.2, 0.0), own, None, jerk=False)
    boxes = [law.at(state(tick, 0.2, 0.0), new, None, jerk=False)[1] for tick in range(1, 12)]
    # alpha = 1/2 in the middle: upper (0.1 - 2) / 2, below lower -0.1
    assert boxes[0].upper.item() == pytest.approx(0.1)
    assert law.empty_ticks[0] <= 5
    assert law.empty_ticks[-1] == 11
