"""Vehicle with a driver: two wheels that do not slip sideways (course 3.3.4)."""

from sympy import cos, sin

from fastdyn.derive import Model, i, j
from fastdyn.systems.vehicle import drunk

board = Model("car", "Vehicle with a driver", "course 3.3.4", t_end=120.0)
x, y, th = board.coordinates("x y th", "m m rad", rates="vx vy omega")
m, L = board.parameters(m=(1.0, "kg"), L=(1.0, "m", "wheelbase"))
c = board.parameters(positive=False, c=(0.1, "kg/m"))
R1, R2 = board.reactions("R1 R2")
alpha, P = board.driver("alpha alpha' P", drunk)

along = cos(th) * i - sin(th) * j
across = sin(th) * i + cos(th) * j
axle = sin(th + alpha) * i + cos(th + alpha) * j
r = x * i + y * j
front = r + L / 2 * along
rear = r - L / 2 * along

chassis = board.body(m, r, inertia=0, turned=-th, name="chassis")
chassis.drag(c)
chassis.force(P * along, at=rear)
chassis.rolls(axle, at=front, reactions=R1)
chassis.rolls(across, at=rear, reactions=R2)
