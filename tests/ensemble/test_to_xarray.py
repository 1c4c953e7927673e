"""Datasets of an ensemble, with the names and units that are known."""

import numpy as np
import pytest
from matplotlib import pyplot

from fastdyn import solve_ensemble, solve_ivp, systems
from fastdyn.ensemble import Shared
from support.sweeps import FAST, crossing, labels, pendulum, plain


def test_a_dataset_has_the_names_of_the_function():
    xarray = pytest.importorskip("xarray", reason="needs xarray")
    result = plain(t_eval=np.linspace(0, 4, 9), events=crossing, reduce=("max", "first_event"))
    data = result.to_xarray()
    assert isinstance(data, xarray.Dataset)
    assert dict(data.sizes) == {"trajectory": 40, "component": 2, "time": 9, "event": 1}
    assert np.array_equal(data.y.sel(time=4.0, component="y[1]"), result.y[:, 1, -1])
    assert np.array_equal(data.stiffness, np.linspace(1.0, 9.0, 40))
    assert data.attrs == {"method": "RK4", "t_start": 0.0, "damping": 0.1}
    assert np.array_equal(data["max"], result.reduced["max"])
    first = data.first_event.sel(event="crossing")
    assert np.array_equal(first, result.reduced["first_event"][:, 0])
    figure = result.plot(of="first_event")
    assert labels(figure) == [("stiffness", "time of the first crossing", "")]
    pyplot.close(figure)
    for name in ("y_end", "t_end", "status", "nfev", "n_accepted", "n_rejected"):
        assert np.array_equal(data[name], getattr(result, name))
    assert data.where(data.stiffness > 5.0, drop=True).sizes["trajectory"] == 20


def test_a_dataset_of_a_system_has_units():
    pytest.importorskip("xarray", reason="needs xarray")
    result = systems.pendulum(l=2.0).ensemble(V0=np.linspace(1, 3, 5), t_eval=[1.0, 2.0])
    data = result.to_xarray()
    assert list(data.component.values) == ["theta", "omega"]
    assert list(data.unit.values) == ["rad", "rad/s"]
    assert data.V0.attrs == {"units": "m/s", "long_name": "velocity at launch, across the cable"}
    assert data.time.attrs == {"units": "s"} and data.attrs["l"] == 2.0
    assert np.array_equal(data.y0.sel(component="omega"), np.linspace(1, 3, 5) / 2.0)


def test_names_that_are_taken_or_unknown():
    pytest.importorskip("xarray", reason="needs xarray")
    y, rate = np.ones(3), np.arange(3.0)
    data = solve_ensemble(
        lambda t, w, y, *more: [-y * w[0] + more[0]],
        (0, 1),
        [1.0],
        (y, rate, Shared([1.0])),
        **FAST,
    ).to_xarray()
    assert set(data.coords) == {"component", "y", "args[1]"}
    taken = solve_ensemble(lambda t, w, status: [-status * w[0]], (0, 1), [1.0], (rate,), **FAST)
    assert np.array_equal(taken.to_xarray()["args[0]"], rate)
    empty = solve_ensemble(pendulum, (0, 1), np.ones((0, 2)), ([], 0.1), **FAST).to_xarray()
    assert empty.sizes["trajectory"] == 0


def test_a_stored_dataset_is_read_when_it_is_used(tmp_path):
    pytest.importorskip("xarray", reason="needs xarray")
    pytest.importorskip("zarr", reason="needs zarr")
    array = pytest.importorskip("dask.array", reason="needs dask")
    options = {"t_eval": np.linspace(0, 4, 9)}
    data = plain(store=tmp_path / "run.zarr", block=7, **options).to_xarray()
    assert isinstance(data.y.data, array.Array) and data.y.data.chunks[0][:2] == (7, 7)
    assert np.array_equal(data.y, plain(**options).y)


def test_sensitivities_are_variables():
    pytest.importorskip("xarray", reason="needs xarray")
    stiffness, start = np.array([1.0, 2.0, 4.0]), [1.0, 0.0]

    def spring(t, y, k):
        return [y[1], -k * y[0]]

    for t_eval, axes in ((None, ()), ([0.5, 1.0], ("time",))):
        given = {"args": (stiffness,), "sensitivity": ("y0", "k"), "t_eval": t_eval}
        run = solve_ensemble(spring, (0, 1), start, **given)
        data = run.to_xarray()
        assert data.dy_dk.dims == ("trajectory", "component", *axes)
        assert data.dy_dy0.dims == ("trajectory", "component", "y0_0", *axes)
        assert np.array_equal(data.dy_dy0, run.sensitivity["y0"])
    alone = solve_ivp(spring, (0, 1), start, args=(2.0,), sensitivity="k").to_xarray()
    assert alone.dy_dk.dims == ("component", "time")
    assert alone.dy_dk.sizes["time"] == alone.sizes["time"]


def test_a_frame_has_a_row_for_each_trajectory_or_time():
    pandas = pytest.importorskip("pandas", reason="needs pandas")
    result = plain(reduce=("max",))
    frame = result.to_pandas()
    assert isinstance(frame, pandas.DataFrame) and frame.index.name == "trajectory"
    columns = ["stiffness", "y[0]", "y[1]", "t_end", "max of y[0]", "max of y[1]", "status"]
    assert list(frame.columns) == columns and len(frame) == 40
    assert np.array_equal(frame["y[1]"], result.y_end[:, 1])
    assert np.array_equal(frame["max of y[0]"], result.reduced["max"][:, 0])
    result = plain(t_eval=np.linspace(0, 4, 9))
    frame = result.to_pandas()
    assert frame.index.names == ["trajectory", "t"] and len(frame) == 40 * 9
    assert frame.loc[(3, 4.0), "y[1]"] == result.y[3, 1, -1]
    assert np.array_equal(frame.xs(0.5, level="t")["y[0]"], result.y[:, 0, 1])
    assert frame.loc[(3, 4.0), "stiffness"] == result.parameters[1 - 1][3]


def test_a_frame_of_a_system_has_units():
    pytest.importorskip("pandas", reason="needs pandas")
    run = systems.pendulum().ensemble(theta0=np.array([0.1, 0.2]), l=np.array([1.0, 2.0]))
    frame = run.to_pandas()
    assert frame.attrs["units"] == {"l": "m", "theta0": "rad", "theta": "rad", "omega": "rad/s"}
    assert frame["theta"][1] == run.y_end[1, 0] and frame["l"][1] == 2.0
