"""Arguments that a step must not move too far: see `recurrences/deceptive.py`.

For example, x must not reach zero if the function has sqrt(x^2) = |x|: beyond zero, the series
would continue as the series of x or -x.
"""

from ..recurrences.deceptive import held
from ..text.instructions import MINUS, hexadecimal
from .step import powers_of, sum_of


def some_held(rows):
    """True if a plan has such arguments."""
    return any(map(_concerned, rows.parts))


def _concerned(part):
    return any(held(step) is not None for step in part.steps)


def excess(rows, x):
    """Emit the largest excess of sum(|u_k| |x|^k), k > 0, over what the `Hold` of u allows."""
    text = rows.text
    powers = powers_of(text, text.intrinsic("fabs", x), rows.last)
    worst = text.slot(text.kind)
    text.store(MINUS, worst)

    def look(steps):
        for node, width, share in filter(None, map(held, steps)):
            terms = [text.load(rows.address(node, k)) for k in range(rows.last + 1)]
            first, *terms = [text.intrinsic("fabs", c) for c in terms]
            allowed = text.larger(text.mul(hexadecimal(share), first), hexadecimal(width))
            found = text.sub(sum_of(text, terms, powers, None), allowed)
            text.store(text.larger(found, text.load(worst)), worst)

    for part in filter(_concerned, rows.parts):
        rows.each(part, look)
    return text.load(worst)
