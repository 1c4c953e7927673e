"""Slips within a function of the user: the exception stays, one sentence says what it means."""

import math
import traceback
import warnings

import numpy as np
import pytest

import fastdyn
from fastdyn import Phase, analysis, solve
from support.slips import hit

Y = [1.0, 0.0]


def texts(t, y):
    return ["a", "b"]


def of_odeint(y, t):
    return [y[1], -y[0]]


def of_odeint_by_other_names(s, time):
    return [s[1], -s[0]]


def unpacked(state, time):
    x, v = state
    return [v, -x]


def of_g(t, y, g):
    return [y[1], -g * y[0]]


def of_three(t, y):
    return [y[1], y[2], -y[0]]


def unpacks_three(t, y):
    a, b, c = y
    return [a, b, c]


def unpacks_one(t, y):
    (a,) = y
    return [a, a]


def power(t, y):
    return [y[1], -(y[0] ^ 2)]


def of_brackets(t, y):
    return [y(1), -y(0)]


def of_math(t, y):
    return [y[1], -math.sin(y)]


def of_float(t, y):
    return [y[1], float(y)]


def whole(t, y):
    return [y[1], -np.sin(y)]


def decides(t, y):
    return -y if y > 0 else y


def of_keys(t, y, p):
    return [y[1], -p["length"] * y[0]]


def alone(y):
    return [y[1], -y[0]]


def divides(t, y):
    return [y[1], 1 / float(t - t)]


def hitting(t, y):
    return y[0]


hitting.terminal = True


class Oscillator:
    def rhs(self, t, y):
        return [y[1], -y[0]]


def root_of(t, y):
    return [y[1], -math.sqrt(y[0] - 2.0)]


CALLED = "`fun` is called as fun(t, y, *args)"
IN_FUN = [  # fun, args, type of the exception, sentence
    (texts, (), ValueError, "`fun` returned ['a', 'b']; it must return 2 numbers"),
    (lambda t, y: None, (), TypeError, "without a `return`, a function returns None"),
    (lambda t, y: np.eye(2), (), ValueError, "returned an array of shape (2, 2), 4 values in rows"),
    (lambda t, y: np.eye(2) * y, (), ValueError, "is A @ y meant, and not A * y?"),
    (lambda t, y: [[y[1], -y[0]]], (), ValueError, "for each component of `y0`, in one row of"),
    (root_of, (), ValueError, "give `domain=` or `nonnegative=`."),
    (of_odeint, (), TypeError, "its first argument, `y` here, is the time. For a function in the"),
    (of_odeint_by_other_names, (), TypeError, "its first argument, `s` here, is the time"),
    (unpacked, (), TypeError, "its first argument, `state` here, is the time"),
    (of_g, (), TypeError, f"{CALLED}: give the value of g, args=(g,)."),
    (of_g, (1.0, 2.0), TypeError, f"{CALLED}, here with the 2 values of `args`"),
    (lambda t, y, g, h: y, (1.0,), TypeError, "`args` has 1 value: give the value of h"),
    (alone, (), TypeError, f"{CALLED}."),
    (Oscillator.rhs, (), TypeError, "is it a method? Give that of an object"),
    (of_g, ([1.0, 2.0],), (TypeError, ValueError), "In `args` `g` is a list of 2 numbers"),
    (of_g, (np.ones(2),), ValueError, "In `args` `g` is an array of 2 numbers; is one number"),
    (of_g, ("9.81",), TypeError, "In `args` `g` is the text '9.81'; is one number meant?"),
    (of_g, (None,), TypeError, "In `args` `g` is None"),
    (of_three, (), IndexError, "`y0`; counted from 0, the last is y[1]."),
    (unpacks_three, (), ValueError, "`y` has 2 components, as many as `y0`."),
    (unpacks_one, (), ValueError, "`y` has 2 components, as many as `y0`."),
    (power, (), TypeError, "`^` is no power in Python: x squared is x**2."),
    (of_brackets, (), TypeError, "counted from 0: the first is y[0]"),
    (of_math, (), TypeError, "`math.sin` takes one number; here it has an array. One component is"),
    (of_float, (), TypeError, "`float` takes one number; here it has an array."),
    (whole, (), ValueError, "Component 1 of what `fun` returned has shape (2,)"),
    (decides, (), ValueError, "A condition is about one number, as in `if y[0] > 0`"),
    (of_keys, ({"lenght": 1.0},), KeyError, "but no 'length'; did you mean 'lenght'?"),
    (divides, (), ZeroDivisionError, "`fun` was called at t = 0, y = [1., 0.]."),
]  # fmt: skip
OF_BVP = lambda ya, yb: [ya[0], yb[0]]  # noqa: E731
OF_A = "give the value of g, args=(g,)"
DOORS = {  # a forgotten `args`, or one that an event does not take, in each door
    "prepare": (lambda: fastdyn.prepare(of_g, (0, 1), Y), OF_A),
    "Stepper": (lambda: fastdyn.Stepper(of_g, 0.0, Y, 1.0).step(), OF_A),
    "solve_ensemble": (lambda: fastdyn.solve_ensemble(of_g, (0, 1), np.ones((3, 2))), OF_A),
    "solve_dae": (
        lambda: fastdyn.solve_dae(lambda t, y, yp, g: yp + g * y, (0, 1), [1.0], [-1.0]),
        f"`F` is called as F(t, y, yp, *args): {OF_A}",
    ),
    "solve_phases": (
        lambda: fastdyn.solve_phases(
            {"a": Phase(of_g, hit(terminal=True), lambda t, y: None)}, "a", (0, 1), Y
        ),
        OF_A,
    ),
    "solve_bvp": (
        lambda: fastdyn.solve_bvp(of_g, OF_BVP, [0.0, 1.0], np.zeros((2, 2))),
        "`fun` is called as fun(x, y): it gets no g.",
    ),
    "a constant of solve_bvp": (
        lambda: fastdyn.solve_bvp(
            lambda x, y: [y[1], 0], OF_BVP, [0.0, 1.0], np.zeros((2, 2))
        ),
        "`fun` is called as fun(x, y) and must return rows of one length",
    ),
    "after": (
        lambda: fastdyn.solve_phases(
            {"a": Phase(lambda t, y: [y[1], -y[0]], hitting, alone)}, "a", (0, 9), Y
        ),
        "`after` is called as after(t, y, *args).",
    ),
    "solve_second_order": (
        lambda: solve.solve_second_order(lambda t, q, g: -q, (0, 1), [1.0], [0.0], step=0.1), OF_A
    ),
    "solve_separable": (
        lambda: solve.solve_separable(of_g, of_g, (0, 1), [1.0], [0.0], step=0.1),
        f"`velocity` is called as velocity(t, p, *args): {OF_A}",
    ),
    "linearise": (lambda: analysis.linearise(of_g, Y), OF_A),
    "lyapunov": (lambda: analysis.lyapunov(of_g, Y), OF_A),
    "event": (
        lambda: fastdyn.solve_ivp(of_g, (0, 1), Y, args=(1.0,), events=lambda t, y: y[0]),
        "An event is called as event(t, y, *args), here with the value of `args`",
    ),
    "event of F": (
        lambda: fastdyn.solve_dae(
            lambda t, y, yp: yp + y, (0, 1), [1.0], [-1.0], events=lambda t, y, yp: y[0]
        ),
        "An event is called as event(t, y, *args): it gets no yp.",
    ),
    "discrete": (
        lambda: fastdyn.solve_ivp(alone, (0, 1), Y, discrete=[1.0], every=1, on_event=of_g),
        "`fun` is called as fun(t, y, d, *args).",
    ),
    "discrete of F": (
        lambda: fastdyn.solve_dae(alone, (0, 1), Y, discrete=[1.0], every=1, on_event=of_g),
        "`F` is called as F(t, y, yp, d, *args).",
    ),
    "fit": (lambda: fastdyn.fit(of_g, fastdyn.Record([0, 1], [1, 1], [fastdyn.Free(1), 0.0],
        noise=1, observed=0)), OF_A),
    "observed": (lambda: fastdyn.fit(of_g, fastdyn.Record([0, 1], [1, 1], Y, (fastdyn.Free(1),),
        noise=1, observed=lambda t, y: y[0])), "`observed` is called as observed(t, y, *args)"),
    "jac": (
        lambda: fastdyn.solve_ivp(
            of_g, (0, 1), Y, "Radau", args=(1.0,), jac=lambda t, y: np.eye(2)
        ),
        "`jac` is called as jac(t, y, *args), here with the value of `args`",
    ),
    "Taylor": (lambda: fastdyn.solve_ivp(of_g, (0, 1), Y, "Taylor"), OF_A),
    "adjoint": (lambda: fastdyn.solve_ivp(of_g, (0, 1), Y, adjoint="y0"), OF_A),
}  # fmt: skip


def raised(call):
    with warnings.catch_warnings(record=True), pytest.raises(Exception) as found:
        warnings.simplefilter("always")
        call()
    return found.value


@pytest.mark.parametrize(("fun", "args", "kind", "words"), IN_FUN)
def test_an_exception_of_fun_gets_a_sentence(fun, args, kind, words):
    error = raised(lambda: fastdyn.solve_ivp(fun, (0, 1), Y, args=args))
    assert isinstance(error, kind)
    said = [str(error), *getattr(error, "__notes__", ())]
    assert words in "\n".join(said)


@pytest.mark.parametrize(
    ("project", "words"),
    [
        (lambda t, y: None, "`project` returned None; it must return 2 numbers"),
        (lambda t, y: y[:1], "`project` returned 1 value for a state of 2"),
        (lambda t, y: "on the circle", "`project` returned the text 'on the circle'"),
    ],
)
def test_a_projection_is_called_by_its_name(project, words):
    def fun(t, y):
        return [y[1], -y[0]]

    assert words in str(raised(lambda: fastdyn.solve_ivp(fun, (0, 1), Y, project=project)))


def test_the_exception_is_that_of_fun_at_its_line():
    error = raised(lambda: fastdyn.solve_ivp(of_three, (0, 1), Y))
    assert str(error) == "index 2 is out of bounds for axis 0 with size 2"
    assert traceback.extract_tb(error.__traceback__)[-1].line == "return [y[1], y[2], -y[0]]"
    assert len(error.__notes__) == 1


@pytest.mark.parametrize("name", DOORS)
def test_each_door_gives_the_sentence(name):
    call, words = DOORS[name]
    assert words in "\n".join(raised(call).__notes__)


@pytest.mark.parametrize("after", [lambda t, y: y, lambda t, y: "a", lambda t, y: (y, "a")])
def test_what_after_must_return(after):
    with pytest.raises(ValueError, match=r"`after` must return \(name, y\), the next phase and 2"):
        fastdyn.solve_phases(
            {"a": Phase(lambda t, y: [y[1], -y[0]], hitting, after)}, "a", (0, 9), Y
        )


def test_an_error_that_is_found_on_the_way_names_its_time():
    error = raised(lambda: fastdyn.solve_ivp(lambda t, y: [-math.sqrt(y[0]) - 1], (0, 5), [1.0]))
    assert error.__notes__[0].startswith("`fun` was called at t = 0.")


def test_an_order_that_raises_nothing_is_told_of():
    with pytest.warns(UserWarning, match="its first argument, `y` here, is the time"):
        fastdyn.solve_ivp(lambda y, t: -y, (0, 1), [1.0])


def test_the_object_of_a_method_is_no_argument(recwarn):
    class Decay:
        def rhs(own, t, y):
            return -y

    fastdyn.solve_ivp(Decay().rhs, (0, 1), [1.0])
    assert not recwarn.list


def test_an_exception_that_has_another_cause_stays_alone():
    def fun(t, y):
        raise ValueError("the tank is empty")

    assert not hasattr(raised(lambda: fastdyn.solve_ivp(fun, (0, 1), Y)), "__notes__")
