"""A trajectory of your own: a figure of eight, tracked to micrometres, also through a switch.

A trajectory is any object with ``at``, ``rate`` and ``end``. Its velocity is added to what the
task asks for; as a set-point at every tick the hand would be centimetres behind.
"""

import numpy as np

import lexstack as lx


class Eight:
    """0.3 by 0.2 m in the plane x, y, once in 8 s, from the pose at time 0."""

    end = np.inf

    def __init__(self, start):
        self.start = start

    def at(self, time):
        w = 2.0 * np.pi / 8.0
        way = [0.1 * np.sin(2 * w * time), 0.15 * np.sin(w * time), 0.0]  # m
        return lx.Pose(self.start.position + way, self.start.rotation)

    def rate(self, time):
        w = 2.0 * np.pi / 8.0
        return np.array([0.2 * w * np.cos(2 * w * time), 0.15 * w * np.cos(w * time), 0, 0, 0, 0])


home = {"shoulder_lift_joint": -1.0, "elbow_joint": 1.5, "wrist_2_joint": 1.0}  # rad
robot = lx.Robot.from_urdf("ur_description/urdf/ur10_robot.urdf", base="holonomic", home=home)
tool = lx.FramePose("tool0")
run = lx.Lockstep(robot, lx.Stack([[tool], [lx.VelocityDamping()]]), dt=0.01)
eight = Eight(run.configuration.frame("tool0").pose)
tool.set_target(eight)
run.until(6.0)
run.switch(lx.Stack([[tool], [lx.BasePose()], [lx.Posture()]]), duration=2.0)
run.until(12.0)
error = run.record().path("tool0") - [eight.at(t).position for t in run.record().time]
print(f"off the path by at most {1e6 * np.abs(error[300:]).max():.1f} um after 3 s")
