"""Faults of a running system, the short form of ``./scripts/experiment faults``."""

import signal
from dataclasses import replace

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped

from lexstack_core.config.resolved import load_scenario
from lexstack_core.model import Team
from lexstack_core.rotation import to_quaternion
from lexstack_experiments.experiment import Options
from lexstack_experiments.experiments import faults
from lexstack_experiments.experiments.fault_records import read_record
from lexstack_ros.faults.cases import CASES, FLOOD
from lexstack_ros.faults.rig import running
from lexstack_ros.qos import STREAM
from support.scenario import CONFIG

pytestmark = pytest.mark.system

# Robot B's death is in test_run.py, the HTMPC's in test_htmpc.py, a cut network in test_hosts.py.
CHOSEN = (
    "kill sim_bridge idle",
    "kill recorder blending",
    "kill hqp_controller blending",
    "stop hqp_controller blending",
    "stop stack_solver blending",
    "flood 1000 requests idle",
    "disk full blending",
)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Return what came of each case, and the bags that cannot be read; all in one run."""
    out = tmp_path_factory.mktemp("faults")
    outcomes, unreadable = faults.done(Options(CONFIG, out, 0, len(CHOSEN)), CHOSEN)
    return {each.case: each for each in outcomes}, unreadable


def test_every_process_is_killed_and_stopped_in_every_phase():
    done = {(case.fault, case.what, case.phase) for case in CASES.values()}
    for process in ("sim_bridge", "hqp_controller", "stack_solver", "htmpc", "recorder"):
        for phase in ("idle", "blending", "following", "sequence"):
            assert {("kill", process, phase), ("stop", process, phase)} <= done


@pytest.mark.parametrize("case", CHOSEN)
def test_the_command_keeps_its_limits_and_its_order(found, case):
    outcome = found[0][case]
    assert outcome.ticks >= 10, "the bag shows it"
    assert outcome.acceleration <= 1.0 + 1e-6
    assert outcome.velocity <= 1.0 + 1e-6
    assert outcome.beyond <= 1e-9
    assert outcome.reordered == 0


@pytest.mark.parametrize("case", CHOSEN)
def test_the_reason_is_told_and_all_serve_again(found, case):
    outcome = found[0][case]
    assert outcome.missing == ""
    assert outcome.rejoined, "robot B serves a switch"
    assert outcome.recovered is not None
    assert outcome.recovered < 20.0


def test_the_bags_can_be_read_and_every_request_was_answered(found):
    outcomes, unreadable = found
    assert unreadable == []
    assert outcomes["flood 1000 requests idle"].answers == FLOOD


def test_the_results_fall_short_where_an_outcome_does(found):
    """The figures are made from the outcomes, whatever they are."""
    good = list(found[0].values())
    assert all(figure.reached for figure in faults.figures(good, []))
    for change in (
        {"acceleration": 1.1},
        {"velocity": 1.1},
        {"beyond": 1e-3},
        {"reordered": 1},
        {"missing": "transition"},
        {"rejoined": False},
        {"recovered": None},
    ):
        bad = [*good[1:], replace(good[0], **change)]
        assert sum(not figure.reached for figure in faults.figures(bad, [])) == 1, change
    assert not all(figure.reached for figure in faults.figures(good, ["bag: not readable"]))


def test_a_robot_b_that_starts_anew_knows_the_targets_of_before(tmp_path):
    """At rest on a target that was sent before its start, robot B has nothing to move."""
    scenario = load_scenario(CONFIG / "scenarios" / "faults.yaml")
    with running(scenario, tmp_path) as rig:
        moved = rig.node.create_publisher(PoseStamped, "/robot_a/ee_target", STREAM)
        rig.until(lambda: moved.get_subscription_count() >= 2, "listeners")
        rig.wait(lambda: False, 0.5)
        pose = PoseStamped()
        start = Team.from_scenario(scenario).tools(np.asarray(rig.state.q))[0]
        place, turn = pose.pose.position, pose.pose.orientation
        place.x, place.y, place.z = (start.position + np.array([0.0, 0.0, 0.1])).tolist()
        turn.x, turn.y, turn.z, turn.w = to_quaternion(start.rotation).tolist()
        moved.publish(pose)
        rig.wait(lambda: False, 4.0)
        rig.send("stack_solver", signal.SIGKILL)
        rig.start("stack_solver")
        rig.switch("track", 1.0)
        rig.until(lambda: rig.follows("robot_b"), "to follow robot B")
        rig.until(lambda: rig.is_on("track"), "the end of the transition")
        rig.supervisor.end()
    record = read_record([tmp_path / "bag"])
    first = record.commands[0].chi
    fastest = max(np.abs(command.chi - first).max() for command in record.commands)
    assert fastest > 0.05, "the target moved the robot"
    assert record.solutions
    assert max(np.abs(solved.chi).max() for solved in record.solutions) < 0.02
