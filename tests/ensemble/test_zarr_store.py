"""Ensembles in a store: they go on where they broke off, and nothing else is taken for them."""

import os
import pathlib
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from fastdyn import solve_ensemble
from support.blocks import M, Watched, assert_same, bottom, in_python, problem, slow


def interrupt():
    raise KeyboardInterrupt


@pytest.mark.parametrize("events", [None, bottom])
def test_a_stored_run_goes_on_where_it_broke_off(store, events):
    given = problem(events=events, reduce=("max", "mean"))
    with ThreadPoolExecutor(2) as pool:
        breaking = Watched(pool, 5, interrupt)
        with pytest.raises(KeyboardInterrupt) as caught:
            solve_ensemble(**given, client=breaking, store=store, block=30)
        so_far = caught.value.result
        n_done = int((so_far.status == 0).sum())
        assert 30 <= n_done <= 150 and n_done % 30 == 0
        assert set(so_far.status) == {0, -2} and so_far[332].message.startswith("Interrupted")
        rest = Watched(pool)
        whole = solve_ensemble(**given, client=rest, store=store)
        assert len(rest.futures) == 12 - n_done // 30
        assert_same(solve_ensemble(**given), whole)
        again = Watched(pool)
        assert_same(whole, solve_ensemble(**given, client=again, store=store, block=7))
        assert again.futures == []


def test_a_block_without_its_mark_is_solved_again(store):
    given = problem(events=bottom)
    whole = solve_ensemble(**given, store=store, block=50)
    (store / "finished" / "c" / "2").unlink()
    (store / "y" / "c" / "2" / "0" / "0").write_bytes(b"half")
    (store / "status" / "c" / "2").unlink()
    with ThreadPoolExecutor(1) as pool:
        again = Watched(pool)
        assert_same(whole, solve_ensemble(**given, client=again, store=store))
    assert len(again.futures) == 1


SCRIPT = """
import sys
from fastdyn import solve_ensemble
from support.blocks import slow
solve_ensemble(**slow(), store=sys.argv[1], block=20, threads=1)
"""


@pytest.mark.hunt
def test_a_killed_process_goes_on(store):
    expected = solve_ensemble(**slow())
    process = subprocess.Popen(
        [sys.executable, "-c", SCRIPT, str(store)], cwd=pathlib.Path(__file__).parents[1]
    )

    def count():  # names under which files are written are longer
        return sum(path.name.isdigit() for path in (store / "finished" / "c").glob("*"))

    while process.poll() is None and count() < 3:
        time.sleep(0.005)
    process.kill()
    assert process.wait() == -signal.SIGKILL
    n_done = count()
    assert 3 <= n_done < 17
    with ThreadPoolExecutor(1) as pool:
        rest = Watched(pool)
        assert_same(expected, solve_ensemble(**slow(), client=rest, store=store))
    assert len(rest.futures) == 17 - n_done


@pytest.mark.parametrize(
    ("changes", "what"),
    [
        ({"fun": lambda t, w, a, d: [w[1], -a * w[0]]}, "functions and what they use"),
        ({"args": (np.linspace(1.0, 9.0, M), 0.2)}, "functions and what they use"),
        ({"args": (np.linspace(1.0, 9.5, M), 0.1)}, "members"),
        ({"y0": [1.0, 0.1]}, "members"),
        ({"method": "DOP853"}, "method"),
        ({"t_span": (0, 20.5)}, "span"),
        ({"rtol": 1e-5}, "tolerances and steps"),
        ({"t_eval": None}, "output"),
        ({"reduce": "max"}, "reduce"),
        ({"events": bottom}, "events"),
        ({"simd": False}, "simd"),
        ({"max_steps": 10**6}, "max_steps"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_store_of_another_run_is_refused(changes, what, finished_store):
    with pytest.raises(ValueError, match=f"another run; what differs: .*{what}"):
        solve_ensemble(**problem(**changes), store=finished_store)


@pytest.fixture(scope="module")
def finished_store(tmp_path_factory):
    pytest.importorskip("zarr", reason="needs zarr")
    path = tmp_path_factory.mktemp("stores") / "run.zarr"
    solve_ensemble(**problem(), store=path)
    return path


def test_a_store_of_another_version_or_of_something_else_is_refused(store, monkeypatch):
    import zarr

    zarr.create_group(store.with_name("other"))
    store.with_name("full").mkdir()
    store.with_name("full").joinpath("notes").write_text("mine")
    for name in ("other", "full"):
        with pytest.raises(ValueError, match="something else"):
            solve_ensemble(**problem(), store=store.with_name(name))
    assert os.listdir(store.with_name("full")) == ["notes"]
    solve_ensemble(**problem(), store=store)
    monkeypatch.setattr("fastdyn.ensemble.in_blocks.__version__", "99")
    with pytest.raises(ValueError, match="what differs: fastdyn"):
        solve_ensemble(**problem(), store=store)


@pytest.mark.filterwarnings("ignore::fastdyn.CompileWarning")
def test_a_store_needs_functions_that_others_can_tell(store):
    with pytest.raises(ValueError, match="`store` needs functions that compile"):
        solve_ensemble(**problem(fun=in_python), store=store)


def test_a_store_is_read_when_it_is_indexed_and_by_others(finished_store):
    zarr, xarray = pytest.importorskip("zarr"), pytest.importorskip("xarray")
    stored, local = solve_ensemble(**problem(), store=finished_store), solve_ensemble(**problem())
    assert isinstance(stored.y, zarr.Array) and np.array_equal(stored.y[5:9, 0], local.y[5:9, 0])
    with xarray.open_zarr(finished_store, consolidated=False) as seen:
        assert seen.y.dims == ("trajectory", "component", "time")
        assert np.array_equal(seen.y.sel(time=20.0), local.y[:, :, -1])


BLOCK = 2
KEPT = ("finished", "status", "counts", "t_end", "y_end", "t_first")


def chunk(store, name, block=BLOCK):
    """The file of a block in an array of a store."""
    path = store / name / "c" / str(block)
    (file,) = (p for p in (path, *path.rglob("*")) if p.is_file())
    return file


def flip(path, at=-1):
    data = bytearray(path.read_bytes())
    data[at] ^= 1
    path.write_bytes(data)


BREAK = {
    "flipped": lambda path: flip(path, 20),
    "flipped checksum": flip,
    "cut": lambda path: path.write_bytes(path.read_bytes()[:-5]),
    "empty": lambda path: path.write_bytes(b""),
}


@pytest.fixture
def full(store):
    """A store of 7 blocks, and what it should say."""
    given = problem(events=bottom, reduce=("max",))
    return store, given, solve_ensemble(**given, store=store, block=50)


@pytest.mark.few(5)
@pytest.mark.parametrize("how", BREAK)
@pytest.mark.parametrize("name", KEPT)
def test_a_block_that_is_damaged_is_solved_again(full, name, how):
    store, given, whole = full
    path = chunk(store, name)
    before = path.read_bytes()
    if len(before) < 21:
        how = "flipped checksum" if how == "flipped" else how
    BREAK[how](path)
    with ThreadPoolExecutor(1) as pool:
        again = Watched(pool)
        if name == "finished":
            found = solve_ensemble(**given, client=again, store=store)
        else:
            with pytest.warns(
                UserWarning, match=r"damaged, and solved again, are the blocks \[2\]"
            ):
                found = solve_ensemble(**given, client=again, store=store)
    assert len(again.futures) == 1 and path.read_bytes() == before
    assert_same(whole, found)


@pytest.mark.parametrize("how", BREAK)
def test_states_and_events_that_are_damaged_are_no_data(full, how):
    store, given, whole = full
    y = whole.y[:]
    BREAK[how](chunk(store, "y"))
    BREAK[how](chunk(store / "events", str(50 * BLOCK), 0))
    found = solve_ensemble(**given, store=store)
    with pytest.raises(ValueError, match="checksum"):
        found.y[:]
    assert np.array_equal(found.y[:100], y[:100])  # of other blocks
    with pytest.raises(ValueError, match=r"`events/100` is lost .*Remove `finished/c/2`"):
        found.t_events  # noqa: B018
    (store / "finished" / "c" / str(BLOCK)).unlink()
    assert_same(whole, solve_ensemble(**given, store=store))


@pytest.mark.parametrize("name", ["y", "t_end", "y_end", "counts", "t_first", "best"])
def test_chunks_that_are_lost_are_not_taken_for_empty_ones(full, name):
    store, given, _ = full
    chunk(store, name).unlink()
    with pytest.raises(ValueError, match=f"is not whole: chunks of `{name}` are lost"):
        solve_ensemble(**given, store=store)


def test_events_and_status_that_are_lost(full):
    import shutil

    store, given, whole = full
    chunk(store, "status").unlink()
    with pytest.warns(UserWarning, match=r"solved again, are the blocks \[2\]"):
        assert_same(whole, solve_ensemble(**given, store=store))
    shutil.rmtree(store / "events" / "50")
    with pytest.raises(ValueError, match="`events/50` is lost"):
        solve_ensemble(**given, store=store).t_events  # noqa: B018


def test_an_array_that_is_described_otherwise_is_refused(full):
    store, given, _ = full
    about = store / "t_end" / "zarr.json"
    about.write_text(about.read_text().replace("float64", "int64").replace('"NaN"', "0"))
    with pytest.raises(ValueError, match="`t_end` is described as another array"):
        solve_ensemble(**given, store=store)


def test_blocks_without_any_number_are_no_loss(store):
    """Chunks of what no event and no trajectory filled are written, too."""
    given = problem(events=lambda t, w, a, d: w[0] + 99.0)
    whole = solve_ensemble(**given, store=store, block=50)
    assert np.isnan(whole.y[:]).sum() == 0
    assert_same(whole, solve_ensemble(**given, store=store))
