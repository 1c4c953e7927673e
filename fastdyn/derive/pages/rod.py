"""Block on a rotating rod, with friction (course 3.3.2, example 3)."""

from sympy import cos, sin

from fastdyn.derive import Model, cross, i, j, k, t

board = Model("block", "Block on a rotating rod", "course 3.3.2, example 3", t_end=2.0)
r = board.coordinates("r", rates="v")
m, omega = board.parameters(m=(1.0, "kg"), omega=(2.0, "rad/s"))
mu = board.parameters(positive=False, mu=(0.3, "1", "coefficient of friction"))
V = board.initial(V=(0.1, "m/s"))
N = board.reactions("N")

along = cos(omega * t) * i + sin(omega * t) * j
across = cross(k, along)
block = board.particle(m, r * along, "block")
block.slides(across, N, over=omega * r * across, friction=mu, along=along, guided=True)

board.start(v=V)
board.quantity("T", mu * N, "N", "friction force T")
