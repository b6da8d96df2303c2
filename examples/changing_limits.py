"""Limits change while the arm moves: slower joints for a person nearby, then a shorter elbow.

The joints come within new limits as fast as the old ones allow, and then stay inside.
"""

import numpy as np

import lexstack as lx

home = {"shoulder_lift_joint": -1.0, "elbow_joint": 1.5, "wrist_2_joint": 1.0}  # rad
robot = lx.Robot.from_urdf("ur_description/urdf/ur10_robot.urdf", home=home)
tool = lx.FramePosition("tool0")
run = lx.Lockstep(robot, lx.Stack([[tool], [lx.Posture()]]), dt=0.01)
start = run.configuration.frame("tool0").pose.position
tool.set_target(start + [0.0, 0.4, -0.1])

run.until(0.8)
run.limits(velocity=0.2)  # rad/s, all joints
run.until(4.0)
run.limits(["elbow_joint"], position=(-3.0, 1.3))  # rad
tool.set_target(start)
run.until(10.0)

record = run.record()
elbow = record.q[:, robot.joints.index("elbow_joint")]
early, late = record.time < 0.8, record.time > 1.6
print(f"fastest joint before: {np.abs(record.velocity[early]).max():.2f} rad/s")
print(f"fastest joint after:  {np.abs(record.velocity[late]).max():.2f} rad/s")
print(f"elbow: {elbow.max():.2f} rad at most, and {elbow[-1]:.2f} rad at the end")
used = np.abs(record.acceleration).max(axis=0) / robot.limits.acceleration
print(f"accelerations used at most {100 * used.max():.0f} % of their limits")
