// Equations with constant delays by DOPRI5 and its interpolant of order 4 (L. F. Shampine, "Some practical
// Runge-Kutta formulas", Math. Comp. 46, 1986): steps no longer than the least delay, which end where a jump of the
// start arrives, up to the order of the method.
#include <vector>

#include "solve.hpp"
#include "tableaux.hpp"

static constexpr double interpolant[7][3] = {
  {-8048581381. / 2820520608, 8663915743. / 2820520608, -12715105075. / 11282082432},
  {0, 0, 0},
  {131558114200. / 32700410799, -68118460800. / 10900136933, 87487479700. / 32700410799},
  {-1754552775. / 470086768, 14199869525. / 1410260304, -10690763975. / 1880347072},
  {127303824393. / 49829197408, -318862633887. / 49829197408, 701980252875. / 199316789632},
  {-282668133. / 205662961, 2019193451. / 616988883, -1453857185. / 822651844},
  {40617522. / 29380423, -110615467. / 29380423, 69997945. / 29380423}};

struct Linear {
  static constexpr int n = 1, delays = 1;
  void operator()(const double (&)[1], const double (&z)[1][1], double (&d)[1]) const { d[0] = -z[0][0]; }
};

struct BloodCells {
  static constexpr int n = 1, delays = 1;
  void operator()(const double (&y)[1], const double (&z)[1][1], double (&d)[1]) const {
    double p = z[0][0], p2 = p * p, p4 = p2 * p2;
    d[0] = 0.2 * p / (1.0 + p4 * p4 * p2) - 0.1 * y[0];
  }
};

struct Infection {
  static constexpr int n = 3, delays = 2;
  void operator()(const double (&y)[3], const double (&z)[2][3], double (&d)[3]) const {
    double caught = y[0] * z[0][1], lost = z[1][1];
    d[0] = lost - caught;
    d[1] = caught - y[1];
    d[2] = y[1] - lost;
  }
};

template <class F>
struct Delayed {
  static constexpr int n = F::n;
  struct Step {
    double t, h, y[n], k[n], q[3][n];
  };
  F fun;
  const double *tau, *history;
  std::vector<Step> &steps;
  mutable std::size_t at[F::delays] = {};  // the step that a delay read last

  void past(int j, double s, double (&z)[n]) const {
    if (s <= 0 || steps.empty()) {
      std::copy(history, history + n, z);
      return;
    }
    std::size_t &m = at[j];
    m = std::min(m, steps.size() - 1);
    while (m > 0 && steps[m].t > s) --m;
    while (m + 1 < steps.size() && steps[m + 1].t <= s) ++m;
    const Step &a = steps[m];
    const double x = (s - a.t) / a.h;
    for (int i = 0; i < n; ++i)
      z[i] = a.y[i] + x * a.h * (a.k[i] + x * (a.q[0][i] + x * (a.q[1][i] + x * a.q[2][i])));
  }

  void operator()(double t, const double (&y)[n], double (&d)[n]) const {
    double z[F::delays][n];
    for (int j = 0; j < F::delays; ++j) past(j, t - tau[j], z[j]);
    fun(y, z, d);
  }

  void keep(double t, double h, const double (&y)[n], const double (&k)[7][n]) {
    Step a{t, h, {}, {}, {}};
    for (int i = 0; i < n; ++i) {
      a.y[i] = y[i];
      a.k[i] = k[0][i];
      for (int c = 0; c < 3; ++c)
        for (int s = 0; s < 7; ++s) a.q[c][i] += interpolant[s][c] * k[s][i];
    }
    steps.push_back(a);
  }
};

// The times up to the end at which the start is felt, through so many delays, within rounding of each other once.
static void arrivals(const double *tau, int delays, double end, std::vector<double> &times) {
  times.assign(1, 0.0);
  std::vector<double> of_order = times, next;
  for (int order = 1; order <= Dopri5::order + 1; ++order) {
    next.clear();
    for (double t : of_order)
      for (int j = 0; j < delays; ++j)
        if (t + tau[j] < end) next.push_back(t + tau[j]);
    times.insert(times.end(), next.begin(), next.end());
    of_order = next;
  }
  times.push_back(end);
  std::sort(times.begin(), times.end());
  auto same = [end](double a, double b) { return b - a < 1e-14 * end; };
  times.erase(std::unique(times.begin(), times.end(), same), times.end());
}

template <class F>
void solve_delayed(const double *tau, double end, const double *history, double *state, double rtol, double atol,
                   long *counts) {
  constexpr int n = F::n, s = Dopri5::stages;
  static thread_local std::vector<typename Delayed<F>::Step> steps;
  static thread_local std::vector<double> goals;
  steps.clear();
  arrivals(tau, F::delays, end, goals);
  Delayed<F> f{F{}, tau, history, steps};
  const double least = *std::min_element(tau, tau + F::delays);
  double t = 0, y[n], u[n], k[s + 1][n];
  std::copy(history, history + n, y);
  f(t, y, k[0]);
  double h = first_step(f, t, y, k[0], end, Dopri5::order - 1, rtol, atol);
  long rejected = 0;
  std::size_t goal = 1;
  while (t < end) {
    double step = std::min(h, least);
    const bool cut = t + step * (1 + 1e-9) >= goals[goal];
    if (cut) step = goals[goal] - t;
    stages<Dopri5>(f, t, y, step, u, k);
    double sum = 0;
    for (int i = 0; i < n; ++i) {
      const double scale = atol + std::max(std::abs(y[i]), std::abs(u[i])) * rtol;
      const double e = error_of<Dopri5, 0>(k, i, std::make_integer_sequence<int, s + 1>{}) / scale;
      sum += e * e;
    }
    const double error = step * std::sqrt(sum / n);
    if (error < 1) {
      f.keep(t, step, y, k);
      t = cut ? goals[goal++] : t + step;
      std::copy(u, u + n, y);
      std::copy(k[s], k[s] + n, k[0]);
      const double wanted = step * (error == 0 ? 10 : std::min(10.0, 0.9 * std::pow(error, -0.2)));
      h = cut ? std::max(h, wanted) : wanted;
      if (cut) f(t, y, k[0]);
    } else {
      h = step * std::max(0.2, 0.9 * std::pow(error, -0.2));
      ++rejected;
    }
  }
  std::copy(y, y + n, state);
  counts[0] = static_cast<long>(steps.size());
  counts[1] = rejected;
}

extern "C" {
void linear(const double *tau, double end, const double *history, double *state, double rtol, double atol, long *c) {
  solve_delayed<Linear>(tau, end, history, state, rtol, atol, c);
}
void blood_cells(const double *tau, double end, const double *history, double *state, double rtol, double atol, long *c) {
  solve_delayed<BloodCells>(tau, end, history, state, rtol, atol, c);
}
void infection(const double *tau, double end, const double *history, double *state, double rtol, double atol, long *c) {
  solve_delayed<Infection>(tau, end, history, state, rtol, atol, c);
}
}
