"""Detection of stiffness: a warning, once a function and method, if stability limits the steps.

So is a solution detected that slides along a switch: see `fastdyn/trace/graph/switches.py`.

E. Hairer and G. Wanner, "Solving Ordinary Differential Equations II", section IV.2.  Let the
stability region of a method end at -z on the real axis.  Stability limits the step h if z / h is
the size of an eigenvalue of the Jacobian, and the solution hardly changes in a step.  In the
directions of damped oscillations the stability regions end at about the same distance z.
"""

import contextlib

import numpy as np

from fastdyn.compile.derivatives.switched import BEHIND, Part, followed, jumping, switched
from fastdyn.compile.python_callback import evaluate
from fastdyn.compile.sentences import warn
from fastdyn.kernels.methods.method import ON_PAIRS
from fastdyn.kernels.methods.taylor.accuracy import order_for
from fastdyn.kernels.state.record import Y_OLD, Y

from .functions.compared import states_of
from .functions.crawling import (
    LEAST_BEYOND,
    LEAST_SHARE,
    SATURATES,
    SENTENCES,
    WIDE,
    Samples,
    counts_beyond,
    crawl,
)
from .loop import NOWHERE, counters, next_look
from .matrices.check_jacobian import evaluated
from .matrices.price import is_dear

# Where |R(iz)| first exceeds 1 + 1e-4, in steps of 0.05, of the methods of "auto": a test computes
# these numbers from the tables, which a solve does not import.
ON_THE_IMAGINARY_AXIS = {"Tsit5": 0.95, "Vern7": 4.55, "Vern9": 2.75}
OF_SERIES = {
    13: 6.21,
    17: 7.70,
    25: 10.69,
}  # `stable_to` of "Taylor" by order: R is a partial sum of exp
MANY = 2000  # a run with fewer steps is not examined, because it loses little time
MOST = 4  # number of solves of a function by a method that are examined
NEAR, SLOW = 0.6, 0.02  # share of the limit; largest change in a step, as a share of the state
FEWEST, LOOKED_AT = 50, 16  # steps of a failed run, and states of it, that may show stiffness
MOST_TIMES = 16  # switching times behind which it is looked along which switches a function jumps
FEW = 32  # up to so many components, Rodas5P is mostly the fastest method
ITERATIONS, SIZE = 40, 1e-6  # iterations of the power method; size of its displacements
DAMPED = 0.25  # loss of an oscillation in a radian
ALIKE = 1e-3  # vectors that differ by less count as parallel

ACCUMULATED = 1e-8  # share of a run in which its last switchings, at several switches, lie


class StiffnessWarning(UserWarning):
    """A problem is stiff, or slides along a switch, and the method is slow."""


class Stiff(Exception):
    """A run is given up because the problem is stiff."""


class Saturated(Exception):
    """A run is given up that looks stiff, where no implicit method and no average helps."""


class Sliding(Exception):
    """A run is given up because the solution slides along switches; `of` is the Switched."""

    def __init__(self, t, of, y, tf, sliding):
        super().__init__(f"The solution slides along a switch at t = {t:.6g}.")
        times = of.times(t, tf)[:MOST_TIMES]
        later = times + BEHIND * np.sign(tf - t) * np.abs(times)
        self.of = of
        self.chosen = followed(of, [k for s in (t, *later) for k in jumping(of, s, y)], sliding)


def watch(problem, run):
    """Examine a run at its looks: whether another method follows, or its steps crawl."""
    run.may_follow = bool(problem.reaction.gives_up)
    run.at_looks = None
    if run.may_follow:
        run.at_looks = lambda: _give_up(problem, run)
    elif problem.method.series:
        run.at_looks = lambda: bool(switches_of(run)[3])
    run.samples = None
    run.at_end = None
    if counts_beyond(problem) and not problem.reaction.gives_up:
        run.at_end = lambda: _tell_beyond(problem, run)
    along = isinstance(problem.fun, Part)  # the motion along switches, which "auto" limits itself
    if problem.method.error_order and not along:
        run.samples = Samples(lambda times, states: _tells_crawl(problem, run, times, states))


def _give_up(problem, run):
    if problem.reaction.gives_up == "slides":
        t, y, of, chosen = switches_of(run)
        if chosen:
            raise Sliding(t, of, y, problem.tf, chosen)
    found = _held_back(problem, run, undamped=True)
    if found is None:
        return
    if not _saturates(problem, run):
        raise Stiff(found)
    if problem.reaction.gives_up == "slides":
        raise Saturated(found)
    t = float(run.view("solve.state")[0]["t"])
    _tell(problem, run, SENTENCES["crawls"].format(t=t))


def _tell_beyond(problem, run):
    """Warn of steps that change the state more than the equations do."""
    (k,) = run.view("solve.state")["n_standing"]
    if k >= LEAST_BEYOND and k > LEAST_SHARE * counters(run.memory)[0]:
        run.at_end = None
        _tell(problem, run, SENTENCES["beyond"].format(k=k), "beyond")


def _tell(problem, run, said, place="crawls"):
    """Warn of what steps do, once a function and method; "auto" takes several methods."""
    function = run.bounds[0].function
    name = problem.method.name
    if function is not None:
        place = place, "auto" if problem.reaction.automatic else name
        if function.notes.get(place) is not None:
            return
        function.notes[place] = True
        function.notes["looked at", name] = MOST
    warn(f"{name} took {counters(run.memory)[0]} steps. {said}", StiffnessWarning)


def _tells_crawl(problem, run, times, states):
    """Whether steps in a row crawl where the equations jump; a warning says what they do there."""
    p, bound, t = problem, run.bounds[0], float(times[-1])
    n = p.fun.n if p.mode.sensitivities else len(states[0]) // (2 if p.mode.residual else 1)
    tolerance = (p.atol + p.rtol * np.abs(states[-1]))[:n]
    counts = np.isfinite(tolerance) & (tolerance > 0.0)
    rest = states[-1][n:]

    def slope(y):
        return _slope(bound, t, np.concatenate([y, rest]))[:n]

    known = None if p.mode.residual or bound.pair else slope
    if known is None and run.switching is not None:  # the steps may show jumps in the time
        return False
    tolerance = np.where(counts, tolerance, np.inf)
    if not crawl(times, states[:, :n], tolerance, known):
        return False
    _tell(p, run, _along(p, bound, times, states, _last_length(run.view("solve.state")[0])))
    return True


def _along(problem, bound, times, states, h):
    """The sentence about steps in a row that crawl."""
    t, of = float(times[-1]), switched(bound)
    if of is None or not of.all:
        return SENTENCES["crawls"].format(t=t)
    if of.slides(t, states[-1], h):
        return _slides(problem, t)
    k = len(of.crossed(times, states))
    return SENTENCES[("crawls", "changes", "twists")[min(k, 2)]].format(t=t, k=k)


def _saturates(problem, run):
    """Whether `fun` changes far less within WIDE tolerances than its Jacobian says.

    Iterations of an implicit method, which follow the Jacobian, then end anywhere.
    """
    p = problem
    (state,) = run.view("solve.state")
    y = run.view("solve.work")[Y].copy()
    t, n = float(state["t"]), p.fun.n if p.mode.sensitivities else len(y)

    def slope(u):
        return _slope(run.bounds[0], t, np.concatenate([u, y[n:]]))[:n]

    f, step = slope(y[:n]), SIZE * max(np.abs(y[:n]).max(), SIZE)
    before = v = np.random.default_rng(0).standard_normal(n)
    for _ in range(ITERATIONS):
        v = v / np.linalg.norm(v)
        change = (slope(y[:n] + step * v) - f) / step
        if not 0.0 < np.linalg.norm(change) < np.inf:
            return False
        before, v = v, change
    far = WIDE / np.max(np.abs(before) / (p.atol + p.rtol * np.abs(y))[:n])
    changes = [np.linalg.norm(slope(y[:n] + way * far * before) - f) for way in (1.0, -1.0)]
    return max(changes) < SATURATES * far * np.linalg.norm(v)


def switches_of(run):
    """The time and the state of a run, its Switched, and the switches along which it slides."""
    (state,) = run.view("solve.state")
    y = run.view("solve.work")[Y].copy()
    t = float(state["t"])
    of = switched(run.bounds[0])
    if of is None or not np.isfinite(y).all():
        return t, y, None, []
    return t, y, of, of.slides(t, y, _last_length(state))


def notice(problem, run):
    """Warn if stability or a switch, not accuracy, limited the steps at the end of a run."""
    function = run.bounds[0].function
    if function is None or problem.reaction.gives_up or counters(run.memory)[0] < MANY:
        return  # "auto" has looked already, and tells what it found
    place = "looked at", problem.method.name
    function.notes[place] = looked = function.notes.get(place, 0) + 1
    if looked > MOST:
        return
    t, _, _, chosen = switches_of(run)
    if chosen and t != problem.tf:
        return  # the message tells the failure
    found = None if chosen else _held_back(problem, run)
    few = len(problem.y0) <= FEW and not problem.mode.complex_numbers
    if found is not None and is_dear(run.bounds[0], len(problem.y0), _evaluations(problem, run)):
        return  # the factorisations of an implicit method take longer
    if found is not None:
        said = f"{found} Take method='{'Rodas5P' if few else 'BDF'}' or 'Radau'."
    elif chosen:
        said = f"{problem.method.name} took {counters(run.memory)[0]} steps. {_slides(problem, t)}"
    else:
        return
    function.notes[place] = MOST
    warn(said, StiffnessWarning)


def unexamined(problem, run):
    """The most steps of further solves like that of a Run which nothing looks at."""
    m = problem.method
    function = run.bounds[0].function
    if function is None or problem.reaction.gives_up or m.series or m.n_matrices:
        return MANY - 1
    looked = function.notes.get(("looked at", m.name), 0)
    return MANY - 1 if looked < MOST else next_look(NOWHERE - 1)


def _evaluations(problem, run):
    """The evaluations of a run, but for those of its start."""
    accepted, rejected, *_ = counters(run.memory)
    return (accepted + rejected) * problem.method.n_stages


def _slides(problem, t):
    """The sentence about a solution that slides along a switch."""
    advice = "Give"
    if not problem.reaction.automatic:
        advice = "Take method='auto', which moves along the switch if no option acts on the state, "
        advice += "or give"
    return SENTENCES["slides"].format(t=t, advice=advice)


def of_failure(problem, run):
    """A sentence for a run that failed on a switch, or by stability; else ""."""
    t, y, of, chosen = switches_of(run)
    if chosen:
        return f" {_slides(problem, t)}"
    met = [] if of is None else of.reached(t, y, ACCUMULATED * abs(t - problem.t0))
    if len(met) > 1:
        return f" {SENTENCES['twists'].format(t=t, k=len(met))}"
    bound, n_steps = run.bounds[0], counters(run.memory)[0]
    if not problem.method.stable_to or bound.function is None or bound.pair or n_steps < FEWEST:
        return ""
    times, states = states_of(run, LOOKED_AT)  # first the end, where the run was lost already
    times = times[2:-1]
    states = states[2:-1]
    mean = abs(float(run.view("solve.state")["t"][0]) - problem.t0) / n_steps
    found = []
    for t, y in zip(times, states, strict=True):
        value = _largest_eigenvalue(lambda y, t=t: evaluated(bound, t, y, len(y)), y)
        end = _limit(problem, value, False)
        if end is not None and mean * abs(value) >= NEAR / 2 * end:  # some steps failed
            found.append((t, value))
    if 2 * len(found) <= len(times):
        return ""
    t, value = found[len(found) // 2]
    return (
        f" Before, its steps were as long as stability allows (an eigenvalue of {_said(value)} of "
        f"the Jacobian at t = {t:.6g}): the problem is stiff"
        f"{'' if problem.reaction.gives_up else '; take Radau'}."  # "auto" takes it by itself
    )


def _held_back(problem, run, undamped=False):
    """The sentence about a run whose last step was limited by stability; None for other runs.

    With `undamped`, undamped oscillations count, too: an undamped oscillation above the tolerance
    would have shortened the steps for accuracy.
    """
    n_steps = counters(run.memory)[0]
    bound = run.bounds[0]
    if n_steps < MANY or bound.pair:
        return None
    state = run.view("solve.state")[0]
    work = run.view("solve.work")
    t, whole, h = float(state["t"]), work[Y].copy(), _last_length(state)
    n = problem.fun.n if problem.mode.sensitivities else len(whole)  # S has the same eigenvalues
    return _verdict(
        problem.method.name, n_steps, t, h, (work[Y_OLD][:n], whole[:n]),
        lambda y: _slope(bound, t, np.concatenate([y, whole[n:]]))[:n],
        lambda value: _limit(problem, value, undamped),
    )  # fmt: skip


def _last_length(state):
    """The length of the last step of a run, or of the next one: t_end may have cut the last."""
    return max(abs(float(state["t"]) - float(state["t_old"])), float(state["h"]))


def _slope(bound, t, y):
    """The value of the equations, compiled or in Python; NaN if the function raises."""
    if bound.function is not None:
        return evaluated(bound, t, y, len(y))
    with contextlib.suppress(Exception):
        return evaluate(bound.python, bound.mode, t, y.copy())
    return np.full(len(y), np.nan)


def _verdict(name, n_steps, t, h, states, slope, limit):
    """The sentence about a step of length h between two states, if stability limited the step."""
    y_old, y = states
    moved = np.abs(y - y_old).max() / max(np.abs(y).max(), 1e-300)
    if not (np.isfinite(y).all() and moved < SLOW):
        return None
    value = _largest_eigenvalue(slope, y)
    end = limit(value)
    if end is None or h * abs(value) < NEAR * end:
        return None
    return (
        f"{name} took {n_steps} steps, and at t = {t:.6g} they are as long as stability allows "
        f"({h:.2g}, with an eigenvalue of {_said(value)} of the Jacobian), not as accuracy asks: "
        "the problem is stiff."
    )


def _said(value):
    """An eigenvalue in words."""
    if abs(value.imag) < DAMPED * abs(value):
        return f"{-abs(value):.2g}"
    return f"{value.real:.2g} ± {abs(value.imag):.2g}i"


def _limit(problem, value, undamped):
    """The stability limit in the direction of an eigenvalue; None if not known."""
    series = problem.method.series
    name = problem.method.name.removesuffix(ON_PAIRS)
    if value.real > -DAMPED * abs(value):
        if not undamped or value.real > DAMPED * abs(value):
            return None
        if not series:
            return ON_THE_IMAGINARY_AXIS.get(name)
    if series:
        return OF_SERIES[order_for(problem.rtol, problem.atol, problem.y0)]
    return problem.method.stable_to or None


def _largest_eigenvalue(slope, y):
    """The eigenvalue of largest size, or one of a pair, by the power method; 0 if there is none.

    The method needs products with the Jacobian only, by differences of the derivative.  Two
    iterations detect a complex pair: J^2 v = p J v + q v.
    """
    f = slope(y)
    step = SIZE * max(np.abs(y).max(), SIZE)
    v = np.random.default_rng(0).standard_normal(len(y))
    vectors = [v / np.linalg.norm(v)]
    sizes = []
    for _ in range(ITERATIONS):
        change = (slope(y + step * vectors[-1]) - f) / step
        size = np.linalg.norm(change)
        if not 0.0 < size < np.inf:
            return 0j
        sizes = [*sizes[-1:], size]
        vectors = [*vectors[-2:], change / size]
    along = float(vectors[1] @ vectors[2])
    if abs(along) > 1.0 - ALIKE:  # of one real eigenvalue, two would differ by noise alone
        return complex(along * sizes[1])
    (a, b), *_ = np.linalg.lstsq(np.array([vectors[1], vectors[0]]).T, vectors[2], rcond=ALIKE)
    p = a * sizes[1]
    q = b * sizes[0] * sizes[1]
    return complex(max(np.roots([1.0, -p, -q]), key=abs))
