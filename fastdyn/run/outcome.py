"""The end of a run: the status, a sentence, and the result."""

import struct
from typing import Any, NamedTuple

import numpy as np

from fastdyn.code_store.call import address_of
from fastdyn.compile.compare import python_value
from fastdyn.kernels.state.record import (
    ATOL,
    BAD_JACOBIAN,
    BAD_JUMP,
    BORDER,
    EVENT,
    FAILED_AGAIN,
    FINISHED,
    INTERRUPTED,
    NEGATIVE,
    NO_TOLERANCE,
    NON_FINITE,
    NOT_CONVERGED,
    OUTSIDE,
    RTOL,
    SINGULAR,
    STATE,
    STEP_TOO_SMALL,
    STOPPED,
    ZENO,
    K,
    Y,
)
from fastdyn.problem.domains.options import warn_of_cut
from fastdyn.problem.schedules import in_order

from .dense_output import PiecewisePolynomial, floors_of
from .functions.undefined import of_undefined
from .output import (
    OCCURRENCES,
    Copies,
    add_parts,
    as_components,
    conversion,
    occurrences,
    unshared,
)
from .result import FIELDS, FOLLOWING, Ended, OdeResult
from .stiffness import of_failure

SUCCESS = "The solver successfully reached the end of the integration interval."
TERMINATED = "A termination event occurred."
OF_LSODA = "Unexpected istate in LSODA."
TOO_SMALL = "Required step size is less than spacing between numbers."
LEFT = -3  # the status of a run that ends at the border of `domain`
SENTENCES = {
    BORDER: "The solution leaves `domain` at {t}: the run ends there, at the border.",
    ZENO: "An event occurs infinitely often at {t}: either ever faster up to there (Zeno), or "
    "because `on_event` leaves the state where it occurs again at once. End the run before, by "
    "the number `terminal` of the event, or go on with equations that hold in this state.",
    SINGULAR: "The matrix of the step from {t} is singular, however short the step: the algebraic "
    "equations of `mass` do not determine the algebraic variables there (the index is above 1, or "
    "two equations say the same). Differentiate constraints, or leave an equation out.",
    BAD_JACOBIAN: "The Jacobian is nan or inf at {t}: `fun` or `jac` is not defined there, or just "
    "beside it.",
    NOT_CONVERGED: "The equations of the implicit step from {t} do not converge: reduce `step`, or "
    "take Radau or BDF if the problem is stiff.",
    NO_TOLERANCE: f"{OF_LSODA} A component of the state is 0 at {{t}}, and so is its `atol`: no "
    "error is small enough there; give that component a positive `atol`.",
    NON_FINITE: "The state is not finite after {t}: the solution blows up there, or the steps are "
    "too long for it; reduce `step`.",
}
# Sentences of runs that end because `on_event` returned a state that is refused.
NOT_FINITE = "returned nan or inf"
OF_ACTIONS = {
    BAD_JUMP: f"{{action}} {NOT_FINITE} at {{t}} ({{component}}).",
    OUTSIDE: "{action} returned a state outside of `domain` at {t}: the run ends before the "
    "action. Return a state inside, or widen `domain`.",
    NEGATIVE: "{action} returned a negative number at {t} ({component}), which `nonnegative` "
    "forbids: the run ends before the action. Return 0 or more.",
}
OF_EACH = {"action": "`on_event`", "component": "in a component"}  # of many trajectories
OF_JUMPS = (
    "If an algebraic variable jumps there at a known time, with what drives it, name the time in "
    "`breakpoints=`. If the equations switch to and fro about a limit there, give an event that "
    "resets the state, or hysteresis."
)
EMPTY = np.empty(0)
# Fields that `results` writes without their formulas, which take 0.1 us each.
WRITTEN_OUT = {"nfev", "njev", "nlu", "n_accepted", "n_rejected"}
BLOWN_UP = 1e8  # growth relative to the initial state that counts as a blow-up


def outcome(status, state, work, problem, bound=None):
    """SciPy's status, and the message that says why the kernels stopped.

    The equations are called where the run stopped, if their `bound` is given.
    """
    s = state[0]
    if status == EVENT:
        return 1, TERMINATED
    if status == INTERRUPTED:
        return -2, f"Interrupted at t = {s['t']:.10g}; the result ends there."
    t = f"t = {s['t']:.10g}"
    if status == STOPPED:
        return 1, f"`callback` stopped the integration at {t}."
    if status == STEP_TOO_SMALL:
        return -1, f"{TOO_SMALL} {_why(s, work, problem, t, bound)}"
    if status == FAILED_AGAIN:
        return -1, f"{OF_LSODA} {_why(s, work, problem, t, bound)}"
    if status in OF_ACTIONS:
        return -1, after_action(status, s, problem, t)
    bad = np.flatnonzero(~np.isfinite(work[K + problem.method.fsal_stage]))
    if status == NON_FINITE and s["t"] == s["t_old"] and bad.size:
        return -1, _not_finite(s, problem, t, bound, bad[0])
    if status == BAD_JACOBIAN and bound is not None:
        if said := of_undefined(problem, bound, float(s["t"]), work[Y], float(s["h"])):
            return -1, said
    if status in SENTENCES:
        said = SENTENCES[status].format(t=t)
        if status == NOT_CONVERGED:
            said = said.replace("`step`", f"`step={problem.h:.10g}`")
        return LEFT if status == BORDER else -1, said
    implicit = problem.method.n_matrices > 0
    return -1, (
        f"`max_steps={problem.max_steps:g}` was reached at {t}, "
        f"{abs(s['t'] - problem.t0) / abs(problem.tf - problem.t0):.1%} of the way: raise "
        f"`max_steps`, {'or ' if implicit else ''}loosen `rtol` and `atol`"
        f"{'' if implicit else ', or take Radau or BDF if the problem is stiff'}."
    )


def _not_finite(s, problem, t, bound, component):
    """The sentence about a slope that is not finite before any step, or behind an action."""
    start = s["n_accepted"] == 0
    if start and bound is not None:
        found = python_value(bound, problem.t0, problem.y0[: bound.n].copy())
        if not isinstance(found, Exception) and np.isfinite(found).all():
            step = "step" if not problem.method.error_order else "first_step"
            return (
                f"The step from {t}, of the length {abs(s['h']):.10g}, gives no finite state, "
                f"though `fun` is finite there: it is too long; reduce `{step}`."
            )
    where = "the start" if start else "the state that `on_event` returned"
    outside = ", or the state lies outside of `domain`" if start and problem.domain else ""
    return f"`fun` returned nan or inf at {where}, {t} (component {component}){outside}."


def _why(s, work, problem, t, bound):
    """The reason why an adaptive run stopped before the end."""
    if problem.h_max < 16 * np.spacing(abs(float(s["t"]))):
        return f"At {t}, `max_step={problem.h_max:g}` is no step."
    if problem.h_least > 0.0 and s["h"] <= 1.1 * problem.h_least:
        return f"At {t}, `min_step={problem.h_least:g}` is too long for the tolerance."
    if problem.nonnegative is not None and (work[Y][problem.nonnegative] < 0.0).any():
        return f"At {t}, a component that must not be negative is, from `y0`."
    if bound is not None and (said := of_undefined(problem, bound, float(s["t"]), work[Y])):
        return said
    if not np.isfinite(s["error"]):
        return f"`fun` returns nan or inf just after {t}."
    slope = ""
    if not problem.method.series:
        rate = np.abs(work[K + problem.method.fsal_stage]).max()
        slope = f" (largest derivative {rate:.1e})"
    sizes = work[ATOL] / work[RTOL]  # above this size, errors are relative
    absolute = np.max(sizes, where=np.isfinite(sizes), initial=0.0)
    growth = np.abs(work[Y]).max() / max(np.abs(problem.y0).max(), absolute, 1e-300)
    if growth > BLOWN_UP:
        return f"The solution blows up at {t}: it has grown {growth:.1e}-fold."
    advice = f" {OF_JUMPS}" if problem.mode.residual else ""
    return (
        f"At {t} no step is short enough for the tolerance: the solution has a singularity or a "
        f"jump there{slope}, or "
        f"rtol = {work[RTOL].max():.1e} is too loose to have kept it away from one.{advice}"
    )


def n_factorised(memory):
    """The numbers of Jacobians and of factorisations, from the memory of a solve."""
    return struct.unpack_from("2q", memory, STATE.fields["n_jacobians"][1])


def end_of(problem, status, run):
    """SciPy's status and the message of a Run that stopped before its end."""
    state = run.view("solve.state")
    code, said = outcome(status, state, run.view("solve.work"), problem, run.bounds[0])
    return code, said + of_failure(problem, run) if status == STEP_TOO_SMALL else said


def result_of(problem, status, run):
    """The OdeResult of a problem whose Run ended with this status."""
    if status == FINISHED:
        code = 0
        message = SUCCESS
    else:
        code, message = end_of(problem, status, run)
    return results(problem, run.plan)(run.memory, run.grown, code, message)


def results(problem, plan, own=None, divided=None):
    """``make(memory, grown=None, code=0, message=SUCCESS)``: the OdeResult of a solve of a problem.

    `code` is SciPy's status.  The output lies in the memory of the solve, or in `grown`, the
    Output.  Arrays of the result are parts of the memory, or copies if most of the memory was not
    used, or if all solves have one memory, `own`.

    With `own`, ``divided(states)`` may divide the output of a longer state, shape (k, N): into the
    states of the result, shape (k, n), and a dict of the parts of its field `sensitivity`.  Then
    there are neither events nor `sol`.
    """
    n = plan.n
    n_stages = problem.method.n_stages
    has_matrices = problem.method.n_matrices > 0
    convert = conversion(problem)
    more = _more(problem, plan, own)
    t_begin, *_, (room,) = plan.arrays["output.t"]
    y_begin = plan.arrays["output.y"][0]
    at_times = problem.t_eval is not None
    points = "i_eval" if at_times else "n_out"
    counts = plan.counts("n_accepted", "n_rejected", "n_extra", points)
    copies = words = plain = None
    if own is not None:
        copies, words = Copies(plan, own, divided), memoryview(own)
        if divided is not None:
            more = add_parts
    others = FOLLOWING.keys() - WRITTEN_OUT
    # Copied for each result, in a third of the time that 13 keywords take.
    empty = dict.fromkeys(FIELDS)
    empty |= {"njev": 0, "nlu": 0, "status": 0, "message": SUCCESS, "success": True}

    if copies is not None and convert is None and not has_matrices and not others:
        names = points, "n_accepted", "n_rejected", "n_extra"
        places = [address_of(own) + plan.place(name) for name in names]
        plain = Plain(OdeResult, empty, copies, more, places, n_stages)

    def make(memory, grown=None, code=0, message=SUCCESS):
        numbers = memory if words is None else words  # whose address is found in half of the time
        n_accepted, n_rejected, n_extra, k = counts(numbers)
        copied = None if copies is None or grown is not None else copies[k]
        if copied is not None:
            t = copied[0]()
            y = copied[1]()
        elif grown is not None:
            t, y = grown.points() if own is None else map(unshared, grown.points())
            y = y.T
        else:
            t = memory[t_begin : t_begin + k]
            y = memory[y_begin : y_begin + k * n]
            if 2 * k < room:
                t = t.copy()
                y = y.copy()
            y = y.reshape(k, n).T
        found = OdeResult(empty)
        if convert is not None:
            t, y = convert(t, y)
        found["t"] = t if k or not at_times else []  # as in SciPy
        found["y"] = y if k or not at_times else []
        if more is not None:
            more(found, copied, memory, numbers, grown)
        found["nfev"] = n_extra + n_stages * (n_accepted + n_rejected)
        if has_matrices:
            found["njev"], found["nlu"] = n_factorised(memory)
        found["n_accepted"] = n_accepted
        found["n_rejected"] = n_rejected
        if others:
            ended = Ended.of(plan.view(memory, "solve.state")[0])
            found.update({name: FOLLOWING[name](problem.method, ended) for name in others})
        if message is not SUCCESS:
            found["status"] = code
            found["message"] = message
            found["success"] = code >= 0
        return found

    make.plain = plain  # pyright: ignore
    return make


class Plain(NamedTuple):
    """What `make` of `results` makes a plain result of, for `specialise/builtin.py`.

    ``more(found, copied)`` adds what other fields need; `copied` is an entry of `copies`.  `places`
    are the addresses of the number of points and of the counts of steps accepted and rejected and
    of other evaluations.
    """

    kind: type
    empty: dict
    copies: dict
    more: Any
    places: list
    stages: int


def _more(problem, plan, own):
    """``more(found, copied, ...)``, which fills `sol` and the fields of events.

    The memory, by default `own`, and this memory as a buffer follow, and the Output that has grown;
    `found` has its times.  None if there is nothing to fill.
    """
    p = problem
    if p.events is None and not p.dense_output and p.nonnegative is None:
        return None
    counts = plan.counts("n_dense", "n_events")

    def parts(memory):
        return [plan.view(memory, name) for name in ("output.d", "output.spans", *OCCURRENCES)]

    laid = None if own is None else parts(own)
    each_event = range(plan.n_events)
    own_words: Any = None if own is None else memoryview(own)
    new_empty = EMPTY.copy
    dense = p.dense_output
    watched = p.events is not None
    cut = p.nonnegative is not None
    cut_at = plan.place("cut") // 8

    def more(found, copied, memory: Any = own, numbers=own_words, grown=None):
        n_dense, n_events = counts(numbers)
        polynomials, lengths, index, t, y = laid or parts(memory)
        if dense:
            if grown is not None:
                d, spans = grown.polynomials()
            else:
                d = polynomials[:n_dense]
                spans = lengths[:n_dense]
            if own is not None:
                d = unshared(d)
                spans = unshared(spans)
            found["sol"] = _solution(p, found["t"], d, spans)
        if watched:
            if grown is not None:
                times, states = occurrences_of(p, *grown.found_so_far())
            elif n_events:
                times, states = occurrences_of(p, index[:n_events], t[:n_events], y[:n_events])
            else:
                times = []
                states = []
                for _ in each_event:
                    times.append(new_empty())
                    states.append(new_empty())
            found["t_events"] = times
            found["y_events"] = states
        if cut:
            warn_of_cut(memory[cut_at])

    return more


def _solution(problem, t, polynomials, spans):
    """The continuous solution; None without a step."""
    n = len(spans)
    if not n:
        return None
    ts = np.empty(n + 1)
    ts[:n], ts[n] = spans[:, 0], t[-1] if problem.t_eval is None else spans[-1].sum()
    floors = floors_of(problem.nonnegative, n)
    return PiecewisePolynomial(ts, as_components(problem, polynomials), spans, floors)


def occurrences_of(problem, index, t, y):
    """The fields t_events and y_events, from the occurrences of events: index, time, state."""
    p = problem
    n = len(problem.events)
    if p.nonnegative is not None:
        y = np.where(p.nonnegative & (y < 0.0), 0.0, y)
    t, y = (
        in_order(each[:n], p.schedules, each[n:])
        for each in occurrences(index, t, y, n + len(p.schedules))
    )
    return t, [as_components(p, each) if each.size else each for each in y]


def after_action(status, s, problem, t):
    """The sentence for a status of OF_ACTIONS; `s` is the record of the state."""
    component = f"component {s['component']}"
    return OF_ACTIONS[status].format(action=_action(s, problem), component=component, t=t)


def _action(s, problem):
    """The function of `on_event` that was called last, in words."""
    p = problem
    found = p.events or ()
    place = int(s["acted"])
    n = len(found)
    if place >= n:
        return f"`on_event` of event {p.schedules[place - n].place}, a schedule,"
    order = list(in_order(range(n), p.schedules, [None] * len(p.schedules)))
    name = found[place].name or "a function"
    return f"`on_event` of event {order.index(place)}, `{name}`,"
