"""A program as a user types it, for the type checker alone: see test_front_door.py."""

import numpy as np
import pinocchio as pin

import lexstack as lx

q, pose = np.zeros(6), pin.SE3.Identity()
robot = lx.Robot.from_urdf("my_arm.urdf", base="fixed")
tool = lx.FramePose("tool0", gain=3.0, mask=(True, True, True, False, False, False))
stack = lx.Stack([[tool], [lx.VelocityDamping()]])
tool.set_target(pose)
tool.set_target((np.zeros(3), [0.0, 0.0, 0.0, 1.0]))
tool.set_target(lx.timed_waypoints([lx.Pose(np.zeros(3), np.eye(3))] * 2, [0.0, 1.0]))
lx.FramePosition("tool0").set_target([0.1, 0.2, 0.3])
lx.BasePose().set_target([0.1, 0.2, 0.3])
v: lx.Vector = lx.solve_hqp(robot.configuration(q), stack, dt=0.01).velocity
run = lx.Lockstep(robot, stack, dt=0.01)
run.switch(lx.Stack([[tool], [lx.Posture(q)]]), duration=1.0)
run.switch(stack.inserted(1, tool).limited({"robot": {"elbow": {"velocity": 0.2}}}))
own = lx.OwnTask("up", lambda at: (at.frame("tool0").jacobian[2:3], np.zeros(1)))
goals = [lx.track("tool0", pose), lx.track_base([1, 0])]
plan: lx.Plan = lx.Htmpc(robot).solve(robot.configuration(q), goals)
wrong = lx.FramePose("tool0", gian=3.0)  # type: ignore[call-arg]  # must be seen
