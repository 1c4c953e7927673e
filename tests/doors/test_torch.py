"""`fastdyn.torch`: autograd through a solve."""

import functools

import numpy as np
import pytest

import fastdyn
from tests.doors import problems
from tests.doors.problems import TIGHT, TIMES, pendulum

torch = pytest.importorskip("torch")

from fastdyn.torch import solve_ivp  # noqa: E402

STRAY = torch.tensor(9.81, dtype=torch.float64)


def varying(*values):
    made = [torch.as_tensor(np.asarray(value, float)) for value in values]
    return [each.requires_grad_() for each in made]


def states(y0, *args, method="Tsit5", fun=pendulum, **options):
    return solve_ivp(fun, (0, 3), y0, method, TIMES, args=args, **{**TIGHT, **options}).y


def test_the_outputs_are_those_of_solve_ivp():
    known = fastdyn.solve_ivp(pendulum, (0, 3), [1, 0], "Tsit5", TIMES, args=(9.81, 0.2), **TIGHT)
    found = solve_ivp(pendulum, (0, 3), [1, 0], "Tsit5", TIMES, args=(STRAY, 0.2), **TIGHT)
    assert np.array_equal(found.y, known.y) and np.array_equal(found.t, TIMES)
    assert found.status == 0 and found.t_events is None and not found.y.requires_grad


@pytest.mark.filterwarnings("ignore:`torch.jit.script` is deprecated")
def test_gradcheck():
    few = varying([1.0, 0.0], 9.81, 0.2)
    for method in ("Tsit5", "Radau"):
        solve = functools.partial(states, method=method)
        assert torch.autograd.gradcheck(solve, few, check_forward_ad=True)
    solve = functools.partial(states, fun=problems.chain)
    many = varying(np.append(np.sin(np.arange(1, 6)), np.zeros(5)), np.linspace(0.5, 2.0, 6))
    assert torch.autograd.gradcheck(solve, many, rtol=1e-4)


def test_only_what_is_asked_for_is_differentiated():
    y0, k, d = varying([1.0, 0.0], 9.81, 0.2)
    states([y0[0], 0.0], k.detach(), d).sum().backward()
    assert k.grad is None and y0.grad[1] == 0.0
    whole = torch.autograd.functional.jacobian(lambda d: states([1.0, 0.0], 9.81, d).sum(), d)
    assert torch.allclose(d.grad, whole, rtol=1e-9)


def test_the_time_of_an_event():
    (k,) = varying(0.1)
    found = solve_ivp(problems.fall, (0, 9), [10.0, 0.0], "DOP853", [1.0, 5.0], problems.ground,
                      (k,), **TIGHT)  # fmt: skip
    found.t_events[0][0].backward(retain_graph=True)
    known = problems.time_of_fall(0.1)
    assert np.allclose((found.t_events[0].item(), k.grad), known, rtol=1e-9)
    assert torch.isnan(found.y[:, 1]).all() and torch.isfinite(found.y[:, 0]).all()
    (end,) = varying(0.98)
    grown = solve_ivp(problems.ramp, (0, 2), [0.0, 1.0], "Tsit5", events=problems.reached,
                      args=(end,), on_event=problems.stop)  # fmt: skip
    grown.y[0, 0].backward()
    assert np.allclose((grown.y[0, 0].item(), end.grad), (0.98, 1.0), rtol=1e-12)


def with_global(t, y, k):
    return [y[1], -STRAY * y[0]]


@pytest.mark.parametrize(
    "error, words, call",
    [
        (
            TypeError,
            "float32; fastdyn computes in float64: .*double",
            lambda k: states(torch.ones(2), k, k),
        ),
        (
            TypeError,
            r"`args\[1\]` is of int64, and has no",
            lambda k: states([1.0, 0.0], k, torch.tensor(1)),
        ),
        (
            TypeError,
            "`t_span` is an array of torch that varies",
            lambda k: solve_ivp(pendulum, (0, k), [1.0, 0.0], args=(k, k)),
        ),
        (
            TypeError,
            "`STRAY`, which `with_global` takes",
            lambda k: states([1.0, 0.0], k, fun=with_global),
        ),
        (NotImplementedError, "differentiated once", lambda k: twice(k)),
    ],
)
def test_slips_get_a_sentence(error, words, call):
    (k,) = varying(9.81)
    with pytest.raises(error, match=words):
        call(k)


def twice(k):
    (first,) = torch.autograd.grad(states([1.0, 0.0], k, 0.2).sum(), k, create_graph=True)
    first.backward()
