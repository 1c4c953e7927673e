"""Times at equal achieved error, between the points that were measured."""

import itertools
import math

LEVELS = (1e-4, 1e-8, 1e-12)


def at_error(points, level):
    """Microseconds at which a solver reaches an error, or None.

    `points` are pairs of error and time, of one solver and one problem.  Between two of the points
    that no other point beats in both, the logarithms are interpolated; an error better than
    all but reached more cheaply than asked for costs what the cheapest such point does.
    """
    front, best = [], math.inf
    for cost, far in sorted((cost, max(far, 1e-17)) for far, cost in points if far is not None):
        if far < best:
            front.append((far, cost))
            best = far
    if not front or best > level:
        return None
    for (coarse, cheap), (fine, dear) in itertools.pairwise(front):
        if coarse > level >= fine:
            part = math.log(coarse / level) / math.log(coarse / fine)
            return cheap * (dear / cheap) ** part
    return front[0][1]


def table(rows, levels):
    """Lines of a table in Markdown: microseconds at each of the levels."""
    head = ["problem", "solver", *(f"error {level:g}" for level in levels)]
    lines = [head, ["---"] * len(head)]
    for problem, solvers in equal_error(rows, levels).items():
        for name, times in solvers.items():
            lines.append([problem, name, *(f"{x:.0f}" if x else "-" for x in times)])
    return [f"| {' | '.join(line)} |" for line in lines]


def equal_error(rows, levels=LEVELS):
    """{problem: {solver: [microseconds at each of the levels]}} from the rows of the group."""
    points = {}
    for row in rows:
        each = points.setdefault(row["problem"], {}).setdefault(row["solver"], [])
        each.append((row["error"], row["min_us"]))
    return {
        problem: {
            name: [at_error(each, level) for level in levels] for name, each in solvers.items()
        }
        for problem, solvers in points.items()
    }
