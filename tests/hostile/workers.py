"""Cases in processes of their own: what hangs is killed, what crashes is named."""

import json
import os
import pathlib
import queue
import subprocess
import sys
import threading
import time

from .solvers import EXPLICIT, OWN

METHODS = (*EXPLICIT, "Radau", "BDF", "LSODA", *OWN)
HANG = 20.0  # seconds of a processor that fastdyn may take for one case
SHARED = 5  # times as long on a machine with other work, and where a case waits for nothing
START = 300.0  # seconds for a process to have its kernels, which one with an empty cache compiles


def serve(*methods):
    """A worker: sources from the standard input, verdicts to the standard output.

    The kernels of the methods are made first: no case waits for them.
    """
    say = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # what C code prints

    def tell(**what):
        print(json.dumps(what), file=say, flush=True)

    from .compare import never_ends, verdict
    from .solving import outcome

    for method in methods:
        outcome(WARM.replace("METHOD", method), "fastdyn", "warm")
    tell(ready=True)
    for line in sys.stdin:
        try:
            source, hangs = json.loads(line)
            if hangs:
                tell(verdict="no reference" if never_ends(source) else "hang", details="fastdyn")
                continue
            found, details = verdict(source, lambda: tell(fastdyn=True))
        except BaseException as error:
            found, details = "crash", f"{type(error).__name__}: {error}"
        tell(verdict=found, details=details)


WARM = """
def fun(t, y): return [-y[0]]
def watched(): pass
HOW = {"way": "once", "method": "METHOD", "rtol": 1e-6, "atol": 1e-8, "span": (0, 1), "y0": [1.0]}
"""


class Worker:
    """A process that judges one case after the other."""

    def __init__(self, methods=METHODS):
        package, begin = str(__package__), f"serve(*{methods!r})"
        root = pathlib.Path(__file__).resolve().parents[package.count(".") + 1]
        paths = os.pathsep.join([str(root), *filter(None, [os.environ.get("PYTHONPATH")])])
        self.process = subprocess.Popen(
            [sys.executable, "-W", "ignore", "-c", f"from {package}.workers import serve; {begin}"],
            env=os.environ | {"PYTHONPATH": paths}, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL, text=True,
        )  # fmt: skip
        self.lines: queue.Queue = queue.Queue()
        threading.Thread(target=self._read, daemon=True).start()
        self._next(START)

    def _read(self):
        for line in self.process.stdout or []:
            self.lines.put(json.loads(line))
        self.lines.put(None)

    def _next(self, seconds):
        try:
            return self.lines.get(timeout=seconds)
        except queue.Empty:
            return {}

    def _processor_seconds(self):
        """Seconds of a processor that the process has taken; the clock's where that is unknown."""
        try:
            numbers = pathlib.Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2]
            return sum(map(int, numbers.split()[11:13])) / os.sysconf("SC_CLK_TCK")
        except OSError:
            return time.perf_counter()

    def _answer(self, stage):
        """The next line; {} where the process hangs."""
        if stage != "fastdyn":
            return self._next(3 * HANG)
        began = self._processor_seconds()
        for _ in range(SHARED):
            said = self._next(HANG)
            if said != {} or self._processor_seconds() - began > HANG:
                return said
        return {}

    def judge(self, source, hangs=False):
        """(verdict, details, whether the worker lives) of a case; `hangs`: fastdyn did before."""
        assert self.process.stdin
        self.process.stdin.write(json.dumps([source, hangs]) + "\n")
        self.process.stdin.flush()
        stage = "SciPy"
        while True:
            said = self._answer(stage)
            if said is None:
                return "crash", f"the process died with {self.process.wait()}", False
            if not said:
                self.end()
                return ("hang" if hangs or stage == "fastdyn" else "no reference"), stage, False
            if "verdict" in said:
                return said["verdict"], said["details"], True
            stage = "fastdyn" if "fastdyn" in said else stage

    def end(self):
        self.process.kill()
        self.process.wait()


def judged(cases, n_workers, report, methods=METHODS):
    """Have workers judge all cases; ``report(case, verdict, details, seconds)`` for each."""
    todo: queue.Queue = queue.Queue()
    for case in cases:
        todo.put(case)
    lock = threading.Lock()

    def work():
        worker = None
        while True:
            try:
                case = todo.get_nowait()
            except queue.Empty:
                break
            worker = worker or Worker(methods)
            began = time.perf_counter()
            found, details, alive = worker.judge(case.source)
            if found == "hang":
                worker = Worker(methods)
                found, details, alive = worker.judge(case.source, True)
            with lock:
                report(case, found, details, time.perf_counter() - began)
            worker = worker if alive else None
        if worker:
            worker.end()

    threads = [threading.Thread(target=work) for _ in range(n_workers)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
