"""Results of an ensemble in a Zarr group, written by block, from which a broken run goes on.

The entry of a block in `finished` is written last; a block without an entry does not count.  Arrays
with a few numbers for each trajectory are in memory, too.  The states at the times of output, and
the events, stay in the group until they are used.  Each chunk ends with a checksum, which Zarr
compares when Zarr reads the chunk.
"""

import hashlib
from typing import Any

import numpy as np

from fastdyn.compile.sentences import warn
from fastdyn.kernels.state.record import INTERRUPTED
from fastdyn.run.checkpoint import refuse_other
from fastdyn.run.resume import FUNCTIONS

from .results import Results

AXES = {
    "y": ("trajectory", "component", "time"), "y_end": ("trajectory", "row"),
    "t_end": ("trajectory",), "h_end": ("trajectory",), "status": ("trajectory",),
    "counts": ("trajectory", "count"),
    "best": ("trajectory", "extremum", "row"), "t_first": ("trajectory", "event"),
    "folded": ("trajectory", "fold"),
}  # fmt: skip
FILL = {"status": INTERRUPTED, "counts": 0}  # values of missing trajectories; NaN for other arrays
DAMAGED = (ValueError, RuntimeError, OSError)  # Zarr's exceptions for a chunk that it cannot read


class Archived(Results):
    """The results of the blocks, and the group that keeps these results.

    Parameters
    ----------
    store : str, path, or a store of Zarr's
    sizes : tuple
        Arguments of `results.Results`.
    members : members.Members
    header : dict
        The identity of the ensemble, in JSON's types.  A group with another header is refused.
    t_eval : ndarray or None
    n : int
        Components of the states at the times of output.
    block : int
        Trajectories in a block; an existing group keeps its own number.
    """

    ROWS = tuple(name for name in Results.ROWS if name != "y_eval")

    def __init__(self, store, sizes, members, header, t_eval, n, block):
        if header[FUNCTIONS] is None:
            raise ValueError(
                "`store` needs functions that compile, and that use no object which exists in this "
                "process alone: a store must tell its run from other runs."
            )
        count, n_extended, _, *others = sizes
        super().__init__(count, n_extended, 0, *others)
        self._n = n
        header = {**header, "shape": [count, n], "members": _digest(members)}
        self._store, self._group = store, _opened(store, header, block)
        self.block = int(self._group.attrs["block"])
        self._arrays: dict[str, Any] = {}
        blocks = self._require("finished", (-(-count // self.block),), ("block",), 1, bool, False)
        self._names = [name for name in self.ROWS if len(getattr(self, name)) == count]
        for name in self._names:
            array = _plain(getattr(self, name))
            fill = FILL.get(name, np.nan)
            self._require(name, array.shape, AXES[name], self.block, array.dtype, fill)
        if t_eval is not None:
            n_times = len(t_eval)
            self._require("y", (count, n, n_times), AXES["y"], self.block)
            self._require("time", (n_times,), ("time",), n_times)[:] = t_eval
        self._finished = _read(blocks, 1)[0]
        self._take_over()

    def _require(self, name, shape, axes, rows, dtype: Any = float, fill: Any = np.nan):
        """An array of the group, which is made if necessary, in chunks of `rows` rows."""
        import zarr

        chunks = tuple(max(1, k) for k in (rows, *shape[1:]))
        with zarr.config.set({"array.write_empty_chunks": True}):  # a missing chunk is a lost chunk
            if name not in self._group:
                self._group.create_array(
                    name, shape=shape, chunks=chunks, dtype=dtype, fill_value=fill,
                    dimension_names=axes, compressors=_compressors(),
                )  # fmt: skip
            found: Any = self._group[name]
        if (found.shape, found.chunks, found.dtype) != (shape, chunks, np.dtype(dtype)):
            raise ValueError(
                f"`store={self._store!r}` is damaged: `{name}` is described as another array. "
                "Give another `store`."
            )
        self._arrays[name] = found
        return found

    def _take_over(self):
        """Read the finished blocks; a damaged block counts as not finished."""
        arrays = {name: _read(self._arrays[name], self.block) for name in self._names}
        damaged = {block for _, blocks in arrays.values() for block in blocks}
        left_out = arrays["status"][0] == INTERRUPTED  # Zarr's value for a missing chunk
        done = map(int, np.flatnonzero(self._finished))
        damaged.update(i for i in done if left_out[self._rows(i)].all())
        damaged = sorted(i for i in damaged if self._finished[i])
        if damaged:
            warn(f"`store={self._store!r}`: damaged, and solved again, are the blocks {damaged}.")
        self._finished[damaged] = False
        there = np.repeat(self._finished, self.block)[: len(self.status)]
        for name, (kept, _) in arrays.items():
            _plain(getattr(self, name))[there] = kept[there]
        for name in {*self._names, "y"} & {*self._arrays}:
            array = self._arrays[name]
            checked = array.size and _has_checksums(array)
            if checked and array.nchunks_initialized < self._finished.sum():
                raise ValueError(
                    f"`store={self._store!r}` is not whole: chunks of `{name}` are lost. Copy it "
                    "again, or give another `store`."
                )

    def _rows(self, block):
        """The trajectories of a block."""
        return slice(self.block * block, self.block * (block + 1))

    def missing(self):
        """The first members of the missing blocks."""
        return [self.block * int(i) for i in np.flatnonzero(~self._finished)]

    def put(self, start, part):
        """Write a block, and its entry in `finished` last."""
        end = start + len(part.t_end)
        self.raised |= {start + i: text for i, text in part.raised.items()}
        for name in self._names:
            self._arrays[name][start:end] = _plain(getattr(part, name))
            getattr(self, name)[start:end] = getattr(part, name)
        if "y" in self._arrays:
            self._arrays["y"][start:end] = part.states(self._n)
        if part.found:  # one row each: member, event, time, state
            rows = np.concatenate([np.column_stack(piece) for piece in part.found])
            rows[:, 0] += start
            self._group.create_array(
                f"events/{start}", shape=rows.shape, dtype=rows.dtype, overwrite=True,
                compressors=_compressors(),
            )[...] = rows  # fmt: skip  # `data=` is younger than the lowest Zarr
        self._arrays["finished"][start // self.block] = True
        self._finished[start // self.block] = True

    def states(self, n):
        """The states at the times of output, as a Zarr array."""
        return self._arrays["y"]

    def occurrences(self):
        """Pieces of ((member, event), time, state) of the events, one row each."""
        blocks = [self._events(int(i)) for i in np.flatnonzero(self._finished)]
        found = [rows for rows in blocks if rows is not None]
        return [(rows[:, :2].astype(int), rows[:, 2], rows[:, 3:]) for rows in found]

    def _events(self, block):
        """The rows of the events of a block, None if nothing occurred."""
        name = f"events/{self.block * block}"
        if name not in self._group and not np.isfinite(self.t_first[self._rows(block)]).any():
            return None
        try:
            return self._group[name][:]  # pyright: ignore
        except (KeyError, *DAMAGED) as error:
            raise ValueError(
                f"`store={self._store!r}`: `{name}` is lost or damaged ({error}). Remove "
                f"`finished/c/{block}` there, and the same call solves this block again."
            ) from error


def _plain(rows):
    """Records of whole numbers as a matrix, since not every Zarr has records."""
    names = rows.dtype.names
    return rows.view(np.int64).reshape(len(rows), len(names)) if names else rows


def _compressors():
    """Zarr's default compressor, then a checksum of the compressed bytes."""
    from zarr.codecs import Crc32cCodec, ZstdCodec

    return ZstdCodec(), Crc32cCodec()


def _has_checksums(array):
    """False for an array of a store that an earlier version has begun."""
    from zarr.codecs import Crc32cCodec

    return any(isinstance(codec, Crc32cCodec) for codec in array.compressors)


def _read(array, rows):
    """An array as a whole, and the indices of its damaged chunks; a chunk has `rows` rows."""
    try:
        return array[:], []
    except DAMAGED:
        whole = np.full(array.shape, array.fill_value, array.dtype)
        damaged = []
    for i in range(-(-len(whole) // rows)):
        part = slice(rows * i, rows * (i + 1))
        try:
            whole[part] = array[part]
        except DAMAGED:
            damaged.append(i)
    return whole, damaged


def _digest(members):
    """A digest of the initial states and arguments of all members."""
    digest = hashlib.sha256(repr([*members.varying]).encode())
    for array in (members.y0, members.words):
        digest.update(repr(array.shape).encode() + np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def _opened(store, header, block) -> Any:
    """The group of this run, a new one if there is none."""
    try:
        import zarr
    except ImportError as error:
        raise ImportError(
            '`store` needs Zarr: python -m pip install "fastdyn[cluster]".'
        ) from error
    try:
        group = zarr.open_group(store, mode="r+")
    except FileNotFoundError:
        attributes = {"fastdyn": header, "block": block}
        try:
            return zarr.open_group(store, mode="w-", attributes=attributes)
        except FileExistsError as error:
            raise ValueError(
                f"`store={store!r}` holds something else; give a new folder."
            ) from error
    found: Any = group.attrs.get("fastdyn")
    if not isinstance(found, dict):
        raise ValueError(f"`store={store!r}` is a Zarr group of something else.")
    refuse_other(store, found, header, "store")
    return group
