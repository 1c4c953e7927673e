"""Unknown names of options: refused, or warned of, with the name that may be meant."""

from fastdyn.compile.sentences import warn
from fastdyn.kernels.methods import METHODS
from fastdyn.words.near import did_you_mean

from .table import ALL_OPTIONS, OPTIONS, adaptive

ARGUMENTS = (  # of `solve_ivp`, which are no options
    "t_span", "y0", "method", "t_eval", "dense_output", "events", "vectorized", "args",
)  # fmt: skip
FEW = 6  # methods that a sentence names
OTHER_WORDS = {  # names in other packages
    "solver": "method", "tspan": "t_span", "x0": "y0", "teval": "t_eval", "params": "args",
    "parameters": "args", "ics": "y0", "energy": "invariants",
    "p": "args", "saveat": "t_eval", "mxstep": "max_steps",
    "nsteps": "max_steps", "maxiters": "max_steps", "dtmax": "max_step",
    **{word: o.name for o in ALL_OPTIONS for word in (*o.words.split(), o.matlab.lower()) if word},
}  # fmt: skip


def advice(name, known):
    """A question, "did you mean `rtol`?", or nothing."""
    return did_you_mean(name, known, OTHER_WORDS)


def _advice_on(names):
    """Questions for several names, to append to a sentence."""
    known = (*OPTIONS, *ARGUMENTS)
    found = [(name, advice(name, known)) for name in names if name not in known]
    return "".join(f" `{name}`: {said}" for name, said in found if said)


def _of_steps(names, method):
    """The substitute for an option of steps that is not for a method, in a sentence."""
    if method.error_order and "step" in names:
        constant = [name for name, other in METHODS.items() if not other.error_order][:FEW]
        return (
            f" {method.name} chooses its steps; `max_step` limits them, `first_step` is the first. "
            f"Constant steps, `step`, are those of {', '.join(constant)} and more."
        )
    known = [OPTIONS[name] for name in names if name in OPTIONS]
    if not method.error_order and any(option.methods is adaptive for option in known):
        return f" {method.name} takes constant steps of the size `step`."
    return ""


def warn_unused(options, method):
    """Warn, as SciPy does, of options that the method does not use."""
    unused = [name for name in options if name not in OPTIONS or not OPTIONS[name].methods(method)]
    if unused:
        unused.sort()
        said = ", ".join(f"`{name}`" for name in unused)
        said = f"The following arguments have no effect for a chosen solver: {said}."
        warn(said + _advice_on(unused) + _of_steps(unused, method))


def refuse_unknown(who, given, known, arguments=()):
    """Raise TypeError for the first name that is not known; `arguments` may be meant, too."""
    for name in given:
        if name not in known:
            said = advice(name, (*known, *arguments))
            raise TypeError(f"{who} takes no `{name}`{f'; {said}' if said else '.'}")
