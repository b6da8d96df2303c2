"""Strict priorities between linear tasks: a lower level uses the freedom that those above leave.

Three velocities in a box. Level 1 wants x + y = 1; level 2 wants x = 2, which the box forbids;
level 3 wants everything at zero, as far as the levels above let it.
"""

import numpy as np

import lexstack

level_1 = lexstack.LinearTask.equality("sum", np.array([[1.0, 1.0, 0.0]]), np.array([1.0]))
level_2 = lexstack.LinearTask.equality("x", np.array([[1.0, 0.0, 0.0]]), np.array([2.0]))
level_3 = lexstack.LinearTask.equality("rest", np.eye(3), np.zeros(3))
box = lexstack.Bounds(np.full(3, -0.5), np.full(3, 1.2))

problem = lexstack.HqpProblem(((level_1,), (level_2,), (level_3,)), box)
solution = lexstack.make_solver().solve(problem)

print("chi:", solution.chi.round(6) + 0.0)
print("norm of each level's residual:", solution.slacks.round(6))
for level in lexstack.explain_unmet_levels(problem, solution):
    print(lexstack.describe([level], ("x", "y", "z")))
