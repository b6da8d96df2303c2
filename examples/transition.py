"""A robot changes its stack of tasks while it moves, and its command does not jump.

The hand goes to a target; after 1 s the platform's way comes first. One solver serves the stack in
effect (``controller``), another one the stack to come (``source``), as two computers would.
"""

import numpy as np

import lexstack

home = (0.0, -0.79, 0.0, -2.36, 0.0, 1.57, 0.79)  # rad
panda = lexstack.mobile_manipulator("panda_description/urdf/panda.urdf", "panda_hand", home)
team = lexstack.Team((lexstack.RobotModel("robot", panda),), dt=0.01)
hand = lexstack.StackConfig.of_tasks("hand", "ee_pose", "minimum_velocity")
drive = lexstack.StackConfig.of_tasks("drive", "base", "ee_position", "posture")
stacks = {config.name: lexstack.build_stack(config, team) for config in (hand, drive)}
options = lexstack.TransitionOptions("hand", lexstack.TransitionConfig(duration=1.0))
controller = lexstack.make_controller(team, stacks, options)
source, schedule = lexstack.make_stack_solver(team, stacks), lexstack.SourceSchedule()

state = lexstack.RobotState.at_rest(team.home())
pose = team.tools(state.q)[0]
higher = lexstack.Pose(pose.position + np.array([0.3, 0.2, 0.1]), pose.rotation)
controller.references.add(lexstack.Target(at=0.0, robot=0, ee=higher))
controller.references.add(lexstack.Target(at=0.0, robot=0, base=np.array([1.0, 0.0, 0.0])))
controller.transition.ask("drive", duration=1.0, method="bridge", at_tick=100)
for _ in range(500):
    for announcement in controller.transition.take_announcements():
        schedule.hear(announcement)
    controller.prepare(state)
    references = controller.references.at(state.stamp)
    for wanted in schedule.current(state.tick):
        controller.transition.hear(source.answer(wanted, team.kinematics(state), references))
    command = controller.tick(state)
    state = state.after(command.chi, team.dt)
    if state.tick % 50 == 0:
        phase = command.transition.phase.name.lower()
        print(f"{state.stamp} s: {command.stack}, {phase}, platform at x = {state.q[0]:.3f} m")
