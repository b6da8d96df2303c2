"""A task of your own is a function: from the configuration to a Jacobian and what it shall do.

The tool keeps a height, J_z v = 2/s (height - z), and everything else is left to the levels below:
there a second function drives the tool round in a circle.
"""

import numpy as np

import lexstack as lx

home = {"shoulder_lift_joint": -1.0, "elbow_joint": 1.5, "wrist_2_joint": 1.0}  # rad
robot = lx.Robot.from_urdf("ur_description/urdf/ur10_robot.urdf", home=home)


def height(at):
    """Return one row: the tool's z goes to 0.4 m."""
    pose, jacobian = at.frame("tool0")
    return jacobian[2:3], 2.0 * (0.4 - pose.position[2:3])


def circle(at):
    """Return two rows: the tool's x and y follow a circle, whose velocity is added."""
    pose, jacobian = at.frame("tool0")
    cos, sin = 0.1 * np.cos(at.time), 0.1 * np.sin(at.time)  # m
    goal, velocity = centre + [cos, sin], np.array([-sin, cos])
    return jacobian[:2], velocity + 3.0 * (goal - pose.position[:2])


centre = robot.configuration(robot.home).frame("tool0").pose.position[:2]
levels = [lx.OwnTask("height", height), lx.OwnTask("circle", circle), lx.Posture()]
run = lx.Lockstep(robot, lx.Stack(levels), dt=0.01)
run.until(10.0)
path = run.record().path("tool0")
print(f"the tool is at a height of {path[-1, 2]:.3f} m")
print(f"the circle's radius is {np.linalg.norm(path[-1, :2] - centre):.3f} m")
