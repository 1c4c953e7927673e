// Reference integrators in C++: DOPRI5 and DOP853 with the step control of scipy.integrate, for a
// right-hand side known at compile time, and DOPRI5 for springs and bodies of any number.
// Endpoint only.  Each entry leaves y0 alone and writes the end state to y and to counts the
// evaluations, accepted and rejected steps, so that it can be called again with nothing to reset.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "tableaux.hpp"

template <class T, int S, class K, int... J>
inline double weighted(const K &k, int i, std::integer_sequence<int, J...>) {
  double sum = 0;
  bool first = true;
  (
      [&] {
        if constexpr (T::a[S][J] != 0) {
          sum = first ? T::a[S][J] * k[J][i] : sum + T::a[S][J] * k[J][i];
          first = false;
        }
      }(),
      ...);
  return sum;
}

template <class T, int R, class K, int... J>
inline double error_of(const K &k, int i, std::integer_sequence<int, J...>) {
  double sum = 0;
  ([&] { if constexpr (T::e[R][J] != 0) sum += T::e[R][J] * k[J][i]; }(), ...);
  return sum;
}

template <class T, class F, int S = 1>
inline void stages(const F &f, double t, const double (&y)[F::n], double h, double (&u)[F::n],
                   double (&k)[T::stages + 1][F::n]) {
  if constexpr (S <= T::stages) {
    for (int i = 0; i < F::n; ++i)
      u[i] = y[i] + h * weighted<T, S>(k, i, std::make_integer_sequence<int, S>{});
    f(t + T::c[S] * h, u, k[S]);
    stages<T, F, S + 1>(f, t, y, h, u, k);
  }
}

template <class F>
double rms(const double (&x)[F::n], const double (&y)[F::n], double rtol, double atol) {
  double sum = 0;
  for (int i = 0; i < F::n; ++i) {
    double v = x[i] / (atol + std::abs(y[i]) * rtol);
    sum += v * v;
  }
  return std::sqrt(sum / F::n);
}

template <class F>
double first_step(const F &f, double t, const double (&y)[F::n], const double (&f0)[F::n], double span,
                  int order, double rtol, double atol) {
  double d0 = rms<F>(y, y, rtol, atol), d1 = rms<F>(f0, y, rtol, atol);
  double h0 = std::min(d0 < 1e-5 || d1 < 1e-5 ? 1e-6 : 0.01 * d0 / d1, span), u[F::n], f1[F::n];
  for (int i = 0; i < F::n; ++i) u[i] = y[i] + h0 * f0[i];
  f(t + h0, u, f1);
  for (int i = 0; i < F::n; ++i) f1[i] -= f0[i];
  double d2 = rms<F>(f1, y, rtol, atol) / h0;
  double h1 = d1 <= 1e-15 && d2 <= 1e-15 ? std::max(1e-6, h0 * 1e-3)
                                         : std::pow(0.01 / std::max(d1, d2), 1.0 / (order + 1));
  return std::min({100 * h0, h1, span});
}

template <class T, class F>
void solve(const F &f, double t, double t_end, const double *y0, double *state, double rtol, double atol, long *counts) {
  constexpr int n = F::n, s = T::stages;
  const double exponent = -1.0 / T::order;
  double y[n], u[n], k[s + 1][n];
  std::copy(y0, y0 + n, y);
  f(t, y, k[0]);
  double h = first_step(f, t, y, k[0], t_end - t, T::order - 1, rtol, atol);
  long accepted = 0, rejected = 0;
  while (t < t_end) {
    const double h_min = 10 * std::abs(std::nextafter(t, INFINITY) - t);
    h = std::max(h, h_min);
    bool refused = false;
    for (;;) {
      if (h < h_min) goto done;
      double t_new = std::min(t + h, t_end), step = t_new - t, sum[2] = {0, 0}, error;
      h = step;
      stages<T, F>(f, t, y, step, u, k);
      for (int i = 0; i < n; ++i) {
        const double scale = atol + std::max(std::abs(y[i]), std::abs(u[i])) * rtol;
        double e = error_of<T, 0>(k, i, std::make_integer_sequence<int, s + 1>{}) / scale;
        sum[0] += e * e;
        if constexpr (T::order == 8) {
          e = error_of<T, 1>(k, i, std::make_integer_sequence<int, s + 1>{}) / scale;
          sum[1] += e * e;
        }
      }
      if constexpr (T::order == 8)
        error = sum[0] == 0 && sum[1] == 0 ? 0 : step * sum[0] / std::sqrt((sum[0] + 0.01 * sum[1]) * n);
      else
        error = step * std::sqrt(sum[0] / n);
      if (error < 1) {
        double factor = error == 0 ? 10 : std::min(10.0, 0.9 * std::pow(error, exponent));
        h *= refused ? std::min(1.0, factor) : factor;
        t = t_new;
        std::copy(u, u + n, y);
        std::copy(k[s], k[s] + n, k[0]);
        ++accepted;
        break;
      }
      h *= std::max(0.2, 0.9 * std::pow(error, exponent));
      refused = true;
      ++rejected;
    }
  }
done:
  std::copy(y, y + n, state);
  counts[0] = 2 + s * (accepted + rejected);
  counts[1] = accepted;
  counts[2] = rejected;
}

struct Satellite {
  static constexpr int n = 4;
  const double *p;
  inline void operator()(double, const double *y, double *d) const {
    const double r2 = y[0] * y[0] + y[1] * y[1], c = -p[0] / (r2 * std::sqrt(r2));
    d[0] = y[2], d[1] = y[3], d[2] = c * y[0], d[3] = c * y[1];
  }
};

struct Projectile {
  static constexpr int n = 6;
  const double *p;  // drag, gravity
  inline void operator()(double, const double *y, double *d) const {
    const double s = p[0] * std::sqrt(y[3] * y[3] + y[4] * y[4] + y[5] * y[5]);
    d[0] = y[3], d[1] = y[4], d[2] = y[5];
    d[3] = -s * y[3], d[4] = -s * y[4], d[5] = -s * y[5] - p[1];
  }
};

struct Pendulum {
  static constexpr int n = 2;
  const double *p;  // gravity, length
  inline void operator()(double, const double *y, double *d) const {
    d[0] = y[1], d[1] = -(p[0] / p[1]) * std::sin(y[0]);
  }
};

struct Building {
  static constexpr int n = 4;
  const double *p;  // k, m, omega, d, L, g
  inline void operator()(double t, const double *y, double *d) const {
    const double s = p[3] * std::sin(p[2] * t);
    const double lower = 2 * p[0] * (y[0] - s - p[4]), upper = 2 * p[0] * (y[1] - y[0] - p[4]);
    d[0] = y[2], d[1] = y[3];
    d[2] = (upper - lower) / p[1] - p[5], d[3] = -upper / p[1] - p[5];
  }
};

// a x = b by elimination with partial pivoting, x left in b.
template <int N>
inline void eliminate(double (&a)[N][N], double (&b)[N]) {
  for (int k = 0; k < N; ++k) {
    int best = k;
    for (int i = k + 1; i < N; ++i)
      if (std::abs(a[i][k]) > std::abs(a[best][k])) best = i;
    if (best != k) {
      for (int j = k; j < N; ++j) std::swap(a[k][j], a[best][j]);
      std::swap(b[k], b[best]);
    }
    const double inverse = 1 / a[k][k];
    for (int i = k + 1; i < N; ++i) {
      const double f = a[i][k] * inverse;
      for (int j = k + 1; j < N; ++j) a[i][j] -= f * a[k][j];
      b[i] -= f * b[k];
    }
  }
  for (int k = N - 1; k >= 0; --k) {
    for (int j = k + 1; j < N; ++j) b[k] -= a[k][j] * b[j];
    b[k] /= a[k][k];
  }
}

// The course's five equations for x', y', x'', y'' and the tension.
struct ConstrainedPendulum {
  static constexpr int n = 4;
  const double *p;  // g, l, m
  inline void operator()(double, const double *y, double *d) const {
    const double r = std::sqrt(y[0] * y[0] + y[1] * y[1]);
    double a[5][5] = {{1, 0, 0, 0, 0},
                      {0, 1, 0, 0, 0},
                      {0, 0, 1, 0, y[0] / (p[2] * r)},
                      {0, 0, 0, 1, y[1] / (p[2] * r)},
                      {0, 0, y[0], y[1], 0}};
    double b[5] = {y[2], y[3], 0, p[0], -y[2] * y[2] - y[3] * y[3]};
    eliminate(a, b);
    std::copy(b, b + 4, d);
  }
};

// The course's eight equations for the rates, the accelerations and the two wheel forces.
struct Vehicle {
  static constexpr int n = 6;
  const double *p;  // m, L, c
  inline void operator()(double t, const double *w, double *d) const {
    const double m = p[0], L = p[1], c = p[2];
    const double alpha = 0.1 + 0.2 * std::sin(t), turn = 0.2 * std::cos(t), P = 0.2;
    const double s = std::sin(w[2]), cs = std::cos(w[2]);
    const double sf = std::sin(w[2] + alpha), cf = std::cos(w[2] + alpha), ca = std::cos(alpha);
    const double v = std::sqrt(w[3] * w[3] + w[4] * w[4]);
    double a[8][8] = {{1, 0, 0, 0, 0, 0, 0, 0},
                      {0, 1, 0, 0, 0, 0, 0, 0},
                      {0, 0, 1, 0, 0, 0, 0, 0},
                      {0, 0, 0, m, 0, 0, -sf, -s},
                      {0, 0, 0, 0, m, 0, -cf, -cs},
                      {0, 0, 0, 0, 0, 0, ca, -1},
                      {0, 0, 0, s, cs, L / 2, 0, 0},
                      {0, 0, 0, sf, cf, -L * ca / 2, 0, 0}};
    double b[8] = {w[3],
                   w[4],
                   w[5],
                   P * cs - c * v * w[3],
                   -P * s - c * v * w[4],
                   0,
                   (-cs * w[3] + s * w[4]) * w[5],
                   (-cf * w[3] + sf * w[4]) * (w[5] + turn) - std::sin(alpha) * L * w[5] * turn / 2};
    eliminate(a, b);
    std::copy(b, b + 6, d);
  }
};

struct ConstrainedByHand {
  static constexpr int n = 4;
  const double *p;  // g
  inline void operator()(double, const double *y, double *d) const {
    const double pull = (y[2] * y[2] + y[3] * y[3] + p[0] * y[1]) / (y[0] * y[0] + y[1] * y[1]);
    d[0] = y[2], d[1] = y[3], d[2] = -pull * y[0], d[3] = p[0] - pull * y[1];
  }
};

struct VehicleByHand {
  static constexpr int n = 6;
  const double *p;  // m, L, c
  inline void operator()(double t, const double *w, double *d) const {
    const double m = p[0], L = p[1], c = p[2];
    const double alpha = 0.1 + 0.2 * std::sin(t), turn = 0.2 * std::cos(t), P = 0.2;
    const double s = std::sin(w[2]), cs = std::cos(w[2]), sa = std::sin(alpha), ca = std::cos(alpha);
    const double sf = std::sin(w[2] + alpha), cf = std::cos(w[2] + alpha);
    const double v = std::sqrt(w[3] * w[3] + w[4] * w[4]);
    const double fx = P * cs - c * v * w[3], fy = -P * s - c * v * w[4];
    const double rear = (s * w[4] - cs * w[3]) * w[5];
    const double front = (sf * w[4] - cf * w[3]) * (w[5] + turn) - 0.5 * L * sa * w[5] * turn;
    const double dx = sf + ca * s, dy = cf + ca * cs;
    const double force = (m * (ca * rear + front) - dx * fx - dy * fy) / (dx * dx + dy * dy);
    const double ax = (fx + force * dx) / m, ay = (fy + force * dy) / m;
    d[0] = w[3], d[1] = w[4], d[2] = w[5], d[3] = ax, d[4] = ay;
    d[5] = 2 / L * (rear - s * ax - cs * ay);
  }
};

struct Arenstorf {
  static constexpr int n = 4;
  const double *p;  // mass of the moon
  inline void operator()(double, const double *y, double *d) const {
    const double moon = p[0], earth = 1 - moon, x = y[0] + moon, z = y[0] - earth;
    const double r2 = x * x + y[1] * y[1], s2 = z * z + y[1] * y[1];
    const double a = earth / (r2 * std::sqrt(r2)), b = moon / (s2 * std::sqrt(s2));
    d[0] = y[2], d[1] = y[3];
    d[2] = y[0] + 2 * y[3] - a * x - b * z, d[3] = y[1] - 2 * y[2] - a * y[1] - b * y[1];
  }
};

struct Lorenz {
  static constexpr int n = 3;
  const double *p;  // sigma, rho, beta
  inline void operator()(double, const double *y, double *d) const {
    d[0] = p[0] * (y[1] - y[0]), d[1] = y[0] * (p[1] - y[2]) - y[1], d[2] = y[0] * y[1] - p[2] * y[2];
  }
};

struct HenonHeiles {
  static constexpr int n = 4;
  const double *p;
  inline void operator()(double, const double *y, double *d) const {
    d[0] = y[2], d[1] = y[3];
    d[2] = -y[0] - 2 * y[0] * y[1], d[3] = y[1] * y[1] - y[1] - y[0] * y[0];
  }
};

// x, y, vx, vy of seven stars of masses 1 to 7.
struct Pleiades {
  static constexpr int n = 28;
  const double *p;
  inline void operator()(double, const double *w, double *d) const {
    for (int i = 0; i < 14; ++i) d[i] = w[14 + i], d[14 + i] = 0;
    for (int i = 0; i < 7; ++i)
      for (int j = 0; j < i; ++j) {
        const double dx = w[j] - w[i], dy = w[7 + j] - w[7 + i], r2 = dx * dx + dy * dy;
        const double c = 1 / (r2 * std::sqrt(r2));
        d[14 + i] += (j + 1) * c * dx, d[21 + i] += (j + 1) * c * dy;
        d[14 + j] -= (i + 1) * c * dx, d[21 + j] -= (i + 1) * c * dy;
      }
  }
};

// Springs between two walls: y is [q, v], the number of components known at run time.
struct Chain {
  int n;
  void operator()(const double *__restrict y, double *__restrict d) const {
    const int m = n / 2;
    for (int i = 0; i < m; ++i) d[i] = y[m + i];
    d[m] = y[1] - 2 * y[0];
    for (int i = 1; i < m - 1; ++i) d[m + i] = y[i - 1] - 2 * y[i] + y[i + 1];
    d[n - 1] = y[m - 2] - 2 * y[m - 1];
  }
};

// Bodies of one mass in all, attraction softened; [q, v], each x, y, z by body.
struct Bodies {
  int n;
  void operator()(const double *__restrict y, double *__restrict d) const {
    const int half = n / 2;
    const double mass = 3.0 / half, softening = 0.01;
    for (int i = 0; i < half; ++i) d[i] = y[half + i], d[half + i] = 0;
    for (int i = 0; i < half; i += 3)
      for (int j = 0; j < i; j += 3) {
        const double dx = y[j] - y[i], dy = y[j + 1] - y[i + 1], dz = y[j + 2] - y[i + 2];
        const double r2 = dx * dx + dy * dy + dz * dz + softening * softening;
        const double c = mass / (r2 * std::sqrt(r2));
        d[half + i] += c * dx, d[half + i + 1] += c * dy, d[half + i + 2] += c * dz;
        d[half + j] -= c * dx, d[half + j + 1] -= c * dy, d[half + j + 2] -= c * dz;
      }
  }
};

// The mean of size(i)^2, in eight partial sums: one sum alone would keep compilers from vectors.
template <class V>
inline double mean_square(int n, const V &size) {
  constexpr int lanes = 8;
  double sum[lanes] = {};
  int i = 0;
  for (; i + lanes <= n; i += lanes)
    for (int j = 0; j < lanes; ++j) sum[j] += size(i + j) * size(i + j);
  for (; i < n; ++i) sum[0] += size(i) * size(i);
  double all = 0;
  for (double x : sum) all += x;
  return all / n;
}

template <class F, int S = 1>
inline void long_stages(const F &f, const double *y, double h, double *__restrict u,
                         double *const (&k)[7]) {
  if constexpr (S <= 6) {
    for (int i = 0; i < f.n; ++i)
      u[i] = y[i] + h * weighted<Dopri5, S>(k, i, std::make_integer_sequence<int, S>{});
    f(u, k[S]);
    long_stages<F, S + 1>(f, y, h, u, k);
  }
}

template <class F>
void solve_long(const F &f, double t, double t_end, const double *y0, double *state, double rtol,
                 double atol, long *counts) {
  const int n = f.n;
  std::vector<double> memory(9 * n);
  double *y = memory.data(), *u = y + n, *k[7];
  for (int j = 0; j < 7; ++j) k[j] = y + (2 + j) * n;
  std::copy(y0, y0 + n, y);
  f(y, k[0]);
  const auto norm = [&](const double *x, double shift) {
    return std::sqrt(mean_square(n, [&](int i) {
      return (x[i] - shift * k[0][i]) / (atol + std::abs(y[i]) * rtol);
    }));
  };
  const double d0 = norm(y, 0), d1 = norm(k[0], 0), span = t_end - t;
  const double h0 = std::min(d0 < 1e-5 || d1 < 1e-5 ? 1e-6 : 0.01 * d0 / d1, span);
  for (int i = 0; i < n; ++i) u[i] = y[i] + h0 * k[0][i];
  f(u, k[1]);
  const double d2 = norm(k[1], 1) / h0;
  const double h1 = d1 <= 1e-15 && d2 <= 1e-15 ? std::max(1e-6, h0 * 1e-3)
                                               : std::pow(0.01 / std::max(d1, d2), 1.0 / 5);
  double h = std::min({100 * h0, h1, span});
  long accepted = 0, rejected = 0;
  bool refused = false;
  while (t < t_end) {
    const double h_min = 10 * std::abs(std::nextafter(t, INFINITY) - t);
    if (refused && h < h_min) break;
    const double t_new = std::min(t + std::max(h, h_min), t_end), step = t_new - t;
    long_stages(f, y, step, u, k);
    const double error = step * std::sqrt(mean_square(n, [&](int i) {
      const double scale = atol + std::max(std::abs(y[i]), std::abs(u[i])) * rtol;
      return error_of<Dopri5, 0>(k, i, std::make_integer_sequence<int, 7>{}) / scale;
    }));
    const double factor = error == 0 ? 10 : 0.9 * std::pow(error, -1.0 / 5);
    if (error < 1) {
      h = step * std::min(refused ? 1.0 : 10.0, factor);
      t = t_new;
      std::swap(y, u);
      std::swap(k[0], k[6]);
      ++accepted;
    } else {
      h = step * std::max(0.2, factor);
      ++rejected;
    }
    refused = !(error < 1);
  }
  std::copy(y, y + n, state);
  counts[0] = 2 + 6 * (accepted + rejected);
  counts[1] = accepted;
  counts[2] = rejected;
}

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
