"""SciPy's own tests of odeint and ode, read from the installed SciPy, run against ours."""

import inspect
import pathlib
import types

import pytest
import scipy.integrate.tests as suite

from fastdyn import integrate

FOLDER = pathlib.Path(suite.__file__).parent
FILES = [
    FOLDER / "test_integrate.py",
    FOLDER / "test_banded_ode_solvers.py",
    FOLDER / "test_odeint_jac.py",  # until SciPy 1.16
]
NAMES = "odeint", "ode", "complex_ode"


def _module(path):
    module = types.ModuleType(f"scipy_{path.stem}")
    module.__file__ = str(path)
    exec(compile(path.read_text(), str(path), "exec"), module.__dict__)
    for name in NAMES:
        if hasattr(module, name):
            setattr(module, name, getattr(integrate, name))
    return module


MODULES = [_module(path) for path in FILES if path.exists()]


def _cases():
    for module in MODULES:
        for name, test in vars(module).items():
            if name.startswith("test_"):
                yield pytest.param(test, id=name)
            elif name.startswith("Test") and isinstance(test, type):
                for part in dir(test):
                    if part.startswith("test_"):
                        yield pytest.param(getattr(test(), part), id=f"{name}.{part}")


def test_the_suite_has_tests():
    assert len([*_cases()]) >= 5


@pytest.mark.filterwarnings("ignore:.*:fastdyn.CompileWarning")
@pytest.mark.parametrize("test", [*_cases()])
def test_of_scipy(test):
    threads = {"num_parallel_threads": 1}
    test(**{k: v for k, v in threads.items() if k in inspect.signature(test).parameters})
