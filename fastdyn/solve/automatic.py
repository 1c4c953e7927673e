"""method="auto": Taylor where Taylor pays, else a pair by tolerance; Radau for stiff problems."""

import contextlib
from typing import Any

import numpy as np

from fastdyn.compile.bind import numpy_errors_are_heard
from fastdyn.compile.derivatives.switched import has_switches
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.sentences import told_once, warn
from fastdyn.compile.traced.known import Attempt
from fastdyn.compile.traced.make import LONG, Near, traced_function
from fastdyn.problem.domains import options as domains
from fastdyn.problem.events import event_list
from fastdyn.problem.options.table import TOLERANCES, refused_among, value_of
from fastdyn.problem.switched import longer, slid_away
from fastdyn.run import again
from fastdyn.run.functions.crawling import SENTENCES
from fastdyn.run.loop import Raised
from fastdyn.run.stiffness import FEW, Saturated, Sliding, Stiff, StiffnessWarning
from fastdyn.specialise.series import NoSeries

from . import by_method, repeated
from .discrete import parted
from .error_estimate import solved_by

LOOSE, TIGHT = 1e-5, 1e-9  # rtol above which Tsit5 is faster than Taylor, and Vern7 than Vern9
# At rtol = 1e-3, Tsit5 is within ten tolerances in 9 of 35 problems with switches, because no step
# ends at a jump; Taylor at LOOSE in 34, with fewer evaluations.
SWITCHES = (
    f"`fun` has conditions on the state, where the steps of Taylor end, here at rtol = {LOOSE:g}."
)
# Steps of a solution along switches, after which it crawls: a solution that slides takes hundreds,
# friction v / |v| with a guard never ends.
MOST_ALONG = 500_000
FOR_EVER = (
    "'auto' took {} steps along switches of `fun`. {} The steps of {} go across, each with an "
    "error of its own: compare with a smaller rtol."
)


def solved(asked):
    """The result of Arguments by their method; with "auto" by the method that suits the problem.

    If stability limits the steps, which is looked at after fixed numbers of steps, the run begins
    anew by Radau.  A run that fails, or in which `fun` raises, begins anew, too; if other methods
    fail as well, the first failure is told.

    Returns
    -------
    OdeResult
        With "auto", with the fields `method`, the name of the method, and `reason`, a sentence.
    """
    if not (isinstance(asked.method, str) and asked.method == "auto"):
        return solved_by(asked, asked.method)
    with told_once():
        return _chosen(asked.reacting(automatic=True), slides=True)


def _chosen(asked, slides):
    """As `solved`; without `slides`, the solve has begun already."""
    if refused_among(asked.options, "again"):
        return _explicit(asked)
    if asked.options.get("mass") is not None:
        name = "Rodas5P" if len(asked.y0) <= FEW and asked.y0.dtype.kind != "c" else "Radau"
        return _begun(asked, name, "`mass` is for implicit methods.")
    try:
        may_slide = slides and asked.adjoint is None
        reacting = asked.reacting(gives_up="slides" if may_slide else "stiff")
        result = _explicit(reacting, _begun if slides else _gone_on)
    except Stiff as found:
        return _named(_to_the_end(asked), "Radau", str(found))
    except Sliding as found:
        return _along_switches(asked, found) or _chosen(asked, slides=False)
    except Saturated:
        return _chosen(asked, slides=False)
    except Raised as found:
        reason = f"`fun` raised {type(found.error).__name__}: {found.error}."
        other = _by_others(asked, reason, "Radau", "Taylor")
        if other is None:
            raise found.error from None
        return other
    if result.status != -1:
        return result
    other = _by_others(asked, f"{result.method} failed: {result.message}", "Radau")
    if other is None:
        result.message += " Radau failed, too."
    return other or result


def _along_switches(asked, found):
    """The result of a solve whose solution slides along switches, by Filippov's average.

    None if an option of the Arguments does not go together with modes, if no switch jumps beside
    the solution, or if the solve fails: where the solution reaches a point on several switches ever
    faster, say.
    """
    if not found.chosen:
        return None
    loose = asked
    asked = (_tightened(asked) if _rtol(asked) > LOOSE else None) or asked
    of_modes = longer(asked, found.of, found.chosen)
    name = _pair(asked)
    n = len(asked.y0)
    if of_modes is None:
        return None
    if of_modes.options.get("max_steps") is None:
        of_modes = of_modes.with_options(max_steps=MOST_ALONG)
    try:
        whole = solved_by(of_modes.reacting(gives_up="slides"), name)
    except Saturated:
        return None
    except Stiff:
        name = "Radau"
        whole = _to_the_end(of_modes)
    if whole.status == -1 and whole.n_accepted >= MOST_ALONG:
        said = SENTENCES["changes"].format(t=whole.t[-1])
        warn(FOR_EVER.format(whole.n_accepted, said, _pair(loose)), StiffnessWarning)
    if whole.status == -1 or slid_away(asked, found.of, found.chosen, whole.t, whole.y):
        return None
    result = parted(whole, n)
    own = len(event_list(asked.events) or ())
    for field in ("discrete", "discrete_events"):
        del result[field]
    if asked.t_eval is None:  # the time of a change of modes is there twice, with one state
        once = np.append(np.diff(result.t) != 0.0, True)
        result.t, result.y = result.t[once], result.y[:, once]
    for field in ("t_events", "y_events"):
        result[field] = None if asked.events is None else result[field][:own]
    return _named(result, name, f"{found} There it moves by Filippov's average of both sides.")


def _to_the_end(asked):
    """The result by Radau, which no other method follows and no warning."""
    try:
        return solved_by(asked.reacting(gives_up="stiff"), "Radau")
    except Raised as found:
        raise found.error from None


def _by_others(asked, reason, *names):
    """The result of the first method that reaches an end; None if each of them fails.

    A stage of a pair may lie where `fun` raises, although the solution stays away.  Radau's steps
    are not held back by stability, and its stages lie near the solution; the steps of Taylor call
    `fun` at their ends alone.
    """
    for name in names:
        try:
            result = solved_by(asked.reacting(gives_up="slides"), name)  # given up: the next one
        except Exception:
            continue
        if result.status >= 0:
            return _named(result, name, reason)
    return None


class Chosen(again.Kind):
    """Calls of one kind with "auto", by the method that the last one of them began and ended with.

    The choice depends on the key, and on the graph of the function, which the readers of a ready
    run follow.  A solve that has to go on by another method goes the long way.
    """

    def __init__(self, of, name, reason):
        super().__init__(of.codes)  # which the Kind of the method may lose
        self._of: Any = of
        self._name = name
        self._reason = reason

    def solve(self, *given):
        of = self._of
        if of is None or not all(ready.is_traced for ready in of.idle):
            return None  # a graph may be found later
        try:
            result = of.solve(*given)
        except (Stiff, Sliding, Saturated, Raised):
            self._of = None  # the next calls may be like this one
            return None
        if result is None or result["status"] == -1:
            return None
        return _named(result, self._name, self._reason)


def _begun(asked, name, reason, by=None):
    """The result by a method that the solve begins with, perhaps as other Arguments `by`.

    Later calls of the kind begin so at once.
    """
    result = _gone_on(asked, name, reason, by)
    if result.status != -1 and not numpy_errors_are_heard():  # then "auto" chooses otherwise
        by = by or asked
        kind = by_method.kind_of(by, name)
        repeated.choose(asked, asked.method, by, kind, lambda of: Chosen(of, name, reason))
    return result


def _gone_on(asked, name, reason, by=None):
    """As `_begun`, if the solve has begun by another method, or in another way."""
    return _named(solved_by(by or asked, name), name, reason)


def _explicit(asked, solve=_begun):
    """Solve by Taylor or by a pair; `solve` is `_gone_on` if the solve has begun already."""
    rtol = _rtol(asked)
    name = _pair(asked)
    if asked.adjoint is not None:
        return solve(asked, name, "`adjoint` goes back over the steps of a pair.")
    if rtol > LOOSE:
        exact = _tightened(asked) if _switches(asked) else None
        if exact is not None:
            with contextlib.suppress(NoSeries):
                result = solve(asked, "Taylor", SWITCHES, exact.reacting(refuses_large=True))
                if result.status >= 0:
                    return result
                solve = _gone_on
        return solve(asked, name, f"rtol is above {LOOSE:g}.")
    if asked.y0.dtype.kind == "c":
        return solve(asked, name, "The state is complex.")
    if domains.asked(asked.options):
        return solve(asked, name, "A series does not end at the border of a domain.")
    reason = f"`fun` has a Taylor series, and rtol is at most {LOOSE:g}."
    try:
        result = solve(asked, "Taylor", reason, asked.reacting(refuses_large=True))
    except NoSeries as refusal:
        return solve(asked, name, f"{refusal} rtol is {rtol:.1e}.")
    if result.status == -1:
        other = solved_by(asked, name)
        if other.status >= 0:
            return _named(other, name, f"Taylor failed: {result.message}")
    return result


def _switches(asked):
    """Whether formulas with conditions on the state make up the function of Arguments."""
    a = asked
    if a.y0.dtype.kind == "c" or a.vectorized or a.sensitivity is not None or not a.y0.size:
        return False
    if len(a.y0) >= LONG or a.t0 == a.tf or domains.asked(a.options) or numpy_errors_are_heard():
        return False
    attempt = Attempt(a.fun, a.args, DERIVATIVE, len(a.y0))
    if attempt.left.reason:
        return False
    found = traced_function(attempt, Near(a.t0, a.tf, a.y0))
    return found is not None and has_switches(found[0])


def _tightened(asked):
    """Arguments with an rtol of LOOSE, and an atol smaller in proportion; None if that fails."""
    rtol, atol = (np.asarray(value_of(asked.options, name), float) for name in TOLERANCES)
    if not (np.all(rtol < 1.0) and np.all(atol >= 0.0)):
        return None
    share = LOOSE / rtol.min()
    given = {"rtol": rtol * share, "atol": atol * share}
    return asked.with_options(**{name: x if x.ndim else float(x) for name, x in given.items()})


def _rtol(asked):
    rtol = value_of(asked.options, "rtol")
    return rtol if rtol.__class__ is float else float(np.min(rtol))


def _pair(asked):
    """The fastest pair at the tolerance of Arguments."""
    rtol = _rtol(asked)
    return "Tsit5" if rtol > LOOSE else "Vern7" if rtol > TIGHT else "Vern9"


def _named(result, method, reason):
    result.method = method
    result.reason = reason
    return result
