"""What rods that end on a plate owe it: to agree where it is, and to hold it (Zhang et al. eq. 9 and 10, corrected).

Axes before the rods are a batch.
"""

from __future__ import annotations

import numpy as np

from softlimb.paper.problem import Array, Problem, rotation_gap

__all__ = ["balance", "less", "pair_gaps", "plate_of_each"]


def plate_of_each(end_position: Array, end_rotation: Array, end_frames: Array) -> tuple[Array, Array]:
    """Origin (..., k, 3) and axes (..., k, 3, 3) of the plate as each of its k rods has it."""
    axes = end_rotation @ np.swapaxes(end_frames[:, :3, :3], -1, -2)
    return end_position - np.einsum("...rij,rj->...ri", axes, end_frames[:, :3, 3]), axes


def pair_gaps(origin: Array, axes: Array, first: Array, second: Array) -> Array:
    """How far the plates of rods ``first`` and ``second`` are apart: positions and turns, shape (..., pairs, 6)."""
    turn = axes[..., first, :, :] @ np.swapaxes(axes[..., second, :, :], -1, -2)
    return np.concatenate([origin[..., first, :] - origin[..., second, :], rotation_gap(turn)], axis=-1)


def balance(problem: Problem, j: int, origin: Array, z: Array, end_position: Array, end_wrench: Array) -> Array:
    """Force and moment about its origin on plate j from the rods below, less loads and weight, shape (..., 1, 6).

    Parameters
    ----------
    origin, z : array, shape (..., 3)
        Of the plate, and its axis.
    end_position, end_wrench : array, shape (..., k, 3) and (..., k, 6)
        Of the rods that end on it.
    """
    load = problem.wrenches[j].copy()
    load[:3] += problem.weight[j]
    arm = 0.5 * problem.thickness[j] * z
    moment = -load[3:] - np.cross(arm, problem.weight[j])
    loads = np.concatenate([np.broadcast_to(-load[:3], moment.shape), moment], axis=-1)[..., None, :]
    held: Array = -less(-loads, end_position - origin[..., None, :], end_wrench)
    return held


def less(balance: Array, arms: Array, wrenches: Array) -> Array:
    """A balance less the wrenches of rods at the given arms."""
    force, moment = wrenches[..., :3], wrenches[..., 3:]
    total = np.concatenate([force, moment + np.cross(arms, force)], axis=-1).sum(axis=-2)
    rest: Array = balance - total[..., None, :]
    return rest
