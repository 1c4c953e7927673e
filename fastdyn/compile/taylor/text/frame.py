"""The common frame of the kernels: words, the record, counts of steps."""

from typing import Any

from fastdyn.kernels.state.record import FINISHED, RUNNING, STATE

from ...function_convention import call_as_text, raised_word_as_text
from .instructions import ZERO, hexadecimal

AT = {name: STATE.fields[name][1] // 8 for name in STATE.names}
FIELDS = (
    "t", "t_old", "t_end", "t_stop", "t_start", "direction", "h", "h_max", "h_first", "h_short",
)  # fmt: skip
WORDS = {"state": (0, "ptr"), "work": (2, "ptr"), "block": (5, "ptr"), "n_steps": (7, "i64")}
RETRY = 0.125  # factor of a step's length if the function raises at the step's end
HALF = 0.5  # factor of a step's length if the argument of a root may touch zero


class Kernel:
    """The base of kernels: the loop over steps, between `_begin` and `_leave`.

    `_begin` reads the record of the solve, `_leave` writes the record.  A subclass also has `text`,
    and `_step`, which emits the code at the label %step.
    """

    text: Any
    _begin: Any
    _step: Any
    _leave: Any

    def __call__(self, symbol, declared):
        """LLVM's text: the kernel, which calls ``fastdyn_invariants(block, out)``."""
        self._begin()
        self.text.put("br label %step")
        self.text.label("step")
        self._step()
        self._leave()
        return listing(self.text, symbol, declared, self._functions())

    def _functions(self) -> list[str]:
        """The texts of the functions that the kernel calls."""
        return []


def read_words(text, words):
    """Name the words of a kernel; `words` has {name: (index, type)}."""
    for name, (at, kind) in words.items():
        text.put(f"%at_{name} = getelementptr i64, ptr %words, i64 {at}")
        text.put(f"%{name} = load {kind}, ptr %at_{name}")


def invariants(text, invariants):
    """A function ``invariant(node)``, the value of a constant or of one of the `invariants`.

    `invariants` is as in `Plan`.
    """
    places = {key: i for i, key in enumerate(invariants)}
    room = text.slot("double", max(len(places), 1))
    text.put(f"call void @fastdyn_invariants(ptr %block, ptr {room})")
    values = {key: text.load(text.at(room, i)) for key, i in places.items()}
    return lambda node: hexadecimal(node.data) if node.op == "const" else values[node.key]


def counted(text, place, more=1):
    """Add to an integer in memory; return the new value."""
    count = text.new(f"add i64 {text.new(f'load i64, ptr {place}')}, {more}")
    text.put(f"store i64 {count}, ptr {place}")
    return count


def step_taken(driver, t, pace):
    """Count a step from t, and keep the status after it; return whether the call ends there."""
    text, var, field = driver.text, driver.var, driver.field
    for name, value in (("t_old", t), ("t", pace.t), ("h", pace.h)):
        text.store(value, var[name])
    count = counted(text, driver.count["n_accepted"])
    past = text.mul(field["direction"], text.sub(pace.t, field["t_stop"]))
    past = text.compare("oge", past, ZERO)
    short = text.compare("olt", pace.h, field["h_short"])
    past = text.new(f"or i1 {past}, {short}")
    enough = text.new(f"icmp sge i64 {count}, %n_steps")
    stop = text.new(f"or i1 {text.new(f'or i1 {past}, {enough}')}, {pace.ends}")
    status = text.new(f"select i1 {pace.ends}, i64 {FINISHED}, i64 {RUNNING}")
    text.put(f"store i64 {status}, ptr {driver.status}")
    return stop


def asked(text, t, y, n, out):
    """Call the function at a time and state; return the truth value of "the function raises".

    The derivative goes to `out`.
    """
    function = text.new("load ptr, ptr %block")
    text.new(call_as_text(function, t, y, n, out))
    return text.new(f"icmp ne i64 {text.new(f'load i64, ptr {raised_word(text)}')}, 0")


def raised_word(text):
    """The address of the word that marks an exception of the function."""
    return text.new(raised_word_as_text())


def listing(text, symbol, declared, others=()):
    """LLVM's text of the kernel, after other functions, without the declarations in `declared`."""
    body = text.kernel(symbol)
    heads = [line for name, line in text.declarations.items() if name not in declared]
    return "\n".join([*heads, *others, body])
