"""A robot changes its stack of tasks while it moves, and its command does not jump.

The hand goes to a target; after 1 s the platform's way comes first. One solver serves the stack in
effect (``controller``), another one the stack to come (``solver``), as two computers would.
"""

import numpy as np

import lexstack

home = (0.0, -0.79, 0.0, -2.36, 0.0, 1.57, 0.79)  # rad
panda = lexstack.mobile_manipulator("panda_description/urdf/panda.urdf", "panda_hand", home)
team = lexstack.Team((lexstack.RobotModel("robot", panda),), dt=0.01)
hand = lexstack.StackConfig.of_tasks("hand", "ee_pose", "velocity_damping")
drive = lexstack.StackConfig.of_tasks("drive", "base", "ee_position", "posture")
stacks = {config.name: lexstack.build_stack(config, team) for config in (hand, drive)}
options = lexstack.TransitionOptions("hand", lexstack.TransitionConfig(duration=1.0))
controller = lexstack.make_controller(team, stacks, options)
solver = lexstack.make_stack_solver(team, stacks)
plant = lexstack.ExactPlant(team.home(), team.dt)
run = lexstack.control.Lockstep(team, controller, solver, plant)

pose = team.tools(team.home())[0]
higher = lexstack.Pose(pose.position + np.array([0.3, 0.2, 0.1]), pose.rotation)
controller.references.add(lexstack.Target(at=0.0, robot=0, ee=higher))
controller.references.add(lexstack.Target(at=0.0, robot=0, base=np.array([1.0, 0.0, 0.0])))
controller.transition.ask("drive", duration=1.0, method="bridge", at_tick=100)
for tick in range(1, 501):
    command = run.step()
    if tick % 50 == 0:
        phase, x = command.transition.phase.name.lower(), plant.state().q[0]
        print(f"{tick * team.dt} s: {command.stack}, {phase}, platform at x = {x:.3f} m")
