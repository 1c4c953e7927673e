"""The words of a Run for the compiled entry: the places of inputs and outputs of a solve."""

from fastdyn.code_store.call import address_of
from fastdyn.kernels.calls.block import SIDES
from fastdyn.specialise.scalar import launch_kernel, whole_solve_kernel


def words_of(run):
    """Addresses, and offsets of a solve's output in its memory, in bytes; by name."""
    plan, every_step = run.plan, run.problem.t_eval is None
    words, launch = run.words()
    return {
        "launch": launch.buffer_info()[0],
        "launch_kernel": launch_kernel().address,
        "words": words.buffer_info()[0],
        "kernel": whole_solve_kernel().address,
        "n_steps": words.buffer_info()[0] + 8 * plan.at["n_steps"],
        "advance": words.buffer_info()[0] + 8 * plan.at["kernels.advance"],
        "n_points": plan.count("n_out" if every_step else "i_eval"),
        "t": 8 * plan.arrays["output.t"][0],
        "y": 8 * plan.arrays["output.y"][0],
        "state": 8 * plan.arrays["solve.state"][0],
        "n_stages": run.problem.method.n_stages,
        "left": run.compared.left.buffer_info()[0],
    }


def sides_of(run):
    """The addresses of the words of sides, taken and compared, of each function that decides."""
    compared = run.compared
    at = compared.sides.buffer_info()[0]
    return [
        (address_of(block) + 8 * SIDES, at + 8 * i) for i, block in enumerate(compared.deciding)
    ]
