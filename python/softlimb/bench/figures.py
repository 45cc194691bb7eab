"""Figures as the tables and pages of benchmarks print them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from softlimb.bench.clock import VOID_ABOVE, Samples, quartiles
from softlimb.units import us

__all__ = ["about_the_yardstick", "median_and_spread", "three_digits"]


def three_digits(value: float) -> str:
    """Three digits without an exponent; a dash where there is no number."""
    if not math.isfinite(value):
        return "-"
    size = abs(value)
    decimals = 0 if size >= 100.0 or value == round(value) else 1 if size >= 10.0 else 2 if size >= 1.0 else 3
    return f"{value:.{decimals}f}"


def median_and_spread(samples: Samples, unit: float) -> tuple[str, str]:
    """Median and quartiles in a unit of time [s]."""
    low, middle, high = quartiles(samples.seconds)
    spread = f"{three_digits(low / unit)}..{three_digits(high / unit)}" if samples.seconds.size > 1 else "one run"
    return three_digits(middle / unit), spread


def about_the_yardstick(seconds: Sequence[float]) -> tuple[list[str], bool]:
    """How the yardstick fared during a run, in sentences, and whether the run is void.

    Parameters
    ----------
    seconds : sequence of float
        Readings [s].
    """
    readings = np.asarray(seconds)
    low, middle, high = quartiles(readings)
    spread = f"{low / us:.2f}..{high / us:.2f}"
    lines = [f"yardstick Y during the run: {middle / us:.2f} us ({spread}), {len(readings)} readings"]
    if high > 1.1 * low:  # twice the jitter of a quiet machine
        change = f"{high / low - 1.0:.0%}"
        lines.append(f"the machine changed its speed: Y was {change} longer or more at one time than at another")
    void = bool(middle > VOID_ABOVE)
    if void:
        limit = f"{VOID_ABOVE / us:g}"
        lines.append(f"VOID: Y took more than {limit} us, this machine is busy or slow; nothing here counts")
    return lines, void
