"""The command ``fastdyn check``: compares a student's worksheet with the exercises."""

import inspect
from pathlib import Path

from . import checks


def add_options(parser):
    """Add the arguments: the worksheet, and the file of exercises."""
    parser.add_argument("worksheet", nargs="?", metavar="FILE",
                        help="functions or models; none lists the exercises")  # fmt: skip
    parser.add_argument("--exercises", metavar="FILE", help="a lecturer's own exercises")
    parser.add_argument("--solutions", action="store_true", help="list the solutions, too")
    parser.add_argument("--limit", type=checks.positive, default=30.0, metavar="SECONDS",
                        help="for each exercise (default: 30)")  # fmt: skip


def run(options):
    from fastdyn.course.exercises.check import check
    from fastdyn.course.exercises.sheet import exercises_of

    for path in filter(None, (options.worksheet, options.exercises)):
        if not Path(path).is_file():
            raise ValueError(checks.no_file(path))
    if options.worksheet is None:
        for one in exercises_of(options.exercises).values():
            print("\n".join(_lines(one, options.solutions)))
        return 0
    judged = check(options.worksheet, options.exercises, options.limit)
    for name, wrong in judged.found.items():
        sentences = [*(wrong or ["right"]), *judged.notes.get(name, ())]
        print(f"{name}: {sentences[0]}")
        for sentence in sentences[1:]:
            print(f"{' ' * len(name)}  {sentence}")
    for sentence in judged.left:
        print(sentence)
    return 1 if judged.left or any(judged.found.values()) else 0


def _lines(exercise, solved):
    """An exercise as text."""

    def with_units(names):
        return ", ".join(f"{name} ({unit})" for name, unit in names.items())

    lines = [f"{exercise.name}: {exercise.question}", f"    {exercise.signature}",
             f"    state {with_units(exercise.state)}",
             f"    parameters {with_units(exercise.parameters)}",
             f"    returns {with_units(exercise.answer)}", ""]  # fmt: skip
    if solved:
        text = inspect.getsource(exercise.solution)
        lines += [*(f"    {line}" for line in text.splitlines()), ""]
    return lines
