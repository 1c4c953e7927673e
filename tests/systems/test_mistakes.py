"""Mistakes in how a system is called: sentences that say what to do."""

import warnings

import numpy as np
import pytest

from fastdyn import energy_drift, prepare, solve_ensemble, solve_ivp, systems
from fastdyn.drift import compare_drift


@pytest.mark.parametrize("name", ["solve", "ensemble"])
@pytest.mark.parametrize("args", [(), ((0, 10),), (10,)])
def test_methods_of_a_class_say_what_to_write(name, args):
    with pytest.raises(TypeError, match=rf"write pendulum\(\)\.{name}\("):
        getattr(systems.pendulum, name)(*args)
    with pytest.raises(TypeError, match=r"pendulum\(\), not its class"):
        energy_drift(systems.pendulum, step=0.1, n_steps=10)


def test_a_class_may_name_its_method():
    run = systems.pendulum.solve(systems.pendulum(), (0, 1))
    assert run.success and "Integrate the equations" in systems.pendulum.solve.__doc__


def test_a_number_is_no_span():
    for solve in (systems.pendulum().solve, systems.pendulum().ensemble, systems.cable().solve):
        with pytest.raises(TypeError, match=r"start and end; got 10: \(0, 10\)\?"):
            solve(10)
    for solve in (
        lambda t_span: solve_ivp(lambda t, y: -y, t_span, [1.0]),
        lambda t_span: solve_ensemble(lambda t, y: -y, t_span, [1.0]),
    ):  # fmt: skip
        with pytest.raises(TypeError) as found:  # SciPy's, with a note
            solve(10)
        assert "start and end; got 10: (0, 10)?" in found.value.__notes__[0]


UNKNOWN = [
    ("rtoll", "rtol"), ("RelTol", "rtol"), ("AbsTol", "atol"), ("maxstep", "max_step"),
    ("tol", "rtol"), ("evnets", "events"), ("dt", "step"), ("teval", "t_eval"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "meant"), [*UNKNOWN, ("V_0", "V0")])
def test_unknown_options_are_errors(name, meant):
    pendulum = systems.pendulum()
    for solve in (
        pendulum.solve, pendulum.ensemble, lambda **o: pendulum.solve(method="auto", **o),
    ):  # fmt: skip
        with pytest.raises(TypeError, match=f"takes no `{name}`; did you mean `{meant}`"):
            solve(**{name: 1e-3})


@pytest.mark.parametrize(("name", "meant"), UNKNOWN[:4])
def test_unknown_options_of_other_studies(name, meant):
    for study in (
        lambda **o: energy_drift(systems.pendulum(), step=0.1, n_steps=10, **o),
        lambda **o: compare_drift(
            systems.pendulum(), ["Gauss4"], evaluations=100, periods=1, **o
        ),
        lambda **o: solve_ensemble(lambda t, y: -y, (0, 1), [1.0], **o),
        lambda **o: prepare(lambda t, y: -y, (0, 1), [1.0], **o),
    ):  # fmt: skip
        with pytest.raises(TypeError, match=f"takes no `{name}`; did you mean `{meant}`"):
            study(**{name: 1e-3})


def test_a_parameter_is_not_of_solve():
    with pytest.raises(TypeError, match=r"pendulum\(l=2.0\).solve\(\)"):
        systems.pendulum().solve(l=2.0)


def test_what_resembles_nothing():
    with pytest.raises(TypeError, match=r"takes no `xyzzy`\."):
        systems.pendulum().solve(xyzzy=1)


def test_solve_ivp_warns_as_scipy_does_and_says_what_may_be_meant():
    with pytest.warns(UserWarning, match=r"no effect .*`rtoll`.*did you mean `rtol`\?"):
        run = solve_ivp(lambda t, y: -y, (0, 1), [1.0], rtoll=1e-9)
    assert run.success
    with pytest.warns(UserWarning, match=r"no effect for a chosen solver: `jac`\.$"):
        solve_ivp(lambda t, y: -y, (0, 1), [1.0], jac=None)


def test_auto_of_a_system():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run = systems.pendulum().solve((0, 1), method="auto")
    assert run.method == "Taylor" and np.isfinite(run.y).all()
