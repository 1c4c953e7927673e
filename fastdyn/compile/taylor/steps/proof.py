"""The proof of a step: function and series must have equal slopes at the end of the step.

The next step computes the slope at this point anyway, as the coefficient of order 1.  The next step
therefore also compares the slopes; if they differ, the step before is taken back.  After the last
step of a call, the function is called for its slope.

A series describes the function near one point.  A saturated tanh or a pulse looks constant at this
point: for such functions, slopes are also compared inside the step (see `deceptive.py`).
"""

from ..text.frame import counted, raised_word
from ..text.instructions import ONE, ZERO, hexadecimal
from .step import powers_of, sum_of

DOUBT = 40.0  # largest error of the slope times the step, in units of order times tolerance
WITHIN = 0.4375  # place of the inner evaluation, as a share of the step
SHORTER = 0.25  # factor of the length after a step without proof


def slope_of(text, coefficients, powers):
    """The slope of a series; `coefficients` begin with order 1."""
    first, *rest = coefficients
    terms = [text.mul(c, hexadecimal(k)) for k, c in enumerate(rest, 2)]
    return sum_of(text, terms, powers, first)


def slope_off(text, coefficients, powers, given, weight):
    """The error of the series' slope, in units of the tolerance; NaN if the slope is NaN.

    `given` is the function's slope in the unit of the series.
    """
    slope = slope_of(text, coefficients, powers)
    return text.mul(text.intrinsic("fabs", text.sub(given, slope)), weight)


def predict(driver, pace, x, inverse, cut):
    """Store the slopes that the series predicts at x, for `check`.

    `inverse` is one over the unit of the series.  `cut` is true if the step ends where the function
    may jump: then no slopes are compared.
    """
    _store_slopes(driver, x, inverse)
    text, allowed = driver.text, _allowed(driver, pace)
    text.store(allowed if cut is None else text.select(cut, ZERO, allowed), driver.var["pending"])


def _allowed(driver, pace):
    """The `allowed_share`, times the variable `finer`, which is 1 for a step along the series."""
    text = driver.text
    allowed = allowed_share(text, pace.h, driver.order)
    return text.mul(allowed, text.load(driver.var["finer"])) if driver.rooted else allowed


def allowed_share(text, h, order):
    """The factor that scales distances of slopes, in units of the tolerance, to 1 at the limit."""
    return text.mul(h, hexadecimal(1.0 / (DOUBT * order)))


def _store_slopes(driver, x, inverse):
    text, wide = driver.text, driver.text.of(4 if driver.n <= 4 else 8)
    powers = powers_of(wide, wide.splat(x, wide.lanes), driver.order - 1)
    inverse, orders = wide.splat(inverse, wide.lanes), range(1, driver.order + 1)
    for first in range(0, driver.row, wide.lanes):
        terms = [wide.load(wide.at(driver.rows, k * driver.row + first)) for k in orders]
        slope = wide.mul(slope_of(wide, terms, powers), inverse)
        wide.store(slope, text.at(driver.room["predicted"], first))


def _excess(driver, slopes, share):
    """The distance of slopes from the predicted slopes, in units of the allowed distance."""
    text, total = driver.text, None
    for i, slope in enumerate(slopes):
        predicted, weight = (
            text.load(text.at(driver.room[name], i)) for name in ("predicted", "weights")
        )
        off = text.intrinsic("fabs", text.sub(slope, predicted))
        total = text.fma(off, weight, total)
    return text.mul(total, share)


def _asked(driver):
    """The slopes that the function returned."""
    return [driver.text.load(driver.text.at(driver.out, i)) for i in range(driver.n)]


def within(driver, step, pace, x, inverse):
    """Compare the slopes of function and series inside the step, if the plan is deceptive.

    For any plan, compare the slopes of a step along a tangent.  The code continues at `seen` or at
    `doubtful`.
    """
    text, room = driver.text, driver.room
    if not (driver.deceptive or driver.rooted):
        return
    if not driver.deceptive:
        of_series = text.compare("oeq", text.load(driver.var["finer"]), ONE)
        text.put(f"br i1 {of_series}, label %seen, label %look")
        text.label("look")
    for i in range(driver.n):
        text.store(ZERO, text.at(room["probe_low"], i))
    inner = text.mul(x, hexadecimal(WITHIN))
    step.end(inner, room["probe"], room["probe_low"])
    _store_slopes(driver, inner, inverse)
    t = text.fma(pace.signed, hexadecimal(WITHIN), text.load(driver.var["t_old"]))
    raised = driver.asked(t, "probe")
    text.put(f"store i64 0, ptr {raised_word(text)}")
    off = text.compare("uge", _excess(driver, _asked(driver), _allowed(driver, pace)), ONE)
    text.put(f"br i1 {text.truths('or', off, raised)}, label %doubtful, label %seen")
    text.label("seen")


def check(driver, slopes):
    """Emit the comparison of the slopes at the start of a step with the predicted slopes.

    The code continues at `proved` or at `doubtful`.
    """
    text = driver.text
    text.put(f"br i1 {_differ(driver, slopes)}, label %doubtful, label %proved")
    text.label("proved")
    text.store(ZERO, driver.var["pending"])


def _differ(driver, slopes):
    """The truth value of "slopes are predicted, and the given slopes differ from them"."""
    text = driver.text
    pending = text.load(driver.var["pending"])
    off = text.compare("uge", _excess(driver, slopes, pending), ONE)
    return text.truths("and", off, text.compare("ogt", pending, ZERO))


def ask(driver, stops):
    """After the last step of a call, compare the function with the prediction."""
    text = driver.text
    text.put(f"br i1 {stops}, label %asking, label %step")
    text.label("asking")
    raised = driver.asked(text.load(driver.var["t"]))
    text.put(f"br i1 {raised}, label %lost, label %answered")
    text.label("answered")
    text.put(f"br i1 {_differ(driver, _asked(driver))}, label %doubtful, label %done")


def take_back(driver):
    """Emit the label `doubtful`: restore the state before the step, and shorten the step."""
    text = driver.text
    text.label("doubtful")
    for i in range(driver.n):
        for place in (text.at(driver.room["y"], i), driver.y[i]):
            text.store(text.load(text.at(driver.rows, i)), place)
        text.store(text.load(text.at(driver.room["low_old"], i)), text.at(driver.room["low"], i))
    back_to_start(driver)


def back_to_start(driver):
    """Emit the return to the time before a step: undo its counts, limit the next length."""
    text, var = driver.text, driver.var
    text.store(text.load(var["t_old"]), var["t"])
    text.store(ZERO, var["pending"])
    text.store(text.mul(text.load(var["h"]), hexadecimal(SHORTER)), var["cap"])
    counted(text, driver.count["n_rejected"])
    counted(text, driver.count["n_accepted"], -1)
    text.put("br label %step")
