"""a b + c with one rounding, as the libraries of linear algebra add up products.

numpy's ``dot`` of small matrices is such a chain on every x86 processor since 2013. Written out,
it has the same bits, and on all other processors too.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numba
from numba import types
from numba.extending import intrinsic


def _exact(a: float, b: float, c: float) -> float:
    """Return a b + c with one rounding, of finite numbers; for loops that run as Python."""
    return float(Fraction(float(a)) * Fraction(float(b)) + Fraction(float(c)))


def _instruction(_typing: Any, _a: Any, _b: Any, _c: Any) -> Any:
    """Return what numba puts in place of a call."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.fma(*arguments)

    number = types.float64
    return number(number, number, number), generate


_config: Any = numba.config
fused: Any = _exact if _config.DISABLE_JIT else intrinsic(_instruction)
