"""Two arms carry a box: first they hold it, then it is lifted and turned, then the arms rest.

``RelativePose`` keeps the second hand where the box's other end is, whatever the first one does.
"""

import numpy as np

import lexstack as lx

fixed = {"panda_finger_joint1": 0.0, "panda_finger_joint2": 0.0}
home = [0.0, -0.79, 0.0, -2.36, 0.0, 1.57, 0.79]  # rad
left, right = (
    lx.Robot.from_urdf(
        "panda_description/urdf/panda.urdf", name=name, tool="panda_hand", fixed=fixed, home=home,
        place=(0.0, y, 0.0, 0.0),
    )
    for name, y in (("left", 0.3), ("right", -0.3))
)  # fmt: skip
hold = lx.RelativePose("right", robot="left")
box = lx.FramePose("panda_hand", robot="left")
run = lx.Lockstep([left, right], lx.Stack([[hold], [box], [lx.Posture()]]), dt=0.01)

start = run.configuration.frame("panda_hand", "left").pose
turn = np.array([[np.cos(0.3), -np.sin(0.3), 0], [np.sin(0.3), np.cos(0.3), 0], [0, 0, 1]])
box.set_target((start.position + [0.05, 0.0, 0.15], turn @ start.rotation))
run.until(5.0)

record = run.record()
hands = [record.path("panda_hand", name) for name in ("left", "right")]
apart = np.linalg.norm(hands[0] - hands[1], axis=1)
print(f"the left hand rose by {hands[0][-1, 2] - hands[0][0, 2]:.3f} m")
print(f"the hands stayed {apart.mean():.3f} m apart, to {1e3 * np.ptp(apart):.2f} mm")
