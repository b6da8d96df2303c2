"""An obstacle swings through the workspace: distance first, then the place of the hand.

Distances are kept between spheres on the robot's links and spheres in its way. The hand gives way,
and is back where it belongs as soon as it may.
"""

import numpy as np

import lexstack as lx

links = {"panda_link4": 0.10, "panda_link5": 0.10, "panda_link6": 0.09, "panda_hand": 0.09}  # m
robot = lx.Robot.from_urdf(
    "panda_description/urdf/panda.urdf",
    tool="panda_hand",
    fixed={"panda_finger_joint1": 0.0, "panda_finger_joint2": 0.0},
    home=[0.0, -0.79, 0.0, -2.36, 0.0, 1.57, 0.79],  # rad
    spheres=[{"link": link, "xyz": [0, 0, 0], "radius": r} for link, r in links.items()],
)
ball = lx.ObstacleConfig((0.45, 0.6, 0.6), radius=0.1, swing=(0.0, -0.6, 0.0), period=6.0)
apart = lx.CollisionAvoidance(margin=0.05, influence=0.3)
hand = lx.FramePosition("panda_hand")
stack = lx.Stack([[apart], [hand], [lx.Posture()]])
run = lx.Lockstep(robot, stack, dt=0.01, obstacles={"ball": ball})
run.until(6.0)

record = run.record()
swing = 0.5 - 0.5 * np.cos(2.0 * np.pi * record.time / 6.0)
ball_path = np.array(ball.position) + swing[:, None] * ball.swing
path = record.path("panda_hand")
room = np.linalg.norm(path - ball_path, axis=1) - 0.1 - links["panda_hand"]
print(f"the hand gave way by {np.linalg.norm(path - path[0], axis=1).max():.2f} m")
print(f"nearest to the ball: {room.min():.3f} m; asked for: 0.05 m")
print(f"it is back within {1e3 * np.linalg.norm(path[-1] - path[0]):.1f} mm")
