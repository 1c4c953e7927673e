"""The command that compares a worksheet that was handed in."""

import inspect


def add_options(parser):
    """Teach a parser the worksheet, and whose exercises it answers."""
    parser.add_argument("worksheet", nargs="?", metavar="FILE",
                        help="functions or models; none lists the exercises")  # fmt: skip
    parser.add_argument("--exercises", metavar="FILE", help="a lecturer's own exercises")
    parser.add_argument("--solutions", action="store_true", help="list the solutions, too")


def run(options):
    from fastdyn.course.exercises.sheet import EXERCISES, check, exercises_of

    exercises = exercises_of(options.exercises) if options.exercises else EXERCISES
    if options.worksheet is None:
        for one in exercises.values():
            print("\n".join(_lines(one, options.solutions)))
        return 0
    found = check(options.worksheet, exercises)
    for name, wrong in found.items():
        print(f"{name}: {'right' if not wrong else wrong[0]}")
        for sentence in wrong[1:]:
            print(f"{' ' * len(name)}  {sentence}")
    return 1 if any(found.values()) else 0


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
