"""The fields of a record say the same of an operation: value, derivative, series, domain."""

import itertools
import math

import numpy as np
import pytest

from fastdyn.code_store.loader import provider
from fastdyn.trace.operations import OPERATIONS
from fastdyn.trace.operations.delays import PASTS
from fastdyn.trace.operations.value import Value, by_rule

X = np.array([-3.7, -1.4, -0.8, -0.3, 0.2, 0.6, 0.9, 1.3, 2.6])
OF_NUMBERS = [r for r in OPERATIONS.values() if r.name not in PASTS]  # a past has no numbers
SMOOTH = [r for r in OF_NUMBERS if r.factors and not (r.tables or r.truth)]
DELICATE = (0.0, -0.0, 1.0, -1.0, -2.0, 0.5, 3.0, -1e300, 1e300, math.inf, -math.inf, math.nan)
ULPS = 64


class Numbers:
    """Rules compute with whatever has `call` and `const`: here with arrays of NumPy."""

    const = staticmethod(float)

    def call(self, operation, *values, data=None):
        formula = OPERATIONS[operation].formula
        if formula:
            return by_rule(self, formula, *values)
        return OPERATIONS[operation].value(*values)


G = Numbers()


def named(record):
    return record.name


def operands(record):
    """All combinations of numbers; the condition of a select, and no whole multiples in fmod."""
    columns = [X + 0.01 * i for i in range(len(record.factors))]
    if record.name == "select":
        columns[0] = X > 0
    return np.meshgrid(*columns)


def same(a, b, rtol):
    """Equal where both are numbers, of which there are some."""
    a, b = np.broadcast_arrays(a, b)
    known = np.isfinite(a) & np.isfinite(b)
    assert known.any()
    np.testing.assert_allclose(a[known], b[known], rtol=rtol, atol=rtol)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("record", SMOOTH, ids=named)
def test_derivatives(record):
    given = operands(record)
    value = record.value(*given)
    for i, factor in enumerate(record.factors):
        if given[i].dtype == bool:
            continue
        h = 1e-6 * np.maximum(1.0, np.abs(given[i]))
        sides = [record.value(*given[:i], given[i] + s * h, *given[i + 1 :]) for s in (1, -1)]
        same(by_rule(G, factor, value, *given), (sides[0] - sides[1]) / (2 * h), 2e-6)
        if record.slopes and record.slopes[i]:
            of_series = by_rule(G, record.slopes[i], value, *given)
            same(of_series, by_rule(G, factor, value, *given), 1e-13)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("record", [r for r in SMOOTH if r.series], ids=named)
def test_series_are_of_the_value(record):
    given = operands(record)
    same(by_rule(G, record.series, *given), record.value(*given), ULPS * np.finfo(float).eps)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("record", [r for r in OPERATIONS.values() if r.parity], ids=named)
def test_parities(record):
    sign = 1.0 if record.parity == "even" else -1.0
    np.testing.assert_array_equal(record.value(-X), sign * record.value(X))


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("record", [r for r in OPERATIONS.values() if r.monotone], ids=named)
def test_monotone_functions(record):
    values = record.value(np.linspace(-3.0, 3.0, 301))
    steps = np.diff(values[np.isfinite(values)])
    assert (steps > 0.0).all() or (steps < 0.0).all()


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("record", [r for r in OPERATIONS.values() if r.in_math], ids=named)
def test_domains(record):
    """Where `math` raises, a condition holds, and its function raises likewise."""
    for given in itertools.product(DELICATE, repeat=2 if record.name in _OF_TWO else 1):
        numbers = [Value(G, np.float64(v)) for v in (record.value(*given), *given)]
        raising = [f for c, f in record.raises(record.in_math, *numbers) if c.of]
        try:
            record.in_math(*given)
        except (ValueError, OverflowError) as error:
            assert raising, given
            with pytest.raises(type(error)):
                raising[0]()


_OF_TWO = {"atan2", "fmod"}


def test_functions_of_c_can_be_linked():
    for record in OPERATIONS.values():
        if record.elementary and not record.llvm:
            assert provider(record.name) in ("libm", "scipy")
