"""Solvers that take one step at a time, SciPy's and ours."""


def ended(stepper):
    """The solver, behind its last step."""
    while stepper.status == "running":
        stepper.step()
    return stepper
