"""Compile the kernels that the tests use, for a worker given its number and how many there are.

Two workers go through one list from both ends, further workers from points between; what one has
made, the others find on disk.  So all end at the same time, and no worker waits in a test for the
kernel that another makes.  Kernels with parts in common stand beside each other: one process
compiles the parts once.
"""

import sys

from fastdyn.code_store.target import width
from fastdyn.kernels.methods import METHODS
from fastdyn.specialise import scalar
from fastdyn.specialise.for_all import FOR_ALL


def kernels():
    """What loads or compiles each kernel, as functions without arguments.

    Those with matrices come first, those that look at every step in the middle.
    """
    implicit = [name for name, method in METHODS.items() if method.n_matrices]
    explicit = [name for name in METHODS if name not in implicit]
    found = [*of_methods(implicit), *map(scalar.kernel_for_all, FOR_ALL)]
    loops = [given for given in scalar.SERIES if given[0] == "series" or given[2] == width()]
    found += [lambda given=given: scalar.series_loop(*given) for given in loops]
    return found + of_methods(explicit)


def of_methods(names):
    """The kernels of methods, as functions without arguments."""
    makers = scalar.start_kernel, scalar.dense_rows_kernel, scalar.shared_kernel
    return [
        lambda make=make, name=name: make(name)
        for name in names
        for make in (makers[:2] if METHODS[name].series else makers)
    ]


def order(worker, n_workers, n):
    """The numbers below n in the order of a worker: upwards, or downwards if its number is odd.

    Two workers with numbers that follow each other begin at the ends of one part of the list.
    """
    parts = (n_workers + 1) // 2
    if worker % 2 == 0:
        first = worker // 2 * n // parts
        return [(first + i) % n for i in range(n)]
    end = (worker // 2 + 1) * n // parts
    return [(end - 1 - i) % n for i in range(n)]


def main(worker, n_workers):
    """Compile what no other worker has compiled yet."""
    made = kernels()
    for i in order(worker, n_workers, len(made)):
        made[i]()


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
