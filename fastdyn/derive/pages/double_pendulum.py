"""Double pendulum, with the forces in both rods."""

from sympy import cos, sin

from fastdyn.derive import Model, i, j

board = Model("double_pendulum", "Double pendulum", t_end=10.0)
th1, th2 = board.coordinates("th1 th2", "rad", rates="w1 w2")
m1, m2 = board.parameters(m1=(1.0, "kg"), m2=(1.0, "kg"))
l1, l2, g = board.parameters(l1=(1.0, "m"), l2=(1.0, "m"), g=(9.81, "m/s²"))
a1, a2 = board.initial(a1=(2.0, "rad"), a2=(2.5, "rad"))
R1, R2 = board.reactions("R1 R2")

e1 = sin(th1) * i - cos(th1) * j
e2 = sin(th2) * i - cos(th2) * j
upper = board.particle(m1, l1 * e1, "upper mass")
lower = board.particle(m2, l1 * e1 + l2 * e2, "lower mass")
board.gravity(-g * j)
upper.force(R2 * e2 - R1 * e1)
lower.force(-R2 * e2)

board.start(th1=a1, th2=a2)
