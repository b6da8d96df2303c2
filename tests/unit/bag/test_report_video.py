"""The run as a film: as long as the run, with the robots in it; or one line that says why not."""

from __future__ import annotations

import dataclasses
import re
import subprocess
import sys

import numpy as np
import pytest

from lexstack.errors import LexstackError
from lexstack_bag.commands import analyze
from lexstack_bag.figures.phases import find_phases
from lexstack_bag.figures.series import measure
from lexstack_bag.report.video import write_video
from lexstack_bag.run.reader import read_run
from lexstack_sim import render


def pictures(path):
    """Return rate [1/s] and pictures of a film, shape (k, height, width, 3)."""
    from imageio_ffmpeg import read_frames

    frames = read_frames(str(path))
    facts = next(frames)
    width, height = facts["size"]
    return facts["fps"], [
        np.frombuffer(frame, np.uint8).reshape(height, width, 3) for frame in frames
    ]


def second(run):
    """The second of the run in whose middle the solver steps aside."""
    plant = run.plant
    rows = {f.name: getattr(plant, f.name)[150:250] for f in dataclasses.fields(plant)}
    return dataclasses.replace(run, plant=dataclasses.replace(plant, **rows))


def test_a_film_shows_the_run_from_beginning_to_end(synthetic, tmp_path):
    run = second(read_run(synthetic.folder))
    parts = []
    try:
        count = write_video(tmp_path / "run.mp4", run, measure(run), find_phases(run), parts.append)
    except render.RenderError as error:
        pytest.skip(str(error))
    rate, shown = pictures(tmp_path / "run.mp4")
    assert rate == 25
    assert len(shown) == count == 25
    assert parts == pytest.approx(np.arange(1, 26) / 25)
    for image in shown[:: len(shown) // 4]:
        red, green, blue = (image[..., i].astype(int) for i in range(3))
        assert np.count_nonzero((red > 140) & (green < 0.7 * red) & (blue < 0.45 * red)) > 200
        assert np.count_nonzero((blue > 110) & (red < 0.5 * blue)) > 200
    before, after = shown[8].astype(int), shown[18].astype(int)
    assert (np.abs(before - after).max(axis=2) > 40).sum() > 200
    steady = np.abs(shown[15].astype(int) - shown[24].astype(int)).max(axis=2)[50:]
    assert (steady > 40).sum() < 50


def test_a_machine_without_opengl_is_told_what_to_install(synthetic, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(render, "_LIBRARIES", {"egl": "libnowhere.so.1"})
    arguments = [str(synthetic.folder), "--video", "--out", str(tmp_path)]
    assert analyze.main(arguments) == 2
    error = capsys.readouterr().err.strip().splitlines()
    assert len(error) == 1
    assert re.match(r"analyze: no offscreen rendering \(install libegl1", error[0])


def test_a_place_that_cannot_be_written_is_named(synthetic, tmp_path):
    run = read_run(synthetic.folder)
    with pytest.raises(LexstackError, match="nowhere"):
        write_video(tmp_path / "nowhere" / "run.mp4", run, measure(run), find_phases(run))


def test_two_bags_make_no_film(synthetic, tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "lexstack_bag.commands.analyze"]
        + [str(synthetic.folder)] * 2
        + ["--video", "--out", str(tmp_path)],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.returncode == 2
    assert "one bag at a time" in done.stderr
