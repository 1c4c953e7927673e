"""The option `callback` of a solve, as a function of a Run."""


def with_observed(asked):
    """The Arguments, with the user's `callback` as a function that a Run calls."""
    if asked.options.get("callback") is None:
        return asked
    from .stepper import observed  # imports SciPy

    return asked.with_options(callback=observed(asked.options["callback"]))
