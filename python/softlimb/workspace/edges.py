"""Pressures whose postures lie on the edge of the workspace, which random pressures hardly ever meet."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from softlimb.sweep import sweep

if TYPE_CHECKING:
    from softlimb.limb import Limb
    from softlimb.sweep import Batch

Array = NDArray[np.float64]

_ROUNDS = 16
_FIRST_RADIUS, _LAST_RADIUS = 0.5, 0.01  # of a step, as parts of each pressure's range
_GAIN = 1e-6  # of the limb's length, its tolerance as a rule: less is no gain


def directions(count: int) -> Array:
    """The six axes, and ``count`` directions spread over the sphere on a spiral, shape (6 + count, 3)."""
    height = 1.0 - (2.0 * np.arange(count) + 1.0) / max(count, 1)
    angle = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)  # the golden angle leaves no seam
    width = np.sqrt(1.0 - height**2)
    spiral = np.stack([width * np.cos(angle), width * np.sin(angle), height], axis=1)
    return np.concatenate([np.eye(3), -np.eye(3), spiral])


def edge_pressures(batch: Batch, lower: Array, upper: Array, along: Array, threads: int | None) -> Array:
    """For each direction pressures that bring the tip far along it.

    Parameters
    ----------
    batch : Batch
        The cloud so far; a direction starts from its row that lies farthest along it.
    lower, upper : array of float, shape (A,)
        Bounds [Pa].
    along : array of float, shape (D, 3)
        Directions, unit length.
    threads : int, optional
        Of the sweeps.

    Returns
    -------
    array of float, shape (M, A)
        Different rows, at most D; none where the batch has no stable posture.

    Notes
    -----
    Sequential linear programming: within a radius, a part of each pressure's range, every pressure moves to the end
    that the slope of the tip's place points to; the radius doubles after a gain and halves after a loss. Local: a
    posture that lies farther out elsewhere is met by chance.
    """
    limb, scene = batch.limb, batch.scene
    known = np.flatnonzero(batch.success & batch.stable)
    if not len(known):
        return np.empty((0, len(lower)))
    best = known[np.argmax(batch.tip[known, :3, 3] @ along.T, axis=0)]
    pressures = batch.pressures[best].copy()
    height = np.einsum("di,di->d", batch.tip[best, :3, 3], along)
    radius = np.full(len(along), _FIRST_RADIUS)
    slopes = _slopes(limb, pressures, along, scene)
    for _ in range(_ROUNDS):
        active = np.flatnonzero(radius >= _LAST_RADIUS)
        if not len(active):
            break
        step = radius[active, None] * (upper - lower) * np.sign(slopes[active])
        trial = np.clip(pressures[active] + step, lower, upper)
        found = sweep(limb, trial, threads=threads, progress=False, **scene)
        reached = np.einsum("di,di->d", found.tip[:, :3, 3], along[active])
        # The place of a row that failed is NaN, which is no gain.
        gains = found.stable & (reached > height[active] + _GAIN * limb.length)
        better = active[gains]
        pressures[better], height[better] = trial[gains], reached[gains]
        slopes[better] = _slopes(limb, pressures[better], along[better], scene)
        radius[active] *= np.where(gains, 2.0, 0.5)
    return np.unique(pressures, axis=0)


def _slopes(limb: Limb, pressures: Array, along: Array, scene: Mapping[str, Any]) -> Array:
    """Change of the tip's place along each direction by each pressure; zero where a posture has no slope."""
    slopes = np.zeros(pressures.shape)
    for row, (given, direction) in enumerate(zip(pressures, along, strict=True)):
        posture = limb.solve(given, **scene)
        if posture.success and posture.stable:
            try:
                slopes[row] = direction @ posture.jacobian[:3]
            except RuntimeError:  # at a fold there is none
                continue
    return slopes
