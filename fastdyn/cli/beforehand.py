"""``fastdyn compile``: the kernels of methods, made before a solve needs them."""

import logging
import time

from fastdyn.kernels.methods import METHODS

from . import checks

SHARED = "what all methods share"


def add_options(parser):
    """Teach a parser the methods."""
    parser.add_argument(
        "methods", nargs="*", type=checks.method, metavar="METHOD",
        help="Radau, BDF ... (default: all methods, some minutes)",
    )  # fmt: skip


def run(options):
    """Make the kernels, and print what took how long."""
    from fastdyn import code_store
    from fastdyn.specialise.scalar import make_kernels

    log = logging.getLogger("fastdyn")
    log.disabled = True  # what is printed tells more
    try:
        names = list(dict.fromkeys(options.methods or METHODS))
        for n, name in enumerate([*names, None], 1):
            print(f"{n:>3} of {len(names) + 1}  {name or SHARED:<24}", end="", flush=True)
            begun = time.perf_counter()
            compiled = code_store.COUNTS["compiled"]
            make_kernels(name)
            made = code_store.COUNTS["compiled"] > compiled
            print(f"{time.perf_counter() - begun:6.1f} s" if made else "is there already")
    finally:
        log.disabled = False
    return 0
