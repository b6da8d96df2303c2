"""Peers whose packages are not ours: they run in a Python that has them, given by ``--peers``."""

from __future__ import annotations

import subprocess
from pathlib import Path

from lexstack_experiments.benches.child import Child

_HOW = (
    "Not in the tables: {name} ({why}). To have it: python -m venv V; V/bin/pip install {pip}; "
    "--peers V/bin/python."
)

MISSING = {
    "placo": _HOW.format(name="placo", why="it needs another pinocchio", pip="placo"),
    "crocoddyl": _HOW.format(name="crocoddyl", why="not in the lock", pip="'pin==4.1.*' crocoddyl"),
    "acados": _HOW.format(
        name="acados",
        why="its wheel's CasADi is to be replaced, and it needs a C compiler",
        pip="comma-deps-acados scipy; V/bin/pip install --force-reinstall 'casadi==3.8.*'",
    ),
}
"""What a bench says where a peer is not to be had."""


def child_with(module: str, program: str, pythons: tuple[Path, ...]) -> Child | None:
    """Return a worker in the first Python that can import a module, None if none can."""
    for python in pythons:
        done = subprocess.run(
            [str(python), "-c", f"import {module}"], capture_output=True, check=False, env={}
        )
        if done.returncode == 0:
            return Child(program, python)
    return None
