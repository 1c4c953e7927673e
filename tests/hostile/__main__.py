"""python -m tests.hostile --count 2000 --seed 0: each difference with its source."""

import argparse
import collections
import pathlib
import sys
from functools import partial

from .compare import verdict
from .compose import draw_case
from .selections import draw_selection
from .solvers import TooMany
from .solving import outcome
from .workers import judged

BAD = ("difference", "hang", "crash")


def check_idioms(cases):
    """Name the cases that are no Python, or that raise: the idioms to look at."""
    raised: collections.Counter = collections.Counter()
    for case in cases:
        try:
            found = outcome(case.source, "scipy")
        except (Exception, TooMany) as error:
            print(case.number, case.name, f"{type(error).__name__}: {error}", case.source, sep="\n")
            continue
        if found.raised:
            raised[case.name, found.raised[:2]] += 1
    for (name, what), n in sorted(raised.items(), key=lambda pair: pair[0][0]):
        print(n, name, *what)
    return 0


def main():
    parser = argparse.ArgumentParser(prog="python -m tests.hostile")
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--only", help="one case, as seed:index, in this process")
    parser.add_argument("--source", type=pathlib.Path, help="a case of this file, in this process")
    parser.add_argument("--keep", type=pathlib.Path, help="a folder for the sources that differ")
    parser.add_argument("--family", default="", help="a file of tests/hostile/idioms, without .txt")
    parser.add_argument("--selections", action="store_true", help="cases of `selections`")
    parser.add_argument("--scipy", action="store_true", help="what SciPy makes of them, only")
    given = parser.parse_args()
    drawn = draw_selection if given.selections else partial(draw_case, family=given.family)
    if given.only:
        seed, index = map(int, given.only.split(":"))
        case = drawn(seed, index)
        print(case.name, case.source, *verdict(case.source), sep="\n")
        return 0
    if given.source:
        print(*verdict(given.source.read_text()), sep="\n")
        return 0
    cases = [drawn(given.seed, given.first + j) for j in range(given.count)]
    if given.scipy:
        return check_idioms(cases)
    counts: collections.Counter = collections.Counter()

    def report(case, found, details, seconds):
        counts[found] += 1
        counts["slow"] += details.startswith("slow")
        if found in BAD or details.startswith("slow") or found == "refused":
            print(
                f"##### {case.number} {found} {case.name}: {details} ({seconds:.1f} s)", flush=True
            )
        if found in BAD:
            print(case.source, flush=True)
        if found in BAD and given.keep:
            given.keep.mkdir(parents=True, exist_ok=True)
            (given.keep / f"{case.number.replace(':', '_')}.py").write_text(case.source)

    judged(cases, given.workers, report)
    print(", ".join(f"{n} {what}" for what, n in sorted(counts.items())))
    return int(any(counts[bad] for bad in BAD))


sys.exit(main())
