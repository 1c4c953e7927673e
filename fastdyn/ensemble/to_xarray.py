"""An ensemble as an xarray.Dataset."""

import numbers

import numpy as np

from .labels import initial_labels

STATUS = "0 the end was reached, 1 a terminal event, -1 failure, -2 interrupted"


def dataset(trajectories):
    """The Dataset of `Trajectories.to_xarray`."""
    try:
        import xarray
    except ImportError as error:
        raise ImportError(
            '`to_xarray` needs xarray: python -m pip install "fastdyn[cluster]".'
        ) from error
    e = trajectories
    of_all = ("trajectory",)
    of_each = ("trajectory", "component")
    second = {"units": "s"} if e.system is not None else {}
    values = {
        "y_end": (of_each, e.y_end),
        "t_end": (of_all, e.t_end, second),
        "status": (of_all, e.status, {"long_name": STATUS}),
        **{name: (of_all, numbers) for name, numbers in e.following().items()},
    }
    coordinates: dict = {"component": [label.name for label in e.labels]}
    if e.system is not None:
        coordinates["unit"] = ("component", [label.unit for label in e.labels])
    if np.ndim(e.y) == 3:
        values["y"] = ((*of_each, "time"), _lazy(e.y))
        coordinates["time"] = ("time", e.t, second)
    for name, slopes in getattr(e, "sensitivity", {}).items():
        times = np.ndim(e.y) == 3
        axes = tuple([f"{name}_{k}" for k in range(slopes.ndim - 2 - times)])
        values[f"dy_d{name}"] = (*of_each, *axes, *["time"] * times), slopes
    if "first_event" in e.reduced:
        coordinates["event"] = e.event_names
    for name, reduced in e.reduced.items():
        axes = ("trajectory", "event") if name == "first_event" else of_each[: reduced.ndim]
        values[name] = (axes, reduced, second if e.is_time(name) else {})
    if len(e.y0) > 1:
        coordinates["y0"] = (of_each, e.y0)
    facts = {"method": e.method, "t_start": e.t_start}
    if e.system is not None:
        facts["system"] = e.system.name
    for j, label in enumerate(e.argument_labels):
        taken = label.name in {*values, *coordinates, *facts, *of_each, "time", "event"}
        name = f"args[{j}]" if taken else label.name
        if j in e.parameters:
            coordinates[name] = (of_all, e.parameters[j], _about(label))
        elif isinstance(e.first[j], numbers.Real):
            facts[name] = e.first[j]
    for label in initial_labels(e.system):
        if label.name in e.initial_conditions:
            coordinates[label.name] = (of_all, e.initial_conditions[label.name], _about(label))
        else:
            facts[label.name] = getattr(e.system, label.name)
    return xarray.Dataset(values, coordinates, facts)


def _about(label):
    known = {"units": label.unit, "long_name": label.meaning}
    return {key: text for key, text in known.items() if text}


def _lazy(y):
    """An array in a store as a dask array, which reads only the parts that are used."""
    if isinstance(y, np.ndarray):
        return y
    from dask import array

    return array.from_array(y, chunks=y.chunks)
