"""Times as multiples of a yardstick that is read again and again between them.

A machine that slows down slows its yardstick too: each sample is divided by the readings before and after it.
"""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softlimb import _core
from softlimb.units import us

__all__ = ["VOID_ABOVE", "Clock", "Samples", "quartiles", "seconds_of", "stopwatch"]

Array = NDArray[np.float64]

VOID_ABOVE = 9 * us
"""A yardstick longer than this [s] belongs to a machine that is busy or slow: figures of such a run are void."""

_FEWEST_ROUNDS, _MOST_ROUNDS = 5, 400


@dataclass(frozen=True)
class Samples:
    """Times of one thing.

    Parameters
    ----------
    seconds : array, shape (n,)
        Of one solve each.
    yardsticks : array, shape (n,)
        Of one pass of the yardstick at the time of each sample [s].
    """

    seconds: Array
    yardsticks: Array

    @property
    def ratios(self) -> Array:
        """Multiples of the yardstick."""
        return self.seconds / self.yardsticks

    def less(self, other: Samples) -> Samples:
        """What these take longer than others of the same rounds."""
        return Samples(self.seconds - other.seconds, self.yardsticks)


def quartiles(values: Array) -> tuple[float, float, float]:
    """Lower quartile, median, upper quartile."""
    low, middle, high = np.percentile(values, [25.0, 50.0, 75.0])
    return float(low), float(middle), float(high)


@contextmanager
def stopwatch() -> Iterator[Callable[[], float]]:
    """Seconds since the start, without pauses of the garbage collector."""
    collects = gc.isenabled()
    gc.disable()
    began = time.perf_counter()
    try:
        yield lambda: time.perf_counter() - began
    finally:
        if collects:
            gc.enable()


def seconds_of(run: Callable[[], Any], shortest: float = 0.0) -> float:
    """Seconds of a run, repeated until all together take the shortest time of a sample [s]."""
    count = 0
    with stopwatch() as elapsed:
        while count == 0 or elapsed() < shortest:
            run()
            count += 1
        return elapsed() / count


@dataclass
class Clock:
    """Takes times, with yardsticks between them.

    Parameters
    ----------
    budget : float
        How long the rounds of one question may take [s]; a few rounds are run whatever they take.
    """

    budget: float
    readings: list[float] = field(default_factory=list)

    def yardstick(self) -> float:
        """One pass of the yardstick now [s]."""
        self.readings.append(_core.yardstick(repetitions=1)[0] * us)
        return self.readings[-1]

    def once(self, run: Callable[[], Any]) -> tuple[Samples, Any]:
        """One run, with its time and what it returned."""
        before = self.yardstick()
        with stopwatch() as elapsed:
            found = run()
            seconds = elapsed()
        return Samples(np.array([seconds]), np.array([0.5 * (before + self.yardstick())])), found

    def in_turn(
        self,
        ways: Mapping[str, Callable[[], Any]],
        rounds: tuple[int, int] = (_FEWEST_ROUNDS, _MOST_ROUNDS),
        warm_up: bool = True,
    ) -> dict[str, Samples]:
        """Run several ways of one question in turn, round after round, so that a drifting machine drifts for all.

        Parameters
        ----------
        ways : mapping of str to callable
            Each returns the seconds of a solve, or an array of them where it ran solves of different kinds.
        rounds : (int, int)
            Fewest, and most where the budget allows.
        warm_up : bool
            Run each way once before, and drop what it took.

        Returns
        -------
        dict of str to Samples
        """
        fewest, most = rounds
        for run in ways.values() if warm_up else ():
            run()
        taken: dict[str, list[Array]] = {name: [] for name in ways}
        beside: dict[str, list[Array]] = {name: [] for name in ways}
        began, before = time.perf_counter(), self.yardstick()
        done = 0
        while done < fewest or (done < most and time.perf_counter() - began < self.budget):
            for name, run in ways.items():
                seconds = np.atleast_1d(np.asarray(run(), dtype=float))
                after = self.yardstick()
                taken[name].append(seconds)
                beside[name].append(np.full(seconds.size, 0.5 * (before + after)))
                before = after
            done += 1
        return {name: Samples(np.concatenate(taken[name]), np.concatenate(beside[name])) for name in ways}
