"""The file of a page: its data, its functions and its parts, put together."""

import html
import json
import re
from pathlib import Path
from typing import Any

from fastdyn.explore.grid import PHONE, grid
from fastdyn.explore.sliders import CONSTANT_STEPS, END, TOLERANCES, slider
from fastdyn.plot.style import COLOURS, GROUND
from fastdyn.problem.options.table import OPTIONS
from fastdyn.trace.emit.source.language import JAVASCRIPT
from fastdyn.words.letters import letters

from . import methods
from .functions import PageFunctions

ASSETS = Path(__file__).with_name("assets")
STEPS = 400  # of a default run by constant steps


def page(system):
    """
    The text of a page.

    Parameters
    ----------
    system : System
        The sliders begin at the values of this system.

    Raises
    ------
    NotExported
        If the equations have no form in JavaScript.
    """
    functions = PageFunctions(system)
    script = "\n".join([
        '"use strict";', solver(functions), f"const DATA = {_json(_data(system, functions))};",
        _asset("draw.js"), _asset("page.js"),
    ])  # fmt: skip
    rules = _asset("page.css").replace("PHONE", f"{PHONE}")
    places = {
        "TITLE": html.escape(system.title), "SOURCE": html.escape(system.source),
        "STYLE": "\n".join([_asset("uplot/uPlot.min.css"), grid("main"), rules]),
        "LICENSE": html.escape(_asset("uplot/LICENSE")),
        "UPLOT": _asset("uplot/uPlot.iife.min.js"), "SCRIPT": script,
        "STEPS": _steps(system), "LEFT": _left_out(functions),
    }  # fmt: skip
    return re.sub(r"\{\{(\w+)\}\}", lambda found: places[found[1]], _asset("page.html"))


def solver(functions):
    """The part of the script that solves, with METHODS, VARIANTS and `solve`."""
    variants = [f"{{chosen: {_json(one.chosen)}, ...{one.text}}}" for one in functions.texts]
    used = "\n".join(one.used for one in functions.texts)
    return "\n".join([
        methods.text(), *JAVASCRIPT.helpers(used), _asset("solve.js"),
        f"const VARIANTS = [{','.join(variants)}];",
    ])  # fmt: skip


def _asset(name):
    return (ASSETS / name).read_text(encoding="utf-8")


def _json(value):
    """JSON that is JavaScript in a page, too, and can end no script."""
    text = json.dumps(value, ensure_ascii=True, allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _steps(system):
    """The nine steps of a derived system."""
    derivation = getattr(system, "derivation", None)
    if derivation is None:
        return ""
    text = derivation.explain().mathml()
    return f"<details><summary>The equations, in nine steps</summary>{text}</details>"


def _left_out(functions):
    if not functions.left_out:
        return ""
    lines = "".join(f"<li>{html.escape(one)}</li>" for one in functions.left_out)
    return f"<details><summary>Not on this page</summary><ul>{lines}</ul></details>"


def _data(system, functions):
    """What the page knows of its system."""
    make = type(system)
    sliders = [slider(one, float(getattr(system, one.name))) for one in functions.names]
    phases = list(system.phases())
    offered = methods.offered(functions.second_order, phases)
    n = len(make.states)
    kept = _first(functions, ("invariants", "constraints"))
    quantity = _first(functions, ("quantities", "invariants", "constraints"))
    span = float(make.t_end)
    return {
        "name": make.name, "title": make.title, "tEnd": span,
        "states": [{"name": one.name, "letters": letters(one.name), "unit": one.unit,
                    "meaning": one.meaning} for one in make.states],
        "sliders": [_slider(one) for one in sliders],
        "end": {"title": "end (s)", "low": END[0] * span, "high": END[1] * span,
                "step": END[0] * span, "positive": True},
        "choices": {name: list(known) for name, known in make.choices.items() if known},
        "methods": offered, "ways": _ways(offered, span, kept is not None),
        "tolerances": TOLERANCES, "steps": CONSTANT_STEPS,
        "values": functions.values, "events": functions.events, "derived": functions.derived,
        "noneIn": {phases.index(name): list(found) for name, found in make.none_in.items()},
        "pushing": _pushing(system, functions), "scene": functions.scene,
        "coordinates": max(1, n // 2),
        "component": 0, "across": 0, "upwards": n // 2 if n > 1 else 0,
        "kept": kept, "value": quantity,
        "colours": {"ways": COLOURS[:2], "body": COLOURS[4], "trail": COLOURS[5], "ground": GROUND},
    }  # fmt: skip


def _pushing(system, functions):
    """Of a derived system: [index of a normal force, the body that it pushes]."""
    known = system.derivation.model.pushing if hasattr(system, "derivation") else {}
    names = [one["name"] for one in functions.values]
    return [[names.index(name), str(body)] for name, body in known.items() if name in names]


def _slider(one) -> dict[str, Any]:
    found = one._asdict() | {"title": one.title(), "positive": one.low > 0.0}
    return {key: found[key] for key in
            ("name", "title", "value", "low", "high", "step", "initial", "positive")}  # fmt: skip


def _first(functions, groups):
    """The index of the first value of the groups, in the order of the groups; None without one."""
    for group in groups:
        for i, one in enumerate(functions.values):
            if one["group"] == group:
                return i
    return None


def _ways(offered, span, compared):
    """The methods with which a page begins: two, if something should be kept."""
    step = min(CONSTANT_STEPS, key=lambda h: abs(h - span / STEPS))
    about = {"rtol": OPTIONS["rtol"].of["systems"], "step": step}
    second = offered[2 if len(offered) > 3 else 1] if compared else "none"
    return [{"method": offered[0], **about}, {"method": second, **about}]
