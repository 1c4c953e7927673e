"""The option `callback` of a solve: checked, and as a function of a Run."""


def checked_callback(options):
    """The user's `callback`, or None; TypeError if it cannot be called."""
    callback = options.get("callback")
    if callback is not None and not callable(callback):
        raise TypeError(f"`callback` must be a function of the solver; got {callback!r}.")
    return callback


def with_observed(options):
    """The options, with the user's `callback` as a function that a Run calls."""
    if options.get("callback") is None:
        return options
    from .stepper import observed  # imports SciPy

    return {**options, "callback": observed(options["callback"])}
