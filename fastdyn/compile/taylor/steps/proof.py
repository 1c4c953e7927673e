"""The proof of a step: function and series must have equal slopes within the step and at its end.

A series describes the function near one point.  A saturated tanh, a pulse, or a power that vanishes
looks constant at that point; an evaluation of the function elsewhere detects the difference.
"""

from ..text.frame import counted, raised_word
from ..text.instructions import ONE, ZERO, hexadecimal
from .accuracy import ALLOWANCE
from .step import powers_of, sum_of

DOUBT = 20.0  # ratio of the allowed error of the slope to the error from terms in tolerance
WITHIN = 0.4375  # place of the inner evaluation, as a share of the step
SHORTER = 0.25  # share of a step that is not proved
INFINITE = hexadecimal(float("inf"))


def slope_off(text, coefficients, powers, given, weight):
    """The error of the series' slope, in units of the tolerance; NaN if the slope is NaN.

    `coefficients` begin with order 1.  `given` is the function's slope in the unit of the series.
    """
    first, *rest = coefficients
    terms = [text.mul(c, hexadecimal(k)) for k, c in enumerate(rest, 2)]
    slope = sum_of(text, terms, powers, first)
    return text.mul(text.intrinsic("fabs", text.sub(given, slope)), weight)


def believed(text, off, x, order):
    """The error of the slope over a length of x, in units of the allowed error."""
    off = text.mul(text.intrinsic("fabs", x), off)
    return text.mul(off, hexadecimal(1.0 / (DOUBT * order * ALLOWANCE[order])))


def _excess(driver, x, share, scale):
    """The error of the slope at a share of a step, in units of the allowed error.

    `driver.out` has the derivative at that point; x is the step's length in units of `scale`.
    """
    text, wide = driver.text, driver.text.of(4 if driver.n <= 4 else 8)
    at = wide.splat(text.mul(x, hexadecimal(share)), wide.lanes)
    powers, found = powers_of(wide, at, driver.order - 1), []
    for first in range(0, driver.row, wide.lanes):
        orders = range(1, driver.order + 1)
        terms = [wide.load(wide.at(driver.rows, k * driver.row + first)) for k in orders]
        given = wide.mul(wide.load(wide.at(driver.out, first)), wide.splat(scale, wide.lanes))
        weight = wide.load(wide.at(driver.room["weights"], first))
        far = slope_off(wide, terms, powers, given, weight)
        found += [
            text.new(f"extractelement {wide.kind} {far}, i64 {i}")
            for i in range(min(wide.lanes, driver.n - first))
        ]
    total = found[0]
    for each in found[1:]:
        total = text.add(total, each)
    found = believed(text, total, x, driver.order)
    return text.mul(found, text.load(driver.var["finer"])) if driver.rooted else found


def _within(driver, step, pace, x, scale):
    """Evaluate the function at a point within the step."""
    text, room = driver.text, driver.room
    for i in range(driver.n):
        text.store(ZERO, text.at(room["probe_low"], i))
    step.end(text.mul(x, hexadecimal(WITHIN)), room["probe"], room["probe_low"])
    t = text.fma(pace.signed, hexadecimal(WITHIN), text.load(driver.var["t"]))
    raised = driver.asked(t, "probe")
    word = raised_word(text)
    text.put(f"store i64 0, ptr {word}")
    off = text.compare("uge", _excess(driver, x, WITHIN, scale), ONE)
    text.put(f"br i1 {text.truths('or', off, raised)}, label %doubtful, label %seen")
    text.label("seen")


def emit(driver, step, pace, x, scale, cut):
    """Emit the proof: go on to the label `proved`, or back to `step` for a shorter step.

    `cut` is true if the step ends where the function may jump.
    """
    text, var = driver.text, driver.var
    _within(driver, step, pace, x, scale)
    raised = driver.asked(pace.t)
    text.put(f"br i1 {raised}, label %lost, label %answered")
    text.label("answered")
    off = _excess(driver, x, 1.0, scale)
    doubtful = text.compare("uge", off, ONE)
    if cut is not None:
        doubtful = text.truths("and", doubtful, text.truths("xor", cut, "true"))
    text.put(f"br i1 {doubtful}, label %doubtful, label %proved")
    text.label("doubtful")
    for i in range(driver.n):
        text.store(text.load(text.at(driver.rows, i)), text.at(driver.room["y"], i))
        text.store(text.load(text.at(driver.room["low_old"], i)), text.at(driver.room["low"], i))
    text.store(text.mul(pace.h, hexadecimal(SHORTER)), var["cap"])
    counted(text, driver.refused)
    text.put("br label %step")
    text.label("proved")
    text.store(INFINITE, var["cap"])
