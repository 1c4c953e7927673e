"""Euler steps past a zero of a root's argument, which the Taylor series does not pass.

Close to a zero of a root's argument (an emptied tank) the series reaches no farther than the zero,
and at the zero there is no series.  If the step of the series is shorter than SHARE of the time
behind or ahead, the step goes along the tangent instead, as far as the slope stays constant within
the tolerance.
"""

from ..text.instructions import INFINITE, ONE, ZERO, hexadecimal
from .pace import longest, unit_of
from .proof import DOUBT

SHARE = 2.0**-30  # least step of the series, as a share of the time behind or ahead
MOST = 2.0**-10  # longest tangent step, which detects no kinks, as a share of this time
GAIN = 4.0  # least ratio of the tangent step to the step of the series
# The values of a step along the series or along the tangent.
VARIABLES = "signed", "later", "length", "ends", "cut", "finer", "reached"
FINER = 4.0  # ratio of the tolerance to the allowed error of the slope


def choose(driver, t, pace, cut):
    """Keep the step of the series and go on to `go`, or to `coarse` if that step is hopeless."""
    text = driver.text
    for name, value in (("signed", pace.signed), ("later", pace.t), ("length", pace.h)):
        text.store(value, driver.var[name])
    for name, truth in (("ends", pace.ends), ("cut", cut)):
        text.store(ZERO if truth is None else text.select(truth, ONE, ZERO), driver.var[name])
    text.store(text.select(pace.stuck, ZERO, pace.h), driver.var["reached"])
    text.store(ONE, driver.var["finer"])
    least = text.mul(_span(driver, t), hexadecimal(SHARE))
    hopeless = text.truths("or", pace.stuck, text.compare("olt", pace.h, least))
    text.put(f"br i1 {hopeless}, label %coarse, label %go")


def _span(driver, t):
    """The time behind, or the time ahead if that is longer and finite."""
    text, f = driver.text, driver.field
    spans = [text.intrinsic("fabs", text.sub(t, f[name])) for name in ("t_start", "t_end")]
    behind, ahead = [text.select(text.compare("olt", s, INFINITE), s, ZERO) for s in spans]
    return text.larger(behind, ahead)


def emit(driver, step, t):
    """Take a tangent step if GAIN times as long as the step of the series; continue at `go`.

    If no tangent step is taken and the step of the series is 0, continue at `lost`.
    """
    text, var, f, n = driver.text, driver.var, driver.field, driver.n
    text.label("coarse")
    cap = longest(text, t, f["t_start"], f["h_first"], f["h_max"])
    most = text.mul(_span(driver, t), hexadecimal(MOST))
    length = text.smaller(text.smaller(text.load(var["cap"]), cap), most)
    left = text.sub(f["t_end"], t)
    ends = text.compare("oge", length, text.intrinsic("fabs", left))
    signed = text.select(ends, left, text.mul(length, f["direction"]))
    later = text.select(ends, f["t_end"], text.add(t, signed))
    signed = text.sub(later, t)
    length = text.intrinsic("fabs", signed)
    reached = text.load(var["reached"])
    gains = text.compare("ogt", length, text.mul(reached, hexadecimal(GAIN)))
    text.put(f"br i1 {gains}, label %tangent, label %reaches")
    text.label("reaches")
    text.put(f"br i1 {text.compare('ogt', reached, ZERO)}, label %go, label %lost")
    text.label("tangent")
    text.put(f"br i1 {driver.asked(t)}, label %lost, label %known")
    text.label("known")
    unit = unit_of(text, length)
    for i in range(n):
        slope = text.mul(text.load(text.at(driver.out, i)), unit)
        text.store(slope, text.at(driver.rows, driver.row + i))
    text.clear(text.at(driver.rows, 2 * driver.row), (driver.order - 1) * driver.row)
    room = driver.room
    step.weights(room["y"], room["rtol"], room["atol"], room["weights"])
    kept = {"signed": signed, "later": later, "length": length, "scale": unit, "cut": ZERO}
    kept["ends"] = text.select(ends, ONE, ZERO)
    kept["finer"] = hexadecimal(FINER * DOUBT * driver.order)
    for name, value in kept.items():
        text.store(value, var[name])
    text.put("br label %go")


def taken(driver, pace):
    """The Pace of the chosen step, its unit of time, and whether a change of sign cut the step."""
    text, var = driver.text, driver.var
    signed, later, length = (text.load(var[name]) for name in ("signed", "later", "length"))
    ends, cut = (text.compare("une", text.load(var[name]), ZERO) for name in ("ends", "cut"))
    return pace._replace(h=length, signed=signed, t=later, ends=ends), text.load(var["scale"]), cut
