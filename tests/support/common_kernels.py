"""Compile the kernels that all tests use: the share of a worker, given its number and how many."""

import sys

from fastdyn.kernels.methods import METHODS
from fastdyn.specialise import scalar
from fastdyn.specialise.rare import KERNELS


def main(worker, n_workers):
    """Compile the kernels of a worker.

    Those with matrices have most of their parts in common: one process compiles them all.
    """
    plain = [name for name, method in METHODS.items() if method.n_matrices == 0]
    with_matrices = [name for name in METHODS if name not in plain]
    mine = plain[worker - 1 :: max(n_workers - 1, 1)] if worker else with_matrices
    for name in mine:
        kernels = scalar.start_kernel, scalar.dense_rows_kernel, scalar.shared_kernel
        for kernel in kernels[: 2 if METHODS[name].series else 3]:
            kernel(name)
    if worker == 0:
        watches = scalar.watch_plain_kernel, scalar.watch_events_kernel, scalar.watch_kernel
        rare = [scalar.kernel_for_all(name) for name, _ in KERNELS]
        for kernel in (*watches, scalar.whole_solve_kernel, *rare):
            kernel()


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
