"""The arrays of a checkpoint: from a solve in progress, and back (`solve_ivp(checkpoint=...)`)."""

import hashlib

import numpy as np

from fastdyn.problem.lsoda import NAME as LSODA

from .checkpoint import Checkpoint, fingerprint

FUNCTIONS = "functions and what they use"  # key of the fingerprint in a description


def checkpoint_of(problem, bounds):
    """The Checkpoint of a problem, or None; `bounds` are all functions that the solve calls."""
    if problem.checkpoint is None:
        return None
    header = {"initial state": problem.y0.tolist(), **description(problem, fingerprint(bounds))}
    return Checkpoint(problem.checkpoint, header)


HERE = ["block", "jump", "series", "phases", "find"]  # fields of an event that are addresses
OF_SCHEDULE = ["jump", "times"]


def description(problem, functions):
    """The identity of a problem, without the initial state and the limit on steps.

    A dict in JSON's types; `functions` is the fingerprint of all functions of the problem.
    """
    p = problem
    events = [(event.rules, event.act is not None) for event in p.events or ()]
    times = b"" if p.t_eval is None else np.ascontiguousarray(p.t_eval, float).tobytes()
    return {
        "method": p.method.name,
        "span": [p.t0, p.tf],
        "tolerances and steps": repr((p.rtol, p.atol, p.h_max, p.h)),
        "output": [p.t_eval is None, bool(p.dense_output), hashlib.sha256(times).hexdigest()],
        "events": repr(events),
        "breakpoints": hashlib.sha256(p.segments.tobytes()).hexdigest(),
        FUNCTIONS: functions,
        **({"schedules": repr([*map(_of_schedule, p.schedules)])} if p.schedules else {}),
        **({} if p.mass is None else {"mass": p.mass.tolist()}),
        **({} if not (p.differences or p.sparsity) else {"Jacobian": _of_jacobian(p)}),
        **({LSODA: [p.h_least, *p.band]} if p.method.name == LSODA else {}),
    }


def _of_schedule(scheduled):
    """The times and the limit of a schedule, and whether the schedule acts."""
    times = b"" if scheduled.times is None else scheduled.times.tobytes()
    rest = scheduled._replace(times=hashlib.sha256(times).hexdigest(), jump=None)
    return tuple(rest), scheduled.jump is not None


def _of_jacobian(problem):
    """The options of a Jacobian by differences."""
    pattern = b"" if problem.sparsity is None else np.concatenate(problem.sparsity).tobytes()
    return [problem.differences, hashlib.sha256(pattern).hexdigest()]


def to_arrays(status, run):
    """All arrays that a resumed solve needs."""
    output = run.output
    t, y = output.points()
    polynomials, spans = output.polynomials()
    index, e_t, e_y = output.found_so_far()
    return {
        "status": np.array(status), "state": run.view("solve.state"),
        "work": run.view("solve.work"), "record": output.record, "t": t, "y": y,
        "polynomials": polynomials, "spans": spans, "events": run.view("events.table"),
        "schedules": run.view("events.schedules"), "e_index": index, "e_t": e_t, "e_y": e_y,
    }  # fmt: skip


def from_arrays(arrays, run):
    """Copy the arrays of a checkpoint into a run; return the status of the solve."""
    run.view("solve.state")[:], run.view("solve.work")[:] = arrays["state"], arrays["work"]
    put_tables(run, arrays["events"], arrays["schedules"])
    run.output.put_back(arrays)
    return int(arrays["status"])


def put_tables(run, events, schedules):
    """Copy the tables of events and schedules into a run, but for the run's own addresses."""
    for name, saved, here in (("table", events, HERE), ("schedules", schedules, OF_SCHEDULE)):
        table = run.view(f"events.{name}")
        own = table[here].copy()
        if len(table):
            table[:] = saved
            table[here] = own
