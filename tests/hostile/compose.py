"""A case: a module with a function, made of one or two idioms, and how it is solved."""

import ast
import random
import re
import textwrap
from typing import NamedTuple

from .solvers import EXPLICIT, OWN
from .templates import all_idioms, filled

HEADER = """import abc, bisect, collections, contextlib, contextvars, copy, dataclasses, decimal
import enum, fractions, functools, gc, heapq, itertools, json, math, numbers, operator, re
import statistics, string, types, typing, weakref
import numpy as np
import scipy.interpolate
"""
METHODS = ["RK45"] * 6 + ["DOP853", "DOP853", "RK23", "RK23", "LSODA", "Radau", "BDF", *OWN]
CHANGING = ("again", "again", "again", "event", "event", "callback", "stepper", "on_event",
            "prepare", "fun", "pieces", "twins")  # fmt: skip
STEADY = ("once", "once", "once", "once", "elsewhere", "elsewhere", "prepare", "ensemble", "events",
          "dense", "backward", "complex", "terminal", "times", "matrix")  # fmt: skip
LONG = (64, 64, 65, 80, 130)  # lengths of long states
QUICK = ("once", "once", "elsewhere", "dense")


class Case(NamedTuple):
    """The source of a module, and the names of what it was made of."""

    number: str
    name: str
    source: str


def draw_case(seed, index, light=False, family=""):
    """Case `index` of a seed: each idiom has its turn, the rest is drawn; `light` are quick.

    With `family`, the idioms of one file only.
    """
    found = [idiom for idiom in all_idioms() if family in ("", idiom.family)]
    turn, place = divmod(index, len(found))
    order = random.Random(f"{seed}.{turn}").sample(range(len(found)), len(found))
    draw = random.Random(f"{seed}:{index}")
    chosen = [found[order[place]]]
    other = draw.choice(found)
    alone = {"real", "module"} & (chosen[0].flags | other.flags)
    if draw.random() < 0.25 and not alone and "long" not in chosen[0].flags ^ other.flags:
        chosen.append(other)
    parts = [filled(idiom, draw) for idiom in chosen]
    if len(parts) == 2 and (_names(parts[0]) & _names(parts[1]) or "params" in parts[1]):
        del parts[1], chosen[1]
    flags = frozenset().union(*[idiom.flags for idiom in chosen])
    name = " + ".join(f"{idiom.family}.{idiom.name}" for idiom in chosen)
    return Case(f"{seed}:{index}", name, _module(parts, flags, light, draw))


def _names(parts):
    """Names that the module of an idiom binds or its function assigns."""
    text = "\n".join([parts["setup"], parts["body"], parts.get("change", "")])
    return set(re.findall(r"[A-Za-z_]\w*", re.sub(r"(\"[^\"]*\"|'[^']*')", "", text))) & set(
        re.findall(r"^\s*(?:def |class |for )?([A-Za-z_]\w*)\b", text, flags=re.M)
    ) - {"k", "try", "except", "if", "else", "for", "return", "with", "elif", "finally", "np"}


def _module(parts, flags, light, draw):
    changes = [p["change"] for p in parts if p.get("change")]
    params = ", ".join(p["params"] for p in parts if p.get("params"))
    own = f"t, y, {params}" if params else "t, y"
    n = draw.choice(LONG if "long" in flags else [1, 1, 2, 2, 3, 4, 6])
    setup = "\n".join(p["setup"] for p in parts if p["setup"])
    if "long" in flags:
        setup = f"len0 = {n}\n{setup}"
    body = _body(parts, draw, own, "real" in flags)
    out, extra = _result(n, draw, flags)
    setup = "\n".join(filter(None, [setup, extra, *body[0]]))
    text = f"def fun({own}):\n" + textwrap.indent("\n".join([*body[1], out]), "    ")
    watch = ", ".join(p["watch"] for p in parts if p.get("watch"))
    how = _how(n, bool(changes), flags, light, draw)
    after = _after("\n".join(changes), watch, how, draw, "event" in flags)
    if not params and "module" not in flags and draw.random() < 0.3:
        lines = "\n".join([setup, text, after, "return fun, change, watched, hook"])
        lines = re.sub(r"^(\s*)global ", r"\1nonlocal ", lines, flags=re.M)
        text = f"def make():\n{textwrap.indent(lines, '    ')}\n"
        text += "\nfun, change, watched, hook = make()"
    else:
        text = "\n".join([setup, _wrapped(text, own, draw), after])
    return f"{HEADER}\n{text}\n\nHOW = {how!r}\n"


def _body(parts, draw, own, returns):
    """(lines of the module, lines of the function): inline, or, unless they return, in others."""
    outside, inside, given = [], [], own
    for j, part in enumerate(parts):
        if not returns and (draw.random() < 0.3 or len(parts) > 1):
            indented = textwrap.indent(part["body"], "    ")
            outside.append(f"def part{j}({own}):\n{indented}\n    return k")
            inside.append(f"k{j} = part{j}({given})")
        else:
            inside.append(part["body"])
    if len(parts) == 2:
        inside.append("k = " + draw.choice(["k0 + k1", "k0 if t < 1.1 else k1", "0.5 * k0 + k1"]))
    elif outside:
        inside.append("k = k0")
    return outside, inside


def _result(n, draw, flags):
    """The line that returns n rates, and what it needs in the module."""
    if "long" in flags:
        return _long_result(draw)
    c = [round(draw.uniform(0.2, 1.8), 1) for _ in range(n + 2)]
    first = draw.choice(["-k * y[0]", f"k - {c[0]} * y[0]", f"-{c[0]} * y[0] + 0.2 * k"])
    rates = [first] + [f"y[{i - 1}] - {c[i]} * y[{i}]" for i in range(1, n)]
    if n == 2 and draw.random() < 0.6:
        rates = ["y[1]", f"-k * y[0] - {c[0]} * y[1]"]
    all_of = ", ".join(rates)
    forms = [f"return [{all_of}]"] * 4 + [
        f"return ({all_of},)", f"return np.array([{all_of}])", f"return np.hstack([{all_of}])",
        f"dy = np.zeros({n})\ndy[:] = {all_of.replace('k', 'k', 1)}\nreturn dy",
    ]  # fmt: skip
    form = draw.choice(forms)
    if n == 1 and "dy[:]" in form:
        form = f"dy = np.zeros(1)\ndy[0] = {rates[0]}\nreturn dy"
    if draw.random() < 0.08 and "real" not in flags:
        lines = "\n".join(f"buffer[{i}] = {rate}" for i, rate in enumerate(rates))
        return f"{lines}\nreturn buffer", f"buffer = np.zeros({n})"
    return form, ""


def _long_result(draw):
    """The line that returns the rates of a long state."""
    c = round(draw.uniform(0.2, 1.8), 1)
    rates = draw.choice([
        f"k - {c} * y", "0.3 * k * (1 - y)", "np.roll(y, 1) - y + 0.2 * k", f"-{c} * y * (0.3 + k)",
    ])  # fmt: skip
    forms = [f"return {rates}"] * 4 + [
        f"return list({rates})", f"dy = np.empty_like(y)\ndy[:] = {rates}\nreturn dy",
        f"dy = np.zeros(len(y))\ndy[1:-1] = ({rates})[1:-1]\nreturn dy",
        f"dy = {rates}\ndy[0] = dy[-1] = 0.0\nreturn dy",
    ]  # fmt: skip
    if draw.random() < 0.1:
        return f"buffer[:] = {rates}\nreturn buffer", "buffer = np.zeros(len0)"
    return draw.choice(forms), ""


def _after(change, watch, how, draw, inline):
    """The functions `change` and `watched`, and the `hook` that a solve calls meanwhile."""
    lines = change or "pass"
    names = [node for node in ast.walk(ast.parse(lines)) if isinstance(node, ast.Name)]
    stored = sorted({each.id for each in names if not isinstance(each.ctx, ast.Load)} - {"_", "j"})
    lines = (f"global {', '.join(stored)}\n" if stored else "") + lines
    when, looks = how["when"], draw.choice(["t", "y[0]"])
    if how["way"] in ("callback", "stepper"):
        looks = "t"
    side = f"1 if {looks} {draw.choice('<>')} {when} else 2"
    if how["way"] == "on_event":
        side, looks = "1", "t"
    act = f"change({side})"
    if inline or draw.random() < 0.5:
        outer = [line for line in lines.splitlines() if line.startswith("global ")]
        act = "\n".join([*outer, f"i = {side}", *lines.splitlines()[len(outer) :]])
    lines = "pass" if inline else lines
    return (
        f"def change(i):\n{textwrap.indent(lines, '    ')}\n"
        f"def watched():\n    return [{watch}]\n"
        f"def hook(t, y, *given):\n{textwrap.indent(act, '    ')}\n    return {looks} - {when}"
    )


def _wrapped(text, own, draw):
    """The function as it is, or behind an object."""
    kind = draw.choice(["plain"] * 6 + ["method", "object", "partial", "lambda", "wraps", "static"])
    rest = own.removeprefix("t, y")
    renamed = text.replace("def fun(", "def fun0(")
    given = text.replace("def fun(", "def fun(self, ")
    called = text.replace("def fun(", "def __call__(self, ")
    unused = text.replace("def fun(", "def fun0(_, ")

    def of_class(lines):
        return f"class Model:\n{textwrap.indent(lines, '    ')}\n"

    return {
        "plain": text,
        "method": f"{of_class(given)}fun = Model().fun",
        "object": f"{of_class(called)}fun = Model()",
        "partial": f"{unused}\nfun = functools.partial(fun0, None)",
        "lambda": f"{renamed}\nfun = lambda t, y{rest}: fun0({own})",
        "wraps": "def decorated(f):\n    @functools.wraps(f)\n    def inner(*a):\n"
        f"        return f(*a)\n    return inner\n@decorated\n{text}",
        "static": of_class(f"@staticmethod\n{text}") + "fun = Model.fun",
    }[kind]  # fmt: skip


def _how(n, changes, flags, light, draw):
    """How it is solved: a dict of the way, the method, the tolerances, the start."""
    steady = QUICK if "explicit" in flags else STEADY
    way = draw.choice(("event",) if "event" in flags else CHANGING if changes else steady)
    if light and way in ("prepare", "ensemble"):  # which compile a kernel for each function
        way = "again"
    method = draw.choice(METHODS)
    if "long" in flags and method == "Taylor":
        method = "auto"  # the series of so many components take seconds to compile
    if "explicit" in flags or light or way not in ("once", "again", "elsewhere", "events", "event"):
        method = draw.choice(["RK45", "RK45", "RK23", "DOP853"])
    if way == "matrix":
        method = draw.choice(["Radau", "BDF", "LSODA"])
    rtol = draw.choice([1e-3, 1e-6, 1e-8]) if method in EXPLICIT else 1e-8
    if "explicit" in flags:
        rtol = 1e-3  # noise that depends on the calls costs steps
    if method == "RK23":
        rtol = max(rtol, 1e-6)
    if "long" in flags and method in EXPLICIT:
        rtol = 1e-3  # at so many kinks
    whole, around = draw.random() < 0.1, (0.0, 2.2) if "long" in flags else (0.7, 2.2)
    return {
        "way": way, "method": method, "rtol": rtol, "atol": rtol * 1e-2,
        "span": (0, 3) if whole else (0.0, draw.choice([2.0, 3.0, 4.0])),
        "y0": [1 if whole else round(draw.uniform(*around), 1) for _ in range(n)],
        "when": round(draw.uniform(0.5, 1.5), 2), "two": draw.random() < 0.3,
    }  # fmt: skip
