// DOPRI5 for a number of components known at run time, and springs and bodies for it.
#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "weights.hpp"

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
