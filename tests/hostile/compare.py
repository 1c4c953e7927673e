"""Whether fastdyn did what SciPy does, and if not, whether rounding explains why."""

import ast
import contextlib
import re

import numpy as np

from .solvers import EXPLICIT, OWN, TooMany
from .solving import outcome

EPS = np.finfo(float).eps
GROWTH = 4096  # units in the last place that a solve of a hundred steps may be off
SAMPLES, SPREAD = 24, 30  # solves with noise of rounding's size, and multiples of what they spread
SENTENCES = (
    "`fun` returned",
    "depend on their order",
    "its Jacobian cannot follow",
)  # of refusals
NUMBER = re.compile(r"-?\d+\.\d+(?:e[-+]?\d+)?")


def verdict(source, before=lambda: None):
    """(verdict, details): "equal", "warned", "refused", "difference", "no reference",
    "no module"."""
    try:
        theirs = outcome(source, "scipy")
    except TooMany:
        return "no reference", "SciPy makes too many calls"
    except Exception as error:  # an idiom that is no Python
        return "no module", f"{type(error).__name__}: {error}"
    if _method(source) in OWN and not _as_rk45(theirs, source):
        return "no reference", "RK45 of SciPy makes too many calls, or raises elsewhere"
    before()
    ours = outcome(source, "fastdyn")
    if _gives_up(theirs, source):
        return "no reference", "SciPy gives up"
    found = difference(ours, theirs, source)
    if found is not None and (_as_scipy_keeps(ours, source) or _raises_in_python(ours, source)):
        found = None
    if found is None:
        return ("warned" if ours.warned else "equal"), timing(ours, theirs)
    if _refused(ours, theirs) or _gave_up(ours, source):
        return "refused", str(ours.raised)
    if ours.warned:
        found += f"\n  it warned: {ours.warned[0][:200]}"
    return "difference", found


def never_ends(source):
    """Whether SciPy makes too many calls with noise of rounding's size: fastdyn may, too."""
    for noise in range(1, SAMPLES + 1):
        try:
            outcome(source, "scipy", noise=noise)
        except TooMany:
            return True
    return False


def _as_scipy_keeps(ours, source):
    """Whether fastdyn does what SciPy does with a buffer that a function returns and writes again.

    SciPy keeps such an array, and calls of the function between two steps change what was kept.
    """
    try:
        theirs = outcome(source, "scipy", keeps=True)
    except TooMany:
        return False
    return difference(ours, theirs, source) is None


def _raises_in_python(ours, source):
    """Whether the function raises in Python, too, where a method goes that SciPy lacks."""
    if _method(source) not in OWN or ours.raised is None:
        return False
    return _exceptions(ours, outcome(source, "python")) is None


def _gives_up(theirs, source):
    """Whether SciPy fails at a jump, or at an event whose function changed during the search."""
    if theirs.raised:
        return theirs.raised[1].startswith("f(a) and f(b) must have different signs")
    return bool(_other_tolerances(source)) and any(run[3] < 0 for run in theirs.runs)


def _method(source):
    how = re.search(r"^HOW = (.*)$", source, flags=re.M)
    return ast.literal_eval(how[1])["method"] if how else ""


def _as_rk45(theirs, source):
    """Whether RK45 goes where DOP853 does: it may slide along a jump, or meet what raises."""
    try:
        found = _by_rk45(source)
    except TooMany:
        return False
    return (found.raised is None) == (theirs.raised is None)


def _by_rk45(source):
    name = f"'method': {_method(source)!r}"
    return outcome(source.replace(name, "'method': 'RK45'"), "scipy")


def _gave_up(ours, source):
    """Whether fastdyn says that a method that SciPy lacks did not come to the end."""
    return _method(source) in OWN and any(run[3] < 0 for run in ours.runs)


def _refused(ours, theirs):
    """Whether fastdyn said that it does not do this, or that it stopped where SciPy raised."""
    if ours.raised is None:
        return theirs.raised and any(run[3] < 0 for run in ours.runs)
    return ours.raised[0] == "NoSeries" or any(part in ours.raised[1] for part in SENTENCES)


def timing(ours, theirs):
    """A note on a solve that took longer than it may."""
    slow = ours.seconds > 1.5 * theirs.seconds + 0.3
    return f"slow: {ours.seconds:.2f} s, SciPy {theirs.seconds:.2f} s" if slow else ""


def difference(ours, theirs, source):
    """What differs beyond rounding, in words; None if nothing does."""
    text = _exceptions(ours, theirs) or _left(ours, theirs) or _numbers(ours, theirs, None)
    if text is None:
        return None
    spread = []
    for noise in range(1, SAMPLES + 1):
        try:
            other = outcome(source, "scipy", noise=noise)
        except TooMany:
            continue
        if (other.raised is None) != (theirs.raised is None):
            return None  # rounding decides whether there is an exception
        spread.append(other)
    for rtol in _other_tolerances(source):
        with contextlib.suppress(TooMany):
            spread.append(outcome(source, "scipy", rtol=rtol))
    if _method(source) in OWN:  # of lower order, they stay farther from the solution
        with contextlib.suppress(TooMany):
            spread.append(_by_rk45(source))
    if _exceptions(ours, theirs) is not None:
        return text
    if _left(ours, theirs) is not None and all(_steps(o) == _steps(theirs) for o in spread):
        return text
    return _numbers(ours, theirs, spread)


def _other_tolerances(source):
    """Those that tell how far a method may be off that does not take SciPy's steps bit by bit."""
    method = _method(source)
    return () if method in EXPLICIT else (1e-5, 1e-10) if method in OWN else (3e-9, 1e-10)


def _steps(found):
    return [(len(t), events) for t, _, events, _ in found.runs]


def _exceptions(ours, theirs):
    if (ours.raised is None) != (theirs.raised is None):
        return f"raised {ours.raised}, SciPy {theirs.raised}"
    if ours.raised is None:
        return None
    same = ours.raised[0] == theirs.raised[0]
    if same and theirs.raised[2]:
        same = NUMBER.sub("#", ours.raised[1]) == NUMBER.sub("#", theirs.raised[1])
    return None if same else f"raised {ours.raised}, SciPy {theirs.raised}"


def _plain(text):
    """Without what NumPy calls its floats: `t` is Python's at SciPy's first call, NumPy's after."""
    return re.sub(r"np\.float64\(([^()]*)\)", r"\1", text)


def _left(ours, theirs):
    """What the functions left behind, where both made as many calls."""
    if ours.nfev != theirs.nfev or ours.left is None or theirs.left is None or ours.raised:
        return None
    if any(_stopped(*runs) for runs in zip(ours.runs, theirs.runs, strict=False)):
        return None  # what it left is as large as where it stopped
    same = NUMBER.sub("#", _plain(ours.left)) == NUMBER.sub("#", _plain(theirs.left))
    mine = [float(x) for x in NUMBER.findall(ours.left)]
    other = [float(x) for x in NUMBER.findall(theirs.left)]
    same = same and np.allclose(mine, other, rtol=1e-6, atol=1e-9, equal_nan=True)
    return None if same else f"left {ours.left[:150]}, SciPy {theirs.left[:150]}"


def _numbers(ours, theirs, spread):
    """Ends, numbers of steps and of events; `spread` are outcomes that differ by rounding alone."""
    if len(ours.runs) != len(theirs.runs):
        return f"{len(ours.runs)} solves, SciPy {len(theirs.runs)}"
    for j, (mine, other) in enumerate(zip(ours.runs, theirs.runs, strict=True)):
        if _stopped(mine, other):
            continue  # fastdyn says that it stopped, SciPy goes on with nan or stops, too
        around = [o.runs[j] for o in spread or [] if len(o.runs) > j]
        end = _end(mine, other, around)
        if end:
            return f"solve {j}: {end}"
    return None


def _stopped(mine, other):
    return mine[3] < 0 and (other[3] < 0 or not np.isfinite(other[1]).all())


def _end(mine, other, around):
    (t, y, events, status), (t0, y0, events0, status0) = mine, other
    if min(status, 0) != min(status0, 0):  # SciPy gives up at a jump where fastdyn gets over it
        return f"status {status}, SciPy {status0}; y {y}, SciPy {y0}"
    if np.shape(y) != np.shape(y0):
        return f"shape {np.shape(y)}, SciPy {np.shape(y0)}"
    scale = np.nanmax(np.abs(y0), initial=1e-3)
    allowed = GROWTH * EPS * scale
    for _, y1, _, _ in around:
        if np.shape(y1) == np.shape(y0):
            allowed = max(allowed, SPREAD * np.nanmax(np.abs(y1 - y0), initial=0))
    unequal = ~(np.abs(y - y0) <= allowed) & ~(np.isnan(y) & np.isnan(y0)) & (y != y0)
    if unequal.any():
        return f"y {y}, SciPy {y0}, allowed {allowed:.1e}"
    if events != events0 and all(e == events0 for _, _, e, _ in around):
        return f"events {events}, SciPy {events0}"
    steps = {len(t0), *[len(t1) for t1, *_ in around]}
    if len(t) and not min(steps) <= len(t) <= max(steps) and len(steps) == 1:
        return f"{len(t)} times, SciPy {len(t0)}, y {y}, SciPy {y0}"
    return None
