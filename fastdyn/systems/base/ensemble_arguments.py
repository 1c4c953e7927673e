"""A system with many values of its fields: the arguments and starts of an ensemble."""

import copy
import dataclasses
import inspect

import numpy as np

from fastdyn.ensemble.solve import solve_ensemble
from fastdyn.problem.members import Shared
from fastdyn.problem.options.table import OPTIONS
from fastdyn.words.kinds import shown

from .consistent_start import check_members
from .declare import checked
from .solve_arguments import completed, projection, span


def fields_of(system):
    """The fields of a system by name."""
    return {field.name: field for field in dataclasses.fields(system)}


def split(system, given):
    """(system with the single values, columns of the others, options) of named arguments."""
    fields = fields_of(system)
    fixed = {}
    columns = {}
    options = {}
    for name, value in given.items():
        if name not in fields:
            options[name] = value
        elif np.ndim(value) == 0:
            fixed[name] = value
        else:
            columns[name] = _checked_column(system, fields[name], value)
    system = dataclasses.replace(system, **fixed)
    lengths = {len(column) for column in columns.values()}
    if len(lengths - {1}) > 1:
        said = ", ".join(f"`{name}` has {len(column)}" for name, column in columns.items())
        raise ValueError(f"everything that varies must have one entry a trajectory: {said}.")
    return system, columns, options


def _checked_column(system, field, value):
    """Values of a field as an array, checked as a single value is."""
    if "unit" not in field.metadata:
        raise ValueError(f"`{field.name}` of the {system.name} is the same for all trajectories.")
    column = np.asarray(value)
    if column.ndim == 1 and column.dtype.kind == "U":  # with units, as "30 deg"
        column = np.array([checked(system.name, field, each) for each in value])
    if column.ndim != 1 or column.dtype.kind not in "fiu" or not column.size:
        raise ValueError(
            f"`{field.name}` must be a number or a 1-D array of numbers, one a trajectory; got "
            f"{shown(column)}."
        )
    column = column.astype(float)
    bad = column[~np.isfinite(column)]
    for extreme in (column.min(), column.max()) if not bad.size else bad[:1]:
        checked(system.name, field, float(extreme))
    return column


def ensemble(system, t_span, y0, method, given):
    """Solve a system for many values of its fields; see `System.ensemble`."""
    system, columns, options = split(system, given)
    starts = {f.name: columns[f.name] for f in system.initial_fields() if f.name in columns}
    if starts and y0 is not None:
        names = ", ".join(f"`{name}`" for name in starts)
        raise ValueError(f"{names} of the {system.name} and `y0` both set the start; give one.")
    known = OPTIONS.keys() | {*inspect.signature(solve_ensemble).parameters} | {*fields_of(system)}
    options = completed(system, method, options, of_ensemble=known)
    if "project" in options:
        options["project"] = projection(system, options["project"])
    args = tuple(columns.get(f.name, _shared(system, f)) for f in system.parameter_fields())
    t_span = span(system, t_span)
    if y0 is not None and system.constraints:
        check_members(system, t_span[0], y0, columns)
    result = solve_ensemble(
        system.rhs,
        t_span,
        _initial_states(system, columns) if y0 is None else y0,
        args,
        method,
        **options,
    )
    result.system = system
    result.initial_conditions = {name: one for name, one in starts.items() if len(one) > 1}
    return result


def _shared(system, field):
    value = getattr(system, field.name)
    return Shared(value) if isinstance(value, np.ndarray) else value


def _initial_states(system, columns):
    """Initial states, (M, n), or (n,) if they do not depend on the varying fields."""
    varied = copy.copy(system)
    for name, column in columns.items():
        object.__setattr__(varied, name, column)
    try:
        parts = np.broadcast_arrays(*varied.initial_state())
    except (TypeError, ValueError):  # the method takes one value at a time
        rows = zip(*np.broadcast_arrays(*columns.values()), strict=True)
        single = (
            dataclasses.replace(system, **dict(zip(columns, row, strict=True))) for row in rows
        )
        return np.array([one.initial_state() for one in single])
    return np.stack(parts, axis=-1).astype(float)
