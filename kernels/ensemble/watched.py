"""Calls `watch` for the trajectory of a lane, after or instead of the step of a vector kernel."""

from ..calls.calling_convention import invoke
from ..jit.options import INTERNAL, njit
from ..output.arguments import Events, Kernels, Output
from ..state.record import FINISHED, RUNNING, Solve
from .arguments import ALREADY, DENSE_ROWS, START, WATCH
from .collect import keep_events


@njit(**INTERNAL)
def already(state, work, block, n_steps):
    """Stands for the stepping kernel where the vector kernel has taken the step already."""
    s = state[0]
    s.n_accepted += 1
    return FINISHED if s.direction * (s.t - s.t_end) >= 0.0 else RUNNING


@njit(**INTERNAL)
def segments_of(task, room, member):
    """The segments of the span of a trajectory."""
    i = member if len(task.rows) > 2 else 0
    return room.segments[task.rows[i] : task.rows[i + 1]]


@njit(**INTERNAL)
def watch_lane(task, lanes, single, room, y_eval, kernel, lane, n_steps):
    """Run `watch` for one trajectory with the stepping kernel at an address; return its status."""
    w = task.worker[0]
    one = slice(lane, lane + 1)
    at = task.addresses
    segments = segments_of(task, room, lanes.members[lane])
    none = room.t[:0]
    own = kernel, at[DENSE_ROWS], w.fsal_stage, w.project, at[START], w.order
    return invoke(
        at[WATCH],
        (
            Kernels(*own, w.inside, w.keeps, w.past, w.n_past),
            Solve(lanes.states[one], single.work, single.block),
            Output(
                lanes.records[one],
                room.t,
                y_eval,
                room.d,
                room.spans,
                room.t_eval,
                segments,
                room.spans[:0],
                none,
                none,
                lanes.states[:0],
            ),
            Events(lanes.events[lane], lanes.schedules[lane], room.e_index, room.e_t, room.e_y),
            single.scratch,
            n_steps,
        ),
    )


@njit(**INTERNAL)
def act_at_start(task, lanes, single, room, results, found, lane):
    """Let schedules act at the start of a trajectory, before a vector kernel steps.

    Returns a status.
    """
    w = task.worker[0]
    o = lanes.records[lane]
    member = lanes.members[lane]
    kernel = task.addresses[ALREADY]
    y_eval = results.y_eval[member]
    status = watch_lane(task, lanes, single, room, y_eval, kernel, lane, 0)
    keep_events(w, o, room, found, results.t_first[member], member)
    return status
