"""The solver learns the stacks that users send from the controller's requests alone."""

from __future__ import annotations

import pytest

from lexstack_interfaces.msg import StackRequest
from lexstack_ros.node.options import NodeOptions
from lexstack_ros.solver.node import StackSolverNode
from lexstack_testing.ros_session import ros_session
from support.scenario import resolved

LEAN = "{name: lean, description: x, levels: [{tasks: [{type: ee_pose}]}, {tasks: [{type: base}]}]}"
OTHER = LEAN.replace("base", "posture")


@pytest.fixture
def solver(tmp_path):
    """Return a solver that hears nobody."""
    path = tmp_path / "scenario.yaml"
    path.write_text(resolved().to_yaml(), encoding="utf-8")
    with ros_session(children=False) as context:
        node = StackSolverNode(NodeOptions(context, parameters={"scenario": str(path)}))
        yield node
        node.destroy_node()


def asked(solver, stack="lean", text=LEAN):
    """Ask for a stack as the controller does; return whether it was refused."""
    before = solver._states.refused
    solver._on_request(StackRequest(id=1, stack=stack, active=True, stack_yaml=text))
    return solver._states.refused > before


def second_task(solver):
    return solver._mine["lean"].levels[1].tasks[0].name


def test_a_text_is_learnt_with_the_first_request_that_a_solver_hears(solver):
    assert asked(solver, text=""), "nobody has sent it yet"
    assert not asked(solver)
    assert second_task(solver).endswith("base")
    assert not asked(solver, text=""), "by its name now"
    assert [wanted.stack for wanted in solver._schedule.current(10)] == ["lean"]


def test_a_controller_that_started_again_may_give_a_name_to_another_stack(solver):
    asked(solver)
    assert not asked(solver, text=OTHER)
    assert second_task(solver).endswith("posture")


def test_what_is_no_such_stack_is_refused_and_told(solver):
    assert asked(solver, "other", LEAN)
    assert "stack: 'other' is not that of stack_yaml" in solver._states._rejection
    assert asked(solver, text="{name: lean")
    assert "/robot_a/stack_request: stack_yaml: not valid YAML" in solver._states._rejection
    assert "lean" not in solver._stacks


def test_a_stack_of_the_scenario_stays_what_it_is(solver):
    before = solver._stacks["track"]
    assert not asked(solver, "track", LEAN.replace("lean", "track"))
    assert solver._stacks["track"] is before


def test_a_reset_of_the_plant_forgets_what_was_sent(solver):
    asked(solver)
    solver._restart()
    assert asked(solver, text="")
    assert "track" in solver._stacks
