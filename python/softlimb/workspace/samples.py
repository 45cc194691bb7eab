"""Pressures that fill a box: at random, on a grid, or by a scrambled Halton sequence."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from softlimb.arguments import one_of, one_real, one_whole

Array = NDArray[np.float64]
Sampling = Literal["halton", "uniform", "grid"]

SAMPLINGS: tuple[Sampling, ...] = ("halton", "uniform", "grid")


def pressure_samples(
    lower: Array, upper: Array, count: int, *, sampling: Sampling, seed: int, at_bounds: float
) -> Array:
    """Rows of pressures between bounds.

    Parameters
    ----------
    lower, upper : array of float, shape (A,)
        Bounds of each actuator's gauge pressure [Pa].
    count : int
        How many; a grid takes the most levels whose combinations are no more than this.
    sampling : {"halton", "uniform", "grid"}
        By a scrambled Halton sequence, at random, or all combinations of evenly spaced levels, bounds included.
    seed : int
        Of the scrambling or of the random numbers; a grid has none.
    at_bounds : float
        Share of the pressures that are set to one of their two bounds, each for itself, not on a grid; in [0, 1).

    Returns
    -------
    array of float, shape (N, A)
        With the same seed the rows of a smaller count are the first of those of a larger one, except on a grid.

    Raises
    ------
    ValueError
        A count below 1, a seed below 0, an unknown sampling, a share outside [0, 1), too few rows for a grid of two
        levels.
    """
    one_of("sampling", sampling, SAMPLINGS)
    count, seed = one_whole("samples", count, 1), one_whole("seed", seed, 0)
    share = one_real("at_bounds", at_bounds)
    if not 0.0 <= share < 1.0:
        raise ValueError(f"at_bounds must be within [0, 1), got {share!r}")
    actuators = len(lower)
    if sampling == "grid":
        places = _grid(count, actuators)
    else:
        rng = np.random.default_rng(seed)
        inside = rng.random((count, actuators)) if sampling == "uniform" else _halton(count, actuators, rng)
        # What lies within half the share of 0 or 1 goes to the bound; the rest is spread evenly between them.
        places = np.clip((inside - 0.5 * share) / (1.0 - share), 0.0, 1.0)
    # Both bounds are met exactly, which lower + places (upper - lower) would miss by rounding.
    pressures: Array = (1.0 - places) * lower + places * upper
    return pressures


def _grid(count: int, actuators: int) -> Array:
    levels = 1
    while (levels + 1) ** actuators <= count:
        levels += 1
    if levels < 2:
        raise ValueError(
            f"samples must be at least {2**actuators} for a grid of two pressures in each of {actuators} actuators, "
            f"got {count}"
        )
    axes = np.meshgrid(*[np.linspace(0.0, 1.0, levels)] * actuators, indexing="ij")
    return np.stack([axis.ravel() for axis in axes], axis=1)


def _halton(count: int, dimensions: int, rng: np.random.Generator) -> Array:
    """Radical inverses in the first primes, each digit through a permutation of its own.

    The permutations break the correlation of neighbouring large primes, and any base**k successive rows still have one
    in each base**k-th part of their axis.
    """
    places = np.empty((count, dimensions))
    for axis, base in enumerate(_primes(dimensions)):
        digits = int(np.ceil(53.0 * np.log(2.0) / np.log(base)))  # what the 53 bits of a float hold
        left, weight, total = np.arange(count), 1.0, np.zeros(count)
        for _ in range(digits):
            weight /= base
            total += weight * rng.permutation(base)[left % base]
            left //= base
        places[:, axis] = total
    return places


def _primes(count: int) -> list[int]:
    found: list[int] = []
    candidate = 2
    while len(found) < count:
        if all(candidate % prime for prime in found):
            found.append(candidate)
        candidate += 1
    return found
