"""Runs of systems by fastdyn, and the same runs as a page solves them."""

import json
import math
import subprocess

import numpy as np

from fastdyn.explore.sources import named
from fastdyn.pages import methods

RTOL, MOST = 1e-6, 100_000
DERIVED = ("double_pendulum", "four_bar", "rolling_disc", "chaplygin_sleigh", "spherical_pendulum")
SHORTER = {"double_pendulum": 5.0}  # s: chaos lets roundings grow by 10 in each second
FEWER = 400  # constant steps of a run
SOLVE = """
function answers(calls, events) {
  const variant = VARIANTS[0];
  return calls.map(([p, method, step, tf]) => {
    const y0 = startOf(variant, p);
    const run = solve({ variant, p, y0, tf, most: 100000, method: METHODS[method],
      rtol: 1e-6, step, events });
    const end = run.t[run.t.length - 1];
    return { start: Array.from(y0), nfev: run.nfev, steps: run.accepted, t: end,
      y: Array.from(run.y[run.y.length - 1]), between: Array.from(run.at(0.37 * end)),
      found: run.found.map((list) => list.map((one) => [one.t, ...one.y])), said: run.message };
  });
}
"""


class Case:
    """A system with three sets of parameters, and its runs by the methods of its page."""

    def __init__(self, name):
        source = named(name)
        self.make, self.first = source.make, source.make(**source.values)
        draws = np.random.default_rng(sum(map(ord, name)))
        self.systems = [self.first]
        while len(self.systems) < 3:
            values = {
                one: float(getattr(self.first, one)) * draws.uniform(0.85, 1.15)
                for one in numbers_of(self.first)
            }
            self.systems.append(self.make(**values))
        self.t_end = SHORTER.get(name, float(self.make.t_end))

    def runs(self, functions):
        """(calls for `answers`, runs by fastdyn)."""
        offered = methods.offered(functions.second_order, self.first.phases())
        calls, found = [], []
        step = self.t_end / FEWER
        for system in self.systems:
            p = [float(getattr(system, one)) for one in functions.numbers]
            for method in offered:
                accuracy = (
                    {"rtol": RTOL, "atol": 1e-3 * RTOL} if method == "RK45" else {"step": step}
                )
                found.append(system.solve(
                    (0.0, self.t_end), method=method, dense_output=True, max_steps=MOST,
                    events=watched(system) or None, **accuracy,
                ))  # fmt: skip
                calls.append([p, method, step, self.t_end])
        return calls, found

    def events(self):
        """The events as `answers` takes them."""
        return [
            {"index": i, "direction": one.direction, "terminal": one.terminal}
            for i, one in enumerate(watched(self.first))
        ]


def numbers_of(system):
    import dataclasses

    return [one.name for one in dataclasses.fields(system) if "unit" in one.metadata]


def watched(system):
    """The events of a system, of which only the ground ends the run."""
    found = []
    for name, function in type(system).events.items():

        def event(t, w, *args, function=function):
            return function(t, w, *args)

        event.direction = float(getattr(function, "direction", 0))
        event.terminal = name == "ground"
        found.append(event)
    return found


def compare(calls, runs, answers):
    """Assert that a page has the runs of fastdyn."""
    for call, run, page in zip(calls, runs, answers, strict=True):
        y, method = np.asarray(run.y), call[1]
        size = np.abs(y).max()
        where = (method, call[0])
        assert page["said"] == "", where
        assert page["steps"] == run.n_accepted, where
        if method != "EnergyConserving2":  # whose iteration ends where rounding ends it
            assert page["nfev"] == run.nfev, where
        assert np.abs(np.array(page["start"]) - y[:, 0]).max() <= 1e-9 * size, where
        assert math.isclose(page["t"], run.t[-1], rel_tol=1e-9), where
        assert np.abs(y[:, -1] - page["y"]).max() <= 1e-9 * size, where
        assert np.abs(run.sol(0.37 * page["t"]) - page["between"]).max() <= 1e-9 * size, where
        for times, states, found in zip(
            run.t_events or [], run.y_events or [], page["found"], strict=True
        ):
            assert len(times) == len(found), where
            if len(times):
                there = np.array(found)
                assert np.abs(there[:, 0] - times).max() <= 1e-9 * run.t[-1], where
                assert np.abs(there[:, 1:] - np.array(states)).max() <= 1e-9 * size, where


def by_node(text, case, calls, folder):
    """The answers of a page's solver, run by node."""
    script = folder / "page.js"
    script.write_text(
        f"{text}\n{SOLVE}\n"
        f"console.log(JSON.stringify(answers({json.dumps(calls)}, {json.dumps(case.events())})));"
    )
    done = subprocess.run(["node", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)
