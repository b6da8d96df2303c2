"""The plots' curves from pictures of the last seconds."""

from __future__ import annotations

import numpy as np

from lexstack_ros.view.picture import WINDOW, History
from support.view import picture


def test_curves_have_a_gap_where_a_level_or_a_solve_is_missing():
    history = History()
    history.add(picture(1.0, levels=(0.1,)))
    history.add(picture(1.1, levels=(0.2, 0.3), solve={"robot_b": 0.6}, alpha=1.0))
    found = history.curves()
    assert found.time.tolist() == [1.0, 1.1]
    assert np.array_equal(found.levels, [[0.1, 0.2], [np.nan, 0.3]], equal_nan=True)
    assert np.array_equal(found.solve["robot_a"], [0.4, np.nan], equal_nan=True)
    assert np.array_equal(found.solve["robot_b"], [np.nan, 0.6], equal_nan=True)
    assert found.alpha.tolist() == [0.5, 1.0]


def test_the_last_seconds_stay():
    history = History()
    for time in np.arange(0.0, WINDOW + 5.0, 0.5):
        history.add(picture(float(time)))
    assert history.curves().time[0] == 4.5
    assert history.curves().time[-1] == WINDOW + 4.5


def test_a_plant_that_stands_still_adds_nothing_and_a_reset_begins_again():
    history = History()
    for time in (1.0, 2.0, 2.0, 2.0):
        history.add(picture(time))
    assert history.curves().time.tolist() == [1.0, 2.0]
    history.add(picture(0.0))
    assert history.curves().time.tolist() == [0.0]
