"""The methods, each a file with its tables.  A new one is a file, and a line in FACTS.

The facts are what a solve asks of a method.  A process whose kernels are compiled imports no
further file; one that compiles compares them with the file.
"""

from collections import ChainMap
from types import MappingProxyType

from .method import Facts

ON_PAIRS = " on complex states"  # ends the name of a method for them
_COMPOSED = ("second_order", "cubic", True)  # and whether it takes T(p) + V(q)
# Name, file, order, order of the error estimate, stages, rows of the work array, stage at the end,
# rows and order of the interpolant, start, further rows of the interpolant.
FACTS = (
    Facts("RK23", "rk23", 3, 2, 3, 4, 3, 3, 3, "hairer", "cubic"),
    Facts("RK45", "rk45", 5, 4, 6, 7, 6, 4, 4, "hairer", "RK45"),
    Facts("DOP853", "dop853", 8, 7, 12, 16, 12, 7, 7, "hairer", "DOP853"),
    Facts("Tsit5", "tsit5", 5, 4, 6, 7, 6, 4, 4, "hairer", "Tsit5"),
    Facts("Vern7", "vern7", 7, 6, 10, 16, 10, 7, 7, "hairer", "Vern7"),
    Facts("Vern9", "vern9", 9, 8, 16, 26, 16, 9, 9, "hairer", "Vern9"),
    Facts("ode45", "ode45", 5, 4, 6, 7, 6, 4, 4, "matlab", "RK45", h_max_share=0.1),
    Facts("ode23", "ode23", 3, 2, 3, 4, 3, 3, 3, "matlab", "cubic", h_max_share=0.1),
    Facts("Radau", "radau", 5, 3, 0, 21, 1, 3, 3, "implicit", "Radau", cost=20, n_matrices=4,
          complex_matrices=True),
    Facts("BDF", "bdf", 5, 1, 0, 18, 1, 5, 5, "implicit", "BDF", projects=False, cost=8,
          n_matrices=2),
    Facts("LSODA", "lsoda", 12, 1, 0, 24, 1, 12, 12, "lsoda", "LSODA", projects=False, cost=4,
          n_matrices=2),
    Facts("Rodas5P", "rodas5p", 5, 4, 0, 17, 1, 4, 4, "implicit", "Rodas5P", cost=10,
          n_matrices=3, takes_mass=True),
    Facts("Taylor", "taylor", 25, 25, 1, 28, 1, 25, 25, "taylor", "Taylor", h_max_share=1.0,
          series=True),
    Facts("RK4", "rk4", 4, 0, 4, 5, 4, 3, 3, "plain", "cubic"),
    *[
        Facts(name, "symplectic", order, 0, stages, 3, 1, 3, dense_order, *_COMPOSED, separable,
              projects=False)
        for name, order, stages, dense_order, separable in (
            ("VelocityVerlet", 2, 1, 2, True),
            ("McLachlanAtela4", 4, 4, 3, False),
            ("BlanesMoanPRK4", 4, 6, 3, True),
            ("BlanesMoan4", 4, 6, 3, False),
            ("BlanesMoan6", 6, 11, 3, False),
            ("KahanLi8", 8, 17, 3, True),
            ("SofroniouSpaletta10", 10, 35, 3, True),
            ("Yoshida4", 4, 3, 3, True),
            ("Yoshida6", 6, 7, 3, True),
            ("Yoshida8", 8, 15, 3, True),
        )
    ],
    *[
        Facts(name, "gauss", order, 0, 0, rows, rows - 1, n_dense, dense_order, start, name,
              nystrom, projects=False, cost=cost)
        for name, order, rows, n_dense, dense_order, start, nystrom, cost in (
            ("Gauss4", 4, 8, 3, 2, "plain", False, 24),
            ("Gauss8", 8, 12, 4, 4, "plain", False, 48),
            ("Gauss16", 16, 20, 8, 8, "plain", False, 96),
            ("GaussNystrom8", 8, 12, 4, 4, "second_order", True, 48),
            ("GaussNystrom16", 16, 20, 8, 8, "second_order", True, 96),
            ("EnergyConserving2", 2, 20, 3, 1, "plain", False, 96),
            ("EnergyConserving4", 4, 20, 3, 2, "plain", False, 96),
        )
    ],
)  # fmt: skip
METHODS = MappingProxyType({m.name: m for m in FACTS})  # read-only
COMPLEX = {  # for complex states, by the names of those for real ones
    name: METHODS[name]._replace(
        name=name + ON_PAIRS, file="on_complex_states", start=start, loop=loop
    )
    for name, start, loop in (
        *((name, "hairer_of_pairs", "") for name in ("DOP853", "RK23", "RK45")),
        *((name, "hairer_of_pairs", "") for name in ("Tsit5", "Vern7", "Vern9")),
        ("RK4", "plain", ""),
        *((name, "implicit_of_pairs", name) for name in ("Radau", "BDF")),
        ("Taylor", "taylor", ""),
    )
}
BY_NAME = ChainMap(dict(METHODS), {m.name: m for m in COMPLEX.values()})
