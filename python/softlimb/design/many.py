"""Many designs of one problem, on several processes, each kept as it is done."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from softlimb.arguments import finite_array, shown
from softlimb.design.history import History
from softlimb.design.problem import Evaluation, Problem

__all__ = ["evaluate_many"]

_CHUNK = 8  # designs that a process is given at once: a second of work, against a millisecond for the message

_problem: list[Problem] = []  # of a worker process


def evaluate_many(
    problem: Problem,
    designs: ArrayLike,
    *,
    workers: int = 1,
    history: str | os.PathLike[str] | None = None,
    progress: Callable[[Evaluation, int], None] | None = None,
) -> list[Evaluation]:
    """Evaluate designs, without gradients.

    Parameters
    ----------
    problem : Problem
        With several workers it travels to them: functions in it must be defined at the top of a module.
    designs : array_like, shape (N, parameters)
    workers : int
        Processes; 1 stays in this one.
    history : str or path, optional
        As for `optimise`: designs that the file has are not computed again.
    progress : callable, optional
        Called with each new evaluation and the number of those known before.

    Returns
    -------
    list of Evaluation
        In the order of the designs; those that failed with their reason.

    Raises
    ------
    ValueError
        Designs of a wrong shape or not finite, ``workers`` below 1, a file of another problem.
    """
    rows = finite_array("designs", designs)
    if rows.ndim != 2 or rows.shape[1] != len(problem.parameters):
        raise ValueError(f"designs must have the shape (N, {len(problem.parameters)}), got {rows.shape}")
    if not isinstance(workers, (int, np.integer)) or isinstance(workers, bool) or workers < 1:
        raise ValueError(f"workers must be a whole number of at least 1, got {shown(workers)}")
    kept = History(problem, history)
    wanted = [tuple(row) for row in rows.tolist()]
    known = {values: kept.find(values, False) for values in wanted}
    missing = [values for values, found in known.items() if found is None]
    recalled = len(known) - len(missing)
    for number, evaluation in enumerate(_evaluated(problem, missing, int(workers)), start=recalled):
        kept.add(evaluation)
        known[evaluation.values] = evaluation
        if progress is not None:
            progress(evaluation, number)
    return [found for found in (known[values] for values in wanted) if found is not None]


def _evaluated(problem: Problem, designs: list[Any], workers: int) -> Iterator[Evaluation]:
    if workers == 1 or len(designs) <= 1:
        for values in designs:
            yield problem.evaluate(values)
        return
    chunks = [designs[first : first + _CHUNK] for first in range(0, len(designs), _CHUNK)]
    # A fresh interpreter each: a fork of a process with threads may hang.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, context, _take, (problem,)) as pool:
        try:
            for done in as_completed([pool.submit(_evaluate_chunk, chunk) for chunk in chunks]):
                yield from done.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def _take(problem: Problem) -> None:
    _problem.append(problem)


def _evaluate_chunk(designs: list[Any]) -> list[Evaluation]:
    return [_problem[0].evaluate(values) for values in designs]
