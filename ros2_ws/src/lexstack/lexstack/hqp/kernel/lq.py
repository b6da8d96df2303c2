"""All levels in one orthogonal factorisation, A_F Q = L, in plain loops.

A_F are the active rows of the deciding levels on the free joints. The rows of a level are taken in
the order of their length in the directions that are left (row pivoting), and each is turned into
one new direction by a Householder reflection from the right. A row of level k then has entries in
the directions of the levels above, and in at most as many new ones as the level has independent
rows: the trapezoid L_k, of shape (m_k, r_k). What no level uses is never formed.

    Q = H_0 H_1 ... H_(p-1),     H_p = I - 2 v v^T / |v|^2,     chi_F = chi_0 + Q [y; 0]

Where m_k > r_k the level is a least-squares problem in y_k alone, solved by L_k = U R.
"""

from __future__ import annotations

import math

from lexstack.compiled import compiled
from lexstack.hqp.kernel.values import RANK, Factors
from lexstack.types import Vector


@compiled
def factorise(at: Factors, k: int, f: int) -> None:
    """Turn the rows of level k into new directions; reflect the rows below along.

    Args:
        at: the levels above are factorised; sets ``used`` of the level below, and what it leads to.
        k: the level.
        f: number of free joints.
    """
    work, begin, used = at.work, at.first[k], at.used[k]
    end, count = at.first[k + 1], at.first[at.first.size - 1]
    tolerance = RANK * at.norms[k]
    rank = 0
    for i in range(begin, end):
        p = used + rank
        best, longest = i, -1.0
        for a in range(i, end):
            square = 0.0
            for c in range(p, f):
                square += work[a, c] * work[a, c]
            if square > longest:
                best, longest = a, square
        length = math.sqrt(longest)
        if not length > tolerance:
            break
        if best != i:
            for c in range(f):
                work[i, c], work[best, c] = work[best, c], work[i, c]
            at.order[i], at.order[best] = at.order[best], at.order[i]
        beta = -length if work[i, p] > 0.0 else length
        head = work[i, p] - beta
        at.heads[p], at.diag[p], at.makers[p] = head, beta, i
        factor = 1.0 / (beta * head)  # -2 / |v|^2, with v = (head, the rest of the row)
        for a in range(i + 1, count):
            dot = work[a, p] * head
            for c in range(p + 1, f):
                dot += work[a, c] * work[i, c]
            dot *= factor
            work[a, p] += dot * head
            for c in range(p + 1, f):
                work[a, c] += dot * work[i, c]
        rank += 1
    at.used[k + 1] = used + rank
    if end - begin > rank:
        orthogonalise(at, k, rank)


@compiled
def orthogonalise(at: Factors, k: int, rank: int) -> None:
    """Write L_k = U R of a level with dependent rows: Gram-Schmidt, each column cleaned twice."""
    begin, end, used = at.first[k], at.first[k + 1], at.used[k]
    basis, triangle = at.basis, at.triangle
    for c in range(rank):
        for i in range(begin, end):
            p = i - begin
            basis[i, c] = 0.0 if p < c else at.diag[used + c] if p == c else at.work[i, used + c]
        for d in range(c):
            triangle[begin + d, c] = 0.0
        for _ in range(2):
            for d in range(c):
                dot = 0.0
                for i in range(begin, end):
                    dot += basis[i, d] * basis[i, c]
                triangle[begin + d, c] += dot
                for i in range(begin, end):
                    basis[i, c] -= dot * basis[i, d]
        square = 0.0
        for i in range(begin, end):
            square += basis[i, c] * basis[i, c]
        triangle[begin + c, c] = math.sqrt(square)
        for i in range(begin, end):
            basis[i, c] /= triangle[begin + c, c]


@compiled
def settle(at: Factors, k: int) -> None:
    """Set y of level k to its least-squares point.

    Args:
        at: y of the levels above is known; ``rest`` of the level is b - A chi_0, and afterwards
            A chi - b, zero where the level is met.
        k: the level.
    """
    begin, end, used = at.first[k], at.first[k + 1], at.used[k]
    rank = at.used[k + 1] - used
    work, rest, y = at.work, at.rest, at.y
    for i in range(begin, end):
        for c in range(used):
            rest[i] -= work[i, c] * y[c]
    if end - begin == rank:
        for i in range(rank):
            total = rest[begin + i]
            for c in range(i):
                total -= work[begin + i, used + c] * y[used + c]
            y[used + i] = total / at.diag[used + i]
            rest[begin + i] = 0.0
        return
    for c in range(rank):
        y[used + c] = 0.0
    for _ in range(2):  # what U reaches of the rest; the second time what rounding left of it
        for c in range(rank):
            dot = 0.0
            for i in range(begin, end):
                dot += at.basis[i, c] * rest[i]
            y[used + c] += dot
            for i in range(begin, end):
                rest[i] -= dot * at.basis[i, c]
    for i in range(begin, end):
        rest[i] = -rest[i]
    for c in range(rank - 1, -1, -1):
        total = y[used + c]
        for d in range(c + 1, rank):
            total -= at.triangle[begin + c, d] * y[used + d]
        y[used + c] = total / at.triangle[begin + c, c]


@compiled
def multipliers(at: Factors, k: int, gradient: Vector, force: Vector) -> None:
    """Set the multipliers of level k that balance a gradient, and take their part off it.

    L_k^T lambda = c, with c the gradient in the level's own directions; where rows depend the
    shortest lambda, U R^-T c.

    Args:
        at: all levels are factorised.
        k: the level.
        gradient: by direction, shape (n,); changed in place.
        force: lambda of the rows of ``work``, shape (m,); written at those of the level.
    """
    begin, end, used = at.first[k], at.first[k + 1], at.used[k]
    rank = at.used[k + 1] - used
    if end - begin == rank:
        for i in range(rank - 1, -1, -1):
            total = gradient[used + i]
            for a in range(i + 1, rank):
                total -= at.work[begin + a, used + i] * force[begin + a]
            force[begin + i] = total / at.diag[used + i]
    else:
        for i in range(begin, end):
            force[i] = 0.0
        for c in range(rank):
            total = gradient[used + c]
            for d in range(c):
                total -= at.triangle[begin + d, c] * gradient[used + d]
            total /= at.triangle[begin + c, c]
            gradient[used + c] = total
            for i in range(begin, end):
                force[i] += total * at.basis[i, c]
    for i in range(begin, end):
        for c in range(used):
            gradient[c] -= at.work[i, c] * force[i]


@compiled
def turned_back(at: Factors, z: Vector) -> None:
    """Replace z = [y; 0] by Q z, shape (f,), in place: the reflections in reverse."""
    for p in range(at.used[at.used.size - 1] - 1, -1, -1):
        i, head = at.makers[p], at.heads[p]
        dot = z[p] * head
        for c in range(p + 1, z.size):
            dot += z[c] * at.work[i, c]
        dot /= at.diag[p] * head
        z[p] += dot * head
        for c in range(p + 1, z.size):
            z[c] += dot * at.work[i, c]
