"""Endpoint-only solves through the public call, against SciPy and C++."""

import scipy.integrate

import fastdyn

from ..cpp import calls as cpp
from ..problems import PROBLEMS, compiled, error, reference
from ..report.timing import interleaved

RTOL, ATOL = 1e-6, 1e-9
TARGET = 1.15
STRETCH = 100


def rows(quick):
    """One row a solver: time, error, steps, and the ratio to C++."""
    for method, order in (("RK45", 5), ("DOP853", 8)):
        for problem in PROBLEMS:
            yield from as_it_is(problem, method, order, quick)
            yield from stretched(problem, method, order, quick)


def stretched(problem, method, order, quick):
    """A span STRETCH times as long, where the call itself no longer counts, against C++ alone.

    The error is the distance from the end state of the first C++ solver.
    """
    stretch = STRETCH // 10 if quick else STRETCH
    t_end = problem.t_span[1] * stretch
    long = problem._replace(t_span=(0.0, t_end))
    given = {"method": method, "t_eval": [t_end], "rtol": RTOL, "atol": ATOL, "args": long.args}

    def ours():
        r = fastdyn.solve_ivp(long.fun, long.t_span, long.y0, **given)
        return r.y[:, -1], (r.nfev,)

    solvers = {"fastdyn": ours, **cpp.solvers(long, order, RTOL, ATOL)}
    if len(solvers) == 1:
        return
    answers = {name: solve() for name, solve in solvers.items()}
    times = interleaved(solvers, 3 if quick else 200, 3.0)
    fastest = min(times[name][0] for name in solvers if name != "fastdyn")
    other = next(answers[name][0] for name in solvers if name != "fastdyn")
    for name, (y, counts) in answers.items():
        ratio = times[name][0] / fastest
        yield {
            "problem": f"{problem.name}, span x {stretch}",
            "method": method,
            "solver": name,
            "min_us": times[name][0] * 1e6,
            "median_us": times[name][1] * 1e6,
            "error": error(y, other),
            "nfev": counts[0],
            "of_fastest_cpp": ratio,
            "of_fastdyn": times[name][0] / times["fastdyn"][0],
            "target": f"<= {TARGET} C++" if name == "fastdyn" else "",
            "met": bool(ratio <= TARGET) if name == "fastdyn" else None,
        }


def as_it_is(problem, method, order, quick, jit=True):
    """The problem as it is, through the public call."""
    t_end = problem.t_span[1]
    given = {"method": method, "t_eval": [t_end], "rtol": RTOL, "atol": ATOL, "args": problem.args}

    def ours(**options):
        r = fastdyn.solve_ivp(problem.fun, problem.t_span, problem.y0, **given, **options)
        return r.y[:, -1], (r.nfev,)

    def scipys(fun, args):
        r = scipy.integrate.solve_ivp(fun, problem.t_span, problem.y0, **given | {"args": args})
        return r.y[:, -1], (r.nfev,)

    ours(compile="inlined")
    references = cpp.solvers(problem, order, RTOL, ATOL)
    fast = {"fastdyn": ours, **references}
    slow = {"SciPy": lambda: scipys(problem.fun, problem.args)}
    if jit:
        jitted = compiled(problem)
        slow["SciPy + njit"] = lambda: scipys(jitted, None)
    exact = reference(problem)
    answers = {name: solve() for name, solve in {**fast, **slow}.items()}
    times = interleaved(fast, 20 if quick else 4000, 0.2 if quick else 4.0)
    times |= interleaved({"fastdyn ": ours, **slow}, 3 if quick else 20)
    fastest = min((times[name][0] for name in references), default=None)
    mine = times["fastdyn"][0]
    for name, (y, counts) in answers.items():
        yield {
            "problem": problem.name,
            "method": method,
            "solver": name,
            "min_us": times[name][0] * 1e6,
            "median_us": times[name][1] * 1e6,
            "error": error(y, exact),
            "nfev": counts[0],
            "of_fastest_cpp": times[name][0] / fastest if fastest else None,
            "of_fastdyn": times[name][0] / mine,
            "target": f"<= {TARGET} C++" if name == "fastdyn" else "",
            "met": bool(mine <= TARGET * fastest) if name == "fastdyn" and fastest else None,
        }
