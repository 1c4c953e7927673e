"""What sessions and notebooks display: results, systems, solvers, studies."""

import copy
import pickle
import re

import numpy as np
import pytest
import scipy.integrate

import fastdyn
from fastdyn import analysis, systems


def decay(t, y):
    return [-y[0], y[0] - y[1]]


SPAN, START, TIMES = (0.0, 1.0), [1.0, 0.0], np.linspace(0.0, 1.0, 201)
OWN = ("n_accepted", "n_rejected")  # fields that SciPy's result has not
SATELLITE = systems.satellite(V=1.2)


@pytest.fixture(scope="module")
def run():
    return SATELLITE.solve((0.0, 10.0))


@pytest.fixture(scope="module")
def displayed(run):
    return {
        "result": fastdyn.solve_ivp(decay, SPAN, START),
        "run": run,
        "ensemble": fastdyn.solve_ensemble(decay, SPAN, np.ones((3, 2))),
        "study": fastdyn.energy_drift(systems.pendulum(), n_steps=2000, step=0.01),
        "analysis": analysis.equilibria(systems.pendulum(), box=[(-4, 4), (-1, 1)]),
    }


@pytest.mark.parametrize("options", [{"t_eval": TIMES}, {}, {"t_eval": []}])
def test_a_result_prints_as_scipys(options):
    own = [fastdyn.solve_ivp(decay, SPAN, START, **options)]
    theirs = scipy.integrate.solve_ivp(decay, SPAN, START, **options)
    lines = [
        [line.strip() for line in str(each).splitlines() if not line.strip().startswith(OWN)]
        for each in (*own, theirs)
    ]
    assert lines[0] == lines[1] and len(lines[0]) < 20


def test_what_is_public_says_in_a_line_what_it_is(displayed):
    objects = [
        *list(displayed.values())[2:], SATELLITE, fastdyn.prepare(decay, SPAN, START),
        fastdyn.Stepper(decay, 0.0, START, 1.0),
        fastdyn.solve_ivp(decay, SPAN, START, dense_output=True).sol,
    ]  # fmt: skip
    for each in objects:
        assert "\n" not in repr(each) and " object at 0x" not in repr(each)
    assert repr(objects[-1]).startswith("<OdeSolution: t = 0 to 1, ")


@pytest.mark.parametrize("name", ["result", "run", "ensemble", "study", "analysis"])
def test_notebooks_show_a_table_and_a_picture(name, displayed):
    shown = displayed[name]._repr_html_()
    assert shown.startswith("<pre") and shown.count("<img ") == 1
    assert "<Study" not in shown


def cells(shown):
    """What a notebook shows, without the alignment of cells."""
    return re.sub(r' style="text-align: left"', "", shown._repr_html_())


def test_a_system_is_a_table_in_notebooks():
    shown = cells(SATELLITE)
    assert "Satellite orbit (satellite)" in shown
    assert "<tr><th>parameter</th><th>value</th><th>unit</th><th>meaning</th></tr>" in shown
    assert "<td>V</td><td>1.2</td><td>m/s</td><td>speed at launch" in shown
    assert shown.count("<img ") == 1  # the start, which needs no solve
    points = cells(systems.projectile())
    assert "<img" not in points and "<td>vz0</td>" in points


def test_a_prepared_solver_is_a_table_in_notebooks():
    shown = cells(fastdyn.prepare(decay, SPAN, START, rtol=1e-6))
    for name, value in (("function", "decay"), ("method", "RK45"), ("t", "0 to 1"),
                        ("rtol", "1e-06"), ("args", "()")):  # fmt: skip
        assert f"<td>{name}</td><td>{value}</td>" in shown
    steps = fastdyn.prepare(decay, SPAN, START, method="RK4", step=0.1)
    assert "<td>step</td><td>0.1</td>" in cells(steps)

    def adding(t, y, d):
        return [-y[0], d[0]]

    kept = fastdyn.prepare(
        adding, SPAN, START, discrete=[1.0], every=0.5, on_event=lambda t, y, d: (y, d + 1)
    )
    assert repr(kept) == "<Prepared with 1 discrete: RK45, t = 0 to 1, 3 components>"
    assert "<td>function</td>" in cells(kept)


def test_nothing_to_draw_is_no_picture():
    shown = fastdyn.solve_ivp(decay, SPAN, START, t_eval=[])._repr_html_()
    assert "<img" not in shown and "success: True" in shown


def test_a_run_has_its_components_and_functions_by_name(run):
    np.testing.assert_array_equal(run["vx"], run.y[2])
    np.testing.assert_array_equal(run.vy, run.y[3])
    np.testing.assert_array_equal(run["energy"], run.invariants()["energy"])
    assert run["y"].shape == run.y.shape  # SciPy's field, not the coordinate
    assert {"vx", "energy"}.isdisjoint(run)
    with pytest.raises(KeyError, match="speed"):
        run["speed"]
    for other in (copy.deepcopy(run), pickle.loads(pickle.dumps(run))):
        np.testing.assert_array_equal(other["x"], run.y[0])


def test_a_result_becomes_a_frame(run):
    pytest.importorskip("pandas")
    frame = run.to_pandas()
    assert list(frame.columns) == ["x", "y", "vx", "vy"] and frame.attrs["units"]["vx"] == "m/s"
    np.testing.assert_array_equal(frame["vy"], run.y[3])
    np.testing.assert_array_equal(frame.index, run.t)
    plain = fastdyn.solve_ivp(decay, SPAN, START, t_eval=[]).to_pandas()
    assert len(plain) == 0


def test_a_result_becomes_a_dataset(run):
    pytest.importorskip("xarray")
    found = run.to_xarray()
    np.testing.assert_array_equal(found.y.sel(component="vy"), run.y[3])
    assert found.attrs["nfev"] == run.nfev and list(found.unit.values) == ["m", "m", "m/s", "m/s"]
    plain = fastdyn.solve_ivp(decay, SPAN, START).to_xarray()
    assert plain.y.shape[0] == 2 and "unit" not in plain.coords


def test_a_table_has_each_time_once_where_events_act():
    """The state before the action, or after; both are in `t`, and by default in the table."""
    pytest.importorskip("pandas")
    given = {"events": lambda t, y: y[0] - 0.5, "on_event": lambda t, y: [y[0] + 1.0, y[1]]}
    jumping = fastdyn.solve_ivp(decay, (0.0, 3.0), START, sensitivity="y0", **given)
    at = jumping.t_events[0][0]
    assert not jumping.to_pandas().index.is_unique
    for actions, value in (("before", 0.5), ("after", 1.5)):
        frame = jumping.to_pandas(actions=actions)
        assert frame.index.is_unique and frame["y[0]"][at] == pytest.approx(value)
        assert len(frame) == len(jumping.t) - len(jumping.t_events[0])
        assert len(frame.reindex([0.25, 0.75], method="nearest")) == 2
    with pytest.raises(ValueError, match="`actions='first'` is unknown; choose from 'both', "):
        jumping.to_pandas(actions="first")
    pytest.importorskip("xarray")
    found = jumping.to_xarray(actions="after")
    assert found.y.sel(time=at).values[0] == pytest.approx(1.5)
    assert found.dy_dy0.shape == (2, 2, len(found.time))
    assert np.isfinite(found.y.interp(time=[0.25, 0.75])).all()
