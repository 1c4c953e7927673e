"""Claims about the tables of the symplectic methods, in arithmetic of 60 digits."""

import itertools
import math
from decimal import Decimal, getcontext, localcontext

import numpy as np
import pytest

import fastdyn
from fastdyn.kernels.methods import METHODS, symplectic
from fastdyn.kernels.methods.gauss import legendre
from fastdyn.solve import solve_second_order, solve_separable

EPS = np.finfo(float).eps

PRINTED = Decimal("1e-24")  # digits in the tables


@pytest.fixture(autouse=True)
def many_digits():
    with localcontext() as context:
        context.prec = 60
        yield


def palindrome(text, n):
    first = [Decimal(word) for word in text.split()]
    return first + first[: n - len(first)][::-1]


def verlet_steps(text, n):
    g = palindrome(text, n)
    half = [x / 2 for x in g]
    return [half[0], *(a + b for a, b in itertools.pairwise(half)), half[-1]], g


def tables():
    s = symplectic
    return {
        "VelocityVerlet": ([Decimal("0.5")] * 2, [Decimal(1)]),
        "BlanesMoanPRK4": (palindrome(s.BM_PRK4_KICKS, 7), palindrome(s.BM_PRK4_DRIFTS, 6)),
        "BlanesMoan4": (palindrome(s.BM4_KICKS, 7), palindrome(s.BM4_DRIFTS, 6)),
        "BlanesMoan6": (palindrome(s.BM6_KICKS, 12), palindrome(s.BM6_DRIFTS, 11)),
        "KahanLi8": verlet_steps(s.KL8, 17),
        "SofroniouSpaletta10": verlet_steps(s.SS10, 35),
        "Yoshida4": verlet_steps(s.Y4, 3),
        "Yoshida6": verlet_steps(s.Y6, 7),
        "Yoshida8": verlet_steps(s.Y8, 15),
    }


def force(q):
    return -q - q * q


def exact(q, p, h, c, terms=60):
    """q and p after h by their Taylor series: q' = p + c p², p' = -q - q²."""
    a, b = [q], [p]
    for k in range(terms):
        of_p, of_q = (sum((x[i] * x[k - i] for i in range(k + 1)), Decimal(0)) for x in (b, a))
        a.append((b[k] + c * of_p) / (k + 1))
        b.append((-a[k] - of_q) / (k + 1))
    return tuple(sum((x * h**k for k, x in enumerate(one)), Decimal(0)) for one in (a, b))


def composed(kicks, drifts, q, p, h, c):
    p += kicks[0] * h * force(q)
    for kick, drift in zip(kicks[1:], drifts, strict=True):
        q += drift * h * (p + c * p * p)
        p += kick * h * force(q)
    return q, p


def order_of_one_step(name, c):
    """For T = p² / 2 + c p³ / 3."""
    if name == "McLachlanAtela4":  # printed with 16 digits: as floats
        table = METHODS[name].tableau
        kicks, drifts = ([Decimal(float(x)) for x in table[part]] for part in ("kicks", "drifts"))
        steps, digits = (Decimal("0.04"), Decimal("0.02")), Decimal("1e-15")
    else:
        kicks, drifts = tables()[name]
        steps, digits = (Decimal("0.02"), Decimal("0.01")), PRINTED
    assert abs(sum(kicks) - 1) < digits and abs(sum(drifts) - 1) < digits
    q, p = Decimal("0.7"), Decimal("-0.4")
    errors = []
    for h in steps:
        found, true = composed(kicks, drifts, q, p, h, c), exact(q, p, h, c)
        errors.append(max(abs(a - b) for a, b in zip(found, true, strict=True)))
    return math.log2(errors[0] / errors[1]) - 1


@pytest.mark.parametrize(
    "name", [n for n, m in METHODS.items() if m.second_order and "Gauss" not in n]
)
def test_the_order_of_one_step_in_sixty_digits(name):
    """Of Nystrom tables for quadratic T, of the others for any; and what the former lose."""
    method = METHODS[name]
    assert abs(order_of_one_step(name, 0) - method.order) < 0.3
    lower = {"McLachlanAtela4": 3, "BlanesMoan6": 4}
    assert (not method.separable) == (name in {"BlanesMoan4", *lower})
    assert abs(order_of_one_step(name, 1) - lower.get(name, method.order)) < 0.3


@pytest.mark.parametrize("name", tables())
def test_the_compiled_table_is_the_printed_one(name):
    table = METHODS[name].tableau
    for part, printed in zip(("kicks", "drifts"), tables()[name], strict=True):
        assert np.allclose(table[part], [float(x) for x in printed], rtol=2 * EPS, atol=EPS)
        assert np.array_equal(table[part], table[part][::-1])


@pytest.mark.parametrize("s", [2, 4, 8])
def test_gauss_satisfies_the_simplifying_conditions(s):
    """B(2s), C(s) and D(s) of J. C. Butcher (1964), to 38 digits."""
    a, (c, b) = legendre.collocation(s), legendre.nodes_and_weights(s)
    small = Decimal("1e-38")
    for k in range(1, 2 * s + 1):
        assert (
            abs(sum(w * x ** (k - 1) for w, x in zip(b, c, strict=True)) - Decimal(1) / k) < small
        )
    for k in range(1, s + 1):
        for i in range(s):
            left = sum(a[i][j] * c[j] ** (k - 1) for j in range(s))
            assert abs(left - c[i] ** k / k) < small
            left = sum(b[j] * c[j] ** (k - 1) * a[j][i] for j in range(s))
            assert abs(left - b[i] * (1 - c[i] ** k) / k) < small


def test_two_stages_are_the_familiar_ones():
    root = Decimal(3).sqrt() / 6
    (first, second), weights = legendre.nodes_and_weights(2)
    assert abs(first - (Decimal("0.5") - root)) < Decimal("1e-50")
    assert abs(second - (Decimal("0.5") + root)) < Decimal("1e-50")
    assert all(abs(w - Decimal("0.5")) < Decimal("1e-50") for w in weights)
    assert getcontext().prec == 60


@pytest.mark.parametrize("order", [8, 16])
def test_nystrom_is_the_same_method(order):
    def fun(t, y):
        return [y[2], y[3], -math.sin(y[0]) + 0.1 * y[1], 0.1 * math.sin(t) - 2.0 * y[1]]

    given = {"t_span": (0, 10), "y0": [0.5, 0.1, -0.3, 0.2], "step": 0.1, "dense_output": True}
    names = f"GaussNystrom{order}", f"Gauss{order}"
    a, b = (fastdyn.solve_ivp(fun, method=name, **given) for name in names)
    t = np.linspace(0, 10, 77)
    assert np.abs(a.y - b.y).max() < 200 * EPS and np.abs(a.sol(t) - b.sol(t)).max() < 1e-13
    assert a.nfev < 0.8 * b.nfev


@pytest.mark.parametrize("name", ["Gauss4", "Gauss8", "Gauss16"])
def test_rounded_coefficients_are_symplectic_exactly(name):
    mu = np.array(METHODS[name].tableau["mu"])
    assert np.array_equal(mu + mu.T, np.ones_like(mu))


@pytest.mark.parametrize("name", [name for name, m in METHODS.items() if m.file == "gauss.methods"])
def test_rounded_coefficients_are_symmetric_exactly(name):
    mu = np.array(METHODS[name].tableau["mu"])
    assert np.array_equal(mu + mu[::-1, ::-1], np.ones_like(mu))


@pytest.mark.few(3)
@pytest.mark.parametrize("name", [m.name for m in METHODS.values() if m.backward == "kicks"])
def test_the_energy_between_steps_is_that_at_steps(name):
    """At the times of the output, of events, and of the dense output; also of a Hamiltonian."""

    def kepler(t, q):
        return -q / np.hypot(*q) ** 3

    def energy(y):
        return 0.5 * (y[2] ** 2 + y[3] ** 2) - 1.0 / np.hypot(y[0], y[1])

    step, t_eval = 2 * np.pi / 80, np.linspace(0.01, 50.0, 301)
    given = (kepler, (0.0, 51.0), [0.7, 0.0], [0.0, np.sqrt(13 / 7)], name)
    whole = solve_second_order(*given, step=step, dense_output=True, events=lambda t, y: y[1])
    start = energy(whole.y[:, 0])
    at_steps = np.abs(energy(whole.y) - start).max() + 2e-15
    some = solve_second_order(*given, step=step, t_eval=t_eval).y
    assert np.array_equal(some, whole.sol(t_eval))
    for y in (some, whole.y_events[0].T):
        assert np.abs(energy(y) - start).max() < 2 * at_steps
    if METHODS[name].separable:
        q0, v0 = given[2:4]
        apart = solve_separable(
            lambda t, p: p, kepler, (0.0, 51.0), q0, v0, name, step=step, t_eval=t_eval
        ).y
        assert np.abs(energy(apart) - start).max() < 2 * at_steps
