"""SciPy's own tests of solve_ivp, read from the installed SciPy, run against ours."""

import pathlib
import types

import pytest
import scipy.integrate._ivp.tests as suite
from scipy.integrate import BDF, DOP853, RK23, RK45, Radau

import fastdyn
from fastdyn.solve import by_method

SOURCE = pathlib.Path(suite.__file__).with_name("test_ivp.py")

# Tests of SciPy that fastdyn fails on purpose, each with its reason.
DEVIATIONS = {}


def _module():
    module = types.ModuleType("scipy_test_ivp")
    module.__file__ = str(SOURCE)
    exec(compile(SOURCE.read_text(), str(SOURCE), "exec"), module.__dict__)
    module.solve_ivp, module.OdeSolution = fastdyn.solve_ivp, fastdyn.OdeSolution
    return module


MODULE = _module()


def _cases():
    for name, test in vars(MODULE).items():
        if not name.startswith("test_") or not callable(test):
            continue
        marks = [m for m in getattr(test, "pytestmark", []) if m.name == "parametrize"]
        if marks:
            names, values = marks[0].args[:2]
            yield from (pytest.param(test, {names: v}, id=f"{name}[{v}]") for v in values)
        else:
            yield pytest.param(test, {}, id=name)


@pytest.fixture
def delegated(monkeypatch):
    """The methods of the solves that are left to SciPy, but for those without anything to solve."""
    found, by_scipy = [], by_method.by_scipy

    def noted(asked, method):
        if len(asked.y0) and asked.t0 != asked.tf:
            found.append(method)
        return by_scipy(asked, method)

    monkeypatch.setattr(by_method, "by_scipy", noted)
    return found


@pytest.mark.parametrize(("test", "given"), list(_cases()))
def test_of_scipy(test, given, delegated):
    arguments = dict(given)
    if "num_parallel_threads" in test.__code__.co_varnames[: test.__code__.co_argcount]:
        arguments["num_parallel_threads"] = 1
    reason = DEVIATIONS.get(test.__name__)
    if reason is None:
        test(**arguments)
    else:
        with pytest.raises(AssertionError):
            test(**arguments)
    own = (RK23, RK45, DOP853, Radau, BDF)
    names = {method.__name__: method for method in own}
    assert not [m for m in delegated if m in own or m in names]
