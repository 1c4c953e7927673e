"""Drift of several methods side by side, at equal work."""

from .drift import energy_drift
from .kernels import METHODS

PILOT_STEPS = 40
ROUNDS = 8  # of finding the step at which an implicit method needs so many evaluations


class Comparison(dict):
    """Studies by label; prints as a table."""

    def __str__(self):
        from .study import table

        return table(self)

    def plot(self, **options):
        """All studies in one figure, see `plot_drift.plot_studies`."""
        from .plot_drift import plot_studies

        return plot_studies(self, **options)


def compare_drift(system, methods, *, evaluations, periods, progress=False, **options):
    """
    Follow the invariants of a system with several methods at equal work.

    Parameters
    ----------
    system : System
        One with a period.
    methods : iterable of str
        Names of methods with constant steps.
    evaluations : float
        Evaluations of the right-hand side in a period, the same for all: steps are chosen so.
    periods : float
        Length of the run.
    progress, **options
        As for `energy_drift`.

    Returns
    -------
    Comparison
        A dict of Study by method, with ``plot()``; prints as a table.
    """
    found = Comparison()
    for name in methods:
        method = METHODS.get(name)
        if method is None or method.error_order:
            raise ValueError(f"`{name}` has no constant steps, so its work cannot be chosen.")
        steps = evaluations / (method.n_stages or method.cost)
        if not method.n_stages:
            for _ in range(ROUNDS):
                pilot = energy_drift(
                    system, name, steps_per_period=steps, n_steps=PILOT_STEPS, samples=1
                )
                converged = not pilot.message
                steps = evaluations / ((pilot.nfev - 1) / pilot.n_steps) if converged else 2 * steps
        found[name] = energy_drift(
            system, name, steps_per_period=steps, periods=periods, progress=progress, **options
        )
    return found
