"""Everyday functions, many alike: what processes that share a cache must not mix up."""

import functools
from typing import Any, NamedTuple

import numpy as np

import fastdyn
from fastdyn import systems

from . import everyday_functions as f


class Case(NamedTuple):
    """A problem over (0, 1); `fold` is a Fold, `events` and `project` are functions."""

    fun: Any
    args: tuple = ()
    y0: tuple = (1.0, 0.5)
    events: Any = None
    project: Any = None
    fold: Any = None


def of_system(system):
    return Case(system.rhs, system.args, tuple(system.initial_state()))


CASES = {
    "first": Case(f.of_all_kinds),
    "int 2": Case(f.rate, (2,)),
    "float 2.5": Case(f.rate, (2.5,)),
    "bool": Case(f.rate, (True,)),
    "int 3, list": Case(f.rate_of, (3,)),
    "float 3.5, list": Case(f.rate_of, (3.5,)),
    "-0.5": Case(f.first),
    "-1.5": Case(f.second),
    "-4": Case(f.third),
    "pull": Case(f.by_pull),
    "push": Case(f.by_push),
    "helper": Case(f.with_helper(1.0)),
    "helper 2": Case(f.with_helper(2.0)),
    "other helper": Case(f.with_other_helper(1.0)),
    "jitted": Case(f.by_jitted),
    "loop": Case(f.looped),
    "longer loop": Case(f.looped_more),
    "while": Case(f.while_loop, (3,)),
    "solve": Case(f.solved),
    "solve too": Case(f.solved_too),
    "inv": Case(f.inverted),
    "A @ y": Case(f.times_a),
    "B @ y": Case(f.times_b),
    "matrix": Case(f.of_matrix, (f.A,)),
    "strided matrix": Case(f.of_matrix, (np.zeros((4, 4))[::2, ::2] - np.eye(2),)),
    "slices": Case(f.sliced),
    "filled": Case(f.filled),
    "true": Case(f.flagged, (True,)),
    "false": Case(f.flagged, (False,)),
    "tuple": Case(f.of_tuple, ((1.0, 2.0),)),
    "tuple of int": Case(f.of_tuple, ((1, 2.0),)),
    "list": Case(f.of_list, ([1.0, 2.0],)),
    "count": Case(f.of_count, (3,)),
    "global": Case(f.of_global),
    "closure": Case(f.closed_over(2.0)),
    "closure of int": Case(f.closed_over_whole(1)),
    "closure of int 2": Case(f.closed_over_whole(2)),
    "cos": Case(f.of_time),
    "sin": Case(f.of_time_too),
    "branch": Case(f.by_parts),
    "complex": Case(f.complex_inside),
    "quadratic": Case(f.quadratic),
    "partial": Case(functools.partial(f.of_count, n=5)),
    "method": Case(f.Oscillator(2.0).motion),
    "callable": Case(f.Oscillator(2.0)),
    "event": Case(f.damped, events=f.halfway),
    "event too": Case(f.damped, events=f.threshold),
    "circle": Case(f.turning, y0=(0.6, 0.8), project=f.to_circle),
    "ellipse": Case(f.turning, y0=(0.6, 0.4), project=f.to_ellipse),
    "fold": Case(f.damped, fold=fastdyn.ensemble.Fold(f.smaller, 1e9)),
    "fold too": Case(f.damped, fold=fastdyn.ensemble.Fold(f.summed)),
    "vehicle": of_system(systems.vehicle(driver=f.steered)),
    "vehicle too": of_system(systems.vehicle(driver=f.held)),
    "satellite": of_system(systems.satellite(V=1.1)),
    "rod": of_system(systems.rod()),
}
