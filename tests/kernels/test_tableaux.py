"""Order conditions of every table, in rational arithmetic, and tables that are refused."""

import functools
import itertools
import math
import re
from fractions import Fraction

import numba
import numpy as np
import pytest

from fastdyn.kernels.methods import METHODS, rk45
from fastdyn.kernels.methods.explicit import pair, single
from fastdyn.kernels.methods.order_conditions import Conditions, density, trees
from fastdyn.kernels.methods.tableau import Row, Table, tableau
from fastdyn.kernels.output.dense_output import hermite, polynomial
from fastdyn.kernels.state.record import Y_OLD, K, Y
from support import few

EPS = float(np.finfo(float).eps)
TABLED = {name: m for name, m in METHODS.items() if "a" in (m.tableau or {})}
PAIRS = [name for name, m in TABLED.items() if m.error_order]
EMBEDDED = {name: (m.error_order,) for name, m in TABLED.items()} | {"DOP853": (5, 3)}

# Significant digits of the shortest rounded coefficients in a source that prints decimals.
DIGITS = {"DOP853": 28, "Tsit5": 39, "Vern7": 33, "Vern9": 33}


def digit(name):
    return 10.0 ** (1 - DIGITS[name]) if name in DIGITS else 0.0


@functools.cache
def table(name):
    return Conditions(TABLED[name].tableau, digit(name), Fraction)


def test_the_trees_are_counted_right():
    assert [len(trees(n)) for n in range(1, 11)] == [1, 1, 2, 4, 9, 20, 48, 115, 286, 719]


def test_the_densities_count_the_orderings_of_the_trees():
    # n! / (gamma sigma) orderings of a tree of n nodes; over all trees they sum to (n - 1)!.
    def symmetry(tree):
        kinds = set(tree)
        return math.prod(
            math.factorial(tree.count(k)) * symmetry(k) ** tree.count(k) for k in kinds
        )

    for n in range(1, 11):
        orderings = [Fraction(math.factorial(n), density(t) * symmetry(t)) for t in trees(n)]
        assert sum(orderings) == math.factorial(n - 1)


@pytest.mark.parametrize("name", TABLED)
def test_every_stage_uses_those_before_it(name):
    t = table(name)
    assert all(x == 0 for i, row in enumerate(t.a) for x in row[i:])
    assert len(t.a) == len(TABLED[name].tableau["c"]) == TABLED[name].n_rows


@pytest.mark.parametrize("name", TABLED)
def test_stage_times_are_row_sums(name):
    for row, c in zip(table(name).a, TABLED[name].tableau["c"].exact, strict=True):
        assert abs(sum(row) - c) <= digit(name) * (sum(abs(row)) + c)


OF_ORDER_9 = few.hunts(TABLED, *(name for name in TABLED if TABLED[name].order < 9))  # 3 s


@pytest.mark.parametrize("name", OF_ORDER_9)
def test_order_is_as_stated_and_no_higher(name):
    t = table(name)
    assert t.order(t.b)[0] == TABLED[name].order


@pytest.mark.few(4)
@pytest.mark.parametrize("name", PAIRS)
def test_error_rows_are_differences_to_methods_of_lower_order(name):
    t = table(name)
    for e, order in zip(t.errors, EMBEDDED[name], strict=True):
        assert abs(sum(e)) <= digit(name) * sum(abs(e))
        assert t.order(*t.embedded(e))[0] == order


@pytest.mark.parametrize("name", TABLED)
def test_last_stage_is_the_derivative_at_the_end_of_the_step(name):
    t = table(name)
    assert (t.a[t.fsal_stage] == t.b).all()
    assert TABLED[name].tableau["c"].exact[t.fsal_stage] == 1
    assert t.fsal_stage == TABLED[name].fsal_stage == TABLED[name].n_stages


@pytest.mark.few(5)
@pytest.mark.parametrize("x", [Fraction(1, 7), Fraction(1, 2), Fraction(9, 10)], ids=str)
@pytest.mark.parametrize("name", TABLED)
def test_dense_output_has_its_order_inside_the_step(name, x):
    t = table(name)
    assert t.order(*t.interpolant(x), x)[0] == TABLED[name].dense_order


@pytest.fixture(scope="module")
def value():
    """`polynomial`, callable from Python."""

    @numba.njit
    def called(d, x, out):
        polynomial(d, x, out)

    return called


@pytest.mark.parametrize("name", TABLED)
def test_the_compiled_interpolant_is_the_one_examined(name, value):
    # Stages e_1 ... e_n, so that component i of the state shows the weight of stage i.
    t, h = table(name), 0.25
    work, d = np.zeros((K + t.n, t.n)), np.zeros((4 + len(t.extra), t.n))
    work[K:], work[Y] = np.eye(t.n), 0.5 + h * np.array(t.b, dtype=float)
    work[Y_OLD] = 0.5
    hermite.py_func(h, t.fsal_stage, work, d)
    d[4:] = h * np.array(t.extra, dtype=float).reshape(-1, t.n)
    found = np.empty(t.n)
    for x in (Fraction(0), Fraction(1, 8), Fraction(1, 2), Fraction(7, 8), Fraction(1)):
        value(d, float(x), found)
        b, _ = t.interpolant(x)
        allowed = 4 * EPS * len(d) * np.abs(d).sum(axis=0)
        assert (np.abs(found - 0.5 - h * np.array(b, dtype=float)) <= allowed).all()
    assert TABLED[name].n_dense == len(d) - 1


A, B, E = tableau("1/3: 1/3; 2/3: 0 2/3"), Row("1/4 0 3/4"), Row("1/4 -1/2 1/4 0")


def heun(table=None, **orders):
    """A pair, as in `tests/methods/test_a_new_method.py`, with these orders."""
    orders = {"order": 3, "error_order": 2, "dense_order": 3} | orders
    return pair("Heun", table or Table(A, B, (E,)), **orders)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Row("3/40 9/4O"), "'9/4O' is no coefficient"),
        (lambda: tableau("1/3: 1/3 2/3: 0 2/3"), "stage 2 of a tableau is '1/3: 1/3 2/3: 0 2/3'"),
        (lambda: tableau("1/3: 1/3;"), "stage 3 of a tableau is ''"),
        (lambda: Table(tableau("1/3: 1/3; 2/3: 2/3"), B), "stage 3 has 1 coefficients instead of"),
        (lambda: Table(tableau("1/3: 1/3; 2/3: 0 3/2"), B), "stage 3 has the sum 1.5 instead of"),
        (lambda: Table(tableau("0: 0"), Row("1/2 1/2")), "stage 2 has no coefficient but zeros"),
        (lambda: Table(A, Row("1/4 3/4")), "b has 2 coefficients instead of 3, one for each stage"),
        (lambda: Table(A, Row("1/4 0 1/4")), "b has the sum 0.5 instead of 1: 1/4 0 1/4"),
        (lambda: Table(A, "1/4 0 3/4"), "b is a Row, got '1/4 0 3/4'"),
        (lambda: Table(A, B, E), "errors is a tuple of Rows, got one Row: write (E,)"),
        (lambda: Table(A, B, (Row("0 1/2 1/2 0"),)), "row 1 of errors has the sum 1 instead of 0"),
        (lambda: Table(A, B, (Row("1/2 -1/2 0"),)), "row 1 of errors has 3 coefficients instead"),
        (lambda: Table(A, B, (E,), (Row("1 -1"),)), "row 1 of d has 2 coefficients instead of 4"),
        (lambda: Table(A, B, (E,), (), tableau("1/2: 1/2")), "stage 5 has 1 coefficients instead"),
        (lambda: heun(Table(A, B)), "Heun: a pair needs a row of errors, got none"),
        (lambda: heun(order=4), "order=4 is given, but the weights b are of order 3: sum(b c^3)"),
        (lambda: heun(order=2), "order=2 is given, but the weights b satisfy the conditions of"),
        (lambda: heun(error_order=3), "error_order=3 is given, but the weights (b - e) are of"),
        (lambda: heun(dense_order=4), "dense_order=4 is given, but the weights b(x = 0.3) are of"),
    ],
)  # fmt: skip
def test_a_wrong_table_is_refused_in_a_sentence(make, sentence):
    with pytest.raises((ValueError, TypeError), match=re.escape(sentence)) as refused:
        make()
    assert "\n" not in str(refused.value)


def with_row(where, i, row):
    """The table of RK45 with another row of this field."""
    times, stages = rk45.STAGES
    fields = {"stages": stages, "b": (rk45.B,), "errors": (rk45.E,), "d": (rk45.D,)}
    rows = [*fields[where]]
    rows[i] = row
    fields[where] = tuple(rows)
    return Table((times, fields["stages"]), *fields["b"], fields["errors"], fields["d"])


ROWS = [("stages", i, row) for i, row in enumerate(rk45.STAGES[1])]
ROWS += [("b", 0, rk45.B), ("errors", 0, rk45.E), ("d", 0, rk45.D)]


@pytest.mark.parametrize(("where", "i", "row"), ROWS, ids=lambda x: "" if x is None else str(x)[:9])
def test_any_wrong_or_exchanged_coefficient_is_found(where, i, row):
    for j, a in enumerate(row.exact):
        wrong = [*row.exact]
        wrong[j] = a * (1 + Fraction(1, 10**12)) if a else Fraction(1, 10**12)
        with pytest.raises(ValueError, match="has the sum"):
            with_row(where, i, Row.of(wrong))
    for j, k in itertools.combinations(range(len(row)), 2):
        wrong = [*row.exact]
        wrong[j], wrong[k] = wrong[k], wrong[j]
        with pytest.raises(ValueError, match=r"order=\d is given, but the weights"):
            pair("RK45", with_row(where, i, Row.of(wrong)), order=5, error_order=4, dense_order=4)


def test_decimals_are_as_exact_as_they_are_printed():
    third = "1/3: .3333333333; 2/3: 0 .6666666667"
    made = Table(tableau(third), Row(".25 0 .75"))
    assert made.accuracy == 1e-9
    assert single("Heun", made, order=3, dense_order=3).facts.order == 3
    with pytest.raises(ValueError, match=r"stage 3 has the sum 0\.6666666767"):
        Table(tableau(third.replace("667", "767")), Row(".25 0 .75"))
