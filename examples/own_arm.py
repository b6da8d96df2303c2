"""An arm of your own: from its URDF to velocities, in a loop of your own.

The hand goes to a point first; with what is left it points down; with the rest the arm keeps near
its posture. ``unmet`` says in words what could not be met, and what stood in its way.
"""

from pathlib import Path

import numpy as np

import lexstack as lx

urdf = Path(__file__).parent / "own_robot/lift_arm.urdf"
home = {"lift": 0.1, "shoulder": -0.6, "elbow": 1.2, "left": 0.035}  # m, rad
robot = lx.Robot.from_urdf(urdf, base="fixed", tool="hand", home=home)
place = lx.FramePosition("hand", gain=3.0)
down = lx.AxisAlignment("hand", axis=(1, 0, 0), direction=(0, 0, -1))
stack = lx.Stack([[place], [down], [lx.Posture()]])
place.set_target([0.3, 0.3, 0.5])  # m

dt, q, v = 0.01, robot.home, np.zeros(robot.n_v)
path = [robot.configuration(q).frame("hand").pose.position]
for tick in range(400):
    result = lx.solve_hqp(robot.configuration(q, v), stack, dt)
    v = result.velocity  # to your robot's driver, which answers with the next q
    q = robot.integrate(q, v, dt)
    path.append(robot.configuration(q).frame("hand").pose.position)
    if tick == 5:
        print(f"at {tick * dt:.2f} s, {result.unmet.split(';')[0]}")
print(f"the hand is at {path[-1].round(3)} m")
print(f"residuals: {result.residuals.round(3) + 0.0}")
