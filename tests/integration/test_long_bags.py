"""Memory grows with the numbers of a run, not with its messages."""

from __future__ import annotations

import subprocess
import sys

import pytest

from lexstack_bag.storage.container import find_files
from lexstack_experiments.synthetic import write_bag
from support.scenario import resolved

# What a tick leaves in memory: 4 vectors of the plant and both chi in full, their bounds
# in single precision, 0.3 kB of scalars, 0.5 kB of errors and ratios: 2.1 kB. Its messages have
# 3.3 kB, and as objects more than 10 kB.
PER_TICK = 3500.0  # bytes, with what the allocator keeps
TICKS = 60 * 100  # a minute

MEASURE = """
import resource, sys
from pathlib import Path
from lexstack_bag.figures.series import measure
from lexstack_bag.run.reader import read_run
run = read_run(Path(sys.argv[1]))
measure(run)
print(len(run.plant.tick), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024)
"""


@pytest.mark.slow
def test_memory_grows_with_the_numbers(tmp_path):
    peaks = []
    for minutes in (1.0, 3.0):
        folder = tmp_path / f"{minutes}"
        counts = write_bag(folder, resolved(), minutes, lambda _part: None)
        assert counts["/robot_b/chi"] == counts["/plant/state"] == minutes * TICKS
        done = subprocess.run(
            [sys.executable, "-c", MEASURE, str(folder)], capture_output=True, text=True, check=True
        )
        ticks, peak = map(int, done.stdout.split())
        assert ticks == minutes * TICKS
        peaks.append(peak)
    assert sum(path.stat().st_size for path in find_files(tmp_path / "3.0")) > 5e6
    growth = (peaks[1] - peaks[0]) / (2 * TICKS)
    assert growth < PER_TICK, f"{growth:.0f} bytes per tick"
