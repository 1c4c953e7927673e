"""Systems of the course, constraints among them, against C++ with the course's own matrices."""

from ..problems import course
from .speed import as_it_is, stretched


def rows(quick):
    """RK45 at rtol 1e-6, t = 20; fastdyn's constrained systems eliminate what they can first."""
    for problem in course():
        yield from as_it_is(problem, "RK45", 5, quick, jit=False)
        yield from stretched(problem, "RK45", 5, quick)
