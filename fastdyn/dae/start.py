"""A problem F(t, y, y') = 0 made ready: F compiled, a consistent start, the Run."""

from fastdyn.compile import budget
from fastdyn.run.begin import jacobian_of
from fastdyn.run.functions.bound import bind_functions
from fastdyn.run.functions.compared import off_the_solution
from fastdyn.run.functions.python_between import of_python_between
from fastdyn.run.loop import Run
from fastdyn.run.solve_problem import load_kernels

from .consistent import consistent
from .equations import Equations
from .index import index_of
from .jumps import bound_in_python, consistent_jumps


def run_of(problem, given):
    """(a Run from a consistent start, the index); `given` says what of the start is held."""
    load_kernels(problem)  # first: no other thread compiles kernels meanwhile
    with budget.limited(0.0):
        near = off_the_solution(problem.y0)  # where code is compared with F
        bound, others = bind_functions(problem._replace(y0=near, on_event=()))
    p = of_python_between(problem, bound, others)
    equations = Equations(p, bound, jacobian_of(p, bound, others))
    p = p._replace(
        y0=consistent(equations, p, given),
        on_event=consistent_jumps(p, equations, problem.on_event),
    )
    acting = [bound_in_python(jump, p.args, len(p.y0)) for jump in p.on_event if jump is not None]
    index = index_of(equations.jacobian(p.y0), equations.n, equations.noise, equations.rates(p.y0))
    return Run(p, bound, [*others, *acting]), index
