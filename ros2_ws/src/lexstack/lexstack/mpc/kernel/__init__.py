"""The QPs of the MPC by their structure, compiled: see docs/htmpc.md.

``riccati`` has the joints one by one, ``schur`` the rows that couple them, ``interior_point`` and
``active_set`` the two methods, ``solver`` what Python calls. ``python -m lexstack.compiled``
compiles it, as the set-up does.
"""
