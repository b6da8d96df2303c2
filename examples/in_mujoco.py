"""A robot of your own in MuJoCo: torque-controlled joints, gravity and a gripper, in one line more.

The same run as on the ideal plant, with ``plant=mujoco_plant``. It needs the package lexstack_sim.
"""

from pathlib import Path

import numpy as np

import lexstack as lx
from lexstack_sim.from_team import mujoco_plant

urdf = Path(__file__).parent / "own_robot/lift_arm.urdf"
home = {"lift": 0.1, "shoulder": -0.6, "elbow": 1.2, "left": 0.035}  # m, rad
robot = lx.Robot.from_urdf(urdf, name="arm", tool="hand", home=home)
hand, posture = lx.FramePosition("hand"), lx.Posture()
run = lx.Lockstep(robot, lx.Stack([[hand], [posture]]), dt=0.01, plant=mujoco_plant)
start = run.configuration.frame("hand").pose.position
hand.set_target(start + [-0.1, 0.25, 0.15])  # m
run.until(3.0)
off = np.linalg.norm(run.configuration.frame("hand").pose.position - hand.goal.position)
print(f"the hand is {1e3 * off:.2f} mm from its target")
run.switch(lx.Stack([[posture]]), duration=1.0)
run.until(8.0)
print(f"back at its posture within {np.abs(run.state.q - robot.model.posture).max():.3f} rad")
