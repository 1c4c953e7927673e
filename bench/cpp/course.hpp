// The course's constrained systems with the course's own matrices, solved at each evaluation.
#pragma once
#include <algorithm>
#include <cmath>
#include <utility>

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
