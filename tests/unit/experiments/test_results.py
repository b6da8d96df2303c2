"""Figures, goals, tables, results.json, and the lines that are printed."""

import json
import math

import pytest

from lexstack_experiments.results import Figure, Goal, Peer, Results, Table
from lexstack_experiments.text import aligned, cell_text, lines_of, number, reached_line

GOOD = Figure("error", 0.5, "mm", Goal("<=", 1.0), paper="< 2 mm", peer=Peer("instant", 3.0))
BAD = Figure("base error", 7.25, "mm", Goal("<=", 5.0))
MISSING = Figure("final error", None, "mm", Goal("<=", 1.0))
PLAIN = Figure("peak jerk", 0.25)


def results(*figures, **values):
    """Return results of a small experiment."""
    table = Table(("row", "error mm"), (("first", 0.5), ("second one", None)), "errors")
    return Results("demo", 3, 2, figures, (table,), **values)


@pytest.mark.parametrize(
    ("comparison", "limit", "slack", "yes", "no"),
    [
        ("<=", 1.0, 0.0, 1.0, 1.0001),
        ("<=", 1.0, 1e-3, 1.0009, 1.002),
        (">=", 2.0, 0.0, 2.0, 1.9),
        ("==", 0.0, 0.0, 0.0, 1.0),
        ("==", 3.0, 0.0, 3.0, 2.0),
    ],
)
def test_a_goal_is_reached_on_one_side_of_its_limit(comparison, limit, slack, yes, no):
    goal = Goal(comparison, limit, slack)
    assert goal.reached(yes)
    assert not goal.reached(no)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_figure_is_finite_or_left_out(value):
    with pytest.raises(ValueError, match=r"'error'.*not finite"):
        Figure("error", value)
    with pytest.raises(ValueError, match=r"'error'.*not finite"):
        Figure("error", 1.0, peer=Peer("other", value))


def test_a_table_refuses_a_row_of_another_length():
    with pytest.raises(ValueError, match="1 cells in 2 columns"):
        Table(("a", "b"), ((1.0,),))


def test_json_holds_every_figure_with_unit_goal_paper_and_peer():
    content = json.loads(results(GOOD, BAD, MISSING, PLAIN, setup={"rate_hz": 100.0}).to_json())
    assert content["name"] == "demo"
    assert (content["seed"], content["cases"]) == (3, 2)
    assert content["figures"][0] == {
        "name": "error",
        "value": 0.5,
        "unit": "mm",
        "goal": {"comparison": "<=", "limit": 1.0, "slack": 0.0},
        "paper": "< 2 mm",
        "peer": {"name": "instant", "value": 3.0},
        "reached": True,
    }
    assert [figure["reached"] for figure in content["figures"]] == [True, False, False, None]
    rows = [{"row": "first", "error mm": 0.5}, {"row": "second one", "error mm": None}]
    assert content["tables"] == [{"title": "errors", "rows": rows}]
    assert content["setup"] == {"rate_hz": 100.0}
    machine = content["machine"]
    assert machine["cores"] >= 1
    assert machine["python"].startswith("3.")
    assert "numpy" in machine["versions"]


def test_nothing_in_the_machine_names_it():
    import platform

    assert platform.node() not in results(GOOD).to_json()


def test_the_last_line_counts_and_names_what_fell_short():
    assert reached_line(results(GOOD, PLAIN)) == "reached 1 of 1"
    assert reached_line(results(GOOD, BAD)) == "reached 1 of 2: base error 7.25 mm (≤ 5 mm)"
    assert reached_line(results(MISSING)) == "reached 0 of 1: final error is not in this run"
    assert lines_of(results(GOOD, BAD))[-1].startswith("reached 1 of 2: ")


def test_all_is_reached_only_when_every_goal_is():
    assert results(GOOD, PLAIN).all_reached
    assert not results(GOOD, BAD).all_reached
    assert not results(GOOD, MISSING).all_reached, "what a run does not show is not reached"


def test_the_text_has_paper_peer_goal_and_ours_side_by_side():
    lines = lines_of(results(GOOD, BAD, PLAIN, notes=("A note.",)))
    head = next(line for line in lines if line.startswith("figure"))
    row = next(line for line in lines if line.startswith("error "))
    for column, text in {
        "paper": "< 2 mm",
        "peer or baseline": "3 mm (instant)",
        "goal": "≤ 1 mm",
        "ours": "0.5 mm",
    }.items():
        assert row[head.index(column) :].startswith(text)
    assert row.endswith("  reached")
    assert any(line.startswith("base error") and "NOT reached" in line for line in lines)
    assert "errors:" in lines
    assert "A note." in lines


def test_words_go_left_and_numbers_right():
    lines = aligned(Table(("name", "value"), (("a", 1.0), ("long name", 123.456))))
    assert lines == ["name       value", "a              1", "long name  123.5"]


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (1e-9, "< 1e-6"), (0.123456, "0.1235"), (None, "–"), ("word", "word"), (7, "7")],
)
def test_cells_in_words(value, text):
    assert cell_text(value) == text


def test_a_number_keeps_its_sign():
    assert number(-0.25) == "-0.25"
