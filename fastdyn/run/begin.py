"""The start of a solve: the records, the work array, the image of the memory."""

import struct
from typing import Any

import numpy as np

from fastdyn.code_store.call import address_of
from fastdyn.compile.derivatives.jacobian_block import exact_block
from fastdyn.compile.derivatives.phases import phases
from fastdyn.kernels.methods.taylor.accuracy import order_for
from fastdyn.kernels.output.arguments import (
    COUNTS,
    EVENTS,
    INTERPOLATED,
    KEEPS,
    OUTPUT,
    SCHEDULES,
    SERIES,
    SLOPES,
)
from fastdyn.kernels.state.record import ATOL, RTOL, STATE, K, Y
from fastdyn.problem.step_options import last_time, unit_of_times
from fastdyn.specialise.scalar import (
    all_roots_kernel,
    roots_inside_kernel,
    watch_events_kernel,
    watch_kernel,
    watch_plain_kernel,
)
from fastdyn.specialise.series import series_of_events

from . import output
from .output import OUTPUT_WORDS, STATE_RECORD, STATE_WORDS

NONE_YET = (0.0, *[0] * 9)  # counts and flags of implicit methods
WITHIN_SPAN = (0, 0.0)  # steps of LSODA do not pass the end
NONE_OF_LSODA = (0.0,) * 10 + (0,) * 7
NOTHING_CUT = (0.0,)
NO_ACTION = (0, 0)
NONE_SHORT = (0.0,)


def first_state(problem, n_extra=0):
    """The fields of the state record before the first step."""
    p = problem
    direction = 1.0 if p.tf >= p.t0 else -1.0
    t0, end = map(float, p.segments[0, :2]) if len(p.segments) else (p.t0, last_time(p.tf))
    passes = WITHIN_SPAN if p.limit is None else (1, p.limit)
    return (
        t0, t0, end, end, t0, direction, p.h, p.h_max, p.h, 0.0, 0, 0, n_extra, *NONE_YET,
        p.h_least, *p.band, *p.orders, *passes, *NONE_OF_LSODA, *NOTHING_CUT,
        *NO_ACTION, *NONE_SHORT,
    )  # fmt: skip


def begin(problem, matrix_rows) -> Any:
    """The state record and the work array before the first step; a matrix takes `matrix_rows`."""
    n = len(problem.y0)
    p = problem
    work = np.zeros((K + p.method.rows(matrix_rows), n))
    work[Y], work[RTOL], work[ATOL] = p.y0, p.rtol, p.atol
    return STATE_RECORD(*first_state(p)), work


def jacobian_of(problem, bound, others):
    """The block of the Jacobian, or None for differences.

    The user's Jacobian is the last of `others`.  A traced function has an exact Jacobian, which
    replaces a `jac` that returns sparse matrices: only Python can call such a `jac`.
    """
    p = problem
    block = None
    given = others[-1] if p.jac is not None else None
    if given is not None and not given.mode.entries:
        return given.block
    if p.method.n_matrices and not p.differences:
        block = exact_block(bound.function, len(p.y0), p.method.by_time)
    return given.block if block is None and given is not None else block


def event_table(problem, others, order=None) -> Any:
    """EVENTS records before the first evaluation; `others` as `problem.events.between_steps`.

    `order` is the order of the series; by default the problem chooses the order.
    """
    events = problem.events or []
    blocks = iter([address_of(bound.block) for bound in others])
    table: Any = np.zeros(len(events), EVENTS)
    for row, event in zip(table, events, strict=True):
        row["block"] = next(blocks)
        for name, value in event.rules.items():
            row[name] = value
    method = problem.method
    for row, event in zip(table, events, strict=True):
        row["jump"] = 0 if event.act is None else next(blocks)
        row["inside"] = COUNTS if counts_inside(method, event) else KEEPS
    for row, event, bound in zip(table, events, others, strict=False):
        if event.turns:
            for name, value in phases(bound.function).fields.items():
                row[name] = value
    if not events:
        return table
    table["unit"] = unit_of_times(problem.events_as_scipy, problem.t0, problem.tf)
    table[0]["middle"] = INTERPOLATED if method.n_matrices or method.series else SLOPES
    table[0]["at_once"] = method.events_at_once
    find = roots_inside_kernel
    if method.series:
        table["series"] = series_of_events(problem, others[: len(events)], order)
        if table["series"].any():
            find = all_roots_kernel
            table[0]["middle"] = SERIES
    table[0]["find"] = find().address
    return table


def counts_inside(method, event):
    """Whether each crossing of an event within a step counts."""
    return method.looks_inside or event.steers


def schedule_table(problem, others) -> Any:
    """SCHEDULES records before the start; `others` as `problem.events.between_steps`."""
    p = problem
    table: Any = np.zeros(len(p.schedules), SCHEDULES)
    events = p.events or ()
    before = len(events) + sum(event.act is not None for event in events)
    blocks = iter([address_of(bound.block) for bound in others[before:]])
    for row, each in zip(table, p.schedules, strict=True):
        row["jump"] = 0 if each.jump is None else next(blocks)
        row["times"] = 0 if each.times is None else address_of(each.times)
        row["next"], row["end"], row["way"] = each.first, each.end, each.way
        row["start"], row["period"], row["limit"] = each.start, each.period, each.limit
        row["t_next"] = each.first_time(p.tf - p.t0)
    return table


def watch_of(problem):
    """The loop between the steps: the smallest that does what a problem asks for."""
    p = problem
    acts = p.project is not None or p.inside is not None or len(p.segments)
    if acts or p.acts:
        return watch_kernel()
    return watch_events_kernel() if p.events else watch_plain_kernel()


def jumps_at_once(problem):
    """The most points that a step stores at its end, after changes of the state."""
    return problem.acts + any(each.jump is not None for each in problem.schedules)


def fill(image, problem, n_extra):
    """Fill the records of the image, the first content of the memory of a solve."""
    p = problem
    STATE_WORDS.pack_into(image, 0, *first_state(p, n_extra))
    OUTPUT_WORDS.pack_into(
        image, STATE_WORDS.size, *first_output(p, p.t_eval is None, p.dense_output)
    )


def first_output(problem, every_step, dense):
    """The fields of the output record; the first point is stored when the solve begins."""
    p = problem
    return (
        every_step, dense, every_step, every_step, 0, 0, 0, 0, jumps_at_once(p), p.method.series,
        1, p.t0, 0, 0, p.most_between, 0, 0,
    )  # fmt: skip


# The fields of STATE from the first to `h_first`: times, direction, step sizes.
OF_SPAN = struct.Struct("9d")
T_LAST = STATE.itemsize + OUTPUT.fields["t_last"][1]


def fill_span(image, t0, tf, h, h_max, segments=()):
    """Fill the fields of the image that depend on the span; in a quarter of the time of `fill`."""
    direction = 1.0 if tf >= t0 else -1.0
    begin, end = map(float, segments[0, :2]) if len(segments) else (t0, tf)
    OF_SPAN.pack_into(image, 0, begin, begin, end, end, t0, direction, h, h_max, h)
    struct.pack_into("d", image, T_LAST, t0)


def fill_tolerances(image, plan, problem):
    """Fill the tolerances of the image."""
    p = problem
    n = plan.n
    numbers = image.view(float)
    work = plan.arrays["solve.work"][0]
    numbers[work + RTOL * n : work + (RTOL + 1) * n] = p.rtol
    fill_atol(image, plan, p.atol)


def fill_atol(image, plan, atol):
    """Fill the absolute tolerances of the image."""
    begin = plan.arrays["solve.work"][0] + ATOL * plan.n
    image.view(float)[begin : begin + plan.n] = atol


def shape_of(problem, pair, n_points=None):
    """The key of the layout of a problem's memory; `n_points` if each step is stored."""
    p = problem
    n = len(problem.y0)
    m = len(problem.events or ())
    k = len(problem.schedules)
    room = output.first_piece(n)
    n_points = (n_points or room) if p.t_eval is None else len(p.t_eval)
    rows = 1 + (order_for(p.rtol, p.atol, p.y0) if p.method.series else p.method.n_dense)
    polynomials = output.first_piece(n * rows) if p.dense_output else 1
    return (p.method.name, pair, n, m, k, n_points, (polynomials, rows), room if m + k else 0)
