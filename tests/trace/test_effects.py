"""What a traced function may not do to its surroundings, and what it may not keep."""

import collections
import enum
import functools
import logging
import types
import warnings
from typing import Any

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.traced import make as by_tracing
from fastdyn.compile.traced.known import Attempt
from fastdyn.trace.graph.refusal import Untraceable
from support.beside_scipy import START, agrees

pytestmark = pytest.mark.filterwarnings("ignore")


@pytest.mark.parametrize("name", ["append", "print", "write"])
def test_numba_is_not_asked_about_effects(name, monkeypatch):
    seen, last = [], {}

    def fun(t, y):
        if name == "append":
            seen.append(t)
        elif name == "write":
            last["t"] = t
        else:
            print(end="")
        return -y

    monkeypatch.delattr("fastdyn.compile.bind.compiled_function")
    agrees(fun)


def test_a_cache_keeps_what_it_gave():
    table = [1.0]

    @functools.lru_cache
    def of(i):
        return table[i]

    def fun(t, y):
        return of(0) * y

    agrees(fun)
    table[0] = 5.0
    agrees(fun)


def test_numbers_of_a_class_of_the_user():
    class Kilo(float):
        def __mul__(self, other):
            return 1e-3 * float(self) * other

        __rmul__ = __mul__

    def fun(t, y, k):
        return [y[0] * k, y[1] * k]

    agrees(fun, 2.0)
    agrees(fun, Kilo(2.0))


def test_an_error_that_holds_a_symbol():
    def fun(t, y):
        return [{0: -1.0, 1: 1.0}[int(y[0] > 0)], -y[1]]

    agrees(fun)


def test_the_text_of_a_number_is_for_errors_alone():
    def fun(t, y, as_text):
        if y[0] > 1e3:
            raise ValueError(f"{y[0]:.2f} in {y}")
        return -y if as_text and f"{y[0]:.0f}" == "0" else -2 * y

    agrees(fun, False)
    agrees(fun, True)


def test_an_enumeration_that_is_written_to():
    class Gear(enum.Enum):
        LOW = 1
        HIGH = 2

    def fun(t, y):
        gear = Gear.LOW if t < 0.5 else Gear.HIGH
        gear.last = t
        return -y * gear.value

    agrees(fun)
    assert type(Gear.LOW.last) in (float, np.float64)


def test_a_singleton():
    class One:
        made = None

        def __new__(cls):
            if One.made is None:
                One.made = object.__new__(One)
            return One.made

    def fun(t, y):
        one = One()
        one.last = t
        return -y

    agrees(fun)
    assert type(One.made.last) in (float, np.float64)


def test_objects_that_notice_their_end():
    ended = []

    class Rate:
        def __init__(self, k):
            self.k = k

        def __del__(self):
            ended.append(self.k)

    def fun(t, y):
        return -Rate(2.0).k * y

    nfev = fastdyn.solve_ivp(fun, (0.0, 1.0), START).nfev
    assert len(ended) == nfev


def test_a_class_that_registers_who_inherits_from_it():
    registered = []

    class Base:
        def __init_subclass__(cls):
            registered.append(cls)

    class Model(Base):
        k = -1.0

        def fun(self, t, y):
            return self.k * y

    agrees(Model().fun)
    assert registered == [Model]


@pytest.mark.filterwarnings("error::fastdyn.CompileWarning")
def test_relatives_of_dict_and_list():
    ordered, queue = collections.OrderedDict(k=1.0, b=2.0), collections.deque([1.0, 2.0])
    given, known = {"k": 0.5}, collections.defaultdict(float, a=2.0)
    proxy = types.MappingProxyType(given)

    def fun(t, y):
        return -y * (ordered["k"] + queue[0] + sum(queue) + proxy["k"] + known["a"])

    agrees(fun)
    ordered["k"], given["k"], known["a"] = 2.0, 0.7, 1.0
    agrees(fun)
    queue.append(3.0)
    agrees(fun)


def test_a_default_that_a_dict_keeps():
    known = collections.defaultdict(float)
    agrees(lambda t, y: -y * (1.0 + known["missing"]))
    assert known == {"missing": 0.0}


def test_a_logger():
    logger, lines = logging.getLogger("fastdyn.test"), []
    handler = logging.Handler()
    handler.emit = lines.append
    logger.addHandler(handler)

    def fun(t, y):
        logger.info("at %s", t)
        return -y

    agrees(fun)
    logger.setLevel(logging.INFO)
    nfev = fastdyn.solve_ivp(fun, (0.0, 1.0), START).nfev
    assert len(lines) == nfev


@pytest.mark.parametrize(
    "write",
    [
        np.save, np.savetxt, np.savez, np.savez_compressed,
        lambda path, y: y.tofile(path),
        lambda path, y: y.dump(path),
    ],
)  # fmt: skip
@pytest.mark.parametrize("n", [2, 100])
def test_no_file_is_written_while_a_function_is_traced(write, n, tmp_path):
    def fun(t, y, path=str(tmp_path / "never")):
        write(path, y)
        return -y

    near = by_tracing.Near(0.0, 1.0, np.ones(n), n == 100)
    with pytest.raises(Untraceable):
        facts = by_tracing.TracesOfPlace()
        attempt = Attempt(fun, (), DERIVATIVE, n)
        by_tracing._traced(attempt, near, "all", n == 100, facts)
    assert not list(tmp_path.iterdir())


def test_an_event_that_changes_a_partial_acts_in_the_solve_only():
    """A comparison would call the event before the solve."""

    def end(solve):
        part: Any = functools.partial(lambda g, t: g + 0.1 * t, 1.68)

        def fun(t, y):
            return [0.2 * part(t) - 0.8 * float(np.ma.array([y[0]])[0])]

        def changes(t, y):
            part.__setstate__((part.func, (1.0,), {}, {}))
            return t - 0.96

        return solve(fun, (0.0, 3.0), [0.9], events=changes).y[0, -1]

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert end(fastdyn.solve_ivp) == pytest.approx(end(scipy.integrate.solve_ivp), rel=1e-12)
