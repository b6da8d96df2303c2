"""Predictive control of two tasks in a strict order: the hand's target first, then the platform's.

The HTMPC plans 1 s ahead in the strict order of the window's tasks; its inputs are accelerations.
"""

import lexstack

home = (0.0, -0.79, 0.0, -2.36, 0.0, 1.57, 0.79)  # rad
panda = lexstack.mobile_manipulator("panda_description/urdf/panda.urdf", "panda_hand", home)
team = lexstack.Team((lexstack.RobotModel("robot", panda),), dt=0.1)
state = lexstack.RobotState.at_rest(team.home())
x, y, z = team.tools(state.q)[0].position

tasks = (
    lexstack.SequenceTask("lift", "ee_position", ((x + 0.4, y, z + 0.2),)),
    lexstack.SequenceTask("park", "base_position", ((1.0, 0.5),), tolerance=0.05),
)
runner = lexstack.SequenceRunner(team, 0, lexstack.DEFAULT_HTMPC)
runner.begin(tasks, lexstack.HT_ARCH, state)
while state.stamp < 15.0:
    progress = runner.step(state)
    if progress.sequence.done:
        break
    if state.tick % 10 == 0:
        names = [task.name for task in progress.sequence.window]
        print(f"{state.stamp:.0f} s: {' before '.join(names)}, {progress.errors[0]:.3f} m to go")
    q, v, _ = progress.plan.sample(state.stamp + team.dt)
    tick = state.tick + 1
    state = lexstack.RobotState(tick, tick * team.dt, q, v, q, v)
print(f"done after {state.stamp:.1f} s")
