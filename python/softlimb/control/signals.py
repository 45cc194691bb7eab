"""Pressures to follow: steps, ramps, sines, and the staircase of the paper's pressures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb.arguments import finite_array, of_type, one_positive
from softlimb.units import kPa, ms

__all__ = ["SIGNALS", "Signal", "ramp", "sine", "staircase", "steps"]

Array = NDArray[np.float64]

_JUMP = 1 * kPa  # in one step of the loop: more than any ramp or sine here does
_HOLD = 100 * ms  # after a jump; a sine that starts off zero jumps as well, and nothing settles there


@dataclass(frozen=True, eq=False)
class Signal:
    """Targets, one row a step of the loop.

    Parameters
    ----------
    name : str
    targets : array, shape (N, A)
        Gauge pressures [Pa].
    period : float
        Of a step [s].

    Raises
    ------
    TypeError
        The name is no text.
    ValueError
        Targets are not finite, not of two dimensions, or none; the period is not positive.
    """

    name: str
    targets: Array
    period: float

    def __post_init__(self) -> None:
        of_type("name of a Signal", self.name, str)
        object.__setattr__(self, "targets", finite_array("targets of a Signal", self.targets))
        if self.targets.ndim != 2 or not self.targets.size:
            raise ValueError(
                f"targets of a Signal must be (steps, actuators), at least one each, got shape {self.targets.shape}"
            )
        object.__setattr__(self, "period", one_positive("period of a Signal", self.period))

    @property
    def seconds(self) -> float:
        """How long it takes."""
        return len(self.targets) * self.period

    @property
    def jumps(self) -> NDArray[np.int64]:
        """Steps at which any target jumps and is then held; the first one, from the atmosphere, may be among them."""
        before = np.vstack([np.zeros_like(self.targets[:1]), self.targets[:-1]])
        found = np.flatnonzero((np.abs(self.targets - before) > _JUMP).any(axis=1))
        held = round(_HOLD / self.period)
        return np.array([k for k in found if not np.ptp(self.targets[k : k + held], axis=0).any()], dtype=np.int64)


def _goal(goal: ArrayLike) -> Array:
    pressures = finite_array("goal", goal)
    if pressures.ndim != 1 or not len(pressures) or (pressures < 0.0).any():
        raise ValueError(f"goal must be a row of pressures that are not negative, got {pressures.tolist()}")
    return pressures


def _held(name: str, goal: ArrayLike, factors: tuple[float, ...], hold: float, period: float) -> Signal:
    pressures = _goal(goal)
    count = round(one_positive("hold", hold) / one_positive("period", period))
    if not count:
        raise ValueError(f"hold must be at least a period of {period:g} s, got {hold:g}")
    return Signal(name, np.repeat(factors, count)[:, None] * pressures, period)


def steps(goal: ArrayLike, *, hold: float = 1.2, period: float = 1 * ms) -> Signal:
    """To the goal, to half of it, and back, each held [s].

    Parameters
    ----------
    goal : array_like, shape (A,)
        Gauge pressures [Pa].
    """
    return _held("steps", goal, (1.0, 0.5, 1.0), hold, period)


def staircase(goal: ArrayLike, *, hold: float = 0.8, period: float = 1 * ms) -> Signal:
    """Thirds of the goal, up and down: of 60 kPa the paper's 20, 40, 60 kPa."""
    return _held("staircase", goal, (1 / 3, 2 / 3, 1.0, 2 / 3, 1 / 3), hold, period)


def ramp(goal: ArrayLike, *, rise: float = 1.5, hold: float = 0.5, period: float = 1 * ms) -> Signal:
    """Up to the goal at a constant rate, a hold, and down to half of it."""
    pressures = _goal(goal)
    times = np.cumsum([0.0, one_positive("rise", rise), one_positive("hold", hold), rise])
    time = np.arange(round(times[-1] / one_positive("period", period))) * period
    return Signal("ramp", np.interp(time, times, [0.0, 1.0, 1.0, 0.5])[:, None] * pressures, period)


def sine(goal: ArrayLike, *, frequency: float = 0.25, seconds: float = 4.0, period: float = 1 * ms) -> Signal:
    """Between 0.2 and 0.8 of the goal, from its least [Hz]."""
    pressures = _goal(goal)
    time = np.arange(round(one_positive("seconds", seconds) / one_positive("period", period))) * period
    wave = 0.5 - 0.3 * np.cos(2.0 * np.pi * one_positive("frequency", frequency) * time)
    return Signal("sine", wave[:, None] * pressures, period)


SIGNALS: dict[str, Callable[..., Signal]] = {"steps": steps, "ramp": ramp, "sine": sine, "staircase": staircase}
"""By name."""
