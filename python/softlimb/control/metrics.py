"""How well pressures followed their targets."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from softlimb.control.loop import Trace
from softlimb.control.signals import Signal
from softlimb.units import kPa

__all__ = ["Metrics", "metrics"]

Array = NDArray[np.float64]

_BAND, _LEAST_BAND = 0.05, 1 * kPa  # of settling: 5 % of the jump, and not below what the converter's codes blur
_END = 0.2  # share of a hold over which the steady error is taken


@dataclass(frozen=True)
class Metrics:
    """Of the true pressures against their targets; means over the actuators.

    Parameters
    ----------
    overshoot : float
        Largest excursion beyond the target after a jump, as a share of the jump; mean over the jumps. NaN without.
    settling : float
        Time from a jump until the pressure stays within 5 % of it (1 kPa at least) [s]; mean over the jumps that
        settled before the next one. NaN where none did.
    unsettled : int
        Jumps of an actuator that did not settle before the next one.
    iae, itae : float
        Integral of |e| [Pa s], and of |e| times the time since the last jump [Pa s^2].
    steady_error : float
        Mean |e| over the last fifth of each hold, or of the run [Pa].
    air : float
        Drawn from the supply [kg], all actuators together.
    """

    overshoot: float
    settling: float
    unsettled: int
    iae: float
    itae: float
    steady_error: float
    air: float


def metrics(trace: Trace, signal: Signal) -> Metrics:
    """Measure a trace that followed the signal from its start.

    Raises
    ------
    ValueError
        The trace is not as long as the signal.
    """
    if trace.targets.shape != signal.targets.shape:
        raise ValueError(f"the trace has targets of shape {trace.targets.shape}, the signal {signal.targets.shape}")
    errors, period = trace.errors, signal.period
    starts = signal.jumps
    bounds = [0, *(int(start) for start in starts if start > 0), len(errors)]
    since = np.concatenate([np.arange(b - a) for a, b in pairwise(bounds)]) * period
    ends = [errors[b - max(1, round(_END * (b - a))) : b] for a, b in pairwise(bounds)]
    overshoots, settlings, unsettled = _after_jumps(signal, errors, [int(start) for start in starts])
    return Metrics(
        overshoot=float(np.mean(overshoots)) if overshoots else np.nan,
        settling=float(np.mean(settlings)) if settlings else np.nan,
        unsettled=unsettled,
        iae=float(np.abs(errors).mean(axis=1).sum() * period),
        itae=float((np.abs(errors).mean(axis=1) * since).sum() * period),
        steady_error=float(np.mean([np.abs(end).mean() for end in ends])),
        air=trace.air,
    )


def _after_jumps(signal: Signal, errors: Array, starts: list[int]) -> tuple[list[float], list[float], int]:
    overshoots, settlings, unsettled = [], [], 0
    before = np.vstack([np.zeros_like(signal.targets[:1]), signal.targets[:-1]])
    for start, end in pairwise([*starts, len(errors)]):
        jump = signal.targets[start] - before[start]
        for channel, size in enumerate(jump):
            if abs(size) <= _LEAST_BAND:
                continue
            row = errors[start:end, channel]
            overshoots.append(max(0.0, float(np.max(-np.sign(size) * row))) / abs(size))
            outside = np.flatnonzero(np.abs(row) > max(_BAND * abs(size), _LEAST_BAND))
            last = int(outside[-1]) + 1 if outside.size else 0
            if last == len(row):
                unsettled += 1
            else:
                settlings.append(last * signal.period)
    return overshoots, settlings, unsettled
