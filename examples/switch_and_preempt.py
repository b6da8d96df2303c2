"""A stack is switched while the robot moves, and the switch is pre-empted by another one.

The command has no jump at either trigger: what is left of the old motion fades.
"""

import numpy as np

import lexstack as lx

robot = lx.Robot.from_urdf(
    "panda_description/urdf/panda.urdf",
    base="holonomic",
    tool="panda_hand",
    fixed={"panda_finger_joint1": 0.0, "panda_finger_joint2": 0.0},
    home=[0.0, -0.79, 0.0, -2.36, 0.0, 1.57, 0.79],  # rad
)
hand, base, rest = lx.FramePose("panda_hand"), lx.BasePose(), lx.VelocityDamping()
run = lx.Lockstep(robot, lx.Stack([[hand], [rest]], "reach"), dt=0.01)
start = run.configuration.frame("panda_hand").pose
hand.set_target((start.position + [0.4, 0.3, 0.1], start.rotation))
base.set_target([0.4, -0.1, 0.6])  # m, m, rad
reach_and_drive = lx.Stack([[hand], [base]], "reach_and_drive")
drive = reach_and_drive.swapped(0, 1)

run.until(0.8)
run.switch(reach_and_drive, duration=1.5)
run.until(1.5)  # in the middle of the blend
run.switch(drive, duration=1.5)
run.until(6.0)

record = run.record()
share = np.abs(record.acceleration).max(axis=0) / robot.limits.acceleration
print(f"accelerations used at most {100 * share.max():.0f} % of their limits")
print(f"the base is at {run.state.q[:3].round(3) + 0.0}")
