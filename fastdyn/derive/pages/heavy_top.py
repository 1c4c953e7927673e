"""Heavy symmetric top with a fixed point, by Euler's angles, and the force at that point."""

from fastdyn.derive import Model, dot, i, j, k, rate, rotation

board = Model("heavy_top", "Heavy symmetric top", t_end=5.0)
phi, theta, psi = board.coordinates("phi theta psi", "rad")
m, l, g = board.parameters(m=(1.0, "kg"), l=(0.1, "m"), g=(9.81, "m/s²"))
A, C = board.parameters(
    A=(0.0025, "kg m²", "across, about the centre of mass"), C=(0.005, "kg m²", "about the axis")
)
tilt, spin = board.initial(tilt=(0.5, "rad"), spin=(100.0, "rad/s"))
X, Y, Z = board.reactions("X Y Z")

turned = rotation(phi, k) * rotation(theta, i) * rotation(psi, k)
axis = turned * k
top = board.body(m, l * axis, (A, A, C), turned, "top")
board.gravity(-g * k)
top.force(X * i + Y * j + Z * k, at=0 * k)

board.start(theta=tilt, vpsi=spin)
H = top.momentum() + m * l * axis.cross(rate(l * axis))
board.invariant("about_the_vertical", H[2], "kg m²/s")
board.invariant("about_the_axis", dot(top.momentum(), axis), "kg m²/s")
