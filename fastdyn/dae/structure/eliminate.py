"""Elimination of unknowns whose pivots are numbers, as masses: a smaller system is left.

Elimination with exchanges of rows takes n^3 operations of a graph, and equations of motion are
mostly zeros.
"""

import numpy as np

from fastdyn.trace.graph.expressions import live

LEAST = 1e-3  # a pivot, in the largest number of its row and column
SMALL = 6  # systems up to this size are left whole


def pivots(reduced, t, z):
    """The pivots (i, j) to eliminate by, in order, from the numbers at one point z."""
    size = len(reduced.orders)
    numbers = reduced.matrices(np.array([float(t)]), z[:, None])[0]
    fixed = {at for at, node in reduced.matrix.items() if is_fixed(node)}
    rows, columns, found = set(range(size)), set(range(size)), []
    there = np.zeros((size, size), bool)
    there[tuple(np.array(list(reduced.matrix)).T)] = True
    while fixed and size > SMALL and np.isfinite(numbers).all():
        i, j = min(fixed, key=lambda at: _fill(there, rows, columns, *at))
        fixed.discard((i, j))
        others = sorted(rows - {i})
        rest = sorted(columns - {j})
        sizes = np.abs(numbers[np.ix_(sorted(rows), sorted(columns))])
        row = sorted(rows).index(i)
        column = sorted(columns).index(j)
        if sizes[row, column] < LEAST * max(sizes[row].max(), sizes[:, column].max()):
            continue
        found.append((i, j))
        rows, columns = set(others), set(rest)
        change = there[others, j][:, None] & there[i, rest]
        fixed = {
            (r, k) for r, k in fixed
            if r != i and k != j and not (there[r, j] and there[i, k])
        }  # fmt: skip
        numbers[np.ix_(others, rest)] -= (
            np.outer(numbers[others, j], numbers[i, rest]) / numbers[i, j]
        )
        there[np.ix_(others, rest)] |= change
    return found


def hold(numbers, order):
    """Whether pivots chosen at one point are large enough at k others, of matrices (k, n, n)."""
    numbers = numbers.copy()
    rows = list(range(numbers.shape[1]))
    columns = list(range(numbers.shape[1]))
    large = np.ones(len(numbers), bool)
    with np.errstate(all="ignore"):
        for i, j in order:
            sizes = np.abs(numbers)
            pivot = numbers[:, i, j]
            largest = np.maximum(sizes[:, i, columns].max(axis=1), sizes[:, rows, j].max(axis=1))
            large &= np.abs(pivot) >= LEAST * largest
            rows.remove(i)
            columns.remove(j)
            column = numbers[:, rows, j]
            row = numbers[:, i, :][:, columns]
            change = column[:, :, None] * row[:, None, :] / pivot[:, None, None]
            numbers[np.ix_(range(len(numbers)), rows, columns)] -= change
    return large


def solved(text, matrix, right, order):
    """The names of the solution of a system in names, after elimination by the pivots `order`."""
    size = len(right)
    matrix = [list(row) for row in matrix]
    right = list(right)
    rows = list(range(size))
    columns = list(range(size))
    for i, j in order:
        rows.remove(i)
        columns.remove(j)
        for r in rows:
            if matrix[r][j] != "0.0":
                factor = text.named(f"{matrix[r][j]} / {matrix[i][j]}")
                for k in columns:
                    if matrix[i][k] != "0.0":
                        matrix[r][k] = _less(text, matrix[r][k], factor, matrix[i][k])
                right[r] = _less(text, right[r], factor, right[i])
    found = {}
    if rows:
        left = [[matrix[r][k] for k in columns] for r in rows]
        found = dict(zip(columns, text.solved(left, [right[r] for r in rows]), strict=True))
    for i, j in reversed(order):
        total = right[i]
        for k, name in found.items():
            if matrix[i][k] != "0.0":
                total = _less(text, total, matrix[i][k], name)
        found[j] = text.named(f"{total} / {matrix[i][j]}")
    return [found[j] for j in range(size)]


def is_fixed(node):
    """Whether a node depends on parameters and constants alone."""
    return not any(each.op in ("t", "y") for each in live([node]))


def _fill(there, rows, columns, i, j):
    return (there[i, sorted(columns)].sum() - 1) * (there[sorted(rows), j].sum() - 1), i, j


def _less(text, a, b, c):
    return text.named(f"-({b} * {c})" if a == "0.0" else f"{a} - {b} * {c}")
