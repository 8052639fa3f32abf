"""Small dense linear systems: elimination with exchange of rows."""

from benchmarks.truth._jit import compiled


@compiled
def factor(a, pivots):
    """LU of `a` in place, rows exchanged; the diagonal of U is inverted."""
    n = pivots.size
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(a[i, k]) > abs(a[best, k]):
                best = i
        pivots[k] = best
        if best != k:
            for j in range(n):
                a[k, j], a[best, j] = a[best, j], a[k, j]
        a[k, k] = 1.0 / a[k, k]
        for i in range(k + 1, n):
            if a[i, k] != 0.0:
                a[i, k] *= a[k, k]
                for j in range(k + 1, n):
                    a[i, j] -= a[i, k] * a[k, j]


@compiled
def solve(a, pivots, b):
    """b becomes the solution."""
    n = pivots.size
    for k in range(n):
        best = pivots[k]
        b[k], b[best] = b[best], b[k]
    for i in range(n):
        for j in range(i):
            b[i] -= a[i, j] * b[j]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            b[i] -= a[i, j] * b[j]
        b[i] *= a[i, i]
