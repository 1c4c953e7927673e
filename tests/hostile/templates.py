"""The text of an idiom: parts of a module with gaps, which a draw fills.

    == name flag ...          one idiom; it sets `k`, a number of moderate size
    lines of the module
    --                        lines of the function
    -- change                 lines of ``change(i)``, which others call during a solve or between
    -- params                 names of further parameters; the module then assigns `args`
    -- watch                  an expression that tells what was left behind

Gaps: ``$a`` to ``$h`` numbers, ``$i`` to ``$m`` small whole numbers, ``$p`` ``$q`` values that a
solution passes, ``$r`` ``$s`` scales of an index, ``$x`` ``$y`` ``$z`` numbers of the state or the
time, ``$K`` ``$L`` keys, ``$N`` ``$M`` names; the same letter is the same value throughout an
idiom.  ``«one¦another»`` is one of the alternatives.

Flags: "module" (it must stand in a module, not in a closure), "explicit" (its value depends on
the number of calls), "real" (nothing else may be drawn into the function).
"""

import functools
import pathlib
import re
from typing import NamedTuple

FOLDER = pathlib.Path(__file__).parent / "idioms"
NAMES = ("box", "state", "cfg", "flags", "store", "ctl", "env", "Q", "it", "_p")
KEYS = ("k", "on", "gain", "rate", "mode", "value", "K", "c_d")
SEEN = (  # what a decision may look at
    "t", "y[0]", "y[0]", "abs(y[0])", "float(y[0])", "y[-1]", "2 * t", "(t + y[0])", "(3.0 - t)",
    "y[0] * y[0]", "np.sqrt(abs(y[0]))", "y.max()", "np.abs(y).sum()", "(y[0] - y[-1] + t)",
)  # fmt: skip
GAP, CHOICE = re.compile(r"\$([a-zA-Z])"), re.compile("«([^«»]*)»")


class Idiom(NamedTuple):
    """An idiom before a draw."""

    family: str
    name: str
    flags: frozenset
    parts: dict


def parsed(family, text):
    """The idioms of a text."""
    found = []
    for block in re.split(r"^== ", text, flags=re.M)[1:]:
        first, _, rest = block.partition("\n")
        name, *flags = first.split()
        parts, part = {"setup": [], "body": []}, "setup"
        for line in rest.splitlines():
            if line.startswith("--"):
                part = line[2:].strip() or "body"
                parts.setdefault(part, [])
            else:
                parts[part].append(line)
        parts = {key: "\n".join(lines).strip("\n") for key, lines in parts.items()}
        found.append(Idiom(family, name, frozenset(flags), parts))
    return found


@functools.cache
def all_idioms():
    """Those of all files of the folder."""
    files = sorted(FOLDER.glob("*.txt"))
    return [idiom for file in files for idiom in parsed(file.stem, file.read_text("utf-8"))]


def filled(idiom, draw):
    """The parts of an idiom with every gap and every choice drawn."""
    values, names = {}, list(NAMES)
    draw.shuffle(names)

    def value(match):
        letter = match[1]
        if letter not in values:
            values[letter] = _drawn(letter, draw, names)
        return values[letter]

    def one(text):
        while CHOICE.search(text):
            text = CHOICE.sub(lambda match: draw.choice(match[1].split("¦")), text)
        return GAP.sub(value, text)

    return {key: one(text) for key, text in idiom.parts.items()}


def _drawn(letter, draw, names):
    if letter in "abcdefgh":
        return str(round(draw.uniform(0.3, 2.9), draw.choice([1, 2, 3])))
    if letter in "ijklm":
        return str(draw.randint(1, 4))
    if letter in "pq":
        return str(round(draw.uniform(0.4, 1.6), 2))
    if letter in "rs":
        return str(draw.choice([1, 2, 3, 4, 5, 1.5, 2.5, 10]))
    if letter in "xyz":
        return draw.choice(SEEN)
    if letter in "KL":
        return draw.choice(KEYS)
    return names.pop()
