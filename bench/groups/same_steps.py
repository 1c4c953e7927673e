"""Before any timing: C++ and fastdyn take SciPy's steps, evaluation for evaluation."""

import scipy.integrate

import fastdyn

from ..cpp import calls as cpp
from ..problems import PROBLEMS, chain_of

RTOL, ATOL = 1e-6, 1e-9


def rows(quick):
    """Counts of evaluations and accepted steps, and the distance of the end state from SciPy's.

    No `t_eval`, since SciPy counts the evaluations of DOP853's interpolant too.  Rounding
    differs, so the end states may differ by a hundredth of the tolerance.
    """
    cases = [(p, m) for p in PROBLEMS for m in ("RK45", "DOP853")]
    cases += [(chain_of(n), "RK45") for n in ((10,) if quick else (10, 1000))]
    for problem, method in cases:
        given = {"method": method, "rtol": RTOL, "atol": ATOL, "args": problem.args}
        theirs = scipy.integrate.solve_ivp(problem.fun, problem.t_span, problem.y0, **given)
        ours = fastdyn.solve_ivp(problem.fun, problem.t_span, problem.y0, **given)
        answers = {"fastdyn": (ours.y[:, -1], (ours.nfev, ours.t.size - 1))}
        order = 8 if method == "DOP853" else 5
        for name, solve in cpp.solvers(problem, order, RTOL, ATOL).items():
            answers[name] = solve()
        end, steps = theirs.y[:, -1], theirs.t.size - 1
        for name, (y, counts) in answers.items():
            far = float(abs(y - end).max())
            near = far <= 0.01 * (ATOL + RTOL * abs(end).max())
            yield {
                "problem": problem.name,
                "method": method,
                "solver": name,
                "nfev": counts[0],
                "scipy_nfev": theirs.nfev,
                "accepted": counts[1],
                "scipy_accepted": steps,
                "from_scipy": far,
                "target": "the same",
                "met": bool(counts[0] == theirs.nfev and counts[1] == steps and near),
            }
