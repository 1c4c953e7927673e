"""A solve in progress as arrays, and back: what `solve_ivp(checkpoint=...)` writes and reads."""

import hashlib

import numpy as np

from fastdyn.problem.lsoda import NAME as LSODA

from .checkpoint import Checkpoint, fingerprint

FUNCTIONS = "functions and what they use"  # in a description


def checkpoint_of(problem, bounds):
    """The Checkpoint of a problem, or None; `bounds` are all functions that it calls."""
    if problem.checkpoint is None:
        return None
    header = {"initial state": problem.y0.tolist(), **description(problem, fingerprint(bounds))}
    return Checkpoint(problem.checkpoint, header)


HERE = ["block", "jump", "series", "find"]  # addresses, of an event


def description(problem, functions):
    """What a problem asks for, but for the initial state and how long it may take.

    A dict in JSON's types; `functions` is the fingerprint of all that it calls.
    """
    p = problem
    events = [(limit, direction) for _, limit, direction in p.events or ()]
    times = b"" if p.t_eval is None else np.ascontiguousarray(p.t_eval, float).tobytes()
    return {
        "method": p.method.name,
        "span": [p.t0, p.tf],
        "tolerances and steps": repr((p.rtol, p.atol, p.h_max, p.h)),
        "output": [p.t_eval is None, bool(p.dense_output), hashlib.sha256(times).hexdigest()],
        "events": repr((events, [jump is not None for jump in p.on_event])),
        "breakpoints": hashlib.sha256(p.segments.tobytes()).hexdigest(),
        FUNCTIONS: functions,
        **({} if p.mass is None else {"mass": p.mass.tolist()}),
        **({} if not (p.differences or p.sparsity) else {"Jacobian": _of_jacobian(p)}),
        **({LSODA: [p.h_least, *p.band]} if p.method.name == LSODA else {}),
    }


def _of_jacobian(problem):
    """How the Jacobian is found by differences."""
    pattern = b"" if problem.sparsity is None else np.concatenate(problem.sparsity).tobytes()
    return [problem.differences, hashlib.sha256(pattern).hexdigest()]


def to_arrays(status, run):
    """Everything that a resumed solve needs."""
    output = run.output
    t, y = output.points()
    polynomials, spans = output.polynomials()
    index, e_t, e_y = output.found_so_far()
    return {
        "status": np.array(status), "state": run.view("solve.state"),
        "work": run.view("solve.work"), "record": output.record, "t": t, "y": y,
        "polynomials": polynomials, "spans": spans, "events": run.view("events.table"),
        "e_index": index, "e_t": e_t, "e_y": e_y,
    }  # fmt: skip


def from_arrays(arrays, run):
    """Put a checkpoint's arrays in place; the status that the solve was in."""
    run.view("solve.state")[:], run.view("solve.work")[:] = arrays["state"], arrays["work"]
    table = run.view("events.table")
    here = table[HERE].copy()
    if len(table):
        table[:] = arrays["events"]
        table[HERE] = here
    run.output.put_back(arrays)
    return int(arrays["status"])
