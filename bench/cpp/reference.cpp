// Reference integrators in C++: DOPRI5 and DOP853 with the step control of scipy.integrate, for a
// right-hand side known at compile time, and DOPRI5 for springs and bodies of any number.
// Endpoint only.  Each entry leaves y0 alone and writes the end state to y and to counts the
// evaluations, accepted and rejected steps, so that it can be called again with nothing to reset.
#include "course.hpp"
#include "equations.hpp"
#include "solve.hpp"
#include "solve_long.hpp"

#define ENTRY(name, F)                                                                              \
  extern "C" void name(int order, int, double t, double t_end, const double *y0, double *y,          \
                       const double *p, double rtol, double atol, long *counts) {                    \
    if (order == 8)                                                                                 \
      solve<Dop853>(F{p}, t, t_end, y0, y, rtol, atol, counts);                                     \
    else                                                                                            \
      solve<Dopri5>(F{p}, t, t_end, y0, y, rtol, atol, counts);                                     \
  }
ENTRY(satellite, Satellite)
ENTRY(projectile, Projectile)
ENTRY(pendulum, Pendulum)
ENTRY(building, Building)
ENTRY(pendulum_xy, ConstrainedPendulum)
ENTRY(vehicle, Vehicle)
ENTRY(constrained_pendulum, ConstrainedByHand)
ENTRY(vehicle_explicit, VehicleByHand)
ENTRY(arenstorf, Arenstorf)
ENTRY(lorenz, Lorenz)
ENTRY(henon_heiles, HenonHeiles)
ENTRY(pleiades, Pleiades)
#define LONG_ENTRY(name, F)                                                                         \
  extern "C" void name(int, int n, double t, double t_end, const double *y0, double *y,              \
                       const double *, double rtol, double atol, long *counts) {                     \
    solve_long(F{n}, t, t_end, y0, y, rtol, atol, counts);                                          \
  }
LONG_ENTRY(chain, Chain)
LONG_ENTRY(bodies, Bodies)
