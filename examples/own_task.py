"""A task of your own: the tool keeps a height, and everything else is left to the levels below."""

import numpy as np

import lexstack


class Height:
    """The tool's z goes to a height [m] with a gain of 2 / s: one row of its Jacobian."""

    name, robots = "robot/height", (0,)

    def __init__(self, team: lexstack.Team, height: float) -> None:
        """Make the task of the team's first robot."""
        self.joints, self.n, self.height = team.slices[0], team.n, height

    def linearise(
        self, kinematics: lexstack.Kinematics, _references: lexstack.References
    ) -> lexstack.LinearTask:
        """Return the row at the present state."""
        row = np.zeros((1, self.n))
        row[0, self.joints] = kinematics.jacobians[0][2]
        error = self.height - kinematics.tools[0].position[2]
        return lexstack.LinearTask.equality(self.name, row, np.array([2.0 * error]))


home = (0.0, -1.0, 1.5, -0.5, 1.0, 0.0)  # rad
ur10 = lexstack.mobile_manipulator("ur_description/urdf/ur10_robot.urdf", "tool0", home)
team = lexstack.Team((lexstack.RobotModel("robot", ur10),), dt=0.01)
posture = lexstack.TASKS["posture"](team, 0, {}, "posture")
levels = tuple(lexstack.Level((task,), (1.0,)) for task in (Height(team, 1.2), posture))
stacks = {"raised": lexstack.tasks.Stack("raised", levels)}
options = lexstack.TransitionOptions("raised", lexstack.TransitionConfig(duration=1.0))
controller = lexstack.make_controller(team, stacks, options)

state = lexstack.RobotState.at_rest(team.home())
for _ in range(400):
    state = state.after(controller.tick(state).chi, team.dt)
print(f"the tool is at a height of {team.tools(state.q)[0].position[2]:.3f} m")
