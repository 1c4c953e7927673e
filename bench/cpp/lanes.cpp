// Eight trajectories at once by hand: DOPRI5 with the step control of scipy.integrate on vectors of
// eight doubles, each lane with its own time and step; a lane that is done takes the next
// trajectory.  Endpoint only.
#include "equations.hpp"
#include "solve.hpp"

namespace lanes {

constexpr int W = 8;
typedef double vec __attribute__((vector_size(8 * W)));
typedef long long bits __attribute__((vector_size(8 * W)));

inline vec splat(double x) { return x - vec{}; }
inline vec root(vec x) {
  for (int i = 0; i < W; ++i) x[i] = __builtin_sqrt(x[i]);
  return x;
}
inline vec size(vec x) { return x < 0 ? -x : x; }
inline vec smaller(vec a, vec b) { return a < b ? a : b; }
inline vec larger(vec a, vec b) { return a > b ? a : b; }

// x^(-1/5): the bits of a double are nearly its logarithm; then two steps of order 4.
inline vec fifth_root_of_inverse(vec x) {
  constexpr double one = 4607182418800017408.0, tilt = 193600000000000.0;
  bits i = (bits)x;
  vec guess = (one - tilt) * 1.2 - 0.2 * __builtin_convertvector(i, vec);
  vec z = (vec)__builtin_convertvector(guess, bits);
  for (int turn = 0; turn < 2; ++turn) {
    vec z2 = z * z, r = 1 - x * (z2 * z2 * z);
    z += z * (0.2 * r) * (1 + 0.6 * r * (1 + (2.2 / 3) * r));
  }
  return z;
}

inline vec sine(vec x) {  // Taylor on |x| <= pi / 4 after reduction by pi / 2, for moderate x
  constexpr double shift = 6755399441055744.0;
  vec near = x * 0.6366197723675814 + shift, k = near - shift;
  bits quarter = (bits)near;
  vec r = x - k * 1.5707963267341256 - k * 6.077100506506192e-11, r2 = r * r;
  vec s = r + r * r2 * (-1.0 / 6 + r2 * (1.0 / 120 + r2 * (-1.0 / 5040 + r2 * (1.0 / 362880 +
          r2 * (-1.0 / 39916800 + r2 * (1.0 / 6227020800))))));
  vec c = 1 + r2 * (-0.5 + r2 * (1.0 / 24 + r2 * (-1.0 / 720 + r2 * (1.0 / 40320 +
          r2 * (-1.0 / 3628800 + r2 * (1.0 / 479001600 - r2 * (1.0 / 87178291200)))))));
  vec y = (quarter & 1) != 0 ? c : s;
  return (quarter & 2) != 0 ? -y : y;
}

struct Satellite {
  static constexpr int n = 4, parameters = 1;
  static void rates(vec, const vec *y, const vec *p, vec *d) {
    vec r2 = y[0] * y[0] + y[1] * y[1], c = -p[0] / (r2 * root(r2));
    d[0] = y[2], d[1] = y[3], d[2] = c * y[0], d[3] = c * y[1];
  }
};

struct Building {
  static constexpr int n = 4, parameters = 6;
  static void rates(vec t, const vec *y, const vec *p, vec *d) {
    vec s = p[3] * sine(p[2] * t);
    vec lower = 2 * p[0] * (y[0] - s - p[4]), upper = 2 * p[0] * (y[1] - y[0] - p[4]);
    d[0] = y[2], d[1] = y[3];
    d[2] = (upper - lower) / p[1] - p[5], d[3] = -upper / p[1] - p[5];
  }
};

template <int S, int... J>
inline vec weighted(const vec (&k)[7][4], int i, std::integer_sequence<int, J...>) {
  vec sum = {};
  ([&] { if constexpr (Dopri5::a[S][J] != 0) sum += Dopri5::a[S][J] * k[J][i]; }(), ...);
  return sum;
}

template <int... J>
inline vec error_of(const vec (&k)[7][4], int i, std::integer_sequence<int, J...>) {
  vec sum = {};
  ([&] { if constexpr (Dopri5::e[0][J] != 0) sum += Dopri5::e[0][J] * k[J][i]; }(), ...);
  return sum;
}

template <class F, int S = 1>
inline void stages(vec t, const vec *y, const vec *p, vec h, vec *u, vec (&k)[7][4]) {
  if constexpr (S <= 6) {
    for (int i = 0; i < F::n; ++i) u[i] = y[i] + h * weighted<S>(k, i, std::make_integer_sequence<int, S>{});
    F::rates(t + Dopri5::c[S] * h, u, p, k[S]);
    stages<F, S + 1>(t, y, p, h, u, k);
  }
}

template <class F>
long solve(long count, double t0, double t_end, const double *y0, const double *parameters,
           double *out, double rtol, double atol) {
  constexpr int n = F::n, m = F::parameters;
  vec t = splat(t_end), h = {}, refused = {}, y[n] = {}, p[m] = {}, u[n], k[7][4] = {};
  long member[W], next = 0, live = 0, steps = 0;
  for (long &i : member) i = -1;
  for (;;) {
    for (int lane = 0; lane < W; ++lane) {
      if (member[lane] >= 0 && t[lane] >= t_end) {
        for (int i = 0; i < n; ++i) out[member[lane] * n + i] = y[i][lane];
        member[lane] = -1, --live;
      }
      if (member[lane] < 0 && next < count) {
        for (int i = 0; i < n; ++i) y[i][lane] = y0[next * n + i];
        for (int i = 0; i < m; ++i) p[i][lane] = parameters[next * m + i];
        t[lane] = t0, h[lane] = -1, member[lane] = next++, ++live;
      }
    }
    if (!live) return steps;
    vec rate[n], f1[n], d0 = {}, d1 = {}, d2 = {};  // the first step, for the lanes that need one
    F::rates(t, y, p, rate);
    for (int i = 0; i < n; ++i) {
      vec scale = atol + size(y[i]) * rtol, a = y[i] / scale, b = rate[i] / scale;
      d0 += a * a, d1 += b * b;
    }
    d0 = root(d0 / n), d1 = root(d1 / n);
    vec first = smaller((d0 < 1e-5 | d1 < 1e-5) ? splat(1e-6) : 0.01 * d0 / d1, splat(t_end - t0));
    for (int i = 0; i < n; ++i) u[i] = y[i] + first * rate[i];
    F::rates(t + first, u, p, f1);
    for (int i = 0; i < n; ++i) {
      vec a = (f1[i] - rate[i]) / (atol + size(y[i]) * rtol);
      d2 += a * a;
    }
    vec top = larger(d1, root(d2 / n) / first);
    vec second = top <= 1e-15 ? larger(splat(1e-6), first * 1e-3) : fifth_root_of_inverse(top * 100);
    second = smaller(smaller(100 * first, second), splat(t_end - t0));
    bits fresh = h < 0;
    h = fresh ? second : h;
    refused = fresh ? vec{} : refused;
    for (int i = 0; i < n; ++i) k[0][i] = fresh ? rate[i] : k[0][i];
    for (bool done = false; !done;) {
      vec t_new = smaller(t + h, splat(t_end)), step = t_new - t, total = {};
      stages<F>(t, y, p, step, u, k);
      for (int i = 0; i < n; ++i) {
        vec scale = atol + larger(size(y[i]), size(u[i])) * rtol;
        vec e = step * error_of(k, i, std::make_integer_sequence<int, 7>{}) / scale;
        total += e * e;
      }
      vec error = root(total / n), factor = 0.9 * fifth_root_of_inverse(error);
      bits good = error < 1;
      vec up = smaller(factor, refused > 0 ? splat(1) : splat(10));
      h = step * (good ? up : larger(factor, splat(0.2)));
      refused = good ? vec{} : splat(1);
      t = good ? t_new : t;
      for (int i = 0; i < n; ++i) {
        y[i] = good ? u[i] : y[i];
        k[0][i] = good ? k[6][i] : k[0][i];
      }
      steps += live;
      bits over = t >= t_end;
      for (int lane = 0; lane < W; ++lane) done |= over[lane] && member[lane] >= 0;
    }
  }
}

}  // namespace lanes

template <class F>
long solve_one_by_one(long count, double t0, double t_end, const double *y0, const double *p, int m,
                      double *out, double rtol, double atol) {
  long counts[3], steps = 0;
  for (long i = 0; i < count; ++i) {
    F f{p + i * m};
    solve<Dopri5>(f, t0, t_end, y0 + i * F::n, out + i * F::n, rtol, atol, counts);
    steps += counts[1] + counts[2];
  }
  return steps;
}

extern "C" long solve_each(int problem, long count, double t0, double t_end, const double *y0,
                           const double *p, double *out, double rtol, double atol) {
  return problem == 0 ? solve_one_by_one<Satellite>(count, t0, t_end, y0, p, 1, out, rtol, atol)
                      : solve_one_by_one<Building>(count, t0, t_end, y0, p, 6, out, rtol, atol);
}

extern "C" long solve_lanes(int problem, long count, double t0, double t_end, const double *y0,
                            const double *p, double *out, double rtol, double atol) {
  return problem == 0 ? lanes::solve<lanes::Satellite>(count, t0, t_end, y0, p, out, rtol, atol)
                      : lanes::solve<lanes::Building>(count, t0, t_end, y0, p, out, rtol, atol);
}
