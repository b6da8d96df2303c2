"""The scenario sudden-limits through all processes, as a user runs it."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

from lexstack_bag.figures.limits import limits_in_force
from lexstack_bag.figures.series import COMMANDER
from lexstack_bag.run.reader import read_run
from support.scenario import ROOT

pytestmark = pytest.mark.system


@pytest.fixture(scope="module")
def out(tmp_path_factory):
    """Run the demo once."""
    folder = tmp_path_factory.mktemp("sudden") / "run"
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "lexstack_bringup.commands.demo",
            "sudden-limits",
            "--out",
            str(folder),
        ],
        capture_output=True,
        text=True,
        timeout=110,
        check=False,
        cwd=ROOT,
        env={k: v for k, v in os.environ.items() if k != "ROS_DOMAIN_ID"},
    )
    assert done.returncode == 0, done.stderr
    return folder


def test_the_report_finds_no_empty_box_and_no_acceleration_beyond(out):
    metrics = json.loads((out / "metrics.json").read_text(encoding="utf-8"))
    assert [phase["stack"] for phase in metrics["phases"]] == ["track", "confined", "track"]
    assert metrics["peak_acceleration_ratio"] <= 1.0001
    for key in ("empty_bounds", "solver_failures", "missing_ticks", "recorder_lost"):
        assert metrics[key] == 0


def test_the_bag_shows_the_joints_inside_the_new_limits(out):
    run = read_run(out / "bag")
    team = run.team()
    limits = limits_in_force(run, team, COMMANDER)
    command = run.chi[COMMANDER]
    wide, tight = team.limits, limits[-1 - round(6.0 / run.period)]
    assert np.any(tight.position_upper < wide.position_upper)
    inside = (command.stack == "confined") & (command.stamp >= 1.43)
    q_star = run.plant.q_star[np.isin(run.plant.tick, command.tick[inside])]
    assert len(q_star) > 500
    assert (q_star >= tight.position_lower - 1e-6).all()
    assert (q_star <= tight.position_upper + 1e-6).all()
    at_trigger = run.plant.q_star[run.plant.tick == 100][0]
    assert (at_trigger < tight.position_lower - 0.1).any()
