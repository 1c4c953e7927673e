"""Problems whose components have unlike sizes: epidemics, kinetics, orbits with mass and charge.

SI units, people, cells, atoms; the components differ by up to 16 powers of ten, and some are zero
at the start.  None is stiff.
"""

from typing import Any, NamedTuple

import numpy as np


class Unlike(NamedTuple):
    """y' = fun(t, y) from 0 to `end`; `floors` are the sizes below which a component is nothing.

    ``atol = tol * floors`` with ``rtol = tol``.
    """

    name: str
    fun: Any
    end: float
    y0: tuple
    floors: tuple


PEOPLE = 1.38e9


def seir(t, y):
    """An epidemic that one infected begins; contacts, incubation and recovery a day."""
    s, e, i, _ = y
    infections = 1.38 * s * i / PEOPLE
    return [-infections, infections - 0.19 * e, 0.19 * e - 0.34 * i, 0.34 * i]


def sir_with_deaths(t, y):
    s, i, r, _ = y
    infections = 0.3 * s * i / (s + i + r)
    return [-infections, infections - 0.101 * i, 0.1 * i, 0.001 * i]


def decays(t, y):
    """Atoms of a chain of nuclides."""
    rates = [5.0, 0.3, 2.0, 0.05]
    gone = [rate * atoms for rate, atoms in zip(rates, y[:4], strict=True)]
    return [-gone[0], gone[0] - gone[1], gone[1] - gone[2], gone[2] - gone[3], gone[3]]


def michaelis_menten(t, y):
    """Substrate, enzyme, complex and product, in mol / l."""
    s, e, c, _ = y
    bound, released, made = 1e4 * s * e, 0.5 * c, 1.0 * c
    return [released - bound, released + made - bound, bound - released - made, made]


def hydrogen_bromide(t, y):
    """H2, Br2, HBr and atoms of bromine, in mol / l."""
    h2, br2, _, br = y
    start, chain, end = 1e-4 * br2, 0.5 * br * h2, 20.0 * br * br
    return [-chain, end - start - chain, 2.0 * chain, 2.0 * start - 2.0 * end]


def drug(t, y):
    """A swallowed dose, in mg: gut, blood, tissue, urine."""
    gut, blood, tissue, _ = y
    back = 0.5 * blood - 0.2 * tissue
    return [-1.2 * gut, 1.2 * gut - 0.3 * blood - back, back, 0.3 * blood]


def tumour(t, y):
    """Cells by Gompertz's law, from one cell, and the concentration of a drug."""
    cells, drug = y
    return [cells * (0.1 * np.log(1e12 / cells) - 1e-3 * drug), -0.5 * drug]


def predators(t, y):
    """Twenty million hares and forty lynxes."""
    hares, lynxes = y
    return [hares - 0.02 * hares * lynxes, 5e-8 * hares * lynxes - 0.8 * lynxes]


GM = 3.986004418e14


def charged_rocket(t, y):
    """A low orbit, slow thrust along the velocity, mass in kg and charge in C."""
    px, py, vx, vy, mass, charge = y
    pull, thrust = GM / (px * px + py * py) ** 1.5, 20.0 / mass / np.sqrt(vx * vx + vy * vy)
    return [
        vx, vy, thrust * vx - pull * px, thrust * vy - pull * py, -0.007, 1e-12 - charge / 3600.0,
    ]  # fmt: skip


def electron(t, y):
    """Across a magnetic field, in a saddle of an electric potential; m and m / s."""
    x, py, z, vx, vy, vz = y
    k, b, e = 1.758820e11, 1e-4, 1.0
    return [vx, vy, vz, -k * (e * x + b * vy), k * (b * vx - e * py), -2.0 * k * e * z]


def probe(t, y):
    """From a low orbit past the moon; m and m / s."""
    px, py, vx, vy = y
    mx, my = 3.844e8 * np.cos(2.6617e-6 * t), 3.844e8 * np.sin(2.6617e-6 * t)
    earth = GM / (px * px + py * py) ** 1.5
    moon = 4.9e12 / ((px - mx) ** 2 + (py - my) ** 2) ** 1.5
    return [vx, vy, moon * (mx - px) - earth * px, moon * (my - py) - earth * py]


UNLIKE = (
    Unlike("epidemic, SEIR", seir, 179.0, (PEOPLE - 1.0, 0.0, 1.0, 0.0), (1.0,) * 4),
    Unlike("epidemic with deaths", sir_with_deaths, 160.0, (8.3e7, 10.0, 0.0, 0.0), (1.0,) * 4),
    Unlike("chain of nuclides", decays, 30.0, (1e20, 0.0, 0.0, 0.0, 0.0), (1.0,) * 5),
    Unlike("Michaelis-Menten", michaelis_menten, 600.0, (1e-4, 1e-6, 0.0, 0.0), (1e-8,) * 4),
    Unlike("hydrogen bromide", hydrogen_bromide, 200.0, (1.0, 1.0, 0.0, 0.0), (1e-3,) * 4),
    Unlike("drug in the body", drug, 48.0, (500.0, 0.0, 0.0, 0.0), (1e-3,) * 4),
    Unlike("tumour", tumour, 60.0, (1.0, 10.0), (1e-3,) * 2),
    Unlike("predators and prey", predators, 30.0, (2e7, 40.0), (1.0,) * 2),
    Unlike(
        "rocket, mass and charge", charged_rocket, 20000.0,
        (7e6, 0.0, 0.0, 7546.0, 500.0, 1e-9), (7e6, 7e6, 7.5e3, 7.5e3, 1.0, 1e-12),
    ),
    Unlike(
        "electron in fields", electron, 3e-6,
        (1e-3, 0.0, 1e-3, 0.0, 1e6, 0.0), (0.1, 0.1, 1e-3, 1e6, 1e6, 1e3),
    ),
    Unlike(
        "probe past the moon", probe, 864000.0, (6.6e6, 0.0, 0.0, 10900.0),
        (1e8, 1e8, 1e3, 1e3),
    ),
)  # fmt: skip
