"""The memory of a large system: coefficients, and states in the order of their vectors."""

import contextlib

from fastdyn.kernels.calls.block import FAILED
from fastdyn.kernels.state.record import Y_OLD, K
from fastdyn.kernels.state.series import HIGHEST

ON_STACK = 2**13  # most numbers of a workspace on the stack
ARRAYS = (
    "y", "low", "rtol", "atol", "weights", "y_old", "low_old",
    "probe", "inner", "predicted", "slope",
)  # fmt: skip


class Memory:
    """Emits the memory accesses of large systems; %space, %work and %block are defined.

    Parameters
    ----------
    text : Text
        A Text with one lane.
    plan : bundles.Bundles
    places : places.Places
    order, width : int

    Attributes
    ----------
    array : dict of str
        The addresses of ARRAYS.
    """

    def __init__(self, text, plan, places, order, width):
        self._text, self._plan, self._places = text, plan, places
        self._order, self._width, self._units = order, width, len(plan.states)
        self._n = len(plan.places_of_states)

    def in_work(self, row, i):
        """The address of a component in a row of `work`."""
        return self._text.at("%work", self._text.new(f"add i64 {i}, {row * self._n}"))

    def make_room(self):
        """Allocate the workspace: coefficients, then arrays of states; by malloc if large."""
        text, each = self._text, self._units * self._width
        whole = self._places.size + len(ARRAYS) * each
        self._on_stack = whole <= ON_STACK
        if self._on_stack:
            place = text.slot("double", whole)
            text.put(f"%space = getelementptr double, ptr {place}, i64 0")
        else:
            text.declarations["malloc"] = "declare ptr @malloc(i64)"
            text.declarations["free"] = "declare void @free(ptr)"
            text.put(f"%room = call ptr @malloc(i64 {8 * whole + 64})")
            none = text.new("icmp eq ptr %room, null")
            text.put(f"br i1 {none}, label %failed, label %room_made")
            text.label("failed")
            text.put(f"ret i64 {FAILED}")
            text.label("room_made")
            whole_words = text.new("ptrtoint ptr %room to i64")
            aligned = text.new(f"and i64 {text.new(f'add i64 {whole_words}, 63')}, -64")
            text.put(f"%space = inttoptr i64 {aligned} to ptr")
        self.array = {
            name: text.at("%space", self._places.size + i * each) for i, name in enumerate(ARRAYS)
        }

    def read_factors(self):
        """Store each invariant in the lanes that need it."""
        text, plan = self._text, self._plan
        constants = {node.key: node for f in plan.factors for node in f.nodes if node.op == "const"}
        keys = [*plan.invariants, *constants]
        if not keys:
            return
        pool = text.slot("double", len(keys))
        text.put(f"call void @fastdyn_invariants(ptr %block, ptr {pool})")
        if constants:
            table = text.table("constants", [node.data for node in constants.values()])
            with text.each(len(constants)) as i:
                target = text.at(text.at(pool, len(plan.invariants)), i)
                text.store(text.load(text.at(table, i)), target)
        at = {key: i for i, key in enumerate(keys)}
        found = [at[node.key] for f in plan.factors for node in f.nodes]
        if found:
            table = text.indices("factors", found)
            with text.each(len(found)) as i:
                text.store(text.load(text.at(pool, text.index(table, i))), text.at("%space", i))

    @contextlib.contextmanager
    def each_lane(self):
        """Loop over the lanes of all states; yields (lane, number of the state)."""
        text = self._text
        numbers = [node.data for bundle in self._plan.states for node in bundle.nodes]
        table = text.indices("states", numbers)
        with text.each(len(numbers)) as lane:
            yield lane, text.index(table, lane)

    def _lanes_of_states(self):
        """The table of each state's lane."""
        number = {bundle.key: i for i, bundle in enumerate(self._plan.states)}
        lanes = [number[b.key] * self._width + lane for b, lane in self._plan.places_of_states]
        return self._text.indices("lanes", lanes)

    @contextlib.contextmanager
    def each_vector(self):
        """Loop over the vectors of states; yields (address of order 0, addresses in the ARRAYS)."""
        text = self._text
        table = text.indices("vectors", [self._places.at[b.key] for b in self._plan.states])
        with text.each(self._units) as i:
            place = text.new(f"mul i64 {i}, {self._width}")
            here = {name: text.at(array, place) for name, array in self.array.items()}
            yield text.at("%space", text.index(table, i)), here

    def write(self, name, row):
        """Copy the states of an array into a row of `work`."""
        text = self._text
        lanes = self._lanes_of_states()
        with text.each(self._n) as i:
            value = text.load(text.at(self.array[name], text.index(lanes, i)))
            text.store(value, self.in_work(row, i))

    def read(self, row, name):
        """Copy a row of `work` into an array."""
        with self.each_lane() as (lane, i):
            value = self._text.load(self.in_work(row, i))
            self._text.store(value, self._text.at(self.array[name], lane))

    def write_series(self):
        """Copy all coefficients into the rows of `work`."""
        text, n = self._text, self._n
        places = [self._places.at[b.key] + lane for b, lane in self._plan.places_of_states]
        table = text.indices("series", places)
        text.clear(text.at("%work", (K + self._order + 1) * n), n * (HIGHEST - self._order))
        with text.each(n) as i:
            source = text.at("%space", text.index(table, i))
            text.store(text.load(source), self.in_work(Y_OLD, i))
            with text.each(self._order + 1) as k:
                value = text.load(text.at(source, text.new(f"mul i64 {k}, {self._width}")))
                row = text.new(f"mul i64 {k}, {n}")
                text.store(value, self.in_work(K, text.new(f"add i64 {row}, {i}")))

    def release(self):
        if not self._on_stack:
            self._text.put("call void @free(ptr %room)")
