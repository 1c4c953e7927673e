// A right-hand side F of F::n components, known at compile time: stages, first step, the loop.
#pragma once
#include <algorithm>
#include <cmath>
#include <limits>

#include "weights.hpp"

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
