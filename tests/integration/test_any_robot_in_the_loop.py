"""The twelve robots in the library's closed loop: a reach, and a smooth switch of the stack."""

import numpy as np
import pytest

import lexstack
from lexstack.mpc import StageModel
from lexstack_config.resolved import load_robot
from support.scenario import CONFIG

TWELVE = (
    *("panda", "ur5", "ur10", "xarm7", "so101", "z1", "kinova"),
    *("tiago", "tiago_dual", "baxter", "pr2", "g1"),
)
DT = 0.01  # s
PLACE = (0.4, -0.3, 0.6, 0.8)


def loop_of(name, second):
    """Return a robot's team, its controller and its loop, on the stack ``reach``."""
    config = load_robot(CONFIG / "robots" / f"{name}.yaml")
    team = lexstack.Team((lexstack.RobotModel(name, config, PLACE),), DT)
    reach = lexstack.StackConfig.of_tasks("reach", "ee_position", "minimum_velocity")
    then = lexstack.StackConfig.of_tasks("then", *second)
    stacks = {each.name: lexstack.build_stack(each, team) for each in (reach, then)}
    options = lexstack.TransitionOptions("reach", lexstack.TransitionConfig(duration=1.0))
    controller = lexstack.make_controller(team, stacks, options)
    solver = lexstack.make_stack_solver(team, stacks)
    plant = lexstack.ExactPlant(team.home(), DT, team)
    return team, controller, plant, lexstack.control.Lockstep(team, controller, solver, plant)


@pytest.mark.parametrize("name", TWELVE)
def test_a_robot_reaches_and_then_switches_smoothly_within_its_limits(name):
    team, controller, plant, run = loop_of(name, ("posture",))
    limits, home = team.limits, team.home()
    rng = np.random.default_rng(3)
    arm, arm_q = team.robots[0].arm, team.robots[0].arm_q
    lower, upper = home - 0.25, home + 0.25
    lower[arm_q] = np.maximum(limits.position_lower[arm], lower[arm_q])
    upper[arm_q] = np.minimum(limits.position_upper[arm], upper[arm_q])
    goal = team.tools(rng.uniform(lower, upper))[0]
    controller.references.add(lexstack.Target(at=0.0, robot=0, ee=goal))
    controller.transition.ask("then", duration=1.0, method="bridge", at_tick=800)
    chi, apart = np.zeros(team.n), np.inf
    for tick in range(1, 1301):
        command = run.step()
        state = plant.state()
        assert (np.abs(command.chi) <= limits.velocity + 1e-9).all()
        assert (np.abs(command.chi - chi) <= limits.acceleration * DT + 1e-9).all(), tick
        places = team.joint_positions(state.q)
        assert (places >= limits.position_lower - 1e-9).all()
        assert (places <= limits.position_upper + 1e-9).all()
        chi = command.chi
        if tick == 799:
            apart = np.linalg.norm(team.tools(state.q)[0].position - goal.position)
    assert apart < 1e-3
    assert command.stack == "then"
    rest = team.robots[0].posture
    left = np.abs(state.q[arm_q] - rest)
    assert (left < np.abs(home[arm_q] - rest) + 0.3).all()


def test_the_mpc_drives_a_robot_whose_grippers_mimic():
    config = load_robot(CONFIG / "robots" / "pr2.yaml")
    robot = lexstack.RobotModel("pr2", config)
    model = StageModel(robot, 4)
    rng = np.random.default_rng(1)
    q = robot.home() + 0.1 * rng.uniform(-1.0, 1.0, (4, robot.n))
    at = model.at(q)
    for k in range(4):
        pose, jacobian = robot.tool(q[k])
        np.testing.assert_allclose(at.tool.position[k], pose.position, atol=1e-12)
        np.testing.assert_allclose(at.tool.rotation[k], pose.rotation, atol=1e-12)
        np.testing.assert_allclose(at.tool.jacobian[k], jacobian, atol=1e-12)
    lexstack.Htmpc(robot, lexstack.DEFAULT_HTMPC)


@pytest.mark.parametrize("name", ["ur10_ridgeback", "tiago", "pr2"])
def test_the_mpc_serves_a_sequence_with_a_robot_that_drives(name):
    robot = lexstack.RobotModel(name, load_robot(CONFIG / "robots" / f"{name}.yaml"))
    team = lexstack.Team((robot,), dt=0.1)
    state = lexstack.RobotState.at_rest(team.home())
    goal = tuple(team.tools(state.q)[0].position + np.array([1.0, 0.3, 0.1]))
    tasks = (
        lexstack.SequenceTask("reach", "ee_position", (goal,), tolerance=0.01),
        lexstack.SequenceTask("park", "base_position", ((2.0, 0.5),), tolerance=0.05),
    )
    runner = lexstack.SequenceRunner(team, 0, lexstack.DEFAULT_HTMPC)
    runner.begin(tasks, lexstack.HT_ARCH, state)
    reached = np.inf
    while not (progress := runner.step(state)).sequence.done and state.stamp < 15.0:
        reached = min(reached, np.linalg.norm(team.tools(state.q)[0].position - goal))
        q, v, _ = progress.plan.sample(state.stamp + team.dt)
        tick = state.tick + 1
        state = lexstack.RobotState(tick, tick * team.dt, q, v, q, v)
    assert progress.sequence.done
    assert reached < 0.01
    np.testing.assert_allclose(state.q[:2], [2.0, 0.5], atol=0.05)
