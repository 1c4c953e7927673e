"""The kernels that serve all methods and functions: their places and their signatures.

The key of a kernel covers the two modules that the kernel is taken from, and all that these import.
"""

PLAIN_START = "stepping.first_step.plain"  # in `kernels`: of methods that call a pair's functions
FOR_ALL = {  # name: function in `kernels`, signature in `specialise`
    "evaluate": ("calls.user_function.one_evaluation", "signatures.EVALUATE"),
    "factors": ("algebra.padded.factors.factors", "signatures.FACTORS"),  # of equations inside one
    "solution": ("algebra.padded.solution.solution", "signatures.SOLUTION"),
    "past": ("output.dense_output.state_before", "signatures.PAST"),  # of a delay equation
    "within past": ("output.past.steps.advance", "signatures.ADVANCE"),
    "filter of Rodas5P": ("methods.rodas5p.residual.filter_residual", "signatures.FILTER"),
    "filter of Radau": ("methods.radau.residual.filter_residual", "signatures.FILTER"),
    "sparse factors": ("algebra.sparse.factors.factors", "signatures.sparse.SPARSE_FACTORS"),
    "sparse solution": ("algebra.sparse.factors.solution", "signatures.sparse.SPARSE_SOLUTION"),
    "complex sparse factors": (
        "algebra.sparse.factors.factors", "signatures.sparse.COMPLEX_SPARSE_FACTORS"
    ),
    "complex sparse solution": (
        "algebra.sparse.factors.solution", "signatures.sparse.COMPLEX_SPARSE_SOLUTION"
    ),
    "newton": ("stepping.collocation.newton", "signatures.meshes.NEWTON"),
    "residuals": ("stepping.collocation.rms_residuals", "signatures.meshes.RESIDUALS"),
    "watch": ("output.between_steps.watch", "signatures.WATCH"),
    # For solves with events and nothing else; without events, projection, breakpoints.
    "watch events": ("output.between_steps.watch_events", "signatures.WATCH"),
    "watch plain": ("output.between_steps.watch_plain", "signatures.WATCH"),
    "launch": ("output.whole_solves.launch", "signatures.LAUNCH"),
    "interpolant": ("output.dense_output.interpolant", "signatures.INTERPOLANT"),
    "whole solve": ("output.whole_solves.whole_solve", "signatures.WHOLE_SOLVE"),
    "decide": ("output.changes.decide", "signatures.changes.DECIDE"),  # about switching times
    "events": ("output.events.open_events", "signatures.OPEN"),
    "all roots": ("output.series_roots.all_roots.find_all", "signatures.FIND"),  # of a step
    "roots inside": ("output.series_roots.inside.find_inside", "signatures.FIND"),
    "open survey": ("output.invariants.open_survey", "signatures.OPEN_SURVEY"),
    "survey": ("output.invariants.survey", "signatures.SURVEYING"),
    "already": ("ensemble.watched.already", "signatures.ADVANCE"),
    "wisdom holman": ("methods.wisdom_holman.steps.take_steps", "signatures.planets.TAKE_STEPS"),
    "wisdom holman by words": ("methods.wisdom_holman.steps.advance", "signatures.ADVANCE"),
    "sweep": ("stepping.backward.sweep", "signatures.sweeps.SWEEP"),
    "replay": ("stepping.backward.replay", "signatures.sweeps.REPLAY"),
    "steps": ("stepping.backward_whole.steps_between", "signatures.sweeps.STEPS"),
    "sweep whole": ("stepping.backward_whole.sweep_whole", "signatures.sweeps.SWEEP_WHOLE"),
    "sweep of kicks": ("stepping.backward_splitting.sweep", "signatures.sweeps.SWEEP_OF_KICKS"),
    "replay of kicks": (
        "stepping.backward_splitting.replay", "signatures.sweeps.REPLAY_OF_KICKS"
    ),
    "sweep of rosenbrock": (
        "stepping.backward_rosenbrock.sweep", "signatures.sweeps.SWEEP_OF_ROSENBROCK"
    ),
    "replay of rosenbrock": (
        "stepping.backward_rosenbrock.replay", "signatures.sweeps.REPLAY_OF_ROSENBROCK"
    ),
    "sweep of collocation": (
        "stepping.backward_collocation.sweep", "signatures.sweeps.SWEEP_OF_COLLOCATION"
    ),
    "replay of collocation": (
        "stepping.backward_collocation.replay", "signatures.sweeps.REPLAY_OF_COLLOCATION"
    ),
    "other jacobian": ("stepping.jacobian.other_jacobian", "signatures.OTHER_JACOBIAN"),
    "other factors": ("algebra.matrices.other_factors", "signatures.OTHER_FACTORS"),
    "other solution": ("algebra.matrices.other_solution", "signatures.OTHER_SOLUTION"),
    "other complex factors": (
        "algebra.complex_matrices.other_complex_factors", "signatures.OTHER_COMPLEX_FACTORS"
    ),
    "other complex solution": (
        "algebra.complex_matrices.other_complex_solution", "signatures.OTHER_SOLUTION"
    ),
    "both of a pair": ("calls.velocity_force.both_by_pointer", "signatures.FUNCTION"),
}  # fmt: skip
FOR_ALL |= {
    f"pencil {name}": (f"algebra.consistent_states.{name}", "signatures.FUNCTION")
    for name in ("rates", "change", "settle", "act")
}


def modules_of(name):
    """The modules, from fastdyn on, that the key of a kernel covers with their imports."""
    function, signature = FOR_ALL[name]
    return f"kernels.{function.rpartition('.')[0]}", f"specialise.{signature.rpartition('.')[0]}"
