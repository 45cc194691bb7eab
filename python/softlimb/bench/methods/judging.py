"""What comparisons need: how far two poses are apart, how bad a matrix is without its units."""

from __future__ import annotations

import numpy as np

from softlimb.paper.problem import Array, rotation_gap

__all__ = ["equilibrated", "hat", "pose_error"]


def hat(vector: Array) -> Array:
    """Matrix of the cross product, for vectors along the last axis."""
    x, y, z = np.moveaxis(np.asarray(vector), -1, 0)
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(*x.shape, 3, 3)


def pose_error(found: Array, true: Array, length: float) -> float:
    """The larger of distance over length and angle [rad] between two poses."""
    turn = found[:3, :3] @ true[:3, :3].T
    # The angle from both sine and cosine: exact at small and at large angles.
    sine = np.linalg.norm(rotation_gap(turn))
    angle = np.arctan2(sine, 0.5 * (np.trace(turn) - 1.0))
    return float(max(np.linalg.norm(found[:3, 3] - true[:3, 3]) / length, abs(angle)))


def equilibrated(matrix: Array, rounds: int = 20) -> Array:
    """The matrix with rows and columns scaled to a length near one, so that no choice of units is left in it."""
    scaled = np.array(matrix, dtype=float)
    for _ in range(rounds):
        rows, columns = np.linalg.norm(scaled, axis=1), np.linalg.norm(scaled, axis=0)
        rows[rows == 0.0], columns[columns == 0.0] = 1.0, 1.0
        scaled = scaled / np.sqrt(rows)[:, None] / np.sqrt(columns)
    return scaled
