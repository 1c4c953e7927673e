"""A function that computes with what it has kept is warned of by each method, in each solve."""

import enum
import warnings

import numpy as np
import pytest

import fastdyn
from fastdyn.compile.remembered import remembered

count, total, last, log, cache = 0, 0.0, 0.0, [], {}
held, held_at, told, fired, heats, mode = 0.0, None, False, False, False, 1
buffer = np.zeros(2)


def pid(t, y):
    global total, last
    error = 1 - y[0]
    total += error * (t - last)
    last = t
    return [y[1], 2 * error + 0.5 * total - 0.7 * y[1]]


def derivative_part(t, y):
    global last
    error = 1 - y[0]
    slope = (error - last) / 0.01
    last = error
    return [y[1], 2 * error + slope]


def latch(t, y):
    global fired
    if y[0] < 0.6:
        fired = True
    return [0.0] if fired else [-y[0]]


def latch_that_returns(t, y):
    global fired
    if y[0] < 0.6:
        fired = True
    if fired:
        return [0.0]
    return [-y[0]]


def thermostat(t, y):
    global heats
    if y[0] < 18.0:
        heats = True
    elif y[0] > 22.0:
        heats = False
    return [(5.0 if heats else 0.0) - 0.1 * y[0]]


def delayed(t, y):
    log.append(y[0])
    return [-log[-1] + 0.1 * log[0]]


class Controller:
    def __init__(self):
        self.sum, self.memory = 0.0, {"sum": 0.0}

    def rates(self, t, y):
        self.sum = self.sum + y[0]
        return [-y[0] - self.sum]

    def items(self, t, y):
        self.memory["sum"] += y[0]
        out = [0.0]
        out[0] = -self.memory["sum"]
        return out

    def __call__(self, t, y):
        s = self.sum
        s = s + y[0]
        self.sum = s
        return [-s]


def closure():
    total = 0.0

    def fun(t, y):
        nonlocal total
        total += y[0]
        return [-total]

    return fun


def controlled(t, error, gain=2.0):
    global total, last
    total += error * (t - last)
    last = t
    return gain * error + 0.5 * total


def calls_a_controller(t, y):
    force = controlled(t, 1 - y[0])
    return [y[1], force - 0.7 * y[1]]


class Sampled:
    """A controller that is called, and the plant that calls it."""

    def __init__(self):
        self.sum, self.at, self.calls = 0.0, 0.0, 0

    def __call__(self, t, error):
        if t - self.at > 0.01:
            self.sum += error * (t - self.at)
            self.at = t
        return 5.0 * error + self.sum

    def rates(self, t, y):
        self.note(t)
        return [y[1], self(t, 1 - y[0]) - y[1]]

    def feedback(self, t, y):
        return self.law(t, 1 - y[0])

    def law(self, t, error):
        self.sum = self.sum + error
        return [self.sum]

    def note(self, t):
        self.calls += 1
        return self.calls


controller = Sampled()


def sums(t, y, out):
    out[0] += y[0]
    out[1] = out[0] + t
    return out


def calls_helpers(t, y):
    """A counter whose value is not used, and a function that writes to what it is given."""
    controller.note(t)
    counter(t, y)
    found = sums(t, y, np.zeros(2))
    return [-found[1]]


@pytest.mark.parametrize(
    "fun, name",
    [
        (calls_a_controller, "total"), (Sampled().feedback, "self.sum"),
        (lambda t, y: [y[1], controller(t, 1 - y[0]) - y[1]], "self.sum"),
        (pid, "total"), (derivative_part, "last"), (latch, "fired"),
        (latch_that_returns, "fired"), (thermostat, "heats"), (delayed, "log"),
        (Controller().rates, "self.sum"), (Controller().items, "self.memory['sum']"),
        (Controller(), "self.sum"), (closure(), "total"),
    ],
)  # fmt: skip
def test_what_is_kept_and_used_is_found(fun, name):
    assert remembered(fun) == name


def counter(t, y):
    global count
    count += 1
    if count % 1000 == 0:
        print(count)
    return [-y[0]]


def limited(t, y):
    global count
    count += 1
    if count > 10**6:
        raise RuntimeError("too many calls")
    return [-y[0]]


def logger(t, y):
    log.append(t)
    return [-y[0]]


def told_once(t, y):
    global told
    if not told:
        print("hello")
        told = True
    return [-y[0]]


def from_cache(t, y):
    if t not in cache:
        cache[t] = t**2
    return [-y[0] * cache[t]]


def from_cache_at_once(t, y):
    if t in cache:
        return [-y[0] * cache[t]]
    value = t**2
    cache[t] = value
    return [-y[0] * value]


def held_value(t, y):
    global held, held_at
    if t != held_at:
        held, held_at = t**2, t
    return [-y[0] * held]


def held_copy(t, y):
    global held, held_at
    value = held if t == held_at else t**2
    held = value
    held_at = t
    return [-y[0] * value]


def writes_to_its_state(t, y):
    y[0] += 0.0
    out = [0.0]
    out[0] += -y[0]
    return out


def in_a_buffer(t, y):
    buffer[0] = y[1]
    buffer[1] = -y[0] - 0.1 * buffer[0]
    buffer[1] += 1.0
    if y[0] < 0.0:
        buffer[0] = 0.0
    return buffer


def in_a_buffer_by_a_loop(t, y):
    buffer[:] = 0.0
    for i in range(2):
        buffer[i] += y[i]
        buffer[0] += y[i] * buffer[1]
    return buffer


def of_modes(t, y):
    global mode
    if y[0] < 0.0:
        mode = 1
    else:
        mode = 2
    return [-y[0] * mode]


@pytest.mark.parametrize(
    "fun",
    [counter, calls_helpers, limited, logger, told_once, from_cache, from_cache_at_once,
     held_value, held_copy, in_a_buffer, in_a_buffer_by_a_loop, of_modes, writes_to_its_state,
     lambda t, y: -y, abs],
)  # fmt: skip
def test_what_changes_no_result_is_left_alone(fun):
    assert remembered(fun) is None


@pytest.mark.filterwarnings("ignore:.* cannot be compiled")
@pytest.mark.parametrize("method", ["RK45", "Radau", "LSODA", "auto"])
def test_each_method_warns_each_time(method):
    for _ in range(2):
        with pytest.warns(fastdyn.CompileWarning, match="pid keeps `total` .* `discrete=` with"):
            fastdyn.solve_ivp(pid, (0, 0.5), [0.0, 0.0], method)
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        fastdyn.solve_ivp(counter, (0, 0.5), [1.0], method)
    assert not [each for each in said if "keeps" in str(each.message)]


class Mode(enum.Enum):
    IDLE = 0
    HEAT = 1


class Thermostat:
    def __init__(self):
        self.mode = Mode.IDLE

    def __call__(s, t, y):
        if s.mode is Mode.IDLE and y[0] < 18.0:
            s.mode = Mode.HEAT
        elif s.mode is Mode.HEAT and y[0] > 21.0:
            s.mode = Mode.IDLE
        return [(4.0 if s.mode is Mode.HEAT else 0.0) - 0.1 * y[0]]


class Integrator:
    total, sizes = 0.0, (1.0, 2.0)

    def rate(this, t, y):
        this.total += 1.0 - y[0]
        return [this.total - y[0]]

    def of_sizes(this, t, y):
        this.seen = this.sizes
        return [this.sizes[0] - y[0]]


@pytest.mark.filterwarnings("ignore:.* cannot be compiled")
def test_the_function_that_keeps_is_named():
    with pytest.warns(fastdyn.CompileWarning, match="^controlled keeps `total` .* `discrete="):
        fastdyn.solve_ivp(calls_a_controller, (0, 0.5), [0.0, 0.0])


def test_objects_of_any_name_and_members_of_enumerations():
    assert remembered(Thermostat()) == "s.mode"
    assert remembered(Integrator().rate) == "this.total"
    assert remembered(Integrator().of_sizes) is None
