"""Many postures of one limb under one scene: pressures in, a `Batch` out; on all cores, or wherever one likes."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb import rows as solver
from softlimb.arguments import real_array, shown, truth
from softlimb.rows import GROUP, INVALID, NOT_RUN, Atlas
from softlimb.sweep.batch import Batch, actuator_names, file_path
from softlimb.sweep.chunks import Chunk, Solved, Task, require_executor, run_chunks
from softlimb.sweep.record import SweepRecord
from softlimb.sweep.row_table import MemoryTable, Messages, Table, runs_of
from softlimb.sweep.sweep_file import SweepFile, read

if TYPE_CHECKING:
    from softlimb.limb import Limb

__all__ = ["resume", "sweep"]

_BLOCK_SECONDS = 0.5  # rows that are solved between two visits to the table: what a killed process loses
_MOST_IN_BLOCK = 32768  # rows, some twenty megabytes
_MOST_IN_CHUNK = 1024  # rows that travel to a worker and back together, half a megabyte
_LONG = 2048  # rows from which on some are solved first, so that the others start near their answers
_ANCHORS = (128, 2048)  # at least and at most so many of them, one in sixteen between: one in three is a term of a fit
_HEADS = 128  # how many where rows are ordered and few of them start there
_BESIDE = 8  # groups of an ordered sweep that a thread may have under way side by side
_CHUNKS = 64  # into which a short sweep is cut at least, so that many workers have something to do


def sweep(
    limb: Limb,
    pressures: ArrayLike,
    *,
    threads: int | None = None,
    executor: Executor | Callable[[], Executor] | None = None,
    progress: bool = True,
    ordered: bool = False,
    file: str | os.PathLike[str] | None = None,
    **scene: Any,
) -> Batch:
    """Solve one posture for each row of pressures; `Limb.sweep` has the arguments in full.

    Raises
    ------
    ValueError
        Pressures of a wrong shape, not finite or not real numbers; loads that `Limb.solve` refuses; a file that holds
        another sweep.
    TypeError
        The executor is none, or the file no path.
    OSError
        The file cannot be written.
    """
    work = _Work.checked(limb, scene, threads, executor, progress, ordered)
    given = _pressure_rows(limb, pressures)
    if file is not None:
        return _sweep_to_file(work, given, file_path("file", file))
    table = MemoryTable(given.copy(), len(limb.segments))
    work.fill(table)
    _require_one_valid(table.messages())
    return work.batch_of(table)


def resume(
    batch: Batch, *, threads: int | None, executor: Executor | Callable[[], Executor] | None, progress: bool
) -> Batch:
    """Solve the rows that a batch lacks; `Batch.resume` has the arguments."""
    work = _Work.checked(batch.limb, batch.scene, threads, executor, progress, batch.ordered)
    if batch.file is not None:
        return _sweep_to_file(work, batch.pressures, batch.file)
    table = MemoryTable.of(batch.as_columns(), batch.as_messages(), batch.builds)
    work.fill(table)
    return work.batch_of(table)


def _sweep_to_file(work: _Work, pressures: NDArray[np.float64], path: Path) -> Batch:
    record = SweepRecord.of(work.limb, work.scene, work.ordered, len(pressures))
    new = not path.exists()
    if new or not _finished(path, record, pressures):
        with SweepFile.create(path, record, pressures) if new else SweepFile(path) as table:
            try:
                work.fill(table)
            except BaseException:
                if new and table.missing().all():  # the scene is refused: there is nothing to go on with
                    table.discard()
                raise
            table.seal()
    content = read(path)
    if new:
        try:
            _require_one_valid(content.messages)
        except ValueError:
            path.unlink()
            raise
    about = {"ordered": work.ordered, "builds": content.builds, "file": path.absolute()}
    return Batch.of_columns(work.limb, work.scene, content.columns, content.messages, **about)


# --- arguments ---------------------------------------------------------------------------------------------------


def _threads(threads: object) -> int | None:
    if threads is None:
        return None
    if not isinstance(threads, (int, np.integer)) or isinstance(threads, bool) or threads < 1:
        raise ValueError(f"threads must be a whole number of at least 1, or None for all cores, got {shown(threads)}")
    return int(threads)


def _all_cores() -> int:
    """Cores that this process may use, which a batch system makes fewer than there are."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _pressure_rows(limb: Limb, pressures: ArrayLike) -> NDArray[np.float64]:
    """Pressures as (N, A), finite; an array of floats is not copied, it may be a file's of any size."""
    plain = isinstance(pressures, np.ndarray) and pressures.dtype == np.float64 and not np.ma.isMaskedArray(pressures)
    rows: NDArray[np.float64] = pressures if plain else real_array("pressures", pressures)  # type: ignore[assignment]
    actuators = len(actuator_names(limb))
    counts = {len(segment.actuators) for segment in limb.segments}
    if rows.ndim == 3 and len(counts) == 1 and rows.shape[1:] == (len(limb.segments), *counts):
        rows = rows.reshape(len(rows), actuators)
    if rows.ndim != 2 or rows.shape[1] != actuators:
        raise ValueError(
            f"pressures has shape {rows.shape} but the limb has {actuators} actuators: expected (N, {actuators})"
        )
    for first in range(0, len(rows), _MOST_IN_BLOCK):
        broken = np.flatnonzero(~np.isfinite(rows[first : first + _MOST_IN_BLOCK]).all(axis=1))
        if broken.size:
            row = first + int(broken[0])
            raise ValueError(f"pressures must be finite; row {row} is {rows[row].tolist()}")
    return rows


def _require_one_valid(messages: Messages) -> None:
    """ValueError where every row was refused: the fault is not in the rows but in what they share."""
    if len(messages) and messages.statuses.are(INVALID).all():
        raise ValueError(messages[-1])


def _finished(path: Path, record: SweepRecord, pressures: NDArray[np.float64]) -> bool:
    """Is the sweep in a file whole? ValueError where it is another one, with what is different."""
    content = read(path)
    content.record.require(path, record)
    there = content.columns["pressures"]
    for first in range(0, len(pressures), _MOST_IN_BLOCK):
        block = slice(first, first + _MOST_IN_BLOCK)
        other = np.flatnonzero((there[block] != pressures[block]).any(axis=1))
        if other.size:
            row = first + int(other[0])
            raise ValueError(
                f"file {path} holds other pressures: row {row} is {there[row].tolist()}, not {pressures[row].tolist()}"
            )
    return content.sealed and not content.messages.statuses.are(NOT_RUN).any()


# --- the work ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Work:
    """What is to be done for every row, and by whom."""

    limb: Limb
    scene: Mapping[str, Any]
    threads: int | None
    executor: Executor | Callable[[], Executor] | None
    progress: bool
    ordered: bool

    @classmethod
    def checked(
        cls, limb: Limb, scene: Mapping[str, Any], threads: object, executor: Any, progress: object, ordered: object
    ) -> _Work:
        require_executor(executor)
        shows, chained = truth("progress", progress), truth("ordered", ordered)
        return cls(limb, scene, _threads(threads), executor, shows, chained)

    def batch_of(self, table: MemoryTable) -> Batch:
        about = {"ordered": self.ordered, "builds": table.builds}
        return Batch.of_columns(self.limb, self.scene, table.columns, table.messages(), **about)

    def fill(self, table: Table) -> None:
        """Solve what a table lacks. Ctrl-C ends it early, with everything kept that is done."""
        missing = self._missing(table)
        with _progress(self.progress, len(missing), int(missing.sum())) as advance, _CtrlC() as ctrl_c:
            try:
                atlas = self._atlas(table, ctrl_c) if missing.any() else None
                # What was under way when an executor broke comes last: it may be what broke it.
                last = np.zeros_like(missing)
                if self.executor is not None:
                    left, last = self._fill_elsewhere(table, missing, atlas, advance, ctrl_c)
                    missing = self._missing(table) & left
                for first, stop in [*runs_of(missing & ~last), *runs_of(missing & last)]:
                    self._fill_here(table, first, stop, atlas, advance, ctrl_c)
            except KeyboardInterrupt:  # the second one, or of a handler that is not ours
                pass

    def _missing(self, table: Table) -> NDArray[np.bool_]:
        """Rows to solve: of an ordered sweep whole groups, each again from its first row."""
        missing = table.missing()
        if not self.ordered or not len(missing):
            return missing
        groups = np.add.reduceat(missing, np.arange(0, len(missing), GROUP)) > 0
        found: NDArray[np.bool_] = np.repeat(groups, GROUP)[: len(missing)]
        return found

    def _atlas(self, table: Table, ctrl_c: _CtrlC) -> Atlas | None:
        """Where rows start, of a long sweep: from all its rows, so that no row depends on which are missing."""
        pressures = table.columns["pressures"]
        if len(pressures) < _LONG:
            return None
        fewest, most = _ANCHORS
        count = _HEADS if self.ordered else min(max(len(pressures) // 16, fewest), most)
        anchors = _some_rows(pressures, count)
        threads = self.threads or _all_cores()
        return solver.survey_rows(
            self.limb, anchors, threads=threads, tick=lambda _: not ctrl_c.pressed, **self.scene
        )

    def _fill_here(
        self, table: Table, first: int, stop: int, atlas: Atlas | None, advance: _Advance, ctrl_c: _CtrlC
    ) -> None:
        """Neighbouring rows, on the cores of this machine, in blocks that take about half a second."""
        threads = self.threads or _all_cores()
        size = GROUP * threads * (_BESIDE if atlas is not None else 1)

        def tick(done: int) -> bool:
            advance(done - shown_so_far[0])
            shown_so_far[0] = done
            return not ctrl_c.pressed

        while first < stop and not ctrl_c.pressed:
            end, started, shown_so_far = min(first + size, stop), time.monotonic(), [0]
            pressures = np.ascontiguousarray(table.columns["pressures"][first:end])
            found = solver.solve_rows(
                self.limb, pressures, threads=threads, ordered=self.ordered, tick=tick, atlas=atlas, **self.scene
            )
            _note_build(table, solver.build())
            table.put(first, found)
            advance(len(found) - shown_so_far[0])
            if NOT_RUN in found.status:
                ctrl_c.pressed = True  # it came to the solver as an exception
            speed = len(found) / max(time.monotonic() - started, 1e-3)
            # Where the cuts are depends on the clock; what is in the rows does not depend on the cuts.
            size = min(int(speed * _BLOCK_SECONDS), 8 * size, _MOST_IN_BLOCK) // GROUP * GROUP
            size = max(size, GROUP * threads)
            first = end

    def _fill_elsewhere(
        self, table: Table, missing: NDArray[np.bool_], atlas: Atlas | None, advance: _Advance, ctrl_c: _CtrlC
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Rows on the workers of the executor; returns which are left to this machine, and which of those last."""
        assert self.executor is not None

        def accept(chunk: Chunk, solved: Solved) -> None:
            _note_build(table, solved.build)
            table.put(chunk.first, solved.rows)
            advance(len(solved.rows))

        report = run_chunks(
            self.executor,
            [Chunk(first, stop) for first, stop in _cut(missing, self.ordered)],
            Task(self.limb, self.scene, self.threads or 1, self.ordered, atlas),
            table.columns["pressures"],
            accept,
            lambda: ctrl_c.pressed,
        )
        for chunk in report.lost:
            text = f"not run: its chunk failed {chunk.attempts} times on the executor; {chunk.cause}"
            table.explain(chunk.first, chunk.stop, text)
            _warn(f"rows {chunk.first} to {chunk.stop - 1} are {text}")
        left, last = np.zeros_like(missing), np.zeros_like(missing)
        if ctrl_c.pressed or not report.untried:
            return left, last
        rows = sum(chunk.stop - chunk.first for chunk in report.untried)
        if report.another:
            for chunk in report.untried:
                table.explain(chunk.first, chunk.stop, f"not run: one executor after the other failed; {report.error}")
            _warn(f"{rows} rows are not run: one executor after the other failed; {report.error!r}")
            return left, last
        _warn(f"the executor broke, {rows} rows are solved in this process: {report.error!r}")
        for chunks, mask in ((report.untried, left), (report.suspects, last)):
            for chunk in chunks:
                mask[chunk.first : chunk.stop] = True
        return left, last


def _some_rows(pressures: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """So many different rows, the same ones in the same order however the rows are ordered: those of smallest hash."""
    rows, keys = np.empty((0, pressures.shape[1])), np.empty(0, dtype=np.uint64)
    for first in range(0, len(pressures), _MOST_IN_BLOCK):
        block = np.array(pressures[first : first + _MOST_IN_BLOCK]) + 0.0  # minus zero is zero
        key = np.full(len(block), 0x9E3779B97F4A7C15, dtype=np.uint64)
        for column in block.T:
            key = (key ^ np.ascontiguousarray(column).view(np.uint64)) * np.uint64(0xBF58476D1CE4E5B9)
            key ^= key >> np.uint64(29)
        keys, at = np.unique(np.concatenate([keys, key]), return_index=True)
        rows, keys = np.concatenate([rows, block])[at[:count]], keys[:count]
    return rows


def _cut(missing: NDArray[np.bool_], ordered: bool) -> list[tuple[int, int]]:
    """Chunks for workers: many of a short sweep, none of an ordered one across a group."""
    size = min(max(-(-int(missing.sum()) // _CHUNKS), 1), _MOST_IN_CHUNK)
    size = -(-size // GROUP) * GROUP if ordered else size
    return [(at, min(at + size, stop)) for first, stop in runs_of(missing) for at in range(first, stop, size)]


def _note_build(table: Table, build: str) -> None:
    if table.builds and build not in table.builds:
        _warn(f"rows are solved by different builds, whose bits may differ: {build}; {table.builds[0]}")
    table.add_build(build)


def _warn(text: str) -> None:
    warnings.warn(text, RuntimeWarning, stacklevel=2)


_Advance = Callable[[int], None]


@contextlib.contextmanager
def _progress(shows: bool, count: int, missing: int) -> Iterator[_Advance]:
    """A bar where tqdm is installed, which moves by the number of rows it is told."""
    if shows:
        try:
            from tqdm import tqdm  # type: ignore[import-untyped, unused-ignore]
        except ModuleNotFoundError:
            pass
        else:
            with tqdm(total=count, initial=count - missing, unit="posture") as bar:
                yield bar.update
            return
    yield lambda _: None


class _CtrlC:
    """Ctrl-C as a question and no exception, so that it cuts no row and no record in two; a second one raises."""

    pressed = False

    def __enter__(self) -> _CtrlC:
        self._ours = False
        # A handler of the caller's stays; outside the main thread there is none.
        if threading.current_thread() is threading.main_thread():
            self._ours = signal.getsignal(signal.SIGINT) is signal.default_int_handler
        if self._ours:
            signal.signal(signal.SIGINT, self._press)
        return self

    def __exit__(self, *_: object) -> None:
        if self._ours:
            signal.signal(signal.SIGINT, signal.default_int_handler)

    def _press(self, number: int, frame: FrameType | None) -> None:
        if self.pressed:
            signal.default_int_handler(number, frame)
        self.pressed = True
