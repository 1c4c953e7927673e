"""The proof of `proof.py` for vectors of trajectories, and for vectors of like nodes."""

from fastdyn.kernels.state.record import STAGE

from ..text.frame import raised_word
from ..text.instructions import ONE, ZERO, hexadecimal
from .proof import WITHIN, allowed_share, back_to_start, slope_of, slope_off
from .step import across, end, powers_of


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
    """The truth value of "slopes of a large system differ from the array `predicted`".

    ``given(row, here)`` returns the slopes of a vector.  Without a `pending` step, the value is
    false.
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
    far = text.mul(across(wide, largest, text.larger), pending)
    total = across(wide, total, text.add)  # NaN if a component is NaN
    off = text.truths("or", text.compare("uge", far, ONE), text.compare("uno", total, total))
    return text.truths("and", off, text.compare("ogt", pending, ZERO))


def look(driver, x, inverse):
    """Store the state and the slope within a step of length x; `inverse` is 1 over its unit."""
    wide, width = driver.wide, driver.width
    powers = driver.powers(driver.text.mul(x, hexadecimal(WITHIN)))
    inverse = wide.splat(inverse, width)
    with driver.memory.each_vector() as (row, here):
        terms = [wide.load(wide.at(row, k * width)) for k in range(driver.order + 1)]
        wide.store(end(wide, terms, powers, ZERO)[0], here["probe"])
        wide.store(wide.mul(slope_of(wide, terms[1:], powers), inverse), here["inner"])


def compare(driver, name, t, predicted):
    """Compare the function's slopes at the state `name` with the predicted slopes.

    If the slopes differ, or if the function raises, the code continues at `doubtful`.
    """
    text, wide = driver.text, driver.wide
    raised = driver.raised(name, t)
    text.put(f"store i64 0, ptr {raised_word(text)}")
    driver.memory.read(STAGE, "slope")
    off = differ(driver, lambda row, here: wide.load(here["slope"]), predicted)
    text.put(f"br i1 {text.truths('or', off, raised)}, label %doubtful, label %{name}_alike")
    text.label(f"{name}_alike")


def take_back(driver):
    """Emit the label `doubtful`: restore the state before the step, and shorten the step."""
    text, wide = driver.text, driver.wide
    text.label("doubtful")
    with driver.memory.each_vector() as (_, here):
        for name in ("y", "low"):
            wide.store(wide.load(here[f"{name}_old"]), here[name])
    back_to_start(driver)
