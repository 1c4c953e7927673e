"""Crossings of events that are lost within steps, and the warning of them.

Methods whose results are SciPy's or MATLAB's count at most one occurrence of an event in a step.
Their kernels look inside the steps as those of other methods do, and note the first two crossings
that do not count, or an interval of zeros: see `TELLS` of `kernels/output/arguments.py`.  Python is
not called for a look: functions may have effects.  Events whose crossings all count are lost where
a step has more of them than there is room for.
"""

from fastdyn.compile.sentences import warn
from fastdyn.kernels.output.arguments import COUNTS, KEEPS, TELLS

from .switching import SwitchingWarning, place_told

LOST = "told of lost crossings"  # a key of a Function's notes
OWN = "'Tsit5', 'Vern9' or 'Rodas5P', which look"
FLAT = (
    "`{}` is exactly zero over an interval around t = {:.10g}. {} takes the ends of its steps "
    "there for occurrences, as SciPy does, not the ends of the interval: take {} inside the steps."
)
FAST = (
    "`{}` changes too fast for the steps of {}: one of them was looked at up to t = {:.10g}, and "
    "the crossings of zero behind are lost. Give `max_step={:.2g}`."
)
SHORTER = 0.9  # share of a distance; no step of this length, rounded, contains both ends


def look_for_lost(table, problem, bounds, others):
    """Let the EVENTS records note crossings that are lost; whether any of them does.

    `others` are the functions that are called between steps, first those of the events.
    """
    p = problem
    tells = not any(each.function is None for each in bounds)
    for row, bound in zip(table, others, strict=False):
        if row["inside"] == COUNTS or not tells:
            continue
        told = place_told(bound, p.method, LOST) in bound.function.notes
        row["inside"] = KEEPS if told else TELLS
    return bool((table["inside"] != KEEPS).any())


def tell_lost(problem, others, table, image):
    """Warn, once a function and method, of the crossings that the records of `table` have noted.

    Neither `table` nor the `image` of the next solve notes more of an event that is told.
    """
    p = problem
    for i, bound in enumerate(others[: len(table)]):
        a = float(table["lost"][i])
        b = float(table["lost_next"][i])
        if not a == a or (a == b and p.method.like_matlab):  # refused by `fastdyn.matlab`
            continue
        counts = table["inside"][i] == COUNTS
        if not counts:
            table["inside"][i] = image["inside"][i] = KEEPS
        place = place_told(bound, p.method, LOST)
        notes = {} if bound.function is None else bound.function.notes
        if place in notes:
            continue
        notes[place] = True
        name = p.events[i].name or "an event function"
        advice = "'Rodas5P', which looks" if p.mass is not None else OWN
        if counts:
            warn(FAST.format(name, place[1], a, SHORTER * abs(a - b)), SwitchingWarning)
            continue
        if a == b:
            warn(FLAT.format(name, a, place[1], advice), SwitchingWarning)
            continue
        both = f"t = {a:.10g}"
        shorter = ""
        if b == b:
            both = f"{both} and t = {b:.10g}"
            shorter = f"{SHORTER * abs(b - a):.2g}"
        warn(
            f"`{name}` crosses zero at {both}, within one step of {place[1]}, which counts at most "
            f"one occurrence in a step: events are lost. Take {advice} inside the steps, or give "
            f"`max_step={shorter}`.",
            SwitchingWarning
        )  # fmt: skip
