"""Runs that C and Python use alternately: a run that is in use is not in the list of idle runs.

C solves in a memory of its own, and copies the result.  Python takes over a solve from C if the
solve is long, fails, or must be compared.  The result then keeps the memory, and C gets another
memory.
"""

from typing import Any, NamedTuple

import numpy as np

from fastdyn.code_store.call import address_of
from fastdyn.compile.rebind import rebind
from fastdyn.compile.traced import met
from fastdyn.problem.events import between_steps
from fastdyn.run import laid_out
from fastdyn.run.for_c import sides_of, words_of
from fastdyn.run.loop import announce
from fastdyn.run.solve_problem import run_of
from fastdyn.run.stiffness import MANY

from . import load
from .rows import rows_of
from .words import OF_RUN

LIVE, LEFT_THEN, LOOK, MEMORY, SHORT, REST, ADVANCE = map(
    OF_RUN.index, "live left_then look memory n_short n_rest advance_kernel".split()
)
SHORT_SECONDS = 20e-6  # longest time of steps with the interpreter lock held
LOOK_EVERY = 32  # solves by C after which Python decides whether to change the kernel
MOST_STEPS = MANY - 1  # most steps of a solve that C ends: Python examines longer solves


class Kept(NamedTuple):
    """A Run with its functions, whose arguments can be replaced; `words` are for C.

    `own` has the objects that the words point to, and `turns`, the number of solves by Python.
    """

    words: np.ndarray
    run: Any
    pairs: list
    own: dict

    def take(self, args):
        """Pass arguments to the functions; False if the arguments need other code."""
        return all(rebind(bound, fun, args) for bound, fun in self.pairs)

    def given_back(self, fun, args):
        """The Kept for the next solve, after a solve by Python."""
        own, run = self.own, self.run
        own["turns"] += 1
        turns = own["turns"]
        if turns > 1 and turns & (turns - 1) == 0 and load.is_here():
            return self.for_c(fun, args, run.seconds_of_step())
        self.words[[LEFT_THEN, ADVANCE]] = met.N_LEFT[0], run.tier.address  # as `rebind` has looked
        if self.words[LIVE] and (run.grown is not None or own["laid"] is not run.words()[1]):
            self.renew()
        return self

    def for_c(self, fun, args, step):
        """A Kept with words for C, if C can solve the problem; `step` is the time of a step."""
        run = self.run
        plain = is_plain(run.problem) and run.is_plain()
        rows = rows_of(run.bounds[0], fun, args) if plain else None
        if rows is None:
            return self
        own: dict[str, Any] = {
            "turns": self.own["turns"], "step": step, "laid": None, "held": rows.held,
            "room": np.zeros(run.plan.n), "rows": np.array(rows.words, np.int64),
            "arrays": np.array(rows.arrays, np.int64),
            "found": np.zeros(1 + len(args) + rows.n_rows, np.int64),
            "sides": np.array(sides_of(run), np.int64).reshape(-1),
        }  # fmt: skip
        kept = Kept(np.zeros(len(OF_RUN), np.int64), run, self.pairs, own)
        addresses = {name: address_of(array) for name, array in own.items() if name in OF_RUN}
        kept.put(addresses | {
            "live": 1, "left_then": met.N_LEFT[0], "n": run.plan.n,
            "n_rows": rows.n_rows, "n_arrays": len(rows.arrays), "n_sides": len(own["sides"]) // 2,
        })  # fmt: skip
        kept.renew()
        return kept

    def put(self, words):
        """Set words by their names."""
        for name, word in words.items():
            self.words[OF_RUN.index(name)] = word

    def renew(self):
        """Give C another memory, and the words that have changed."""
        run, words, own = self.run, self.words, self.own
        run.make_room()
        if own["laid"] is not run.words()[1]:
            own["laid"] = run.words()[1]
            self.put(words_of(run))
        own["memory"] = memory = laid_out.new_memory(run.plan.size)
        words[MEMORY], words[ADVANCE] = address_of(memory), run.tier.address
        words[LOOK] = LOOK_EVERY if run.tier.open else 0
        most = min(run.n_first(), MOST_STEPS)
        words[SHORT] = short = max(1, min(int(SHORT_SECONDS / max(own["step"], 1e-9)), most))
        words[REST] = most - short

    def take_spans(self, sizes):
        """Allow C another span, and other times of output, at each solve.

        `sizes` are the least and the largest size of a state, or None.
        """
        run, own = self.run, self.own
        own["image"], own["t_eval"] = run.given()
        share = run.problem.method.h_max_share
        numbers = {"h_max_share": share} | dict(
            zip(("smallest", "largest"), sizes or (), strict=False)
        )
        times = {} if own["t_eval"] is None else {
            "n_eval": len(own["t_eval"]), "t_eval": address_of(own["t_eval"])
        }  # fmt: skip
        words = {name: int(np.float64(value).view(np.int64)) for name, value in numbers.items()}
        self.put(words | times | {
            "image": address_of(own["image"]), "n_sized": 0 if sizes is None else run.plan.n
        })  # fmt: skip

    def problem_of(self, problem):
        """The problem with the span and the times of output that C has taken."""
        (s,), times = self.run.plan.view(self.own["image"], "solve.state"), self.own["t_eval"]
        t0, tf, h_max = (float(s[name]) for name in ("t", "t_end", "h_max"))
        times = None if times is None else times.copy()
        return problem._replace(t0=t0, tf=tf, h_max=h_max, t_eval=times)

    def let_go(self):
        """Drop the data of the last solve."""
        self.run.memory = None
        for bound in self.run.bounds:
            bound.keepalive[:] = None, (), bound.function


def kept_of(problem):
    """A Kept for a problem, whose functions are compiled."""
    run = run_of(problem)
    announce(run.bounds)
    functions = [problem.fun, *(function for function, _ in between_steps(problem))]
    pairs = list(zip(run.bounds, functions, strict=True))
    return Kept(np.zeros(len(OF_RUN), np.int64), run, pairs, {"turns": 0})


def is_plain(problem):
    """Whether C can make the result of a problem."""
    p = problem
    times = p.t_eval is None or (p.t_eval.dtype == float and len(p.t_eval))
    return bool(
        times and p.events is None and not p.dense_output and p.on_interrupt == "raise"
        and p.project is None and p.inside is None and p.jac is None and p.callback is None
        and p.checkpoint is None and not p.progress and not p.mode.complex_numbers
    )  # fmt: skip
