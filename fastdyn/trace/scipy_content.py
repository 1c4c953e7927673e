"""What the objects of SciPy are, by the names of their attributes."""

INTERP1D = (
    "x", "y", "_y", "_call", "_kind", "_extrapolate", "_y_axis", "_y_extra_shape", "bounds_error",
)  # fmt: skip


def content_of(value):
    """The names of the attributes that make an object of SciPy what it is; None if not known."""
    from scipy import interpolate

    if getattr(value, "format", None) in ("csr", "csc"):
        return "data", "indices", "indptr", "shape"
    if isinstance(value, interpolate.PPoly):
        return "x", "c", "extrapolate", "axis"
    if isinstance(value, interpolate.BSpline):
        return "t", "c", "k", "extrapolate", "axis"
    if isinstance(value, interpolate.UnivariateSpline):
        return "_eval_args", "ext"
    if isinstance(value, interpolate.interp1d):
        more = "_spline x_bds _x_shift _side _ind _fill_value_below _fill_value_above".split()
        return INTERP1D + tuple(name for name in more if hasattr(value, name))
    return () if type(value).__name__ == "Rotation" else None
