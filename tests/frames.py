"""What many tests need: rotations, poses, and a solve that is checked."""

from __future__ import annotations

from typing import Any

import numpy as np

import softlimb as sl


def turn(vector: Any) -> np.ndarray:
    """Rotation matrix of a rotation vector, by Rodrigues' formula."""
    vector = np.asarray(vector, dtype=float)
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = vector / angle
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation: np.ndarray = np.eye(3) + np.sin(angle) * k + 2.0 * np.sin(0.5 * angle) ** 2 * k @ k
    return rotation


def pose(position: Any = (0.0, 0.0, 0.0), rotation: Any = None) -> np.ndarray:
    """A 4x4 pose."""
    frame = np.eye(4)
    frame[:3, 3] = position
    if rotation is not None:
        frame[:3, :3] = rotation
    return frame


def solved(limb: sl.Limb, *pressures: Any, **options: Any) -> sl.Posture:
    """A posture that succeeds and that an integration of its own confirms."""
    found = limb.solve(*pressures, **options)
    assert found.success, found.message
    check = found.verify()
    assert check.success, check
    return found
