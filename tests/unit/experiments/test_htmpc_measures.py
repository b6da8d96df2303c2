"""What the experiments of paper H measure with, against what is known in closed form."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lexstack_experiments.baselines.htloop import Record
from lexstack_experiments.experiments import reactivity, waypoint_path
from lexstack_experiments.experiments.delivery import layouts
from lexstack_experiments.experiments.htmpc_runs import (
    EXAMPLE,
    HALF,
    SEEN,
    WITHIN,
    Wave,
    between,
    peaks_of,
)
from lexstack_experiments.experiments.htmpc_sequences import Trip, length
from lexstack_experiments.experiments.oracle_gap import Gap, of_all, shares

TOOL = np.array([1.48985, 0.17431, 0.705131])  # m, the authors'


def wave(rate_1, rate_2, optimum=0.2):
    """Return a run whose base error decays exponentially to its optimum in both parts."""
    half = np.arange(0.0, HALF + 1e-9, 0.02)
    first = optimum + (1.0 - optimum) * np.exp(-rate_1 * half)
    times = np.concatenate((half, HALF + half))
    base = np.concatenate((first, np.exp(-rate_2 * half)))
    none = np.zeros(len(times))
    return Wave(times, none, base, np.zeros((len(times), 2)), optimum, 0)


def area(rate, seconds, optimum):
    """Return the integral of such an error in closed form [s]."""
    return optimum * seconds + (1.0 - optimum) * (1.0 - np.exp(-rate * seconds)) / rate


def test_integrals_of_a_wave():
    found = wave(1.0, 2.0)
    assert found.integrals[0] == pytest.approx(area(1.0, HALF, 0.2), rel=1e-3)
    assert found.integrals[1] == pytest.approx(area(2.0, HALF, 0.0), rel=1e-3)
    assert found.blind == pytest.approx(area(1.0, HALF - SEEN, 0.2), rel=1e-3)


def test_when_a_wave_is_settled_and_by_how_much():
    found = wave(1.0, 0.2)
    first, second = found.settled
    assert first == pytest.approx(np.log(0.8 / WITHIN), abs=0.02)
    assert second is None, "0.2 of the error is left"
    assert found.off[0] == pytest.approx(0.8 * np.exp(-(HALF - SEEN - 1.0)), rel=1e-6)
    assert found.off[1] == pytest.approx(np.exp(-0.2 * (HALF - 1.0)), rel=1e-6)


def test_the_papers_example_is_among_the_peaks_and_all_are_out_of_reach():
    peaks = peaks_of(TOOL, 25, 0)
    assert np.linalg.norm(peaks - EXAMPLE, axis=1).min() < 1e-3
    away = np.linalg.norm(peaks - TOOL[:2], axis=1)
    assert away.min() > 1.83 + 0.25 - 1e-9
    assert np.linalg.norm(peaks, axis=1).max() < 3.0
    np.testing.assert_array_equal(peaks_of(TOOL, 5, 0), peaks[:5])


def test_between_two_states_the_input_is_constant():
    rng = np.random.default_rng(0)
    u = rng.normal(size=(5, 3))
    q, v = [np.zeros(3)], [rng.normal(size=3)]
    for each in u:
        q.append(q[-1] + 0.1 * v[-1] + 0.005 * each)
        v.append(v[-1] + 0.1 * each)
    record = Record(0.1 * np.arange(6), np.array(q), np.array(v), np.zeros(5), (), 0)
    times, fine = between(record)
    np.testing.assert_allclose(np.diff(times), 0.02)
    np.testing.assert_allclose(fine[::5], q, atol=1e-14)
    expected = q[2] + 0.04 * v[2] + 0.5 * 0.04**2 * u[2]
    np.testing.assert_allclose(fine[12], expected, atol=1e-14)


@settings(derandomize=True, deadline=None, max_examples=50)
@given(
    st.tuples(st.floats(0.5, 4.5), st.floats(0.5, 3.0)),
    st.floats(0.3, 2.0),
    st.floats(-np.pi, np.pi),
)
def test_no_place_at_a_distance_makes_a_shorter_way(center, radius, angle):
    def way(place):
        return length((np.zeros(2), place, np.array(waypoint_path.STATION)))

    found = waypoint_path.through(np.array(center), radius)
    assert np.linalg.norm(found - center) == pytest.approx(radius)
    other = center + radius * np.array((np.cos(angle), np.sin(angle)))
    assert way(found) <= way(other) + 1e-4
    assert way(found) >= np.linalg.norm(waypoint_path.STATION) - 1e-9


def test_plans_of_deliveries_are_those_of_three_people_in_turns():
    for layout in layouts():
        tasks = layout.tasks(4)
        assert len({task.name for task in tasks}) == len(tasks) == 24
        assert [task.kind for task in tasks[:2]] == ["base_position", "ee_position"]
        assert [task.name.split()[0] for task in tasks[:6:2]] == ["red", "blue", "yellow"]
        away = np.linalg.norm(layout.places[:, :2] - layout.stations, axis=1)
        np.testing.assert_allclose(away, 1.1, atol=1e-9)
        once, often = layout.line(1), layout.line(4)
        round_trip = length([*layout.stations, layout.stations[0]])
        assert often == pytest.approx(once + 3 * round_trip)


def test_a_trip_knows_its_lengths_and_durations():
    q = np.zeros((4, 9))
    q[:, 0] = (0.0, 1.0, 2.0, 2.0)
    record = Record(np.arange(4.0), q, np.zeros((4, 9)), np.zeros(3), (), 0)
    trip = Trip(record, {"go": 1.0, "give": 3.0}, np.zeros((4, 3)), complete=True)
    assert trip.seconds == 3.0
    assert trip.length == 2.0
    assert length(trip.until("go")) == 1.0
    assert trip.durations == {"go": 1.0, "give": 2.0}
    np.testing.assert_allclose(trip.off(np.array([3.0, 4.0, 0.0])), 5.0)


def test_random_changes_are_those_that_the_page_tells():
    found = list(reactivity.cases(30, 0))
    assert [case.kind for case in found[:3]] == list(reactivity.KINDS)
    for case in found:
        assert 16.0 <= case.released <= 22.0
        if case.kind == "held":
            assert case.change is None
            assert not case.moved.any()
        else:
            assert case.change is not None
            assert 6.0 <= case.change <= 9.0
            low, high = (0.1, 0.4) if case.kind == "jump" else (0.5, 1.5)
            assert low <= np.linalg.norm(case.moved[:2]) <= high
    again = list(reactivity.cases(30, 1))
    assert again[0].released != found[0].released


def test_shares_leave_out_states_with_nothing_to_gain():
    gaps = [Gap(0, "warm", 1, gap, gain, 0.0, 0.0) for gap, gain in ((1, 10), (2, 4), (0.5, 1e-3))]
    np.testing.assert_allclose(shares(gaps), (0.1, 0.5))
    assert of_all(gaps) == pytest.approx(3.5 / 14.001)
    assert of_all([]) is None
