"""Teleoperation: a stream of twists moves the hand, and it comes to rest where the stream breaks.

The velocity of a stream is followed exactly, within the joints' limits. A twist that is not
renewed within its ``timeout`` fades to zero by itself.
"""

import numpy as np

import lexstack as lx

robot = lx.Robot.from_urdf(
    "panda_description/urdf/panda.urdf",
    tool="panda_hand",
    fixed={"panda_finger_joint1": 0.0, "panda_finger_joint2": 0.0},
    home=[0.0, -0.79, 0.0, -2.36, 0.0, 1.57, 0.79],  # rad
)
hand = lx.FramePose("panda_hand")
run = lx.Lockstep(robot, lx.Stack([[hand], [lx.Posture()]]), dt=0.01)

for tick in range(300):
    angle = 2.0 * np.pi * run.time / 3.0
    if tick < 225:  # then the radio is lost
        joystick = [0.15 * np.cos(angle), 0.15 * np.sin(angle), 0.0, 0.0, 0.0, 0.0]  # m/s, rad/s
        hand.set_target(lx.Twist(joystick, timeout=0.2))
    run.step()

record = run.record()
speed = np.linalg.norm(np.diff(record.path("panda_hand"), axis=0), axis=1) / 0.01
print(f"at 2 s the hand moves at {speed[200]:.3f} m/s")
print(f"the last twist came at 2.24 s; at 3 s it moves at {speed[-1]:.3f} m/s")
