"""The closed-form constant-curvature model: every segment an arc set by its rods' lengths, no loads, no stiffness.

A rod at (x, y) on its plate has the length s (1 - kx x - ky y) on an arc of length s that bends with curvature kx
towards +x and ky towards +y. Three numbers a segment from n lengths, by least squares of smallest norm.
"""

from __future__ import annotations

import numpy as np

from softlimb.paper.problem import Answer, Array, Problem

__all__ = ["arc", "solve"]


def arc(length: float, towards_x: float, towards_y: float) -> Array:
    """Pose at the end of a circular arc that starts along z and bends with the two curvatures [1/m]."""
    curvature = float(np.hypot(towards_x, towards_y))
    angle = curvature * length
    azimuth = np.arctan2(towards_y, towards_x)
    across = length * 0.5 * angle * np.sinc(0.5 * angle / np.pi) ** 2  # (1 - cos angle)/curvature without subtraction
    pose = np.eye(4)
    pose[:3, 3] = [across * np.cos(azimuth), across * np.sin(azimuth), length * np.sinc(angle / np.pi)]
    axis = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    x, y, z = axis
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    pose[:3, :3] = np.eye(3) + np.sin(angle) * k + 2.0 * np.sin(0.5 * angle) ** 2 * k @ k
    return pose


def solve(problem: Problem) -> Answer:
    """Plates of the limb by constant curvature, for rods that stand parallel on both plates at the same places."""
    if not np.allclose(problem.base_frames, problem.end_frames, rtol=0.0, atol=1e-12 * problem.scale) or not (
        np.allclose(problem.base_frames[:, :3, :3], np.eye(3))
    ):
        return Answer(False, "does not apply")
    foot, plates = np.eye(4), []
    for j in range(problem.plates):
        here = problem.segment == j
        places = problem.base_frames[here, :2, 3]
        lengths = problem.lengths[here]
        mean = places.mean(axis=0)
        rows = np.column_stack([np.ones(here.sum()), places - mean])
        rows[:, 1:] /= problem.scale
        at_mean, *slopes = np.linalg.lstsq(rows, lengths, rcond=None)[0]
        slopes = np.array(slopes) / problem.scale
        length = at_mean - slopes @ mean  # at the axis of the plate
        plates.append(foot @ arc(length, *(-slopes / length)))
        face = np.eye(4)
        face[2, 3] = problem.thickness[j]
        foot = plates[-1] @ face
    return Answer(True, "closed form", plates=np.array(plates), lengths=problem.lengths)
