"""Functions drawn at random, by number: alike in names and shape, different in what they do."""

import random

TERMS = (
    "-{a} * y[{i}]",
    "{a} * math.sin({b} * y[{j}])",
    "-{a} * y[{i}] / (1 + y[{j}] * y[{j}])",
    "{a} * math.cos({n} * t)",
    "helper(y[{j}])",
    "inner({a} * y[{i}], {b})",
    "-abs({a} * y[{i}])",
    "{a} * np.tanh(y[{i}] - {b})",
    "looped(y[{i}], {n})",
    "-y[{i}] * p",
    "-y[{j}] * q / 4",
    "-y[{i}] * s[{k}]",
    "(-{a} * y[{i}] if t < {b} else -{b} * y[{i}])",
    "-y[{i}] * {n}",
    "-y[{i}] * G",
)
HELPERS = ("-{a} * x", "{a} - x", "math.sin({a} * x)", "x / (1 + {n} * x * x)", "-x * G")
RESULTS = ("[{}]", "({})", "np.array([{}])")
ARGUMENTS = ("{a}", "{n}", "True", "False", "-{b}")

MODULE = """
import math
import numpy as np

G = {g}


def helper(x):
    return {helper}


def make(c):
    def inner(x, b):
        return {closure}

    def looped(x, n):
        total = 0.0
        for i in range({first}, n + 1):
            total -= x * {step} / (i + 1)
        return total

    def fun(t, y, p, q, s):
        {lines}
        return {result}

    return fun


fun, args, y0 = make({c}), ({p}, {q}, np.array({s})), {y0}
"""


def source(number):
    """The text of a module with `fun`, `args` and `y0`."""
    rng = random.Random(number)

    def filled(template, n):
        i, j = rng.randrange(n), rng.randrange(n)
        return template.format(
            a=rng.choice((0.5, 1.0, 1.5, 2.0)), b=rng.choice((0.25, 0.5, 0.75)),
            n=rng.randint(1, 3), i=i, j=j, k=rng.randrange(3),
        )  # fmt: skip

    n = rng.choice((1, 2, 2, 3, 4))
    parts = [" + ".join(filled(rng.choice(TERMS), n) for _ in range(2)) for _ in range(n)]
    lines = [f"d{i} = {part}" for i, part in enumerate(parts)]
    names = ", ".join(f"d{i}" for i in range(n)) + ","
    return MODULE.format(
        g=rng.choice((0.5, 1.5)), helper=filled(rng.choice(HELPERS), n),
        closure=rng.choice(("-c * x + b", "c * x * b - x", "math.cos(c * x) - b", "b - c * x")),
        first=rng.randint(0, 1), step=rng.choice((1, 2, 0.5)), lines="\n        ".join(lines),
        result=rng.choice(RESULTS).format(names), c=rng.choice((1, 2, 0.5)),
        p=filled(rng.choice(ARGUMENTS), n), q=filled(rng.choice(ARGUMENTS), n),
        s=[rng.choice((0.5, 1.0, 2.0)) for _ in range(3)], y0=[1.0, 0.5, -0.5, 0.25][:n],
    )  # fmt: skip


def module(number):
    """The module as a namespace."""
    space = {"__name__": "drawn"}
    exec(compile(source(number), "drawn.py", "exec"), space)
    return space
