"""Chunks of rows on the workers of an executor: none is lost, none is kept twice, whatever dies on the way."""

from __future__ import annotations

import uuid
from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from softlimb import rows
from softlimb.arguments import shown
from softlimb.rows import NOT_RUN, Rows

if TYPE_CHECKING:
    from softlimb.limb import Limb

__all__ = ["Chunk", "Report", "Solved", "Task", "require_executor", "run_chunks"]

ATTEMPTS = 3  # how often a chunk is tried: what kills three workers kills the fourth
_VAIN = 10  # times in a row that nothing but failures arrived: the fault is not in single chunks
_WINDOW = 256  # chunks under way where the number of workers is not known; each holds half a megabyte
_LOOK = 0.1  # [s] between two looks at who wants to stop
_DRAIN = 10.0  # [s] for what is under way in a broken pool to end; a pool of processes takes milliseconds


@dataclass
class Chunk:
    """Neighbouring rows that one worker solves.

    Parameters
    ----------
    first, stop : int
        First row, last row + 1.
    attempts : int
        How often it has failed.
    cause : str
        Why, the last time.
    """

    first: int
    stop: int
    attempts: int = 0
    cause: str = ""

    def failed(self, error: BaseException) -> None:
        """Note one more attempt."""
        self.attempts += 1
        self.cause = _in_words(error)


@dataclass(frozen=True)
class Solved:
    """What a worker hands back.

    Parameters
    ----------
    rows : Rows
    build : str
        What solved them there.
    """

    rows: Rows
    build: str


@dataclass(frozen=True)
class Task:
    """What a worker does with a chunk; it travels there.

    Parameters
    ----------
    limb : Limb
    scene : mapping
        Loads and options of `Limb.solve`.
    threads : int
        Of one worker.
    ordered : bool
    atlas : Atlas, optional
        Where rows start.
    """

    limb: Limb
    scene: Mapping[str, Any]
    threads: int
    ordered: bool
    atlas: rows.Atlas | None = None

    def __call__(self, pressures: NDArray[np.float64], label: str) -> Solved | ValueError | TypeError:
        """Solve; what the limb refuses comes back as a value, so that every exception speaks of the way there.

        The label is another one for each attempt: Dask takes equal calls for one, and its failure for that of both.
        """
        try:
            found = rows.solve_rows(
                self.limb,
                pressures,
                threads=self.threads,
                ordered=self.ordered,
                tick=lambda _: True,
                atlas=self.atlas,
                **self.scene,
            )
        except (ValueError, TypeError) as refusal:
            return refusal
        return Solved(found, rows.build())


@dataclass(frozen=True)
class Report:
    """What is left when an executor has done what it could.

    Parameters
    ----------
    lost : list of Chunk
        Given up: every attempt failed.
    untried : list of Chunk
        Not finished, because the executor broke for good or the sweep was stopped.
    suspects : list of Chunk
        Those of them that were under way when an executor broke.
    error : Exception, optional
        What went wrong last.
    another : bool
        The executor could be made anew, and that did not help.
    """

    lost: list[Chunk]
    untried: list[Chunk]
    suspects: list[Chunk]
    error: Exception | None
    another: bool


def require_executor(executor: object) -> None:
    """TypeError for what neither is an executor nor makes one."""
    if executor is not None and not isinstance(executor, Executor) and not callable(executor):
        raise TypeError(
            f"executor must be a concurrent.futures.Executor or a callable that makes one, got {shown(executor)}"
        )


class _Executors:
    """The executor that is used now: given, or made anew whenever the last one broke."""

    def __init__(self, given: Executor | Callable[[], Executor]) -> None:
        self.now = given if isinstance(given, Executor) else None
        self._make = _like(given) if isinstance(given, Executor) else given
        self._made_here = False

    @property
    def another(self) -> bool:
        """True where a broken executor can be followed by a new one."""
        return self._make is not None

    def ready(self) -> Executor | None:
        """The executor, or None when it broke and there is no way to another."""
        if self.now is None and self._make is not None:
            made = self._make()
            if not isinstance(made, Executor):
                raise TypeError(f"executor must make a concurrent.futures.Executor, it made {shown(made)}")
            self.now, self._made_here = made, True
        return self.now

    def end(self) -> None:
        """Shut down what was made here; what was given belongs to the caller."""
        if self._made_here and self.now is not None:
            # Nothing of ours is left there; Python's pools may wait for a dead worker for ever.
            self.now.shutdown(wait=False)
        self.now = None


def _like(pool: Executor) -> Callable[[], Executor] | None:
    """What makes another pool of processes like this one; other executors live elsewhere and have no second."""
    if type(pool) is not ProcessPoolExecutor:
        return None
    names = {"max_workers": "_max_workers", "mp_context": "_mp_context"}
    names |= {"initializer": "_initializer", "initargs": "_initargs"}
    options = {name: getattr(pool, attribute) for name, attribute in names.items() if hasattr(pool, attribute)}
    return lambda: ProcessPoolExecutor(**options)


def run_chunks(
    given: Executor | Callable[[], Executor],
    chunks: list[Chunk],
    task: Task,
    pressures: NDArray[np.float64],
    accept: Callable[[Chunk, Solved], None],
    stopped: Callable[[], bool],
) -> Report:
    """Solve chunks on an executor.

    A chunk whose worker dies, or whose result does not arrive, is tried `ATTEMPTS` times. Where a whole pool dies, all
    that was under way is suspect and runs one by one on the next pool, so that only the chunk that kills is given up.

    Parameters
    ----------
    given : Executor or callable
        A callable makes executors. A broken one is followed by a new one, a broken `ProcessPoolExecutor` as well.
    chunks : list of Chunk
    task : Task
    pressures : array of float, shape (N, A)
        Gauge pressures of all rows [Pa].
    accept : callable
        Takes each chunk once, with its rows, in the order in which they arrive.
    stopped : callable
        True ends the work: chunks that run are waited for, the others are left.

    Returns
    -------
    Report

    Raises
    ------
    ValueError, TypeError
        The limb refuses the scene.
    RuntimeError
        The executor never returned anything.
    """
    executors, run = _Executors(given), uuid.uuid4().hex
    executors.ready()  # what goes wrong here is the caller's to see as it is
    waiting, suspects, lost = deque(chunks), deque[Chunk](), list[Chunk]()
    running: dict[Future[Any], Chunk] = {}
    arrived, vain, alone = 0, 0, False
    error: Exception | None = None

    def submit(executor: Executor) -> None:
        nonlocal alone
        if not running:
            alone = bool(suspects)
        queue = suspects if alone else waiting
        window = 1 if alone else 2 * int(getattr(executor, "_max_workers", 0) or _WINDOW // 2)
        while queue and len(running) < window:
            chunk = queue[0]
            label = f"{run}, row {chunk.first}, attempt {chunk.attempts}"
            running[executor.submit(task, pressures[chunk.first : chunk.stop], label)] = chunk
            queue.popleft()

    def outcome(future: Future[Any], chunk: Chunk) -> Solved | Exception:
        found = _result(future)
        if isinstance(found, Solved) and len(found.rows) != chunk.stop - chunk.first:
            return RuntimeError(f"its worker returned {len(found.rows)} rows")
        if isinstance(found, Solved) and NOT_RUN in found.rows.status and not stopped():
            return RuntimeError("its worker was interrupted")
        return found

    def settle(chunk: Chunk, failure: Exception, queue: deque[Chunk]) -> None:
        """One more try, or none."""
        chunk.failed(failure)
        if chunk.attempts >= ATTEMPTS:
            lost.append(chunk)
        else:
            queue.append(chunk)

    def collect() -> list[Chunk]:
        """Empty what is under way: keep what is finished, and return the rest."""
        nonlocal arrived
        wait(running, timeout=_DRAIN)
        rest = []
        for future in list(running):
            chunk = running.pop(future)
            found = outcome(future, chunk) if future.done() else None
            if isinstance(found, Solved):
                accept(chunk, found)
                arrived += 1
            else:
                future.cancel()
                rest.append(chunk)
        return rest

    try:
        while (waiting or suspects or running) and vain < _VAIN and not stopped():
            broken: Exception | None = None
            try:
                executor = executors.ready()
                if executor is None:
                    break
                submit(executor)
            except Exception as failure:  # whatever the transport raises: this executor takes no more
                broken = failure
            done, _ = wait(running, timeout=0.0 if broken else _LOOK, return_when=FIRST_COMPLETED)
            hit: list[Chunk] = []
            before = arrived, error
            for future in done:
                chunk = running.pop(future)
                found = outcome(future, chunk)
                if isinstance(found, Solved):
                    accept(chunk, found)
                    arrived += 1
                elif isinstance(found, BrokenExecutor):
                    broken = found
                    hit.append(chunk)
                else:
                    error = found
                    settle(chunk, found, waiting)
            if broken is not None:
                error = broken
                for chunk in [*hit, *collect()]:
                    settle(chunk, broken, suspects)
                executors.end()
            if arrived > before[0]:
                vain = 0
            elif error is not before[1]:
                vain += 1
        for future in [future for future in running if future.cancel()]:
            waiting.append(running.pop(future))
        wait(running)
        waiting.extend(collect())
    finally:
        for future in running:
            future.cancel()
        executors.end()
    if error is not None and not arrived and not stopped():
        raise RuntimeError(f"the executor returned nothing; the last it said was {_in_words(error)}") from error
    return Report(lost, [*waiting, *suspects], list(suspects), error, executors.another)


def _result(future: Future[Any]) -> Solved | Exception:
    """What a worker handed back, or why it did not.

    Raises
    ------
    ValueError, TypeError
        The limb refuses the scene: the worker is well, the question is not.
    """
    try:
        failure = future.exception()
        if failure is None:
            found = future.result()
            if isinstance(found, Exception):
                raise found
            if isinstance(found, Solved):
                return found
            return RuntimeError(f"its worker returned {shown(found)}")
    except CancelledError as cancelled:
        return cancelled
    # An interrupt over there is not one here.
    return failure if isinstance(failure, Exception) else RuntimeError(_in_words(failure))


def _in_words(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}".rstrip(": ")
