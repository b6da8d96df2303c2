"""Strict hierarchies in rational numbers: nothing rounds, nothing is judged to be zero.

Every level is a convex quadratic program in integers, solved as a linear complementarity problem
by Lemke's method with the lexicographic rule, which cannot cycle. It shares neither method nor
arithmetic with the solvers, and is for problems of a few joints and rows.
"""

from fractions import Fraction
from math import inf, lcm

import numpy as np


def exact_optimum(problem):
    """Return the optimum chi of a hierarchy, as fractions: floats are taken for what they are."""
    lower, upper = problem.bounds.lower.tolist(), problem.bounds.upper.tolist()
    n = len(lower)
    held, walls = _Equations(n), []
    levels = [[row for task in level for row in _rows(task)] for level in problem.levels]
    unit = [[Fraction(int(i == j)) for j in range(n)] for i in range(n)]
    chi = [Fraction(0)] * n
    for level in [*levels, [(row, Fraction(0), Fraction(0)) for row in unit]]:
        chi = _level(level, held.rows, walls, (lower, upper))
        for row, low, high in level:
            value = _dot(row, chi)
            if low == high or not low <= value <= high:
                held.add(row, value)
            else:
                walls.append((row, low, high))
    return chi


def exact_slacks(problem, chi):
    """Return the norm of each level's residual at a chi in fractions, rounded only at the end."""
    slacks = []
    for level in problem.levels:
        square = Fraction(0)
        for row, low, high in (row for task in level for row in _rows(task)):
            value = _dot(row, chi)
            square += max(low - value, value - high, Fraction(0)) ** 2
        slacks.append(_root(square))
    return np.array(slacks)


def _root(square):
    """Return the square root of a fraction that may be too small or too large for a double."""
    if not square:
        return 0.0
    power = (square.numerator.bit_length() - square.denominator.bit_length()) // 2
    return float(square / Fraction(4) ** power) ** 0.5 * 2.0**power


def _rows(task):
    """Return the rows of a task, with ends that may be infinite."""
    for row, low, high in zip(
        task.matrix.tolist(), task.lower.tolist(), task.upper.tolist(), strict=True
    ):
        yield [Fraction(x) for x in row], _end(low), _end(high)


def _end(value):
    return value if abs(value) == inf else Fraction(value)


def _dot(row, chi):
    return sum((a * x for a, x in zip(row, chi, strict=True) if a), Fraction(0))


class _Equations:
    """Equations that do not depend on each other."""

    def __init__(self, n):
        self.rows = []
        self._reduced = []
        self._n = n

    def add(self, row, value):
        """Add ``row chi = value``, if it does not follow from those that are there."""
        left = list(row)
        for pivot, other in self._reduced:
            if left[pivot]:
                factor = left[pivot] / other[pivot]
                left = [a - factor * b for a, b in zip(left, other, strict=True)]
        pivot = next((j for j in range(self._n) if left[j]), None)
        if pivot is not None:
            self._reduced.append((pivot, left))
            self.rows.append((row, value))


def _level(level, equations, walls, box):
    """Return a chi that is optimal for a level within equations, walls and the box.

    The variables of the program are not negative: the way of each joint from one of its bounds, or
    up and down from zero; and the distance of each inequality row to each of its ends.
    """
    offset, columns = _coordinates(*box)
    objective, constraints = [], []
    for row, low, high in level:
        place, constant = _placed(row, offset, columns)
        if low == high:
            objective.append((place, low - constant))
        else:
            constraints += _sides(place, low, high, constant)
    distances = len(constraints)
    for k, (place, _) in enumerate(constraints):
        place += [Fraction(int(k == own)) for own in range(distances)]
    for row, value in equations:
        place, constant = _placed(row, offset, columns)
        constraints += _sides(place, value, value, constant)
    for row, low, high in [*walls, *_box_rows(box)]:
        place, constant = _placed(row, offset, columns)
        constraints += _sides(place, low, high, constant)
    total = len(columns) + distances
    padded = [(row + [Fraction(0)] * (total - len(row)), end) for row, end in constraints]
    z = _quadratic(*_squares(objective, len(columns), distances), padded)
    chi = list(offset)
    for (joint, sign), value in zip(columns, z, strict=False):
        chi[joint] += sign * value
    return chi


def _sides(place, low, high, constant):
    """Return ``row z >= end`` for each end of a row that is finite."""
    return [
        ([sign * a for a in place], sign * (end - constant))
        for sign, end in ((1, low), (-1, high))
        if abs(end) != inf
    ]


def _squares(objective, width, distances):
    """Return H and g of half the sum of the squares of residuals and distances."""
    total = width + distances
    hessian = [[Fraction(int(i == j and i >= width)) for j in range(total)] for i in range(total)]
    gradient = [Fraction(0)] * total
    for row, target in objective:
        for i in (i for i in range(width) if row[i]):
            gradient[i] -= row[i] * target
            for j in range(width):
                hessian[i][j] += row[i] * row[j]
    return hessian, gradient


def _coordinates(lower, upper):
    """Return where the joints begin, and which joint each variable moves, up or down."""
    offset, columns = [], []
    for joint, (low, high) in enumerate(zip(lower, upper, strict=True)):
        if low != -inf:
            offset.append(Fraction(low))
            columns.append((joint, 1))
        elif high != inf:
            offset.append(Fraction(high))
            columns.append((joint, -1))
        else:
            offset.append(Fraction(0))
            columns += [(joint, 1), (joint, -1)]
    return offset, columns


def _placed(row, offset, columns):
    """Return a row of chi as a row of the variables, and its value where they are zero."""
    return [sign * row[joint] for joint, sign in columns], _dot(row, offset)


def _box_rows(box):
    """Return the ends of the box that the choice of the variables does not keep."""
    lower, upper = box
    n = len(lower)
    for joint in range(n):
        if lower[joint] != -inf and upper[joint] != inf:
            yield [Fraction(int(i == joint)) for i in range(n)], -inf, Fraction(upper[joint])


def _quadratic(hessian, gradient, constraints):
    """Return z >= 0 that minimises z'Hz/2 + g'z with ``row z >= end`` for all constraints."""
    n, m = len(gradient), len(constraints)
    matrix = [hessian[i] + [-row[i] for row, _ in constraints] for i in range(n)]
    matrix += [row + [Fraction(0)] * m for row, _ in constraints]
    return _lemke(matrix, [*gradient, *(-end for _, end in constraints)])[:n]


def _lemke(matrix, q):
    """Return z >= 0 with w = M z + q >= 0 and w'z = 0.

    The table [w, z, z0, q] holds integers over a common denominator, the last pivot.
    """
    size = len(q)
    if min(q, default=0) >= 0:
        return [Fraction(0)] * size
    table = np.zeros((size, 2 * size + 2), dtype=object)
    for i in range(size):
        scale = lcm(*(x.denominator for x in [*matrix[i], q[i]]))
        row = [int(x * scale) for x in [*matrix[i], q[i]]]
        table[i, i] = 1
        table[i, size : 2 * size] = [-x for x in row[:-1]]
        table[i, 2 * size :] = [-1, row[-1]]
    basis, denominator = list(range(size)), 1
    # The first pivot makes all of q positive; of equal ones the lexicographically least.
    first = min(range(size), key=lambda i: (table[i, -1], tuple(table[i, :size])))
    entering, row = 2 * size, first
    while True:
        pivot = table[row, entering]
        other = table[row].copy()
        column = table[:, entering].copy()
        sign = 1 if pivot > 0 else -1
        changed = (table * (sign * pivot) - np.outer(sign * column, other)) // denominator
        changed[row] = sign * other
        table, denominator = changed, sign * pivot
        leaving, basis[row] = basis[row], entering
        if leaving == 2 * size:
            break
        entering = leaving + size if leaving < size else leaving - size
        row = _leaving(table, entering, size)
    z = [Fraction(0)] * size
    for i, variable in enumerate(basis):
        if size <= variable < 2 * size:
            z[variable - size] = Fraction(int(table[i, -1]), int(denominator))
    return z


def _leaving(table, entering, size):
    """Return the row with the lexicographically least ratio."""
    rows = [i for i in range(size) if table[i, entering] > 0]
    if not rows:
        raise ArithmeticError("the levels above have no feasible point: a fault of this module")
    for column in [2 * size + 1, *range(size)]:
        best = min(Fraction(int(table[i, column]), int(table[i, entering])) for i in rows)
        rows = [i for i in rows if table[i, column] == best * table[i, entering]]
        if len(rows) == 1:
            break
    return rows[0]
