"""``python -m bench.problems.references``: the end states of `WORK`, to references.json.

Computed in quadruple precision by heyoka's Taylor method, and checked by extrapolation of the
midpoint rule in `numpy.longdouble`, which shares no line with it.  Needs a platform whose
`longdouble` has more digits than double.
"""

import json

import numpy as np

from .collection import WORK
from .end_states import REFERENCES

LOCAL = 1e-18
NUMBERS = 2 * np.arange(1, 11)


def taylor(problem):
    """End state as strings of 34 digits."""
    import heyoka as hy

    names = [f"y{i}" for i in range(len(problem.y0))]
    y = hy.make_vars(*names)
    system = list(zip(y, problem.terms(hy)(hy.time, y, *problem.args), strict=True))
    start = [hy.real128(float(value)) for value in problem.y0]
    run = hy.taylor_adaptive(
        system, start, tol=hy.real128(1e-30), fp_type=hy.real128, compact_mode=True
    )
    run.propagate_until(hy.real128(problem.t_span[1]))
    return [str(value) for value in run.state]


def midpoints(fun, t, y, step, n):
    """Gragg's rule: n substeps of the midpoint rule, without smoothing (n even)."""
    h = step / n
    before, now = y, y + h * fun(t, y)
    for i in range(1, n):
        before, now = now, before + 2 * h * fun(t + i * h, now)
    return now


def extrapolated(fun, t, y, step):
    """A step of order 20 by Aitken and Neville, and the change of the last column."""
    row = []
    for k, n in enumerate(NUMBERS):
        new = [midpoints(fun, t, y, step, n)]
        for j in range(1, k + 1):
            ratio = (np.longdouble(n) / NUMBERS[k - j]) ** 2
            new.append(new[-1] + (new[-1] - row[j - 1]) / (ratio - 1))
        row = new
    return row[-1], np.abs(row[-1] - row[-2]).max()


def extrapolation(problem):
    """End state in extended precision."""
    inner = problem.terms(np)

    def fun(t, y):
        return np.array(inner(t, y, *problem.args))

    t, y = np.longdouble(0), np.array(problem.y0, dtype=np.longdouble)
    t_end, step = np.longdouble(problem.t_span[1]), np.longdouble(0.01)
    while t < t_end:
        step = min(step, t_end - t)
        new, error = extrapolated(fun, t, y, step)
        if error > LOCAL * np.abs(new).max():
            step /= 2
            continue
        t, y = (t_end if step == t_end - t else t + step), new
        step *= np.longdouble(1.2)
    return y


def main():
    """Write the file, with how far the two are apart: the second has 19 digits and no more."""
    record = {}
    for problem in WORK:
        words = taylor(problem)
        first, second = np.array(words, dtype=np.longdouble), extrapolation(problem)
        far = float(np.abs(first - second).max() / np.abs(first).max())
        print(f"{problem.name}: relative difference {far:.1e}", flush=True)
        record[problem.name] = {"y": words, "checked_to": far}
    REFERENCES.write_text(json.dumps(record, indent=1) + "\n")


if __name__ == "__main__":
    main()
