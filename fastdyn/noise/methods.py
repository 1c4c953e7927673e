"""The methods for stochastic equations, and which of them a problem takes."""

from typing import NamedTuple


class NoiseMethod(NamedTuple):
    """The facts about a method.

    Parameters
    ----------
    name : str
    step : str
        The function of `fastdyn.kernels.noise.steps` that writes the step.
    strong, weak : float
        The order of the error of paths, and of the error of moments.
    integrals : tuple of str
        The integrals for which the method holds: "ito", "stratonovich".
    noise : str
        The noise that the method takes: "any", "unmixed" (each source acts by one component, or
        one source acts on all) or "additive" (which does not depend on the state).
    areas : bool
        Whether a step needs the area of the Brownian motion, too.
    derivative : bool
        Whether a step needs the derivative of the diffusion.
    langevin : bool
        Whether the method is for Langevin's equation.
    evaluations : int
        Evaluations of the drift in a step.
    relaxations : int
        Parts of a step with friction and noise, for Langevin's equation.
    """

    name: str
    step: str
    strong: float
    weak: float
    integrals: tuple = ("ito",)
    noise: str = "any"
    areas: bool = False
    derivative: bool = False
    langevin: bool = False
    evaluations: int = 1
    relaxations: int = 0


BOTH = ("ito", "stratonovich")
METHODS = {
    each.name: each
    for each in (
        NoiseMethod("EulerMaruyama", "euler_maruyama", 0.5, 1.0),
        NoiseMethod("EulerHeun", "heun", 0.5, 1.0, ("stratonovich",), evaluations=2),
        NoiseMethod("Milstein", "milstein", 1.0, 1.0, BOTH, "unmixed", derivative=True),
        NoiseMethod("SRA1", "sra1", 1.5, 2.0, BOTH, "additive", areas=True, evaluations=2),
        NoiseMethod("Platen", "platen", 1.0, 2.0, noise="unmixed", evaluations=2),
        NoiseMethod("BAOAB", "baoab", 1.0, 2.0, BOTH, "additive", langevin=True, relaxations=1),
        NoiseMethod(
            "OBABO", "obabo", 1.0, 2.0, BOTH, "additive", areas=True, langevin=True, relaxations=2
        ),
    )
}
