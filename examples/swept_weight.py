"""What a weight can do, and what only a level can: a hand's place against an arm's posture.

In one level the two are weighed: the larger the weight of the posture, the farther the hand ends
from its target. In two levels the hand is where it belongs, and the posture gets all the rest.
"""

import numpy as np

import lexstack as lx

robot = lx.Robot.from_urdf(
    "panda_description/urdf/panda.urdf",
    tool="panda_hand",
    fixed={"panda_finger_joint1": 0.0, "panda_finger_joint2": 0.0},
    home=[0.0, -0.79, 0.0, -2.36, 0.0, 1.57, 0.79],  # rad
)
hand = lx.FramePosition("panda_hand")
hand.set_target(robot.configuration(robot.home).frame("panda_hand").pose.position + [0, 0.3, -0.2])


def ended(stack):
    """Return how far the hand and the posture are from their targets after 10 s, m and rad."""
    run = lx.Lockstep(robot, stack, dt=0.01)
    run.until(10.0)
    place = run.configuration.frame("panda_hand").pose.position
    return np.linalg.norm(place - hand.goal.position), np.linalg.norm(run.state.q - robot.home)


rows = []
for weight in (0.001, 0.01, 0.1, 1.0, 10.0):
    rows.append((weight, *ended(lx.Stack([[hand, lx.Posture(robot.home, weight=weight)]]))))
    print("weight {:6g}: hand {:.4f} m, posture {:.3f} rad off".format(*rows[-1]))
strict = ended(lx.Stack([[hand], [lx.Posture(robot.home)]]))
print("two levels:    hand {:.4f} m, posture {:.3f} rad off".format(*strict))
