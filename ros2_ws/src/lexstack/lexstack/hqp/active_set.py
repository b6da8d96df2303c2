"""The whole hierarchy at once, for a guess of which bounds and rows hold.

If the guess is right this is the exact optimum: one chain of least-squares problems, each in the
null space of those above, with the joints of the working set held at their bounds. Whether it is
right is decided by the optimality conditions of the hierarchy (Escande, Mansard and Wieber 2014):
chi is inside the box, and the multiplier of everything held is lexicographically positive, that
is, the highest level that feels it presses against it. A wrong working set is corrected:
what is violated is held, what is pulled away from its bound is released.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lexstack.hqp.bands import settle
from lexstack.hqp.chain import Step, lay_chain
from lexstack.hqp.hierarchy import FEASIBILITY, Hierarchy, Mask, Signs, noise
from lexstack.hqp.judge import Balance, judge
from lexstack.hqp.scaling import Bands
from lexstack.types import Matrix, Vector


@dataclass(slots=True)
class WorkingSet:
    """What is held: joints at their bounds, shape (n,), and inequality rows, shape (M,)."""

    joints: Signs
    rows: Signs

    @classmethod
    def split(cls, hierarchy: Hierarchy, sides: Signs) -> WorkingSet:
        """Return the working set of one vector: first the joints, then all inequality rows."""
        n = hierarchy.matrix.shape[1]
        rows: Signs = np.zeros(hierarchy.lower.size, dtype=np.int8)
        rows[~hierarchy.equal] = sides[n:]
        return cls(sides[:n].copy(), rows)

    def copy(self) -> WorkingSet:
        """Return a working set of its own."""
        return WorkingSet(self.joints.copy(), self.rows.copy())

    def keep_first_change(self, before: WorkingSet) -> None:
        """Take back all changes but the first one: of a joint if there is one, else of a row."""
        first = True
        for own, old in ((self.joints, before.joints), (self.rows, before.rows)):
            changed = np.flatnonzero(own != old)[1 if first else 0 :]
            first = first and not np.count_nonzero(own != old)
            own[changed] = old[changed]


def solve_by_active_set(
    hierarchy: Hierarchy,
    lower: Vector,
    upper: Vector,
    working_set: WorkingSet,
    rounds: int,
    *,
    changes: int | None = None,
    bands: Bands | None = None,
) -> Vector | None:
    """Return the exact optimum chi, shape (n,), or None if no set in ``rounds`` was right.

    Freedom that no level uses is spent on the smallest ``||chi||``. A level that asks for all of
    chi is no step of the chain: every step is the shortest possible, so the chain ends at the
    point that is nearest to its beginning, and it begins at what that level wants.

    Args:
        hierarchy: all levels.
        lower: bounds of chi, shape (n,).
        upper: shape (n,).
        working_set: what probably holds; it is left as the last one tried.
        rounds: the number of working sets to try.
        changes: give up where a working set was wrong in more places; None: never.
        bands: how the levels were divided, if they were.
    """
    fixed = hold_fixed(working_set, lower, upper)
    for left in range(rounds - 1, -1, -1):
        chi, steps = point_of(hierarchy, lower, upper, working_set, bands)
        if not math.isfinite(chi.dot(chi)):
            return None
        held = hold(hierarchy, chi, (lower, upper), working_set, FEASIBILITY)
        if held and left == 0:
            return None
        wrong = held
        if steps is not None:
            wrong += release(hierarchy, steps, chi, working_set, fixed, bands)
        if not wrong:
            return chi
        if changes is not None and wrong > changes:
            return None
    return None


def hold_fixed(working_set: WorkingSet, lower: Vector, upper: Vector) -> Mask | None:
    """Hold the joints that cannot move; return which these are, shape (n,), or None for none."""
    fixed = upper - lower <= FEASIBILITY
    if not np.count_nonzero(fixed):
        return None
    working_set.joints[fixed] = 1
    return fixed


def point_of(
    hierarchy: Hierarchy, lower: Vector, upper: Vector, working_set: WorkingSet, bands: Bands | None
) -> tuple[Vector, list[Step] | None]:
    """Return the optimum with what is held as equations, and the chain to it.

    The optimum is not finite where there is none. The chain is None where nothing is held.
    """
    chi, basis = hierarchy.nearest.copy(), None
    if np.count_nonzero(working_set.joints):
        chi = _on_bounds(working_set.joints, lower, upper, chi)
        basis = _unit(chi.size).compress(working_set.joints == 0, axis=1)
    pressing = basis is not None or bool(np.count_nonzero(working_set.rows))
    if bands is None or not bands.several:
        steps = lay_chain(hierarchy, working_set.rows, basis, chi, pressing)
    else:
        begin = chi.copy()
        steps = lay_chain(hierarchy, working_set.rows, basis, chi, pressing=True)
        if not settle(steps, bands, begin, chi):
            chi[:] = np.nan
    return chi, steps if pressing else None


@lru_cache(maxsize=64)
def _unit(n: int) -> Matrix:
    """Return the unit matrix, read-only."""
    unit: Matrix = np.eye(n)
    unit.setflags(write=False)
    return unit


def _on_bounds(joints: Signs, lower: Vector, upper: Vector, nearest: Vector) -> Vector:
    """Return chi with the held joints on their bounds; free those that have no such bound."""
    ends = np.where(joints > 0, upper, lower)
    chi = np.where(joints != 0, ends, nearest)
    if not math.isfinite(chi.dot(chi)):
        joints[np.isinf(ends)] = 0
        chi = np.where(joints != 0, ends, nearest)
    return chi


def hold(
    hierarchy: Hierarchy,
    chi: Vector,
    box: tuple[Vector, Vector],
    working_set: WorkingSet,
    inside: float,
) -> int:
    """Hold what chi violates by more than ``inside``; return how much that is."""
    square = chi.dot(chi)
    held = _hold_violated(chi, *box, working_set.joints, inside, square)
    if not hierarchy.exact:
        held += _hold_rows(hierarchy, chi, working_set.rows, inside, square)
    return held


def _hold_rows(hierarchy: Hierarchy, chi: Vector, rows: Signs, inside: float, square: float) -> int:
    """Hold the inequality rows that chi violates; return how many there were."""
    end = hierarchy.deciding[-1].rows.stop if hierarchy.deciding else 0
    if end == 0:
        return 0
    lower, upper = hierarchy.lower[:end], hierarchy.upper[:end]
    value = np.where(hierarchy.equal[:end], lower, hierarchy.matrix[:end].dot(chi))
    return _hold_violated(value, lower, upper, rows[:end], inside, square)


def _hold_violated(
    value: Vector, lower: Vector, upper: Vector, sides: Signs, inside: float, square: float
) -> int:
    """Set the side of every value that is outside and free; return how many there were.

    What counts as outside is more than ``inside``, and more than the rounding of a chi whose
    squared length is ``square``.
    """
    above = value - upper
    below = lower - value
    outside = np.maximum(above, below)
    if outside[outside.argmax()] <= inside:  # four times as fast as max()
        return 0
    violated = (outside > max(inside, noise(math.sqrt(square)))) & (sides == 0)
    sides[violated] = np.where(above > below, 1, -1)[violated]
    return int(np.count_nonzero(violated))


def release(
    hierarchy: Hierarchy,
    steps: list[Step],
    chi: Vector,
    working_set: WorkingSet,
    fixed: Mask | None,
    bands: Bands | None,
) -> int:
    """Release what the highest level with a force on it pulls inside; return how many there were.

    The gradient of each level's objective is balanced by multipliers of the rows above it, and what
    remains acts on the joints that are held:

        mu_k = -(A_k' (A_k chi - b_k) + sum over j above k: A_j' lambda_kj)

    The last of these rows is for the distance to where the chain began, so that a joint which is
    held without need is released even if no level is concerned. All levels are balanced in one
    sweep from the lowest step up: row k of ``gradient`` and of ``forces`` belongs to step k.

    Args:
        hierarchy: all levels.
        steps: of the chain, the highest first.
        chi: the optimum for this working set, shape (n,).
        working_set: what is held; changed in place.
        fixed: joints that cannot move, shape (n,); None: there are none.
        bands: how the levels were divided, if they were.
    """
    count = len(steps)
    # Of ||chi - nearest||^2 / 2: each step moved chi as little as possible, so this gradient has no
    # component in the directions that the last step leaves.
    gradient = np.empty((count + 1, chi.size))
    gradient[count] = chi - hierarchy.nearest
    forces = None if hierarchy.exact else np.zeros((count + 1, working_set.rows.size))
    sweep = []
    # With Z_j the directions that step j leaves, and Z_(-1) those of the free joints, the invariant
    # before step j is balanced is Z_j' g_k = 0 for every row k below it: there, the gradient of a
    # lower level can only lie along the rows of step j and of those above. The multipliers of step
    # j then solve Z_(j-1)' (g_k - A_j' lambda) = 0, up to the rank tolerance. That is why the sweep
    # goes upwards: downwards, the rows of a lower step would undo what a higher one had balanced.
    for j in range(count - 1, -1, -1):
        step = steps[j]
        # A row joins the sweep at its own step: chi is the least-squares point of step j within
        # Z_(j-1), so Z_(j-1)' g_j = 0 holds already, as the invariant of the next pass demands.
        residual = step.rows.dot(chi) - step.target
        gradient[j] = residual.dot(step.rows)
        below = gradient[j + 1 :]
        multipliers = step.factor.solve_transposed(
            below if step.basis is None else below.dot(step.basis)
        )
        below -= multipliers.dot(step.rows)
        sweep.append(multipliers)
        # The rows of a step are pressed by their own level with its residual (beyond the upper end:
        # outward), and by each level below with the opposite of what they give to balance it.
        if forces is not None and step.chosen is not None:
            forces[j, step.chosen] = residual
            forces[j + 1 :, step.chosen] = -multipliers
    # Now Z_(-1)' g_k = 0 for all k: free joints are in balance, and what remains is on held joints.
    # The force is the negative gradient. What cannot move anyway is not judged. In place, because
    # the gradient is not needed any more.
    judged = (
        working_set.joints if fixed is None else np.where(fixed, np.int8(0), working_set.joints)
    )
    balance = Balance(steps, chi, sweep, bands)
    released = judge(working_set.joints, judged, np.negative(gradient, out=gradient), balance)
    # ``judge`` looks at the first force that is not zero, from the highest level down: if it pulls
    # inside, that level improves by the release and no level above it notices.
    if forces is not None:
        released += judge(working_set.rows, working_set.rows, forces, balance)
    return released
