"""A solve as a user of fastdyn writes it, and the same of SciPy's parts."""

import numpy as np
import scipy.integrate

MOST_CALLS = 8000
N_STARTS = 3
NOISE = (1e-15, 8e-15)  # relative; the larger one moves the first step by its last bits
EXPLICIT = ("RK45", "RK23", "DOP853")
OWN = ("auto", "Taylor", "Tsit5", "Vern7")  # methods that SciPy lacks: its DOP853 is the truth


class TooMany(BaseException):
    """SciPy does not come to an end."""


class Solver:
    """What both have in common."""

    def __init__(self, module, how):
        self.module, self.how, self.runs, self.nfev = module, how, [], 0
        self.again = lambda: module  # the same text once more

    def args(self):
        return tuple(getattr(self.module, "args", ()))

    def options(self):
        return {key: self.how[key] for key in ("method", "rtol", "atol")}

    def keep(self, t, y, events=(), status=0):
        """Note what a solve gave."""
        counts = [len(e) for e in events or []]
        self.runs.append((np.array(t), np.array(y)[:, -1].copy(), counts, status))

    def start(self, j=0):
        given = self.how["y0"]
        if not j and self.how["way"] in ("once", "again", "twins"):
            return given  # events would be given the list itself by SciPy
        return np.array(given) * (1.0, -0.35, 2.5)[j]

    def once(self, y0=None, events=None, span=None, **options):
        r = self.solve(
            self.fun(), span or self.how["span"], self.start() if y0 is None else y0,
            args=self.args(), events=events, **self.options(), **options,
        )  # fmt: skip
        self.keep(r.t, r.y, r.t_events, r.status)
        self.nfev += r.nfev
        if r.sol is not None:
            self.runs[-1][1][:] += r.sol(self.how["when"])


class ByFastdyn(Solver):
    """As a user of fastdyn writes."""

    def fun(self):
        return self.module.fun

    def solve(self, *given, **options):
        import fastdyn

        return fastdyn.solve_ivp(*given, **options)

    def many(self, between):
        import fastdyn

        h = self.how
        shot = fastdyn.prepare(
            self.fun(), h["span"], self.start(), args=self.args(), **self.options()
        )
        for j in range(N_STARTS):
            between(j)
            r = shot(self.start(j), args=self.args())
            self.keep(r.t, r.y, (), r.status)
            self.nfev += r.nfev

    def ensemble(self):
        import fastdyn

        starts = np.array([self.start(j) for j in range(N_STARTS)])
        r = fastdyn.solve_ensemble(
            self.fun(), self.how["span"], starts, **self.options(),
            args=tuple(fastdyn.ensemble.Shared(a) if np.ndim(a) else a for a in self.args()),
        )  # fmt: skip
        self.runs += [([], y, [], s) for y, s in zip(r.y_end, r.status, strict=True)]

    def steps(self, at_each, way):
        import fastdyn

        h = self.how
        if way == "callback":
            return self.once(callback=lambda s: at_each(s.t, s.y))
        s = fastdyn.Stepper(
            self.fun(), h["span"][0], self.start(), h["span"][1], args=self.args(), **self.options()
        )
        self.walk(s, at_each)

    def walk(self, s, at_each):
        times, n = [s.t], 0
        while s.status == "running":
            s.step()
            times.append(s.t)
            at_each(s.t, s.y)
            n += 1
        self.keep(times, s.y[:, None], (), -1 if s.status == "failed" else 0)
        self.nfev += s.nfev

    def acting(self, event, act):
        self.once(events=event, on_event=act)


class InPython(ByFastdyn):
    """By fastdyn's methods, with a function that stays in Python."""

    def fun(self):
        times = []

        def noted(t, y, *args):
            times.append(t)
            return self.module.fun(t, y, *args)

        return noted


class ByScipy(Solver):
    """The same by SciPy; what SciPy lacks, of its parts."""

    def __init__(self, module, how, noise, keeps):
        super().__init__(module, how)
        self.keeps = keeps
        self.calls, self.draw = 0, np.random.default_rng(noise) if noise else None
        self.size = NOISE[noise % len(NOISE)]

    def fun(self):
        def bounded(t, y, *args):
            self.calls += 1
            if self.calls > MOST_CALLS:
                raise TooMany
            f = self.module.fun(t, y, *args)
            if isinstance(f, np.ndarray) and not self.keeps:  # and what is written to it later
                f = f.copy()
            if self.draw is None:
                return f
            try:
                f = np.asarray(f, dtype=complex if np.iscomplexobj(f) else float)
            except (TypeError, ValueError):
                return f  # SciPy says what it thinks of this
            return f * (1 + self.size * self.draw.uniform(-1, 1, f.shape))

        return bounded

    def options(self):
        found = super().options()
        return found | {"method": "DOP853"} if found["method"] in OWN else found

    def solve(self, *given, **options):
        return scipy.integrate.solve_ivp(*given, **options)

    def many(self, between):
        for j in range(N_STARTS):
            between(j)
            self.once(self.start(j))

    def ensemble(self):
        for j in range(N_STARTS):
            self.once(self.start(j))

    def steps(self, at_each, way):
        h, fun, args = self.how, self.fun(), self.args()
        method = getattr(scipy.integrate, h["method"])
        given = {"rtol": h["rtol"], "atol": h["atol"]}
        s = method(lambda t, y: fun(t, y, *args), h["span"][0], self.start(), h["span"][1], **given)
        ByFastdyn.walk(self, s, at_each)

    def acting(self, event, act):
        """A solve up to the event, which occurs once, and one from there."""
        h, args = self.how, self.args()
        event.terminal = True
        options = {"args": args, **self.options()}
        one = self.solve(self.fun(), h["span"], self.start(), events=event, **options)
        t, y, r = one.t, one.y, one
        if one.status == 1:
            start = act(t[-1], y[:, -1].copy(), *args)
            fun, time = self.fun(), float if h["method"] == "LSODA" else np.float64
            again = lambda t, *given: fun(time(t), *given)  # noqa: E731 # it is no first call
            r = self.solve(again, (t[-1], h["span"][1]), start, **options)
            t, y = np.append(t, r.t), np.hstack([y, r.y])
        self.keep(t, y, [one.t_events[0]], min(0, r.status))
