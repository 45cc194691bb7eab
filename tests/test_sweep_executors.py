"""Sweeps on the workers of an executor: the same bits, and nothing lost or doubled when workers die."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import threading
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import softlimb as sl
from softlimb import rows
from softlimb.sweep import run
from sweep_examples import KnownRows, same_bits, small_limb, some_pressures, use_known_rows

PRESSURES = some_pressures(100)
SPAWN = multiprocessing.get_context("spawn")  # a process with threads, as numpy's, is not to be forked


@pytest.fixture
def known_rows(monkeypatch):
    solver = KnownRows()
    monkeypatch.setattr(rows, "solve_rows", solver)
    return solver


class Broken(Exception):
    """What a transport may raise."""


class Here(Executor):
    """Runs a task when it is submitted; what it is told to fail fails, and what was given is noted."""

    def __init__(self, fail=lambda number, task, pressures: None):
        self.fail = fail
        self.first = []  # first pressure of every chunk, in the order in which they came
        self.labels = []
        self.ended = False

    def submit(self, task, pressures, label):
        self.first.append(float(pressures[0, 0]))
        self.labels.append(label)
        future = Future()
        future.set_running_or_notify_cancel()
        try:
            instead = self.fail(len(self.first) - 1, task, pressures)
            future.set_result(task(pressures, label) if instead is None else instead)
        except Exception as error:
            future.set_exception(error)
        return future

    def shutdown(self, wait=True, *, cancel_futures=False):
        self.ended = True


def swept(executor, pressures=PRESSURES, **options):
    return small_limb().sweep(pressures, progress=False, executor=executor, **options)


@pytest.fixture
def here(known_rows):
    """The batch of a sweep in this process."""
    batch = small_limb().sweep(PRESSURES, progress=False)
    known_rows.solved = []
    return batch


# --- pools of processes ------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def pool():
    with ProcessPoolExecutor(2, mp_context=SPAWN) as executor:
        yield executor


@pytest.mark.parametrize("ordered", [False, True])
def test_a_pool_of_processes_finds_the_same_bits(pool, ordered: bool) -> None:
    limb, pressures = small_limb(), some_pressures(70)
    options = {"progress": False, "gravity": (0.0, 0.0, 9.81), "ordered": ordered}
    batch = limb.sweep(pressures, executor=pool, **options)
    assert same_bits(batch, limb.sweep(pressures, **options))
    assert batch.builds == (rows.build(),)
    assert pool.submit(os.getpid).result() != os.getpid()  # and it is still there for others


@dataclass(frozen=True)
class Killer:
    """A task that kills its worker, or fails, when it first comes to certain chunks; the first rows' pressures tell."""

    task: object
    folder: str
    firsts: tuple[float, ...]
    always: tuple[float, ...] = ()
    failing: tuple[float, ...] = ()

    def __call__(self, pressures, label):
        first = float(pressures[0, 0])
        marker = Path(self.folder) / f"{first!r}.died"
        if first in self.always or (first in self.firsts + self.failing and not marker.exists()):
            marker.open("a", encoding="utf-8").close()
            if first in self.failing:
                raise Broken("the line was cut")
            os.kill(os.getpid(), signal.SIGKILL)
        return self.task(pressures, label)


class KillingPool(ProcessPoolExecutor):
    """A pool of processes some of whose tasks kill their worker."""

    def __init__(self, folder, firsts, always=()):
        super().__init__(2, mp_context=SPAWN, initializer=use_known_rows)
        self.given = str(folder), firsts, always

    def submit(self, task, *arguments):
        return super().submit(Killer(task, *self.given), *arguments)


def test_a_worker_that_dies_once_costs_nothing(here, tmp_path) -> None:
    first = float(PRESSURES[44, 0])
    made = []

    def pools():
        made.append(KillingPool(tmp_path, (first,)))
        return made[-1]

    batch = swept(pools, file=tmp_path / "a")
    assert same_bits(batch, here) and not batch.interrupted
    assert len(made) == 2 and len(list(tmp_path.glob("*.died"))) == 1
    small_limb().sweep(PRESSURES, progress=False, file=tmp_path / "b")
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_a_chunk_that_always_kills_is_given_up_alone_and_its_rows_say_why(here, tmp_path) -> None:
    # 100 rows are chunks of two: row 44 starts one.
    first = float(PRESSURES[44, 0])
    with pytest.warns(RuntimeWarning, match=r"rows 44 to 45 are not run: its chunk failed 3 times .* Broken"):
        batch = swept(lambda: KillingPool(tmp_path, (), (first,)), file=tmp_path / "a")
    assert batch.interrupted and batch.having("not_run").tolist() == [44, 45]
    assert "its chunk failed 3 times on the executor; BrokenProcessPool" in batch.message[45]
    assert list(sl.Batch.load(tmp_path / "a").message) == list(batch.message)
    assert same_bits(batch.resume(progress=False), here)
    small_limb().sweep(PRESSURES, progress=False, file=tmp_path / "b")
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


def test_a_given_pool_of_processes_that_breaks_is_followed_by_one_like_it(here) -> None:
    with ProcessPoolExecutor(1, mp_context=SPAWN, initializer=use_known_rows) as pool:
        worker = pool.submit(os.getpid).result()
        os.kill(worker, signal.SIGKILL)
        with pytest.raises(BrokenExecutor):
            pool.submit(os.getpid).result()
        batch = swept(pool)
    assert same_bits(batch, here)


# --- other executors ---------------------------------------------------------------------------------------------


def test_threads_of_python_do_too(here) -> None:
    with ThreadPoolExecutor(3) as executor:
        assert same_bits(swept(executor), here)
        assert executor.submit(lambda: 1).result() == 1


@pytest.mark.parametrize("ordered", [False, True])
def test_chunks_hold_every_row_once_and_ordered_ones_whole_groups(known_rows, ordered: bool) -> None:
    executor = Here()
    assert same_bits(swept(executor, ordered=ordered), small_limb().sweep(PRESSURES, progress=False, ordered=ordered))
    assert sorted(known_rows.solved) == sorted(2 * PRESSURES[:, 0].tolist())
    assert len(executor.first) == (4 if ordered else 50)
    assert not executor.ended  # it is the caller's


def test_workers_have_one_thread_each_unless_told_otherwise(known_rows, monkeypatch) -> None:
    told = []
    solve = rows.solve_rows
    monkeypatch.setattr(
        rows, "solve_rows", lambda *a, threads, **options: told.append(threads) or solve(*a, threads=threads, **options)
    )
    swept(Here())
    swept(Here(), threads=3)
    assert set(told) == {1, 3}


def test_a_result_that_does_not_arrive_is_asked_for_again(here, known_rows) -> None:
    def fail(number, task, pressures):
        if number in (0, 3, 50):  # the first chunk twice: it comes again at the end
            raise Broken("the line was cut")
        if number == 7:
            return "nonsense"
        if number == 8:
            return type(task(pressures, ""))(rows.Rows.not_run(1, 1), "a build")  # too few rows
        if number == 9:
            return type(task(pressures, ""))(rows.Rows.not_run(len(pressures), 1), "a build")  # it was interrupted
        return None

    executor = Here(fail)
    assert same_bits(swept(executor), here)
    assert len(executor.first) == 50 + 6
    assert len({*executor.labels}) == 56  # no scheduler may take two attempts for one


def test_a_chunk_that_never_arrives_is_not_run_and_says_why(here) -> None:
    poison = float(PRESSURES[10, 0])

    def fail(number, task, pressures):
        if pressures[0, 0] == poison:
            raise Broken("the line was cut")

    executor = Here(fail)
    with pytest.warns(RuntimeWarning, match=r"rows 10 to 11 are not run: its chunk failed 3 times .* Broken"):
        batch = swept(executor)
    assert executor.first.count(poison) == 3
    assert batch.having("not_run").tolist() == [10, 11] and "Broken: the line was cut" in batch.failures[10]
    assert same_bits(batch.resume(progress=False), here)


class Fragile(Executor):
    """Tasks that are under way together end together: all of them broken where one of them is poison."""

    _max_workers = 4

    def __init__(self, poison):
        self.poison, self.given = poison, []

    def submit(self, task, pressures, label):
        self.given.append((Future(), task, pressures, label))
        threading.Timer(0.02, self.end, [len(self.given)]).start()  # [s], the last of a window ends all of it
        return self.given[-1][0]

    def end(self, count):
        if count != len(self.given) or self.given[-1][0].done():
            return
        under_way = [entry for entry in self.given if not entry[0].done()]
        broken = any(float(pressures[0, 0]) in self.poison for _, _, pressures, _ in under_way)
        for future, task, pressures, label in under_way:
            future.set_running_or_notify_cancel()
            if broken:
                future.set_exception(BrokenExecutor("a worker died"))
            else:
                future.set_result(task(pressures, label))


def test_what_runs_beside_a_chunk_that_kills_is_not_given_up_with_it(here, known_rows) -> None:
    poison = [float(PRESSURES[row, 0]) for row in (44, 46, 80)]
    with pytest.warns(RuntimeWarning, match="are not run: its chunk failed 3 times"):
        batch = swept(lambda: Fragile(poison))
    assert batch.having("not_run").tolist() == [44, 45, 46, 47, 80, 81]
    assert len(known_rows.solved) == 94


def test_every_row_is_counted_once_whatever_happens_on_the_way(here, monkeypatch) -> None:
    counted = []

    @contextlib.contextmanager
    def progress(shows, count, missing):
        counted.append([count, missing, 0])

        def advance(rows):
            counted[-1][-1] += rows

        yield advance

    monkeypatch.setattr(run, "_progress", progress)
    first = float(PRESSURES[44, 0])

    def fail(number, task, pressures):
        if number in (1, 5):
            raise Broken("the line was cut")
        if number == 30:
            raise BrokenExecutor("gone")

    swept(lambda: Here(fail))
    swept(lambda: Fragile([]))
    with pytest.warns(RuntimeWarning, match="the executor broke"):
        swept(Here(fail))
    with pytest.warns(RuntimeWarning, match="not run"):
        batch = swept(lambda: Fragile([first]))
    batch.resume()
    assert counted == [[100, 100, 100]] * 3 + [[100, 100, 98], [100, 2, 2]]


def test_an_executor_that_breaks_for_good_leaves_the_rest_to_this_process(here, known_rows, tmp_path) -> None:
    def fail(number, task, pressures):
        if number >= 20:
            raise BrokenExecutor("no workers")

    with pytest.warns(RuntimeWarning, match=r"the executor broke, 60 rows are solved in this process: BrokenExecutor"):
        batch = swept(Here(fail), file=tmp_path / "a")
    assert same_bits(batch, here)
    assert sorted(known_rows.solved) == sorted(PRESSURES[:, 0].tolist())


def test_an_executor_that_takes_nothing_more_counts_as_broken(here) -> None:
    class Closed(Here):
        def submit(self, task, pressures, label):
            if len(self.first) == 5:
                raise RuntimeError("cannot schedule new futures after shutdown")
            return super().submit(task, pressures, label)

    with pytest.warns(RuntimeWarning, match="the executor broke, 90 rows are solved in this process"):
        assert same_bits(swept(Closed()), here)


def test_executors_that_fail_one_after_the_other_end_the_sweep_and_keep_what_is_done(here, tmp_path) -> None:
    made = []

    def makes():
        def fail(number, task, pressures, last=20 if not made else -1):
            if number > last:
                raise BrokenExecutor("gone")

        made.append(Here(fail))
        return made[-1]

    with pytest.warns(RuntimeWarning, match="not run"):
        batch = swept(makes, file=tmp_path / "a")
    assert all(executor.ended for executor in made) and len(made) <= 11
    assert batch.interrupted and int(batch.success.sum()) > 20
    assert all("not run: " in batch.message[row] and "gone" in batch.message[row] for row in batch.having("not_run"))
    assert same_bits(batch.resume(progress=False), here)


def test_an_executor_that_never_returns_anything_is_an_error(known_rows, tmp_path) -> None:
    def fail(number, task, pressures):
        raise Broken("no route to host")

    for executor in (Here(fail), lambda: Here(fail)):
        with pytest.raises(RuntimeError, match=r"the executor returned nothing; .* Broken: no route to host"):
            swept(executor, file=tmp_path / "a")
        assert not list(tmp_path.iterdir())
    with pytest.raises(RuntimeError, match="executor returned nothing"), ThreadPoolExecutor(1) as executor:
        executor.shutdown()
        swept(executor)


def test_what_the_limb_refuses_on_a_worker_is_refused_here(tmp_path) -> None:
    for options, error in (({"gravity": "up"}, ValueError), ({"gravitas": 1}, TypeError)):
        with pytest.raises(error, match="gravit"):
            swept(Here(), **options)
        with pytest.raises(error, match="gravit"):
            swept(Here(), file=tmp_path / "a", **options)
        assert not list(tmp_path.iterdir())


def test_a_full_disk_is_no_fault_of_the_workers(known_rows, tmp_path, monkeypatch) -> None:
    def full(self, first, rows):
        raise OSError(28, "file a cannot be written: No space left on device")

    monkeypatch.setattr("softlimb.sweep.sweep_file.SweepFile.put", full)
    executor = Here()
    with pytest.raises(OSError, match="No space left"):
        swept(executor, file=tmp_path / "a")
    assert len(executor.first) <= 256


def test_rows_of_workers_with_another_build_are_named(known_rows) -> None:
    def fail(number, task, pressures):
        solved = task(pressures, "")
        return type(solved)(solved.rows, "softlimb elsewhere") if number == 3 else None

    # Which of the two comes first is a matter of which chunk was ready first.
    with pytest.warns(RuntimeWarning, match="solved by different builds, whose bits may differ: .*softlimb elsewhere"):
        batch = swept(Here(fail))
    assert batch.builds == tuple(sorted((rows.build(), "softlimb elsewhere")))


@pytest.mark.parametrize("where", ["memory", "file"])
def test_ctrl_c_keeps_what_workers_have_done(here, tmp_path, where: str) -> None:
    def fail(number, task, pressures):
        if number == 9:
            signal.raise_signal(signal.SIGINT)

    options = {"file": tmp_path / "a"} if where == "file" else {}
    batch = swept(lambda: Slow(fail), **options)
    assert batch.interrupted and 0 < batch.status.count("not_run") < 100
    assert same_bits(batch.resume(progress=False), here)


class Slow(Here):
    """Ends a task when it is waited for, as a pool does, with four workers."""

    _max_workers = 4


def test_a_short_sweep_is_cut_for_many_workers_and_a_long_one_into_small_pieces() -> None:
    def sizes(count, ordered=False):
        return [stop - first for first, stop in run._cut(np.ones(count, dtype=bool), ordered)]

    assert sizes(5) == [1] * 5
    assert sizes(1000) == [16] * 62 + [8]
    assert sizes(1000, ordered=True) == [32] * 31 + [8]
    assert max(sizes(10**6)) == 1024 and sum(sizes(10**6)) == 10**6
    assert {size % 32 for size in sizes(100_000, ordered=True)} == {0}


def test_a_sweep_may_run_outside_the_main_thread(here) -> None:
    found = []
    thread = threading.Thread(target=lambda: found.append(small_limb().sweep(PRESSURES, progress=False)))
    thread.start()
    thread.join()
    assert same_bits(found[0], here)


# --- Dask --------------------------------------------------------------------------------------------------------


class DaskKilling(Executor):
    """An executor of Dask some of whose tasks kill their worker, or fail."""

    def __init__(self, inner, *given):
        self.inner, self.given = inner, given

    def submit(self, task, *arguments):
        return self.inner.submit(Killer(task, *self.given), *arguments)


# Clusters warn of their own affairs when workers come and go (closed streams, event loops).
@pytest.mark.filterwarnings("default")
def test_a_cluster_of_dask_finds_the_same_bits_and_survives_a_worker(tmp_path) -> None:
    distributed = pytest.importorskip("distributed")
    limb, pressures = small_limb(), some_pressures(64)
    options = {"progress": False, "gravity": (0.0, 0.0, 9.81)}
    import dask

    with (
        # How long a result is waited for whose worker has died: half a minute if not told.
        dask.config.set({"distributed.comm.timeouts.connect": "2s"}),
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address="127.0.0.1:0", silence_logs=50
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        there = limb.sweep(pressures, executor=client.get_executor(), **options)
        kills, fails = float(pressures[30, 0]), float(pressures[50, 0])
        executor = DaskKilling(client.get_executor(), str(tmp_path), (kills,), (), (fails,))
        killed = limb.sweep(pressures, executor=executor, file=tmp_path / "a", **options)
        client.wait_for_workers(2, timeout=60)  # a cluster that closes while it makes a worker anew takes half a minute
    assert len(list(tmp_path.glob("*.died"))) == 2
    here = limb.sweep(pressures, **options)
    assert same_bits(there, here) and same_bits(killed, here)
