"""Compiled parts of scipy, without the packages around them: LAPACK, BLAS, and NNLS.

``scipy.linalg`` takes 0.2 s to import, most of them for modules of numpy that only its array-API
support wants; ``scipy.optimize`` takes 0.2 s more. That was a third of the time until a controller
is ready, and in the middle of a run it would be 20 late ticks. The compiled modules need none of
it, and are the very ones that scipy's own functions call.
"""

from __future__ import annotations

import importlib
import sys
from importlib.machinery import PathFinder
from importlib.util import module_from_spec
from pathlib import Path
from types import ModuleType

import numpy as np
import scipy

from lexstack.types import Matrix, Vector

_TOO_MANY = 3  # what scipy's NNLS returns when its steps are used up


def _compiled(package: str, name: str) -> ModuleType:
    """Return a compiled module of scipy, the one of this process."""
    full = f"scipy.{package}.{name}"
    spec = PathFinder.find_spec(full, [str(Path(scipy.__file__).parent / package)])
    if full in sys.modules or spec is None or spec.loader is None:
        return importlib.import_module(full)
    # Under its own name, so that a later import of the package takes this one.
    module = sys.modules[full] = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


lapack = _compiled("linalg", "_flapack")
blas = _compiled("linalg", "_fblas")


def nnls(matrix: Matrix, target: Vector, steps: int) -> Vector:
    """Return the x >= 0 with the least ``||matrix x - target||``, as ``scipy.optimize.nnls`` does.

    Args:
        matrix: shape (m, n).
        target: shape (m,).
        steps: at most.

    Raises:
        RuntimeError: ``steps`` were too few.
    """
    solve = _compiled("optimize", "_slsqplib").nnls
    x, _, outcome = solve(np.ascontiguousarray(matrix, float), np.asarray(target, float), steps)
    if outcome == _TOO_MANY:
        raise RuntimeError(f"NNLS: more than {steps} steps")
    return np.asarray(x)
