"""Relaxed barriers of limits and distances at one stage: B(z) of ``lexstack.mpc.barriers``.

Logarithms are the dearest part of a cost, so their arguments are multiplied first: one logarithm
takes as many factors as a number can hold.
"""

from __future__ import annotations

import math

from lexstack.compiled import compiled
from lexstack.mpc.stage.kernel.values import Array, Limits, Scene, Stages
from lexstack.types import Matrix, Vector

Sums = tuple[float, float, float]
"""What parabolas sum up to, what logarithms do, and a product whose logarithm is to come."""

_LARGE, _SMALL = 1e100, 1e-100
_CONCENTRIC = 1e-9  # m: below this there is no direction away


@compiled
def take(z: float, zeta: float, sums: Sums) -> Sums:
    """Return sums to which B(z) / mu is added."""
    rest, logarithms, product = sums
    if z > zeta:
        product *= z
        if product > _LARGE or product < _SMALL:
            logarithms += math.log(product)
            product = 1.0
    else:
        below = z / zeta - 2.0
        rest += 0.5 * (below * below - 1.0) - math.log(zeta)
    return rest, logarithms, product


@compiled
def sum_of(sums: Sums) -> float:
    """Return the sum of what was taken."""
    return sums[0] - (sums[1] + math.log(sums[2]))


@compiled
def take_limits(limits: Limits, q: Vector, v: Vector, u: Vector, sums: Sums) -> Sums:
    """Return sums with the barriers of all limits at one stage."""
    zeta, count, n = limits.settings[1], limits.bounded.size, v.size
    first = q.size - n
    lower, upper = limits.lower, limits.upper
    for i in range(count):
        value = q[first + limits.bounded[i]]
        sums = take(upper[i] - value, zeta, sums)
        sums = take(value - lower[i], zeta, sums)
    for j in range(n):
        i = count + j
        sums = take(upper[i] - v[j], zeta, sums)
        sums = take(v[j] - lower[i], zeta, sums)
        sums = take(upper[i + n] - u[j], zeta, sums)
        sums = take(u[j] - lower[i + n], zeta, sums)
    return sums


@compiled
def slope(z: float, mu: float, zeta: float) -> tuple[float, float]:
    """Return B'(z) and B''(z)."""
    inverse = 1.0 / max(z, zeta)
    first = -mu * inverse + (mu / (zeta * zeta)) * min(z - zeta, 0.0)
    return first, mu * inverse * inverse


@compiled
def take_near(room: float, zeta: float, reach: float, sums: Sums) -> Sums:
    """Return sums with B + ln R + z / R - 1, over mu, of a distance below the reach R."""
    if room >= reach:
        return sums
    rest, logarithms, product = take(room, zeta, sums)
    if not math.isinf(reach):
        rest += math.log(reach) + room / reach - 1.0
    return rest, logarithms, product


@compiled
def slope_near(room: float, mu: float, zeta: float, reach: float) -> tuple[float, float]:
    """Return the derivatives of what ``take_near`` adds."""
    if room >= reach:
        return 0.0, 0.0
    first, second = slope(room, mu, zeta)
    return first + mu / reach, second


@compiled
def take_distances(
    scene: Scene, limits: Limits, at: Stages, k: int, first: int, sums: Sums
) -> Sums:
    """Return sums with all distances at stage k; the spheres are the points from ``first``."""
    zeta, reach = limits.settings[3], limits.settings[4]
    for s in range(scene.reach.shape[0]):
        point = at.points[k, first + s]
        for o in range(scene.reach.shape[1]):
            x = point[0] - scene.centers[k, o, 0]
            y = point[1] - scene.centers[k, o, 1]
            z = point[2] - scene.centers[k, o, 2]
            square = x * x + y * y + z * z
            if not beyond(square, scene.reach[s, o] + reach):
                sums = take_near(math.sqrt(square) - scene.reach[s, o], zeta, reach, sums)
    for i in range(scene.lifted.size):
        height = at.points[k, first + scene.lifted[i], 2] - scene.heights[i]
        sums = take_near(height, zeta, reach, sums)
    return sums


@compiled
def beyond(square: float, length: float) -> bool:
    """Return whether a squared distance is certainly above a length: most pairs need no root."""
    return square > 1.000001 * length * length


@compiled
def push(
    scene: Scene, limits: Limits, at: Stages, k: int, first: int, forces: Matrix, stiffness: Array
) -> None:
    """Write gradient and Gauss-Newton Hessian of the distances by the spheres' centres at stage k.

    Args:
        scene: what is around.
        limits: with the barrier's settings.
        at: where the points are.
        k: the stage.
        first: the point that is the first sphere.
        forces: shape (s, 3).
        stiffness: shape (s, 3, 3); zero where nothing is near.
    """
    mu, zeta, reach = limits.settings[2], limits.settings[3], limits.settings[4]
    forces[:] = 0.0
    stiffness[:] = 0.0
    for s in range(scene.reach.shape[0]):
        point = at.points[k, first + s]
        for o in range(scene.reach.shape[1]):
            x = point[0] - scene.centers[k, o, 0]
            y = point[1] - scene.centers[k, o, 1]
            z = point[2] - scene.centers[k, o, 2]
            square = x * x + y * y + z * z
            if beyond(square, scene.reach[s, o] + reach):
                continue
            distance = math.sqrt(square)
            slant, bend = slope_near(distance - scene.reach[s, o], mu, zeta, reach)
            if bend == 0.0:
                continue
            # In its centre there is no direction: with zero the pair pushes nowhere, but costs.
            inverse = 1.0 / max(distance, _CONCENTRIC)
            x, y, z = x * inverse, y * inverse, z * inverse
            forces[s, 0] += slant * x
            forces[s, 1] += slant * y
            forces[s, 2] += slant * z
            stiffness[s, 0, 0] += bend * x * x
            stiffness[s, 0, 1] += bend * x * y
            stiffness[s, 0, 2] += bend * x * z
            stiffness[s, 1, 1] += bend * y * y
            stiffness[s, 1, 2] += bend * y * z
            stiffness[s, 2, 2] += bend * z * z
    for i in range(scene.lifted.size):
        s = scene.lifted[i]
        height = at.points[k, first + s, 2] - scene.heights[i]
        slant, bend = slope_near(height, mu, zeta, reach)
        forces[s, 2] += slant
        stiffness[s, 2, 2] += bend
    for s in range(scene.reach.shape[0]):
        stiffness[s, 1, 0] = stiffness[s, 0, 1]
        stiffness[s, 2, 0] = stiffness[s, 0, 2]
        stiffness[s, 2, 1] = stiffness[s, 1, 2]
