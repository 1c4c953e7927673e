"""A solve in progress as arrays, and back: what `solve_ivp(checkpoint=...)` writes and reads."""

import hashlib

import numpy as np

from .checkpoint import Checkpoint, fingerprint


def checkpoint_of(problem, bounds):
    """The Checkpoint of a problem; `bounds` are all functions that it calls."""
    p = problem
    events = [(limit, direction) for _, limit, direction in p.events or ()]
    times = b"" if p.t_eval is None else np.ascontiguousarray(p.t_eval, float).tobytes()
    header = {
        "method": p.method.name,
        "span": [p.t0, p.tf],
        "initial state": p.y0.tolist(),
        "tolerances and steps": repr((p.rtol, p.atol, p.h_max, p.h)),
        "output": [p.t_eval is None, bool(p.dense_output), hashlib.sha256(times).hexdigest()],
        "events": repr(events),
        "breakpoints": hashlib.sha256(p.legs.tobytes()).hexdigest(),
        "functions": fingerprint(bounds),
    }
    return Checkpoint(p.checkpoint, header)


def to_arrays(status, state, work, output, table):
    """Everything that a resumed solve needs."""
    t, y = output.points()
    polynomials, spans = output.polynomials()
    index, e_t, e_y = output.found_so_far()
    return {
        "status": np.array(status), "state": state, "work": work, "record": output.record,
        "t": t, "y": y, "polynomials": polynomials, "spans": spans, "events": table,
        "e_index": index, "e_t": e_t, "e_y": e_y,
    }  # fmt: skip


def from_arrays(arrays, state, work, output, table):
    """Put a checkpoint's arrays in place; the status that the solve was in."""
    state[:], work[:] = arrays["state"], arrays["work"]
    blocks = table["block"].copy()
    if len(table):
        table[:] = arrays["events"]
        table["block"] = blocks
    output.put_back(arrays)
    return int(arrays["status"])
