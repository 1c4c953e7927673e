"""The table in docs/adjoint.md of what is differentiable is that of the code."""

import pathlib
import re

import numpy as np
import pytest

import fastdyn
from fastdyn import solve_ivp
from fastdyn.kernels.methods import METHODS

PAGE = pathlib.Path(__file__).parents[2] / "docs" / "adjoint.md"
ROWS = [
    [cell.strip() for cell in line.strip("| \n").split("|")]
    for line in PAGE.read_text().split("## What is differentiable")[1].split("##")[0].splitlines()
    if line.startswith("|")
][2:]
WORDS = [(re.findall(r"\w+", row[0]), row) for row in ROWS]
OF_METHOD = {name: row for words, row in WORDS for name in words if name in METHODS}


def motion(t, y, k):
    return [y[1], -k * y[0]]


def solved(option, name, **options):
    if not METHODS[name].error_order:
        options["step"] = 0.1
    t_eval = None if options.get("dense_output") else [0.3, 1.0]
    r = solve_ivp(
        motion, (0, 1), [1.0, 0.1], name, t_eval, args=(1.0,), **{option: "args"}, **options
    )
    return r.vjp(np.ones_like(r.y))["k"] if option == "adjoint" else r.sensitivity["k"]


def test_each_method_stands_in_one_row():
    assert sorted(name for words, _ in WORDS for name in words if name in METHODS) == sorted(
        METHODS
    )


@pytest.mark.few(6)
@pytest.mark.parametrize("name", METHODS)
def test_methods(name):
    _, sensitivity, adjoint = OF_METHOD[name]
    assert sensitivity.startswith("yes")
    if adjoint != "yes":
        with pytest.raises(ValueError, match=f"not over those of {name}"):
            solved("adjoint", name)
        return
    forward = solved("sensitivity", name)
    assert np.isclose(solved("adjoint", name), forward.sum(), rtol=2e-2)


ACTS = {"at": [0.5], "on_event": [lambda t, y, k: y]}


@pytest.mark.parametrize(
    ("row", "name", "options"),
    [
        ("dense_output", "RK45", {"dense_output": True}),
        ("breakpoints", "RK45", {"breakpoints": [0.5]}),
        ("schedules", "RK45", ACTS),
        ("VelocityVerlet", "VelocityVerlet", ACTS),
        ("GaussNystrom8", "GaussNystrom8", ACTS),
        ("times of events", "Tsit5", {"events": lambda t, y, k: y[0] - 0.9}),
        ("functions that run in Python", "RK45", {"events": fastdyn.at([0.5]), "compile": False}),
    ],
)
def test_other_rows(row, name, options):
    (found,) = [each for each in ROWS if row in each[0]]
    given = options
    for option, cell in zip(("sensitivity", "adjoint"), found[1:], strict=True):
        taken = not (cell.startswith("no") or ("without `on_event`" in cell and given is ACTS))
        if taken:
            assert np.isfinite(solved(option, name, **given)).all()
        else:
            with pytest.raises(ValueError):
                solved(option, name, **given)
