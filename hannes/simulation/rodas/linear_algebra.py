"""The few loops over states that the method consists of; in place, nothing is allocated."""

import math

from hannes.core.kernels.jit import fused, kernel


@kernel
def copy_to(target, row):
    """target = row."""
    for i in range(target.size):
        target[i] = row[i]


@kernel
def total(row):
    """Sum, in order."""
    found = 0.0
    for i in range(row.size):
        found += row[i]
    return found


@kernel
def add_scaled(target, factor, row):
    """target += factor row."""
    if factor == 0.0:
        return
    for i in range(target.size):
        target[i] = fused(factor, row[i], target[i])


@kernel
def combine(target, base, weight, row, scale, factors, stages):
    """target = base + weight row + scale (factors of the first five stages), in one pass."""
    first, second, third = scale * factors[0], scale * factors[1], scale * factors[2]
    fourth, fifth = scale * factors[3], scale * factors[4]
    for i in range(target.size):
        some = fused(first, stages[0, i], fused(weight, row[i], base[i]))
        more = fused(third, stages[2, i], second * stages[1, i])
        more = fused(fifth, stages[4, i], fused(fourth, stages[3, i], more))
        target[i] = some + more


@kernel
def weigh(target, factors, stages):
    """target = factors of the first five stages."""
    first, second, third = factors[0], factors[1], factors[2]
    fourth, fifth = factors[3], factors[4]
    for i in range(target.size):
        some = fused(second, stages[1, i], first * stages[0, i])
        more = fused(fourth, stages[3, i], third * stages[2, i])
        target[i] = fused(fifth, stages[4, i], some + more)


@kernel
def scaled_size(row, first, second, rtol, atol, parts):
    """RMS of row_i / (atol_i + rtol max(|first_i|, |second_i|)); `parts` is room to work, or row.

    Summed in four turns, i = 0, 4, 8, ..., then 1, 5, ... side by side, so that no sum waits.
    """
    for i in range(row.size):
        part = row[i] / (atol[i] + rtol * max(abs(first[i]), abs(second[i])))
        parts[i] = part * part
    sums = (0.0, 0.0, 0.0, 0.0)
    last = row.size - row.size % 4
    for i in range(0, last, 4):
        sums = (
            sums[0] + parts[i],
            sums[1] + parts[i + 1],
            sums[2] + parts[i + 2],
            sums[3] + parts[i + 3],
        )
    total = (sums[0] + sums[1]) + (sums[2] + sums[3])
    for i in range(last, row.size):
        total += parts[i]
    return math.sqrt(total / row.size)


@kernel
def interpolate_piece(x, piece, after, row):
    """Fill row with a step's solution at x in [0, 1]; piece as `keep_piece` leaves it, `after` it.

    Rows of a piece: the solution where it begins, two of curvature.
    """
    left = 1.0 - x
    bend = x * left
    for i in range(row.size):
        line = fused(x, after[0, i], left * piece[0, i])
        row[i] = fused(bend, fused(x, piece[2, i], piece[1, i]), line)


@kernel
def factor(matrix, shift, factors, rows):
    """factors = LU of shift I - matrix with row exchanges, whose order goes into `rows`."""
    n = rows.size
    for i in range(n):
        for j in range(n):
            factors[i, j] = -matrix[i, j]
        factors[i, i] += shift
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(factors[i, k]) > abs(factors[best, k]):
                best = i
        rows[k] = best
        if best != k:
            for j in range(n):
                factors[k, j], factors[best, j] = factors[best, j], factors[k, j]
        for i in range(k + 1, n):
            factors[i, k] /= factors[k, k]
            if factors[i, k] != 0.0:
                for j in range(k + 1, n):
                    factors[i, j] = fused(-factors[i, k], factors[k, j], factors[i, j])


@kernel
def substitute(factors, rows, b):
    """Replace b by the solution of the factored system."""
    n = rows.size
    for k in range(n):
        b[k], b[rows[k]] = b[rows[k]], b[k]
    for k in range(n):
        for i in range(k + 1, n):
            b[i] -= factors[i, k] * b[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            b[k] -= factors[k, j] * b[j]
        b[k] /= factors[k, k]
