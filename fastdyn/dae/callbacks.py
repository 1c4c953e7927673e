"""The option `callback`: the solver that a user's function gets has the state y alone."""

from fastdyn.problem.options.table import OPTIONS


def with_observed(options, own):
    """The options with a `callback` that follows a Run; `own` as of an Observer."""
    callback = options.get("callback")
    if callback is None:
        return options
    OPTIONS["callback"].check(callback)
    from fastdyn.solve.by_method import observed  # imports SciPy

    from .observer import Observer

    def follow(run):
        found = Observer.of_run(run)
        found.own = own
        return found

    return {**options, "callback": observed(callback, follow=follow)}
