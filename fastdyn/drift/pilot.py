"""Short runs that choose steps, or tolerances, for a comparison."""

import math

from fastdyn.kernels.methods import METHODS

from .energy import LENGTHS, energy_drift, length_of
from .methods import cost_of

N_STEPS = 40  # of the first pilot, which is repeated with more steps below SECONDS
SECONDS = 0.02  # least time of a pilot that measures time
ROUNDS = 8  # iterations of the search for the step with the wanted cost of a period
PERIODS = 20  # of a pilot with adaptive steps
SHARE = 20  # of the length of the run, for a pilot that measures errors
TIGHTEST, LOOSEST, HALVINGS = 2.3e-16, 0.1, 9  # rtol: found to a 30th of a decade


def is_adaptive(name):
    """True for a method that chooses its steps."""
    return name in METHODS and bool(METHODS[name].error_order)


class Pilot:
    """The short runs of one method; `options` are those of `energy_drift`."""

    def __init__(self, system, name, options):
        self._system = system
        self._name = name
        self._given = options
        self._options = {
            **{key: value for key, value in options.items() if key not in LENGTHS},
            "samples": 1, "checkpoint": None, "progress": False, "rounding": False,
        }  # fmt: skip
        self._n_steps = N_STEPS

    def _run(self, **length):
        return energy_drift(self._system, self._name, **{**self._options, **length})

    def evaluations(self, steps):
        """The evaluations of a step; None if the equations of the step cannot be solved."""
        study = self._run(steps_per_period=steps, n_steps=self._n_steps)
        return None if study.message else (study.nfev - 1) / study.n_steps

    def seconds(self, steps):
        """The shortest of three times of a step, s; None if its equations cannot be solved."""
        given = {"steps_per_period": steps, "n_steps": self._n_steps}
        study = self._run(**given)
        while not study.message and study.seconds < SECONDS:
            self._n_steps = given["n_steps"] = 4 * self._n_steps
            study = self._run(**given)
        times = [study.seconds, *(self._run(**given).seconds for _ in range(2))]
        return None if study.message else min(times) / study.n_steps

    def steps(self, whole, cost):
        """The number of steps in a period with the total cost `whole`, by iteration.

        The number must be iterated, because the cost of a step depends on the step size.
        """
        steps = whole / cost_of(self._name) if cost == self.evaluations else N_STEPS
        fewest = 0.0
        for _ in range(ROUNDS):
            one = cost(steps)
            if one is None:
                fewest = max(fewest, 2.0 * steps)
            steps = fewest if one is None else max(whole / one, fewest)
        return steps

    def tolerance(self, whole, cost):
        """The `rtol` with which a period costs `whole`, in what `cost` names of a Study."""
        return self._found(
            lambda study: getattr(study, cost) / PERIODS < whole, periods=PERIODS
        )  # fmt: skip

    def tolerance_of_error(self, error):
        """The `rtol` with which the first invariant errs by `error` at most.

        The drift of a method with adaptive steps grows in proportion to time.
        """
        length = length_of(self._system, self._name, self._given) / SHARE
        return self._found(
            lambda study: next(iter(study.drifts.values())).largest * SHARE > error, t_end=length
        )  # fmt: skip

    def _found(self, too_loose, **length):
        low = math.log(TIGHTEST)
        high = math.log(LOOSEST)
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            study = self._run(rtol=math.exp(middle), **length)
            if study.message or too_loose(study):
                high = middle
            else:
                low = middle
        return math.exp(low)
