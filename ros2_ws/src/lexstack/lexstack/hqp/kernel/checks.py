"""What is looked at before chi is sent."""

from __future__ import annotations

from lexstack.compiled import entry
from lexstack.types import Vector

_GIVEN = "Array(float64, 1, 'A', readonly=True)"


@entry(f"boolean({_GIVEN}, {_GIVEN}, {_GIVEN}, float64, float64[::1])")
def clip(chi: Vector, lower: Vector, upper: Vector, tolerance: float, inside: Vector) -> bool:
    """Set chi put into a box; return whether all of it was there, never so for a NaN.

    Args:
        chi: shape (n,).
        lower: shape (n,).
        upper: shape (n,).
        tolerance: how far outside is still inside.
        inside: the nearest point of the box, shape (n,).
    """
    if not chi.size == lower.size == upper.size == inside.size:
        raise ValueError("clip: the arrays do not fit each other")
    fits = True
    for j in range(chi.size):
        value = chi[j]
        if not (lower[j] - value <= tolerance and value - upper[j] <= tolerance):
            fits = False
        value = value if value >= lower[j] else lower[j]
        inside[j] = value if value <= upper[j] else upper[j]
    return fits
