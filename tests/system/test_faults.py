"""Faults of a running system, the short form of ``./scripts/experiment faults``."""

import contextlib
import re
import signal
from dataclasses import replace

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped

from lexstack.robots import to_quaternion
from lexstack_bringup.processes import ADAPTERS, MODULES
from lexstack_config.parts import build_team
from lexstack_config.resolved import load_scenario
from lexstack_experiments.experiment import Options
from lexstack_experiments.experiments import faults
from lexstack_experiments.experiments.fault_cuts import CUTS
from lexstack_experiments.experiments.fault_records import read_record
from lexstack_testing.faults.cases import CASES, FLOOD
from lexstack_testing.faults.rig import running
from support.quiet import MACHINE, TIMEOUT
from support.scenario import CONFIG, ROOT

pytestmark = [pytest.mark.system, pytest.mark.alone, pytest.mark.timeout(TIMEOUT)]

# The solver's end is in test_run.py, the HTMPC's in test_htmpc.py, a cut network in test_hosts.py.
CHOSEN = (
    "kill sim_bridge idle",
    "kill recorder blending",
    "kill hqp_controller blending",
    "stop hqp_controller blending",
    "stop stack_solver blending",
    "flood 1000 requests idle",
    "disk full blending",
)


def short_of_limits(outcome):
    """Return which limits the command of a case did not keep."""
    return [
        name
        for name, kept in (
            (f"ticks: {outcome.ticks}, the bag does not show it", outcome.ticks >= 10),
            (f"acceleration: {outcome.acceleration}", outcome.acceleration <= 1.0 + 1e-6),
            (f"velocity: {outcome.velocity}", outcome.velocity <= 1.0 + 1e-6),
            (f"beyond its box: {outcome.beyond}", outcome.beyond <= 1e-9),
            (f"reordered: {outcome.reordered}", outcome.reordered == 0),
        )
        if not kept
    ]


def short_of_service(outcome):
    """Return what nobody told, and who did not serve again."""
    recovered = outcome.recovered
    return [
        name
        for name, kept in (
            (f"missing: {outcome.missing}", outcome.missing == ""),
            ("the solver does not serve a switch", outcome.rejoined),
            (f"recovered: {recovered}", recovered is not None and recovered < 20.0),
        )
        if not kept
    ]


class WrongError(AssertionError):
    """Some cases did not come out as they should; the text says which."""


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Return what came of each case, and the bags that cannot be read; all in one run.

    Cases that come out wrong while others have the machine are done again. Where they come out
    wrong on a quiet machine the tests say what.
    """
    good, bad, unreadable = {}, {}, []

    def attempt(_number):
        left = [case for case in CHOSEN if case not in good]
        out = tmp_path_factory.mktemp("faults")
        outcomes, unreadable[:] = faults.done(Options(CONFIG, out, 0, len(left)), left)
        bad.clear()
        for each in outcomes:
            kept = not short_of_limits(each) and not short_of_service(each)
            (good if kept and not unreadable else bad)[each.case] = each
        if bad:
            raise WrongError({c: short_of_limits(o) + short_of_service(o) for c, o in bad.items()})

    with contextlib.suppress(WrongError):  # the tests below say so, each of its case
        MACHINE.undisturbed(attempt, "faults")
    return good | bad, unreadable


def test_every_process_of_a_run_is_killed_and_stopped_in_every_phase_that_the_page_tells_of():
    """The page lists every case; the list of processes is that of what a run starts."""
    page = (ROOT / "docs" / "faults.md").read_text(encoding="utf-8")
    table = page.partition("\n## Times\n")[2]
    told = re.findall(r"^\| ((?:kill|stop|slow|flood|disk|message|cut) [^|]+) \|", table, re.M)
    assert sorted(told) == sorted([*CASES, *CUTS])
    assert f"# {len(told)} cases" in page
    phases = re.findall(r"\*(\w+)\*, ", re.search(r"^Phases: .*$", page, re.M).group())
    assert sorted(phases) == ["blending", "following", "idle", "sequence"]
    for fault in ("kill", "stop"):
        simulated = MODULES.keys() - ADAPTERS.keys()
        wanted = {f"{fault} {process} {phase}" for process in simulated for phase in phases}
        assert wanted == {name for name in told if name.startswith(fault)}


@pytest.mark.parametrize("case", CHOSEN)
def test_the_command_keeps_its_limits_and_its_order(found, case):
    assert short_of_limits(found[0][case]) == []


@pytest.mark.parametrize("case", CHOSEN)
def test_the_reason_is_told_and_all_serve_again(found, case):
    assert short_of_service(found[0][case]) == []


def test_a_wrong_outcome_is_seen(found):
    """Whatever may be wrong with a case is named by one of the two tests above."""
    good = next(iter(found[0].values()))
    for change, told in (
        ({"ticks": 9}, "ticks: 9"),
        ({"acceleration": 1.1}, "acceleration: 1.1"),
        ({"velocity": 1.1}, "velocity: 1.1"),
        ({"beyond": 1e-3}, "beyond its box: 0.001"),
        ({"reordered": 1}, "reordered: 1"),
        ({"missing": "transition"}, "missing: transition"),
        ({"rejoined": False}, "the solver does not serve"),
        ({"recovered": None}, "recovered: None"),
        ({"recovered": 20.0}, "recovered: 20.0"),
    ):
        bad = replace(good, **change)
        assert any(line.startswith(told) for line in short_of_limits(bad) + short_of_service(bad))


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


@pytest.mark.realtime
def test_a_robot_b_that_starts_anew_knows_the_targets_of_before(tmp_path):
    """At rest on a target that was sent before its start, the solver has nothing to move."""
    scenario = load_scenario(CONFIG / "scenarios" / "faults.yaml")
    with running(scenario, tmp_path) as rig:
        moved = rig.publisher(PoseStamped, "/robot_a/ee_target", listeners=2)
        pose = PoseStamped()
        start = build_team(scenario).tools(np.asarray(rig.state.q))[0]
        place, turn = pose.pose.position, pose.pose.orientation
        place.x, place.y, place.z = (start.position + np.array([0.0, 0.0, 0.1])).tolist()
        turn.x, turn.y, turn.z, turn.w = to_quaternion(start.rotation).tolist()
        moved.publish(pose)
        rig.spin(4.0)
        rig.run.send("stack_solver", signal.SIGKILL)
        rig.run.start("stack_solver")
        rig.switch("track", 1.0)
        rig.until(lambda: rig.follows("robot_b"), "to follow the solver")
        rig.until(lambda: rig.is_on("track"), "the end of the transition")
        rig.run.end()
    record = read_record([tmp_path / "bag"])
    first = record.commands[0].chi
    fastest = max(np.abs(command.chi - first).max() for command in record.commands)
    assert fastest > 0.05, "the target moved the robot"
    assert record.solutions
    assert max(np.abs(solved.chi).max() for solved in record.solutions) < 0.02
