"""A problem F(t, y, y') = 0 made ready: F compiled, a consistent start, the Run."""

from fastdyn.compile import budget
from fastdyn.run.begin import jacobian_of
from fastdyn.run.functions.bound import bind_functions
from fastdyn.run.functions.compared import off_the_solution
from fastdyn.run.functions.python_between import of_python_between
from fastdyn.run.loop import Run
from fastdyn.run.solve_problem import load_kernels
from fastdyn.run.stiffness import watch

from .consistent import consistent, consistent_behind
from .equations import StartEquations
from .index import index_of
from .jumps import consistent_jump, with_acting, with_jumps


def run_of(problem, held, breakpoints=None, longer=None):
    """(A Run from a consistent start, the index); `held` says what of the start is held.

    ``longer(problem, equations)`` makes a tangent.residual.Tangent, which the Run solves.
    """
    load_kernels(problem)  # first: no other thread compiles kernels meanwhile
    with budget.limited(0.0):
        near = off_the_solution(problem.y0)  # where code is compared with F
        plain = with_jumps(problem, lambda act: None)
        bound, others = bind_functions(plain._replace(y0=near))
    p = of_python_between(problem, bound, others)
    equations = StartEquations(p, bound, jacobian_of(p, bound, others))
    p = p._replace(y0=consistent(equations, p, held))
    index = index_of(equations.jacobian(p.y0), equations.n, equations.noise, equations.rates(p.y0))

    def again(t, both):
        return consistent_behind(equations, p, t, both)

    if longer is None:
        whole = with_jumps(p, lambda act: consistent_jump(p, equations, act))
    else:
        tangent = longer(p, equations)
        whole = tangent.problem
        again = tangent.again
        bound = tangent.bound
        others = tangent.others
    if breakpoints is not None:
        whole = breakpoints.scheduled(whole, again)
    run = Run(whole, bound, with_acting(whole, others))
    watch(whole, run)
    return run, index
