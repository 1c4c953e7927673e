// Right-hand sides of few components; p are the parameters.
#pragma once
#include <algorithm>
#include <cmath>

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
