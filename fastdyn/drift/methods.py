"""The methods of drift studies: those for any equations, and WisdomHolman, which is for planets."""

from fastdyn.kernels.methods import METHODS
from fastdyn.planets.planets import Planets
from fastdyn.planets.run import NAME, PlanetSteps, facts
from fastdyn.problem import validate

LOOKS = 10  # evaluations of the invariants in a bin by default, where outputs take long
OPTIONS = {"step", "corrector", "compile"}


def method_of(system, name):
    """The Facts of a method by its name; ValueError unless it is one for the system."""
    if name == NAME:
        if not isinstance(system, Planets):
            raise ValueError(
                f"`{NAME}` is for the motion of planets: give fastdyn.planets.Planets(masses, q0, "
                "v0, G)."
            )
        return facts(1)
    method = validate.method_named(name)
    if method is None:
        raise ValueError(f"`method={name!r}` is SciPy's; a drift study needs a compiled method.")
    return method


def cost_of(name):
    """The evaluations of a step of a method, for a first guess."""
    method = facts(1) if name == NAME else METHODS[name]
    return method.n_stages or method.cost


def study_of(planets, y0, t_end, options):
    """The steps of WisdomHolman, as a problem and as what a Survey takes."""
    options = {name: value for name, value in options.items() if value is not None}
    if unknown := sorted(options.keys() - OPTIONS):
        raise TypeError(f"`{NAME}` takes no `{unknown[0]}`: its steps are constant, `step=`.")
    if "step" not in options:
        raise ValueError(f"`{NAME}` has constant steps: give `step` or `steps_per_period`.")
    q, v = y0.reshape(2, -1, 3)
    moved = Planets(planets.masses, q, v, planets.G)
    return PlanetSteps(moved, options["step"], 0.0, t_end, options.get("corrector", 17))
