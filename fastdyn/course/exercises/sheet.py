"""A worksheet that was handed in: which exercises it answers, and where it is wrong."""

import difflib
import inspect
import runpy
import types

from fastdyn.systems import SYSTEMS

from .compare import compared
from .exercise import Exercise
from .first_half import FIRST
from .origin import borrowed
from .second_half import SECOND

EXERCISES = {one.name: one for one in (*FIRST, *SECOND)}
ALIKE = 0.8  # of the letters of a name that is misspelt
BORROWED = "It is a reference of fastdyn, or calls one: that is no answer of one's own."


def exercises_of(path):
    """
    The exercises that a lecturer's file makes, by name; those of the course without a file.

    Raises
    ------
    ValueError
        If it makes none, or one whose terms and solution contradict each other.
    """
    if not path:
        return EXERCISES
    made = runpy.run_path(path).values()
    found = [one for part in made for one in (part if isinstance(part, list) else [part])]
    by_id = {id(one): one for one in found if isinstance(one, Exercise)}
    by_name = {one.name: one for one in by_id.values()}
    if not by_name:
        raise ValueError(f"{path} makes no `Exercise`.")
    if len(by_name) < len(by_id):
        raise ValueError(f"{path}: two exercises have one name of {', '.join(by_name)}.")
    for one in by_name.values():
        if wrong := _contradiction(one):
            raise ValueError(f"{path}: the exercise {one.name} contradicts itself. {wrong}")
    return by_name


def _contradiction(exercise):
    """The faults of an exercise that no student can answer; empty for a good one."""
    if not exercise.name.isidentifier():
        return f"No function can have its name, {exercise.name!r}."
    if list(exercise.terms) != list(exercise.answer):
        return (f"It asks for {', '.join(exercise.answer)} and has terms of "
                f"{', '.join(exercise.terms)}.")  # fmt: skip
    known = (*exercise.state, *exercise.parameters)
    if unknown := [name for name in exercise.ranges if name not in known]:
        return f"It has a range of {', '.join(unknown)}, and neither a state nor a parameter of it."
    if unknown := [name for name in exercise.free_zero if name not in exercise.answer]:
        return f"The zero of {', '.join(unknown)} is free, which is not asked for."
    try:
        wrong, _ = compared(exercise, exercise.solution)
    except Exception as error:  # of a term, a range or `project`
        return f"{type(error).__name__}: {str(error).rstrip('.')}."
    return f"Its terms say of its solution: {' '.join(wrong)}" if wrong else ""


def answers(made, exercises):
    """The functions and models of a worksheet's names, by the exercise that each answers."""
    found = {}
    for one in made.values():
        if hasattr(one, "derive") and hasattr(one, "bodies") and one.name in exercises:
            found[one.name] = one
    for name in exercises:
        if name not in found and callable(made.get(name)):
            found[name] = made[name]
    return {name: found[name] for name in exercises if name in found}


def strays(made, answered, exercises):
    """Sentences about functions that answer no exercise: misspelt, or of systems without one."""
    said = []
    for name, one in made.items():
        if name in exercises or isinstance(one, types.ModuleType):
            continue
        own = (getattr(one, "__module__", "") or "") == made["__name__"]
        model = hasattr(one, "derive") and hasattr(one, "bodies")
        if not (model or (own and callable(one))):
            continue
        name = getattr(one, "name", name) if model else name
        if name.lower() in SYSTEMS and name.lower() not in exercises:
            said.append(f"`{name}` is not judged: the system {name.lower()} has no exercise.")
            continue
        near = difflib.get_close_matches(name.lower(), exercises, n=1, cutoff=ALIKE)
        if near and near[0] not in answered:
            said.append(f"`{name}` answers no exercise; did you mean {near[0]}?")
    return said


def judged(exercise, answer, own=()):
    """Sentences about what is wrong with an answer, and notes about what is no error."""
    if borrowed(answer, own):
        return [BORROWED], []
    if inspect.isclass(answer):
        return ["It is a class; a function is asked for."], []
    if hasattr(answer, "bodies"):
        return _of_model(exercise, answer), []
    return compared(exercise, answer)


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

    return compared(exercise, function)[0]
