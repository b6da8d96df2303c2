"""Losses are counted from sequence numbers, whoever else publishes on the topic."""

from __future__ import annotations

import pytest

from lexstack_bag.run.loss import LossCounter


@pytest.mark.parametrize(
    ("numbers", "lost"),
    [
        ([], 0),
        ([1, 2, 3], 0),
        ([5, 6, 7], 0),  # it came later: what was sent before is no loss
        ([1, 2, 5, 6], 2),
        ([1, 3, 5], 2),
        ([1, 2, 1, 3, 2, 4], 0),  # two publishers
        ([1, 2, 3, 1, 2, 5], 1),  # a publisher that was started again, and a loss
        ([20, 500, 21, 501, 22], 0),  # two publishers, met in the middle
        ([500, 20, 501, 21], 0),
    ],
)
def test_gaps(numbers, lost):
    counter = LossCounter()
    for number in numbers:
        counter.see(number)
    assert counter.lost == lost
