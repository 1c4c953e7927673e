"""One table of the fields of a result: each way of solving gives all of them."""

import copy
import pathlib
import pickle
import re
import warnings

import numpy as np
import pytest

import fastdyn
from fastdyn import solve_ivp
from fastdyn.run.result import ALL_FIELDS, FIELDS, FOLLOWING, OdeResult
from fastdyn.solve import solve_second_order
from fastdyn.solve.stepper import Stepper
from support.edited import run_edited
from support.steppers import ended


def decay(t, y):
    return [-y[0]]


def with_effect(t, y, seen=[]):  # noqa: B006
    seen[:] = [t]
    return [-y[0]]


def crossing(t, y):
    return y[0] - 0.5


crossing.terminal = True
START = (0, 1), [1.0]


def again_and_again(solve):
    for _ in range(40):
        result = solve()
    return result


def in_python():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fastdyn.CompileWarning)
        return again_and_again(lambda: solve_ivp(with_effect, *START))


def phases():
    end = fastdyn.Phase(decay, crossing, lambda t, y: ("one", y + 1.0))
    return fastdyn.solve_phases({"one": end}, "one", (0, 2), [1.0])


def hanging(t, y, yp):
    """A pendulum in x and z, of index 3."""
    x, z, u, v, force = y
    return [yp[0] - u, yp[1] - v, yp[2] + force * x, yp[3] + force * z + 9.81, x**2 + z**2 - 1]


def implicit_decay(t, y, yp):
    return [yp[0] + y[0]]


def planets():
    two = fastdyn.planets.Planets([1.0, 1e-3], [[0, 0, 0], [1, 0, 0]], [[0, 0, 0], [0, 1, 0]])
    return two.solve((0, 1), step=0.1)


AT_REST = [0.6, -0.8, 0.0, 0.0, 0.0]
WAYS = {
    "once": lambda: solve_ivp(decay, *START),
    "again": lambda: again_and_again(lambda: solve_ivp(decay, *START)),
    "implicit": lambda: solve_ivp(decay, *START, "Radau"),
    "series": lambda: solve_ivp(decay, *START, "Taylor", rtol=1e-8),
    "auto": lambda: solve_ivp(decay, *START, "auto"),
    "with events": lambda: again_and_again(lambda: solve_ivp(decay, *START, events=crossing)),
    "dense": lambda: again_and_again(lambda: solve_ivp(decay, *START, dense_output=True)),
    "estimate": lambda: solve_ivp(decay, *START, error_estimate=True),
    "sensitivity": lambda: again_and_again(lambda: solve_ivp(decay, *START, sensitivity="y0")),
    "adjoint": lambda: again_and_again(
        lambda: solve_ivp(decay, *START, t_eval=[0.0, 1.0], adjoint="y0")
    ),
    "complex": lambda: solve_ivp(decay, (0, 1), [1.0 + 1.0j]),
    "in Python": in_python,
    "prepared": lambda: again_and_again(fastdyn.prepare(decay, *START)),
    "phases": phases,
    "ensemble": lambda: fastdyn.solve_ensemble(decay, (0, 1), [[1.0], [2.0]])[1],
    "ensemble with events": lambda: fastdyn.solve_ensemble(
        decay, (0, 1), [[1.0], [2.0]], t_eval=[0.5, 1.0], events=crossing
    )[1],
    "second order": lambda: solve_second_order(lambda t, q: -q, (0, 1), [1.0], [0.0], step=0.1),
    "planets": planets,
    "dae": lambda: fastdyn.solve_dae(implicit_decay, *START, [-1.0]),
    "dae with sensitivities": lambda: fastdyn.solve_dae(
        implicit_decay, *START, [-1.0], sensitivity="y0"
    ),
    "delay": lambda: fastdyn.solve_dde(
        lambda t, y, past: [-past(t - 0.5)[0]], (0, 1), lambda t: [1.0]
    ),
    "delay ensemble": lambda: fastdyn.solve_dde_ensemble(
        lambda t, y, past, a: [-a * past(t - 0.5)[0]], (0, 1), [1.0], ([1.0, 2.0],)
    )[1],
    "dae of index 3": lambda: fastdyn.solve_dae(hanging, (0, 0.5), AT_REST),
    "dae without time": lambda: fastdyn.solve_dae(hanging, (0, 0), AT_REST),
    "dae ensemble": lambda: fastdyn.solve_dae_ensemble(implicit_decay, (0, 1), [[1.0], [2.0]])[1],
}


@pytest.mark.parametrize("way", WAYS)
def test_a_result_has_all_fields_in_their_order(way):
    result = WAYS[way]()
    assert list(result)[: len(FIELDS)] == list(FIELDS)
    assert {*result} - {*FIELDS} <= {f.name for f in ALL_FIELDS} | {
        "phases", "yp", "index", "yp_events", "states", "differentiated", "delays", "history",
        "jumps",
    }  # fmt: skip
    uncounted = {"njev", "nlu"} if way == "dae ensemble" else set()
    for name in FOLLOWING:
        if name in uncounted:
            assert result[name] is None
            continue
        assert result[name].__class__ is int and result[name] >= 0, name
    assert isinstance(result, OdeResult)
    for name in ("vjp", "history"):  # which no pickle takes, the second because of its lambda
        result.pop(name, None)
    for other in (pickle.loads(pickle.dumps(result)), copy.copy(result), OdeResult(result)):
        assert list(other) == list(result)


def test_numbers_of_steps_and_evaluations_are_those_of_the_table():
    result = WAYS["once"]()
    stepper = ended(Stepper(decay, 0.0, [1.0], 1.0))
    many = fastdyn.prepare(decay, *START).many([[1.0], [1.0]])
    ensemble = fastdyn.solve_ensemble(decay, (0, 1), [[1.0], [1.0]])
    for name in FOLLOWING:
        assert getattr(stepper, name) == result[name]
        if name in many:
            assert np.array_equal(many[name], [result[name]] * 2)
            assert np.array_equal(getattr(ensemble, name), [result[name]] * 2)
    assert {*FOLLOWING} - {*many} == {"njev", "nlu"}
    with pytest.raises(AttributeError, match="no attribute 'njev'"):
        _ = ensemble.njev
    with pytest.raises(AttributeError, match="no attribute 'y_old'"):
        _ = stepper.y_old


def test_each_field_has_an_entry_in_the_docstring():
    for field in ALL_FIELDS:
        entry = rf"(?m)^(\w+, )*{field.name}(, \w+)* : .*\n    \S"
        assert re.search(entry, OdeResult.__doc__), field.name
    for name in FIELDS:
        assert f"`{name}`" in solve_ivp.__doc__


LAST = '    Field("n_rejected", "", "", lambda method, c: c.n_rejected, sum),\n'
RECORD = """    Field(
        "n_tried", "int", "Number of steps, accepted or not.",
        lambda method, c: c.n_accepted + c.n_rejected, sum,
    ),
    Field(
        "most_steps", "int", "Most steps, accepted or not, of a part.",
        lambda method, c: c.n_accepted + c.n_rejected, max,
    ),
    Field(
        "next_step", "float", "Size of the step that would be next.",
        of_end=lambda method, c: c.h,
    ),
    Field(
        "n_beyond", "int", "Steps that changed the state more than the equations do.",
        lambda method, c: c.n_standing, sum,
    ),
"""
OF_END = (
    "    n_factorised: Any = None\n",
    "    n_factorised: Any = None\n    n_standing: Any = None\n",
)
FOLDER = pathlib.Path(__file__).parent
TRIED = f"sys.path[:0] = {str(FOLDER)!r}, {str(FOLDER.parent)!r}"
TRIED += """
import math, pickle
import numpy as np
import fastdyn
from fastdyn.solve.stepper import Stepper

def decay(t, y):
    return [-y[0]]

def expected(r):
    is_size = isinstance(r.next_step, float) and 0.0 < r.next_step < math.inf
    counted = isinstance(r.n_beyond, int) and r.n_beyond >= 0
    return counted and is_size and r.n_tried == r.n_accepted + r.n_rejected > 0

result = fastdyn.solve_ivp(decay, (0, 1), [1.0])
assert list(result)[-4:] == ["n_tried", "most_steps", "next_step", "n_beyond"]
assert expected(pickle.loads(pickle.dumps(result)))
from test_fields import WAYS
for way, solve in WAYS.items():
    assert way == "dae without time" or expected(solve()), way
prepared = fastdyn.prepare(decay, (0, 1), [1.0])
few, more = [prepared.many(np.ones((m, 1))) for m in (2, 200)]
assert (few.n_tried == result.n_tried).all() and (few.next_step == result.next_step).all()
assert (more.n_tried == result.n_tried).all()
ensemble = fastdyn.solve_ensemble(decay, (0, 1), np.ones((9, 1)))
assert ensemble.next_step.shape == (9,) and ensemble[8].next_step == ensemble.next_step[8]
for steps in (more.next_step, ensemble.next_step):
    assert np.allclose(steps, result.next_step, 1e-9)
stepper = Stepper(decay, 0.0, [1.0], 1.0)
stepper.step()
assert expected(stepper)
while stepper.status == "running":
    stepper.step()
assert stepper.next_step == result.next_step
inputs = Stepper(lambda t, y, u: [u - y[0]], 0.0, [1.0], 100.0, args=(0.0,))
for u in (1.0, 2.0):
    inputs.step()
    inputs.args = (u,)
assert (inputs.n_tried, inputs.most_steps) == (2, 1) and inputs.next_step > 0.0
def half(t, y):
    return y[0] - 0.5

half.terminal = True
phases = {"early": fastdyn.Phase(decay, half, lambda t, y: ("late", 0.4 * y))}
phases["late"] = phases["early"]._replace(fun=decay)
parts = fastdyn.solve_phases(phases, "early", (0, 0.7), [1.0])
assert len(parts.phases) == 2 and parts.most_steps < parts.n_tried < 2 * parts.most_steps
assert "n_tried : int\\n    Number of steps, accepted or not.\\n" in fastdyn.OdeResult.__doc__
assert "`n_tried`" in fastdyn.solve_ivp.__doc__
print("as told")
"""


def test_a_record_more_is_a_field_more():
    edits = {"fastdyn.run.result": (LAST, LAST + RECORD, *OF_END)}
    assert run_edited(TRIED, edits) == "as told\n"


def test_a_field_of_a_stepper_or_an_ensemble_computes_no_other(monkeypatch):
    def counted(method, ended):
        raise AssertionError

    stepper = Stepper(decay, 0.0, [1.0], 1.0)
    together = fastdyn.solve_ensemble(decay, (0, 1), [[1.0], [2.0]])
    monkeypatch.setitem(FOLLOWING, "n_rejected", counted)
    assert stepper.nfev > 0 and (together.nfev > 0).all()
    with pytest.raises(AssertionError):
        stepper.n_rejected  # noqa: B018
