"""The costs of the MPC at all stages in one call: ``evaluation`` values, ``curvature`` derivatives.

``chain`` has the kinematics, ``barriers`` what keeps off limits and things, ``errors`` the tasks,
``condensing`` the step from states to inputs, ``values`` the arrays. The same equations in numpy
are in ``barriers.py``, ``effort.py``, ``collision_cost.py``, ``measures.py``, ``level_problem.py``.
"""
