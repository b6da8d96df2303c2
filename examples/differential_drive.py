"""A differential drive with an arm: it parks sideways while the hand stays where it is.

Such a base cannot be led straight to a place: it drives ahead or back and turns, but never goes
sideways. ``BasePose`` leads it there by a law that ends at the pose, wherever it starts.
"""

import numpy as np

import lexstack as lx

robot = lx.Robot.from_urdf(
    "panda_description/urdf/panda.urdf",
    base="differential",
    tool="panda_hand",
    fixed={"panda_finger_joint1": 0.0, "panda_finger_joint2": 0.0},
    home=[0.0, -0.79, 0.0, -2.36, 0.0, 1.57, 0.79],  # rad
)
print(f"n_q = {robot.n_q}, n_v = {robot.n_v}: {', '.join(robot.joints[:2])} and the arm")
hand, base = lx.FramePosition("panda_hand"), lx.BasePose()
run = lx.Lockstep(robot, lx.Stack([[base], [hand], [lx.Posture()]]), dt=0.01)
start = run.configuration.frame("panda_hand").pose.position
base.set_target([0.0, 0.25, 0.0])  # m, m, rad: beside itself
run.until(20.0)

record = run.record()
x, y, yaw = record.q[-1, :3]
print(f"parked at x = {1e3 * x:.1f} mm, y = {1e3 * y:.1f} mm, yaw = {1e3 * yaw:.1f} mrad")
moved = np.linalg.norm(record.path("panda_hand") - start, axis=1)
print(f"the hand moved by at most {1e3 * moved.max():.1f} mm, and {1e3 * moved[-1]:.2f} at the end")
