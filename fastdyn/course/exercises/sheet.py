"""A worksheet that was handed in: which exercises it answers, and where it is wrong."""

import inspect
import runpy

from .compare import compare
from .exercise import Exercise
from .first import FIRST
from .second import SECOND

EXERCISES = {one.name: one for one in (*FIRST, *SECOND)}


def exercises_of(path):
    """
    The exercises that a lecturer's file makes, by name.

    Raises
    ------
    ValueError
        If it makes none.
    """
    made = runpy.run_path(path).values()
    found = [one for part in made for one in (part if isinstance(part, list) else [part])]
    by_name = {one.name: one for one in found if isinstance(one, Exercise)}
    if not by_name:
        raise ValueError(f"{path} makes no `Exercise`.")
    return by_name


def check(path, exercises=None):
    """
    Compare the functions and models of a worksheet with the exercises of their names.

    Parameters
    ----------
    path : str
        A Python file.
    exercises : dict of str to Exercise, optional
        Those of the course unless given.

    Returns
    -------
    dict of str to list of str
        For each exercise that is answered, what is wrong.

    Raises
    ------
    ValueError
        If no exercise is answered.
    """
    exercises = EXERCISES if exercises is None else exercises
    made, found = runpy.run_path(path), {}
    for one in made.values():
        if hasattr(one, "derive") and hasattr(one, "bodies") and one.name in exercises:
            found[one.name] = _of_model(exercises[one.name], one)
    for name, exercise in exercises.items():
        if inspect.isfunction(made.get(name)) and name not in found:
            found[name] = compare(exercise, made[name])
    if not found:
        listed = ", ".join(exercises)
        raise ValueError(f"{path} answers no exercise: it has no function or model {listed}.")
    return {name: found[name] for name in exercises if name in found}


def _of_model(exercise, model):
    """The defects of a model of `fastdyn.derive`, whose names are those of the exercise."""
    if list(exercise.answer) != [f"{name}'" for name in exercise.state]:
        return ["It asks for more than equations of motion: answer it by a function."]
    try:
        system = model.derive().system
    except ValueError as error:
        return [str(error)]
    states = [one.name for one in system.states]
    parameters = [one.name for one in system.parameter_fields()]
    for ours, theirs, what in (
        (list(exercise.state), states, "state"), (exercise.parameters, parameters, "parameters")
    ):  # fmt: skip
        if missing := [name for name in ours if name not in theirs]:
            wanted = ", ".join(missing)
            return [f"Its {what} {'has' if what == 'state' else 'have'} no {wanted}."]
        if what == "state" and len(ours) != len(theirs):
            return [f"Its state has {len(theirs)} components; {len(ours)} are asked for."]

    def function(t, y, *values):
        given = dict(zip(exercise.parameters, values, strict=True))
        named = dict(zip(exercise.state, y, strict=True))
        p = [given.get(name, 1.0) for name in parameters]
        rates = dict(zip(states, system.rhs(t, [named[name] for name in states], *p), strict=True))
        return [rates[name] for name in exercise.state]

    return compare(exercise, function)
