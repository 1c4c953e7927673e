"""The proof of `proof.py` for vectors of trajectories, and for vectors of like nodes."""

from fastdyn.kernels.state import record

from ..text.instructions import ONE, ZERO, hexadecimal
from .proof import WITHIN, believed, slope_off
from .step import powers_of


def unproved(driver, pace):
    """The lanes in which function and series differ in slope, within or at the end of the step."""
    text = driver.text
    x = text.div(pace.signed, text.load(driver.var["scale"]))
    within = text.mul(x, hexadecimal(WITHIN))
    for i, (value, _) in enumerate(driver.states_at(within)):
        text.store(value, text.at(driver.probe, i * driver.width))
    t = text.fma(pace.signed, hexadecimal(WITHIN), text.load(driver.var["T"]))
    looks = (t, driver.probe, within), (pace.t, driver.new, x)
    found = [_off_in_lanes(driver, *look) for look in looks]
    found = [believed(text, total, x, driver.order) for total in found]
    return text.truths("or", *[text.compare("uge", far, ONE) for far in found])


def _off_in_lanes(driver, t, states, x):
    """The errors of the slopes at x, combined over all components."""
    text, width, total = driver.text, driver.width, None
    powers = powers_of(text, x, driver.order - 1)
    given = f"{text.kind} {t}, ptr {states}, ptr %block, ptr {driver.slopes}"
    text.put(f"call void @fastdyn_slopes({given})")
    for i, place in enumerate(driver.state_rows):
        terms = [text.load(text.at(place, k * width)) for k in range(1, driver.order + 1)]
        slope, weight = (text.load(text.at(p, i * width)) for p in (driver.slopes, driver.weights))
        slope = text.mul(slope, text.load(driver.var["scale"]))
        total = text.add(slope_off(text, terms, powers, slope, weight), total)
    return total


def off(driver, x, share):
    """A truth value: the slope of a large system is wrong at a share of a step of length x.

    The row STAGE has the slope that the function returned.
    """
    text, wide, width = driver.text, driver.wide, driver.width
    at, scale = (
        wide.splat(value, width)
        for value in (text.mul(x, hexadecimal(share)), text.load(driver.var["scale"]))
    )
    powers = powers_of(wide, at, driver.order - 1)
    driver.memory.read(record.STAGE, "slope")
    places = [wide.slot(wide.kind) for _ in range(2)]
    for place in places:
        wide.store(ZERO, place)
    with driver.memory.each_vector() as (row, here):
        terms = [wide.load(wide.at(row, k * width)) for k in range(1, driver.order + 1)]
        given = wide.mul(wide.load(here["slope"]), scale)
        far = slope_off(wide, terms, powers, given, wide.load(here["weights"]))
        for place, join in zip(places, (wide.larger, wide.add), strict=True):
            wide.store(join(far, wide.load(place)), place)
    largest, total = (wide.load(place) for place in places)
    far = believed(text, driver.across(largest, text.larger), x, driver.order)
    total = driver.across(total, text.add)  # NaN if a component is NaN
    return text.truths("or", text.compare("uge", far, ONE), text.compare("uno", total, total))
