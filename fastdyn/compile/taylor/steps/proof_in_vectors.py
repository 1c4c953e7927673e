"""The proof of `proof.py` for vectors of trajectories, and for vectors of like nodes."""

from ..text.instructions import ONE, ZERO, hexadecimal
from .proof import WITHIN, allowed_share, slope_off
from .step import powers_of


def unproved(driver, pace):
    """The lanes in which function and series differ in slope, at the end of the step or within."""
    text = driver.text
    x = text.div(pace.signed, text.load(driver.var["scale"]))
    looks = [(pace.t, driver.new, x)]
    if driver.deceptive:
        within = text.mul(x, hexadecimal(WITHIN))
        for i, (value, _) in enumerate(driver.states_at(within)):
            text.store(value, text.at(driver.probe, i * driver.width))
        t = text.fma(pace.signed, hexadecimal(WITHIN), text.load(driver.var["T"]))
        looks.append((t, driver.probe, within))
    share, unsure = allowed_share(text, text.intrinsic("fabs", x), driver.order), None
    for look in looks:
        far = text.compare("uge", text.mul(_off_in_lanes(driver, *look), share), ONE)
        unsure = far if unsure is None else text.truths("or", unsure, far)
    return unsure


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


def differ(driver, given, predicted):
    """A truth value: slopes of a large system differ from the array `predicted`.

    ``given(row, here)`` are the slopes of a vector.  No slopes differ without a `pending` step.
    """
    text, wide = driver.text, driver.wide
    pending = text.load(driver.var["pending"])
    places = [wide.slot(wide.kind) for _ in range(2)]
    for place in places:
        wide.store(ZERO, place)
    with driver.memory.each_vector() as (row, here):
        off = wide.sub(given(row, here), wide.load(here[predicted]))
        far = wide.mul(wide.intrinsic("fabs", off), wide.load(here["weights"]))
        for place, join in zip(places, (wide.larger, wide.add), strict=True):
            wide.store(join(far, wide.load(place)), place)
    largest, total = (wide.load(place) for place in places)
    far = text.mul(driver.across(largest, text.larger), pending)
    total = driver.across(total, text.add)  # NaN if a component is NaN
    off = text.truths("or", text.compare("uge", far, ONE), text.compare("uno", total, total))
    return text.truths("and", off, text.compare("ogt", pending, ZERO))
