"""A new pair is one file and one line: everything else finds the pair, and reads its facts."""

import argparse
import hashlib

import numba
import numpy as np
import pytest

from bench.report import methods as report
from fastdyn import METHODS, Stepper, energy_drift, prepare, solve_ensemble, solve_ivp
from fastdyn.cli import checks
from fastdyn.kernels import methods
from fastdyn.kernels.methods import BY_NAME, COMPLEX, FILES
from fastdyn.specialise.scalar import every_kernel
from fastdyn.systems import satellite
from support.steppers import ended

FILE = '''
"""Heun's method of order 3 with an error estimate of order 2."""

from .explicit import pair
from .tableau import Row, Table, tableau

B = Row("1/4 0 3/4")
TABLE = Table(tableau("1/3: 1/3; 2/3: 0 2/3"), B, (B - Row("0 1/2 1/2 0"),))
HEUN = pair("NAME", TABLE, order=3, error_order=2, dense_order=3)
'''
NAME = f"Heun{hashlib.sha256(FILE.encode()).hexdigest()[:8]}"  # kernels are kept by their names
TIGHT = {"method": NAME, "rtol": 1e-8, "atol": 1e-8}


@pytest.fixture(scope="module", autouse=True)
def new(tmp_path_factory):
    """The file in a folder of its own, and the line."""
    folder = tmp_path_factory.mktemp("methods")
    (folder / f"{NAME.lower()}.py").write_text(FILE.replace("NAME", NAME))
    methods.__path__.append(str(folder))
    FILES[NAME] = NAME.lower()
    methods.register(NAME, FILES[NAME])
    yield
    methods.__path__.remove(str(folder))
    for table in FILES, methods._real, methods._complex, *BY_NAME.maps:
        table.pop(NAME, None)
    BY_NAME.maps[1].pop(f"{NAME} on complex states", None)


def turning(t, y):
    return [y[1], -y[0]]


def test_the_facts_are_read_from_the_file():
    facts = METHODS[NAME]
    assert (facts.order, facts.error_order, facts.dense_order, facts.n_stages) == (3, 2, 3, 3)
    assert facts.stable_to == 2.51  # of all methods of order 3 with 3 stages
    assert facts.code.facts == facts._replace(file="") and not facts.like_matlab
    assert COMPLEX[NAME].start == "methods.complex_states.hairer_of_pairs"
    assert {f"advance {NAME}", f"advance {NAME} on complex states"} <= every_kernel().keys()


@pytest.mark.parametrize("compile", ["shared", "inlined"])
def test_solve_ivp(compile):
    r = solve_ivp(turning, (0, 3), [0.0, 1.0], compile=compile, dense_output=True, **TIGHT)
    t = np.linspace(0, 3, 50)
    np.testing.assert_allclose(r.sol(t)[0], np.sin(t), atol=1e-6)
    assert r.nfev == 3 * (r.n_accepted + r.n_rejected) + 2
    errors = []
    for h in (0.1, 0.05):
        r = solve_ivp(turning, (0, 3), [0.0, 1.0], NAME, max_step=h, rtol=1e-2)
        errors.append(abs(r.y[0, -1] - np.sin(3)))
    assert abs(np.log2(errors[0] / errors[1]) - 3) < 0.3


def test_complex_states():
    r = solve_ivp(lambda t, z: 1j * z, (0, 3), [1.0 + 0j], **TIGHT)
    assert abs(r.y[0, -1] - np.exp(3j)) < 1e-6


def test_other_solvers():
    assert abs(prepare(turning, (0, 3), [0.0, 1.0], **TIGHT)().y[0, -1] - np.sin(3)) < 1e-6
    stepper = ended(Stepper(turning, 0.0, [0.0, 1.0], 3.0, **TIGHT))
    assert abs(stepper.y[0] - np.sin(3)) < 1e-6
    many = solve_ensemble(
        lambda t, y, k: [y[1], -k * y[0]], (0, 3), [0.0, 1.0], args=(np.linspace(1, 2, 9),), **TIGHT
    )
    assert abs(many.y[0, 0] - np.sin(3)) < 1e-6
    drift = energy_drift(satellite(V=1.1), NAME, periods=20, rtol=1e-6, atol=1e-9)
    assert NAME in str(drift)


def test_messages_and_tables_name_the_method():
    with pytest.raises(ValueError, match=NAME):
        solve_ivp(turning, (0, 1), [0.0, 1.0], "a method")
    with pytest.raises(ValueError, match=f"RK4 does not take `nonnegative`.*{NAME}"):
        solve_ivp(turning, (0, 1), [0.0, 1.0], "RK4", step=0.1, nonnegative=True)
    assert checks.method(NAME) == NAME
    with pytest.raises(argparse.ArgumentTypeError, match=f"did you mean {NAME}"):
        checks.method(f"{NAME}x")
    assert f'| `"{NAME}"` | 3 | 3 | adaptive | y\' = f(t, y) | yes |' in report.table()
    assert f'"{NAME}": [{{"name": "{NAME}"' in report.facts()


def test_what_is_kept_of_the_others_is_what_their_files_say():
    """`python -m bench.report.methods` has been run."""
    page = report.PAGE.read_text()
    for text, kept in ((report.facts(), methods.KEPT.read_text()), (report.table(), page)):
        lines = {line.rstrip(",") for line in text.splitlines() if NAME not in line}
        assert lines <= {line.rstrip(",") for line in kept.splitlines()}


def test_the_docstring_of_solve_ivp_names_each_method():
    """A new pair has a line there; the pair of these tests has none."""
    assert {name for name in METHODS if f'"{name}"' not in solve_ivp.__doc__} == {NAME}


def test_kernels_of_one_name_are_one_kernel():
    """Methods with one name for the start, or the interpolant, have one function."""
    starts, rows = {}, {}
    for facts in BY_NAME.values():
        code = facts.code
        assert starts.setdefault(facts.start, code.start) is code.start
        assert rows.setdefault(facts.dense_rows, code.dense_rows) is code.dense_rows


def test_messages_of_numba_show_the_lines_of_a_step():
    step = METHODS[NAME].code.kernel.args[0]
    with pytest.raises(
        numba.TypingError, match=r'"<step of .*", line 6:\n(.|\n)*k2 = rhs\(t \+ 1/3 \* h'
    ):
        step(None, 0.0, "no state", *[None] * 7)
