"""An ensemble as a pandas.DataFrame."""

import numpy as np

from fastdyn.plot.needed import needed


def frame(trajectories):
    """The DataFrame of `Trajectories.to_pandas`."""
    pandas = needed("pandas", "`to_pandas` needs")
    e = trajectories
    fields, starts = e.varied()
    columns = {label.name: np.asarray(values) for label, values in (*fields, *starts)}
    names = [label.name for label in e.labels]
    times = np.ndim(e.y) == 3
    index = pandas.RangeIndex(len(e), name="trajectory")
    if times:
        index = pandas.MultiIndex.from_product([index, e.t], names=["trajectory", "t"])
    repeat = len(e.t) if times else 1
    states = np.moveaxis(np.asarray(e.y), 1, -1).reshape(-1, len(names)) if times else e.y_end
    known = {name: np.repeat(values, repeat) for name, values in columns.items()}
    known |= {
        (f"{name} at the end" if name in known and not times else name): column
        for name, column in zip(names, np.asarray(states).T, strict=True)
    }
    if not times:
        known |= {"t_end": e.t_end}
        for name, values in e.reduced.items():
            if np.ndim(values) == 2 and name != "first_event":
                own = zip(names, values.T, strict=True)
                known |= {f"{name} of {one}": column for one, column in own}
    known["status"] = np.repeat(e.status, repeat)
    units = {label.name: label.unit for label in (*[f for f, _ in fields], *e.labels) if label.unit}
    found = pandas.DataFrame(known, index)
    if units:
        found.attrs["units"] = units
    return found
