"""Straight-line text that factors and solves the fingers, then tensions and border.

Most of the matrix is always zero; writing the elimination out, entry by entry, leaves only the
work that is needed, about a tenth of that of loops over all of it.
"""

from collections.abc import Sequence

TENSIONS = 5
FOR_ALL = "    for f in range(5):"
Pattern = list[list[bool]]


def symbolic_factors(pattern: Sequence[Sequence[bool]]) -> Pattern:
    """Return where the factors of a matrix with this pattern may differ from zero."""
    full = [list(row) for row in pattern]
    for k in range(len(full)):
        for i in range(k + 1, len(full)):
            for j in range(k + 1, len(full)):
                full[i][j] = full[i][j] or (full[i][k] and full[k][j])
    return full


def markowitz_order(pattern: Sequence[Sequence[bool]]) -> list[int]:
    """An order of elimination: next that which meets the fewest rows and columns (Markowitz)."""
    full, order = [list(row) for row in pattern], list[int]()
    left = list(range(len(full)))
    while left:
        rows = {k: [i for i in left if i != k and full[i][k]] for k in left}
        columns = {k: [j for j in left if j != k and full[k][j]] for k in left}
        best = min(left, key=lambda k: len(rows[k]) * len(columns[k]))
        for i in rows[best]:
            for j in columns[best]:
                full[i][j] = True
        order.append(best)
        left.remove(best)
    return order


def _ordered(pattern: Sequence[Sequence[bool]], order: Sequence[int]) -> Pattern:
    return symbolic_factors([[i == j or pattern[i][j] for j in order] for i in order])


def text(
    pattern: Sequence[Sequence[bool]],
    couplings: Sequence[Sequence[bool]],
    border: Sequence[int],
    seen: Sequence[int],
) -> str:
    """Functions `factor_border` and `solve_border` for arrowhead.py.

    `pattern`: rows and columns of tensions, then border; `couplings`: their rows by the wire that
    each finger takes up; `border`: places of its states; `seen`: which of them fingers read.
    """
    return "\n\n".join([_factor(pattern, couplings, seen), _solve(pattern, couplings, border)])


def fingers(pattern: Sequence[Sequence[bool]], own: Sequence[Sequence[int]]) -> str:
    """Functions for arrowhead.py that factor and solve the fingers, take and give their states.

    `pattern`: where the rates of a finger's own states depend on these; `own`: their places, which
    lie evenly from finger to finger.
    """
    order = markowitz_order(pattern)
    full = _ordered(pattern, order)
    places = [f"{first} + {second - first} * f" for first, second in zip(*own[:2], strict=True)]
    return "\n\n".join(
        [_factor_fingers(pattern, order, full), _solve_fingers(order, full), _moves(places)]
    )


def _moves(places):
    lines = [
        "def gather_fingers(b, own):",
        '    """Copy b to own (states of a finger, fingers)."""',
    ]
    lines += [FOR_ALL, *(f"        own[{i}, f] = b[{at}]" for i, at in enumerate(places)), "", ""]
    lines += ["def scatter_fingers(own, b):", '    """Copy it back."""']
    lines += [FOR_ALL, *(f"        b[{at}] = own[{i}, f]" for i, at in enumerate(places))]
    return "\n".join(lines) + "\n"


def _factor_fingers(pattern, order, full):
    size = len(order)
    lines = ["def factor_fingers(shift, blocks, factors):"]
    lines += ['    """LU of shift - F of all fingers; what acts on them beside."""', FOR_ALL]
    for i, row in enumerate(order):
        for j, column in enumerate(order):
            if full[i][j]:
                parts = ["shift"] if i == j else []
                parts += [f"- blocks[{row}, {column}, f]"] if pattern[row][column] else []
                lines.append(f"        m_{i}_{j} = {' '.join(parts) or '0.0'}")
    lines += ["    " + line for line in _triangles(full)]
    lines += [
        f"        factors[{order[i]}, {order[j]}, f] = m_{i}_{j}"
        for i in range(size)
        for j in range(size)
        if full[i][j]
    ]
    lines += [f"        for n in range({size}, blocks.shape[1]):"]
    lines += [f"            factors[{row}, n, f] = blocks[{row}, n, f]" for row in range(size)]
    return "\n".join(lines) + "\n"


def _solve_fingers(order, full):
    size = len(order)
    lines = ["def solve_fingers(factors, b):"]
    lines += ['    """Replace b (states of a finger, fingers) by the solution."""', FOR_ALL]
    for i, row in enumerate(order):
        lines.append(f"        z_{i} = b[{row}, f]")
        lines += [
            f"        z_{i} = fused(-factors[{row}, {order[k]}, f], z_{k}, z_{i})"
            for k in range(i)
            if full[i][k]
        ]
    for i, row in reversed(list(enumerate(order))):
        lines += [
            f"        z_{i} = fused(-factors[{row}, {order[k]}, f], z_{k}, z_{i})"
            for k in range(i + 1, size)
            if full[i][k]
        ]
        lines += [f"        z_{i} *= factors[{row}, {row}, f]", f"        b[{row}, f] = z_{i}"]
    return "\n".join(lines) + "\n"


def _factor(pattern, couplings, seen):
    order = markowitz_order(pattern)
    full, count = _ordered(pattern, order), len(pattern) - TENSIONS
    lines = ["def factor_border(shift, border, couplings, lu):"]
    lines += ['    """LU of tensions and border; short steps make row exchanges needless."""']
    for i, row in enumerate(order):
        lines += [
            f"    m_{i}_{j} = {_entry(row, column, pattern, couplings, seen, count)}"
            for j, column in enumerate(order)
            if full[i][j]
        ]
    lines += _triangles(full)
    places = _places(full)
    lines += [f"    lu[{n}] = m_{i}_{j}" for (i, j), n in places.items()]
    return "\n".join(lines) + "\n"


def _triangles(full):
    """Lines that replace m by its LU, the reciprocal on the diagonal."""
    size, lines = len(full), []
    for k in range(size):
        lines.append(f"    m_{k}_{k} = 1.0 / m_{k}_{k}")
        for i in range(k + 1, size):
            if full[i][k]:
                lines.append(f"    m_{i}_{k} *= m_{k}_{k}")
                lines += [
                    f"    m_{i}_{j} = fused(-m_{i}_{k}, m_{k}_{j}, m_{i}_{j})"
                    for j in range(k + 1, size)
                    if full[k][j]
                ]
    return lines


def _entry(i, j, pattern, couplings, seen, count):
    """One entry of the matrix: the unit or shift on the diagonal minus the entry of `border`."""
    parts = []
    if i == j:
        parts.append("1.0" if i < TENSIONS else "shift")
    if j < TENSIONS and couplings[i][j]:
        parts.append(f"- {_coupling(i, j, 0, count)}")
    if j >= TENSIONS and pattern[i][j]:
        parts.append(f"- border[{j - TENSIONS}, {i}]")
    if j - TENSIONS in seen:
        n = 1 + list(seen).index(j - TENSIONS)
        parts += [f"- {_coupling(i, f, n, count)}" for f in range(TENSIONS) if couplings[i][f]]
    return " ".join(parts) if parts else "0.0"


def _coupling(i, f, n, count):
    first, second = f"border[{count + f}, {i}]", f"border[{count + TENSIONS + f}, {i}]"
    return f"({first} * couplings[0, {n}, {f}] + {second} * couplings[1, {n}, {f}])"


def _places(full):
    places = [(i, j) for i in range(len(full)) for j in range(len(full)) if full[i][j]]
    return {place: n for n, place in enumerate(places)}


def _solve(pattern, couplings, border):
    order = markowitz_order(pattern)
    full, count = _ordered(pattern, order), len(border)
    places = _places(full)
    lines = ["def solve_border(b, excursion, excursion_rate, border, lu, solved_tensions):"]
    lines += ['    """Solve for the border in b, and for the tensions in solved_tensions."""']
    targets = [
        f"solved_tensions[{i}]" if i < TENSIONS else f"b[{border[i - TENSIONS]}]" for i in order
    ]
    for i, row in enumerate(order):
        terms = ["0.0" if row < TENSIONS else targets[i]]
        for f in range(TENSIONS):
            if couplings[row][f]:
                terms.append(f"border[{count + f}, {row}], excursion[{f}]")
                terms.append(f"border[{count + TENSIONS + f}, {row}], excursion_rate[{f}]")
        lines.append(f"    z_{i} = {terms[0]}")
        lines += [f"    z_{i} = fused({term}, z_{i})" for term in terms[1:]]
        lines += [
            f"    z_{i} = fused(-lu[{places[i, k]}], z_{k}, z_{i})" for k in range(i) if full[i][k]
        ]
    for i in reversed(range(len(order))):
        lines += [
            f"    z_{i} = fused(-lu[{places[i, k]}], z_{k}, z_{i})"
            for k in range(i + 1, len(order))
            if full[i][k]
        ]
        lines += [f"    z_{i} *= lu[{places[i, i]}]", f"    {targets[i]} = z_{i}"]
    return "\n".join(lines) + "\n"


def entries(pattern: Sequence[Sequence[bool]]) -> int:
    """Number of entries of the factors."""
    return sum(map(sum, _ordered(pattern, markowitz_order(pattern))))
