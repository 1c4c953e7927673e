"""Why a trajectory ended: SciPy's status, and a sentence."""

from fastdyn.kernels.state.record import (
    BAD_JUMP,
    EVENT,
    FINISHED,
    INTERRUPTED,
    RAISED,
    STEP_LIMIT,
    STEP_TOO_SMALL,
)
from fastdyn.run.outcome import SENTENCES as IN_WORDS
from fastdyn.run.outcome import SUCCESS, TERMINATED, TOO_SMALL

CODES = {FINISHED: 0, EVENT: 1, INTERRUPTED: -2}  # SciPy's, and -1 for every failure


SENTENCES = {status: text.format(t="t = {t:.10g}") for status, text in IN_WORDS.items()} | {
    FINISHED: SUCCESS,
    EVENT: TERMINATED,
    INTERRUPTED: "Interrupted before it was done.",
    STEP_TOO_SMALL: TOO_SMALL + " At t = {t:.10g} no step is short enough for the tolerance.",
    RAISED: "A function raised an exception after t = {t:.10g}.",
    BAD_JUMP: "`on_event` returned nan or inf at t = {t:.10g}.",
    STEP_LIMIT: "`max_steps` was reached at t = {t:.10g}.",
}
