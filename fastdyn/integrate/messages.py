"""How a run of `odeint` ended: ODEPACK's `istate`, and SciPy's sentences."""

import warnings

from fastdyn.kernels.state.record import (
    FAILED_AGAIN,
    FINISHED,
    NO_TOLERANCE,
    STEP_LIMIT,
    STEP_TOO_SMALL,
)

DONE = 2
NOTHING = 1
MANY_STEPS = -1
TOO_ACCURATE = -2
ILLEGAL = -3
SAID = {
    DONE: "Integration successful.",
    NOTHING: "Nothing was done; the integration time was 0.",
    MANY_STEPS: "Excess work done on this call (perhaps wrong Dfun type).",
    TOO_ACCURATE: "Excess accuracy requested (tolerances too small).",
    ILLEGAL: "Illegal input detected (internal error).",
    -4: "Repeated error test failures (internal error).",
    -5: "Repeated convergence failures (perhaps bad Jacobian or tolerances).",
    -6: "Error weight became zero during problem.",
}
# A step that does not change the time goes on in ODEPACK until all steps are spent.
OF_STATUS = {
    FINISHED: DONE, STEP_LIMIT: MANY_STEPS, STEP_TOO_SMALL: MANY_STEPS, NO_TOLERANCE: -6,
}  # fmt: skip


def istate_of(status, error):
    """The `istate` of a status of the kernels; `error` is that of the last trial of a step."""
    if status == FAILED_AGAIN:
        return -4 if error > 1.0 else -5
    return OF_STATUS.get(status, ILLEGAL)


def warn(istate, because, printmessg, depth):
    """Warn of a failure, as SciPy does, with the reason; with `printmessg` tell of any end."""
    if istate > 0 and not printmessg:
        return
    from scipy.integrate import ODEintWarning

    said = SAID[istate]
    if istate < 0:
        said += f" Run with full_output = 1 to get quantitative information. {because}"
    warnings.warn(said.rstrip(), ODEintWarning, stacklevel=depth + 1)


def tell(said):
    """Warn of a probable mistake in the arguments."""
    warnings.warn(said, UserWarning, stacklevel=3)
