"""Pressures near those of postures that stand alone: they fill a cloud where pressures spread evenly leave it thin."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from softlimb.workspace.voxels import cells_of, occupancy

if TYPE_CHECKING:
    from softlimb.sweep import Batch

Array = NDArray[np.float64]

# Each pressure moves with this chance, by a normal deviate of this part of its range. On the reference limb 0.1 and
# 0.25 fill the same volume.
_CHANCE, _MOVE = 0.5, 0.15


def pressures_nearby(batch: Batch, lower: Array, upper: Array, count: int, rng: np.random.Generator) -> Array:
    """Pressures around those of the batch, from all occupied voxels alike.

    Parameters
    ----------
    batch : Batch
        The cloud so far.
    lower, upper : array of float, shape (A,)
        Bounds [Pa]; what would move beyond stops there.
    count : int
    rng : Generator

    Returns
    -------
    array of float, shape (count, A)
    """
    known = np.flatnonzero(batch.success & batch.stable)
    if len(known):
        points = batch.tip[known, :3, 3]
        cells = cells_of(points, occupancy(points).cell)
        weights = 1.0 / cells.counts[cells.of_point]
        chosen = known[rng.choice(len(known), count, p=weights / weights.sum())]
    else:
        chosen = rng.integers(len(batch), size=count)
    shape = (count, len(lower))
    move = np.where(rng.random(shape) < _CHANCE, _MOVE * rng.normal(size=shape), 0.0)
    pressures: Array = np.clip(batch.pressures[chosen] + move * (upper - lower), lower, upper)
    return pressures
