"""The frame of the kernels of one trajectory, ``int64 kernel(int64 *words)``.

The words are the arguments of ``advance(state, work, block, n_steps)``; see
`kernels/state/record.py`.
"""

from typing import Any

from fastdyn.kernels.state.record import (
    ATOL,
    FINISHED,
    RAISED,
    RTOL,
    STEP_TOO_SMALL,
    Y_OLD,
    Y,
)
from fastdyn.kernels.state.series import LOW, SCALE

from .steps.pace import Clock, longest, retry
from .text.frame import AT, FIELDS, WORDS, Kernel, counted, read_words
from .text.instructions import INFINITE, ONE, ZERO


class OneTrajectory(Kernel):
    """The base of the kernels: reads the record before the loop over steps, writes it after.

    A subclass has `text` and `n`, and memory for states and coefficients.  `_make_room` reads the
    states, ``_write(name, row)`` copies an array of states into a row of `work`, and
    `_write_series` copies all coefficients into rows of `work`.  `_raised` returns the truth value
    of "the function raises at the present time and state".
    """

    n: int
    _make_room: Any
    _write: Any
    _write_series: Any
    _raised: Any
    variables = ("t", "t_old", "h", "scale", "cap", "pending")
    counts = ("n_accepted", "n_rejected")

    def _begin(self):
        text = self.text
        read_words(text, WORDS)
        self.field = f = {name: text.load(text.at("%state", AT[name])) for name in FIELDS}
        ahead = text.mul(f["direction"], text.sub(f["t"], f["t_end"]))
        text.put(f"br i1 {text.compare('oge', ahead, ZERO)}, label %over, label %first")
        text.label("over")
        text.put(f"ret i64 {FINISHED}")
        text.label("first")
        self.var = {name: text.slot("double") for name in self.variables}
        given = {name: f[name] for name in ("t", "t_old", "h")}
        for name, value in {**given, "scale": ONE, "cap": INFINITE, "pending": ZERO}.items():
            text.store(value, self.var[name])
        self.count = {name: text.slot("i64") for name in self.counts}
        for place in self.count.values():
            text.put(f"store i64 0, ptr {place}")
        self.status = text.slot("i64")
        tolerances = [text.load(text.at("%work", row * self.n)) for row in (RTOL, ATOL)]
        self.tolerance = text.add(*tolerances)
        self._make_room()

    def _clock(self, t):
        """The Clock of a step, no longer than the cap."""
        text, f = self.text, self.field
        most = longest(text, t, f["t_start"], f["h_first"], f["h_max"])
        return Clock(t, f["t_end"], f["direction"], text.smaller(text.load(self.var["cap"]), most))

    def _retry(self, t, x, size, scale, hopeless="lost"):
        """Begin the step again with a shorter unit of time if the series needs one.

        If the unit is too short, the code continues at the label `hopeless`.
        """
        text = self.text
        again, shorter, short = retry(text, t, x, size, scale)
        text.put(f"br i1 {again}, label %again, label %fine")
        text.label("again")
        text.store(shorter, self.var["h"])
        text.put(f"br i1 {short}, label %{hopeless}, label %step")
        text.label("fine")

    def _leave(self):
        """Store the record and the rows before the kernel returns."""
        text, var = self.text, self.var
        text.label("lost")
        lost = text.new(f"select i1 {self._raised()}, i64 {RAISED}, i64 {STEP_TOO_SMALL}")
        text.put(f"store i64 {lost}, ptr {self.status}")
        self._write("y", Y_OLD)
        text.put("br label %leave")
        text.label("done")
        self._write_series()
        text.put("br label %leave")
        text.label("leave")
        self._write("y", Y)
        self._write("low", LOW)
        text.store(text.load(var["scale"]), text.at("%work", SCALE * self.n))
        for name in ("t", "t_old", "h"):
            text.store(text.load(var[name]), text.at("%state", AT[name]))
        for name, place in self.count.items():
            counted(text, text.at("%state", AT[name]), text.new(f"load i64, ptr {place}"))
        self._release()
        text.put(f"ret i64 {text.new(f'load i64, ptr {self.status}')}")

    def _release(self):
        """Release the memory, unless it is on the stack."""
