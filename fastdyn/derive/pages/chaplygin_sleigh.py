"""Chaplygin's sleigh: a body on a knife edge that does not slip sideways."""

from sympy import cos, sin

from fastdyn.derive import Model, i, j

board = Model("chaplygin_sleigh", "Chaplygin sleigh", t_end=10.0)
x, y, th = board.coordinates("x y th", "m m rad")
m, I = board.parameters(m=(1.0, "kg"), I=(0.5, "kg m²"))
a = board.parameters(a=(0.4, "m", "from the edge to the centre of mass"))
u0, w0 = board.initial(u0=(0.0, "m/s"), w0=(2.0, "rad/s"))
R = board.reactions("R")

along = cos(th) * i + sin(th) * j
across = cos(th) * j - sin(th) * i
edge = x * i + y * j
sleigh = board.body(m, edge + a * along, I, th, "sleigh")
sleigh.rolls(across, at=edge, reactions=R)

board.start(vx=u0, vth=w0)
