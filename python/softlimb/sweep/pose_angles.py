"""Angles of poses: how far they bend, and about which axis they turn."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def bending_angle(pose: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angle between a pose's z axis and the base's z axis [rad], in [0, pi].

    Parameters
    ----------
    pose : array of float, shape (..., 4, 4)

    Returns
    -------
    array of float, shape (...)
    """
    # atan2 keeps its digits near 0 and pi, where the arc cosine of z loses half of them.
    return np.arctan2(np.hypot(pose[..., 0, 2], pose[..., 1, 2]), pose[..., 2, 2])


def rotation_vector(pose: NDArray[np.float64]) -> NDArray[np.float64]:
    """Axis times angle of a pose's rotation [rad], shape (..., 3).

    Parameters
    ----------
    pose : array of float, shape (..., 4, 4)
    """
    r = pose[..., :3, :3]
    twice_sine = np.stack([r[..., 2, 1] - r[..., 1, 2], r[..., 0, 2] - r[..., 2, 0], r[..., 1, 0] - r[..., 0, 1]], -1)
    norm = np.linalg.norm(twice_sine, axis=-1, keepdims=True)
    twice_cosine = np.trace(r, axis1=-2, axis2=-1)[..., None] - 1.0
    angle = np.arctan2(norm, twice_cosine)
    # Towards half a turn the sine vanishes, but (r + r^T)/2 - cos 1 = (1 - cos) a a^T still holds the axis a.
    symmetric = 0.5 * (r + np.swapaxes(r, -1, -2) - twice_cosine[..., None] * np.eye(3))
    largest = np.argmax(np.nan_to_num(np.diagonal(symmetric, axis1=-2, axis2=-1)), axis=-1)
    column = np.take_along_axis(symmetric, largest[..., None, None], axis=-1)[..., 0]
    sign = np.where(np.sum(column * twice_sine, axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    near_half_turn = angle > 3.0  # [rad]; within 0.14 of pi, where the sine has lost one digit
    with np.errstate(invalid="ignore", divide="ignore"):
        from_column = sign * column / np.linalg.norm(column, axis=-1, keepdims=True)
        from_sine = np.where(norm > 0.0, twice_sine / norm, 0.0)
    return np.where(np.isnan(norm), np.nan, np.where(near_half_turn, from_column, from_sine) * angle)


def rotation_matrix(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    """The rotation about a vector's axis by its length, shape (3, 3): Rodrigues' formula.

    Parameters
    ----------
    vector : array of float, shape (3,)
        [rad]
    """
    angle = float(np.linalg.norm(vector))
    x, y, z = vector
    turn = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    # sin(a)/a and (1 - cos a)/a^2 without subtraction, so that a small angle keeps its digits.
    sine, versine = np.sinc(angle / np.pi), 0.5 * np.sinc(0.5 * angle / np.pi) ** 2
    rotation: NDArray[np.float64] = np.eye(3) + sine * turn + versine * turn @ turn
    return rotation
