"""Figures made of plain arrays, and how series are thinned out."""

from __future__ import annotations

import base64

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lexstack_bag.report.blocks import Path, Span, paths_from_above, series, timeline
from lexstack_bag.report.traces import extremes


def values(plain):
    return np.frombuffer(base64.b64decode(plain["bdata"]), "<f4")


def test_paths_are_drawn_to_scale_with_their_beginnings_targets_and_obstacles():
    figure = paths_from_above(
        "way",
        "Way",
        "",
        [Path("base", [0, 1, 2], [0, 1, 0]), Path("EE", [0.5, 2.5], [1, 1])],
        {"red": (2.0, 1.0)},
        [(1.0, 2.0, 0.25)],
    )
    lines = [t for t in figure.traces if t["mode"] == "lines"]
    assert values(lines[0]["x"]).tolist() == [0, 1, 2]
    assert len({(t["line"]["color"], t["line"]["dash"]) for t in lines}) == 2
    assert figure.layout["yaxis"]["scaleanchor"] == "x"
    circle = figure.layout["shapes"][0]
    assert (circle["x0"], circle["x1"], circle["y0"], circle["y1"]) == (0.75, 1.25, 1.75, 2.25)
    target = figure.traces[-1]
    assert (values(target["x"])[0], values(target["y"])[0]) == (2.0, 1.0)
    assert not figure.linked


def test_a_long_path_is_thinned_out():
    angle = np.linspace(0, 2 * np.pi, 100_000)
    figure = paths_from_above("way", "", "", [Path("round", np.cos(angle), np.sin(angle))])
    drawn = values(figure.traces[0]["x"])
    assert 1000 < len(drawn) <= 3000
    assert drawn.min() == pytest.approx(-1.0, abs=1e-3)


def test_a_timeline_has_a_row_for_every_lane_and_a_look_for_every_label():
    spans = [
        Span("base", "go", 0.0, 2.0),
        Span("arm", "hold", 0.5, 1.5),
        Span("base", "hold", 2.0, 3.0),
    ]
    figure = timeline("tasks", "Tasks", "", spans, (0.0, 3.0))
    assert [trace["name"] for trace in figure.traces] == ["go", "hold"]
    hold = figure.traces[1]
    assert hold["y"] == ["arm", "base"]
    assert hold["base"] == [0.5, 2.0]
    assert hold["x"] == [1.0, 1.0]
    looks = [(t["marker"]["color"], t["marker"]["pattern"]["shape"]) for t in figure.traces]
    assert looks[0] != looks[1]
    assert figure.layout["xaxis"]["range"] == [0.0, 3.0]
    assert figure.layout["yaxis"]["categoryarray"] == ["arm", "base"]  # from below


def test_series_share_their_time_and_have_units():
    time = np.arange(200) * 0.1
    rows = [
        ("error", "mm", {"level 1": np.sin(time), "level 2": np.cos(time)}),
        ("solve time", "ms", {"HTMPC": np.full(200, 1.5)}),
    ]
    figure = series("errors", "Errors", "", time, rows, log=True)
    assert [t["yaxis"] for t in figure.traces] == ["y", "y", "y2"]
    assert figure.layout["yaxis2"]["title"]["text"] == "solve time [ms]"
    assert figure.layout["yaxis"]["type"] == "log"
    assert all(t["dx"] == pytest.approx(0.1) for t in figure.traces)
    assert figure.traces[2]["hovertemplate"].endswith(" ms")
    assert np.allclose(values(figure.traces[1]["y"]), np.cos(time), atol=1e-6)


@settings(derandomize=True, deadline=None)
@given(
    numbers=st.lists(st.floats(-1e3, 1e3) | st.just(float("nan")), min_size=1, max_size=200),
    stride=st.integers(1, 20),
)
def test_thinning_out_keeps_every_peak_in_its_place(numbers, stride):
    whole = np.array(numbers)
    drawn = extremes(whole, stride)
    if stride == 1:
        assert np.array_equal(drawn, whole, equal_nan=True)
        return
    size = 2 * stride
    assert len(drawn) == 2 * -(-len(whole) // size)
    for k in range(len(drawn) // 2):
        part = whole[k * size : (k + 1) * size]
        known = part[~np.isnan(part)]
        pair = drawn[2 * k : 2 * k + 2]
        if not len(known):
            assert np.isnan(pair).all()
            continue
        assert sorted(pair) == [known.min(), known.max()]
        places = [int(np.flatnonzero(part == value)[0]) for value in pair]
        assert places == sorted(places)
