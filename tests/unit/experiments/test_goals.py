"""The table of goals: which figures count, what is worst, and how ratios within a run are taken."""

import os

import numpy as np
import pytest

from lexstack_experiments.benches.goals import ROWS, figures_of, goal_of, table_of, with_goals
from lexstack_experiments.measuring import paired_ratio, silent
from lexstack_experiments.results import Figure


def rows_of(*figures):
    """Return the rows of the bench hqp by their text."""
    return {row[1]: row for row in table_of({"hqp": figures}).rows}


def test_the_worst_figure_of_a_row_stands_for_it():
    rows = rows_of(
        Figure("2 levels, at bounds: p50", 21.0, "us"),
        Figure("base, at bounds: p50", 40.0, "us"),
        Figure("base: p50", 17.0, "us"),
    )
    assert rows["at bounds: p50"][4:] == ("40", "NOT reached", "base, at bounds: p50")
    assert rows["base: p50"][4:] == ("17", "reached, and the moonshot", "base: p50")
    assert rows["posture: p50"][4:] == (None, "not in this run", "")


def test_where_more_is_better_the_least_is_worst():
    name = "{}, N = 10, authors: the paper's way over ours"
    figures = [Figure(name.format(robot), value) for robot, value in (("a", 50.0), ("b", 20.0))]
    (row,) = [row for row in table_of({"htmpc": figures}).rows if "paper" in row[1]]
    assert row[4:6] == ("20", "NOT reached")


def test_only_benches_that_ran_have_rows():
    assert {row[0] for row in table_of({"tick": (), "scaling": ()}).rows} == {"tick", "scaling"}


@pytest.mark.parametrize(
    ("bench", "name", "limit"),
    [
        ("hqp", "follow-chi to posture: p50", 20.0),
        ("hqp", "follow-chi to track, at bounds: p99", 70.0),
        ("hqp", "3 levels, distances above: p50", 35.0),
        ("hqp", "2 levels: p50 over DAQP hierarchical", 0.5),
        ("htmpc", "ur10_ridgeback, N = 30, 10 spheres, lexstack: p99", 22.0),
        ("htmpc", "ur10_ridgeback, N = 30, lexstack: p99 over d94d011", 0.25),
        ("scaling", "whole tick, 32 robots over 2", 10.0),
        ("transition", "track, blending: p50 of a tick", 130.0),
    ],
)
def test_a_figure_gets_the_goal_of_its_row(bench, name, limit):
    assert goal_of(bench, name).limit == limit


@pytest.mark.parametrize("name", ["2 levels: p50", "ur10, N = 10, authors: p50", "base: p50 quiet"])
def test_other_figures_have_none(name):
    assert goal_of("hqp", name) is None


def test_ratios_come_before_times():
    shown = with_goals("hqp", [Figure("base: p50", 1.0, "us"), Figure("a ratio", 2.0)])
    assert [figure.name for figure in shown] == ["a ratio", "base: p50"]
    assert shown[1].goal.limit == 25.0


def test_every_row_is_a_figure_of_its_own():
    names = [figure.name for figure in figures_of({row.bench: () for row in ROWS})]
    assert len(set(names)) == len(names) == len(ROWS)


def test_a_ratio_is_taken_turn_by_turn():
    """A turn in which the machine was slow for both changes neither ratio."""
    ours = np.array([[1.0, 1.0, 1.0], [10.0, 10.0, 10.0], [1.0, 1.0, 4.0]])
    others = 2.0 * np.ones((3, 5))
    others[1] = 20.0
    assert paired_ratio(ours, others) == pytest.approx(0.5)
    with pytest.raises(ValueError, match="do not pair"):
        paired_ratio(ours, others[:2])


def test_what_libraries_print_is_kept_from_the_terminal(capfd):
    with silent():
        os.write(1, b"chatter")
        os.write(2, b"chatter")
    print("heard")
    assert capfd.readouterr() == ("heard\n", "")
