"""Deliveries by the lexicographic MPC: a sequence of tasks, two of them worked on at a time.

While the hand finishes a task, the base is on its way to the next one as far as that lets it.
Then the robot goes smoothly back to a stack.
"""

import lexstack as lx

robot = lx.Robot.from_urdf(
    "panda_description/urdf/panda.urdf",
    base="holonomic",
    tool="panda_hand",
    fixed={"panda_finger_joint1": 0.0, "panda_finger_joint2": 0.0},
    home=[0.0, -0.79, 0.0, -2.36, 0.0, 1.57, 0.79],  # rad
)
stack = lx.Stack([[lx.FramePose("panda_hand")], [lx.VelocityDamping()]])
run = lx.Lockstep(robot, stack, dt=0.02)
tasks = (
    lx.track("panda_hand", [0.8, 0.3, 0.9]).task("pick"),  # m
    lx.track_base([1.2, 0.2]).task("drive", tolerance=0.05),
    lx.track("panda_hand", [1.8, -0.3, 1.1]).task("place"),
    lx.track_base([0.0, 0.0]).task("home", tolerance=0.05),
)
run.sequence(tasks, duration=0.5)
done = 0
while run.time < 30.0 and done < len(tasks):
    run.step()
    sequence = run.progress["robot"].sequence
    if sequence.first > done:
        done = sequence.first
        print(f"{run.time:5.2f} s: {tasks[done - 1].name} is done")
run.switch(stack, duration=0.5)
run.until(run.time + 1.0)
