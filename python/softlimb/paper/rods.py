"""A batch of Cosserat rods by classical RK4: base pose and wrench to end pose and wrench (Zhang et al. eq. 4-6)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from softlimb.paper.problem import Array, Problem

__all__ = ["STEPS", "end_of", "extrapolated"]

STEPS = 40


def _cross(a: Array, b: Array) -> Array:
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def extrapolated(values: Sequence[Array]) -> tuple[Array, float]:
    """What answers by RK4 tend to as their step is halved again and again.

    Parameters
    ----------
    values : sequence of at least 3 arrays
        With the step h, h/2, h/4 ...

    Returns
    -------
    array, float
        The limit, and how far it is from what one halving less would have given. RK4 errs by c4 h^4 + c5 h^5 + ...:
        two extrapolations in a row take both terms out.
    """
    fourth = [fine + (fine - coarse) / 15.0 for coarse, fine in pairwise(values)]
    fifth = [fine + (fine - coarse) / 31.0 for coarse, fine in pairwise(fourth)]
    before = fifth[-2] if len(fifth) > 1 else fourth[-1]
    return fifth[-1], float(np.linalg.norm(fifth[-1] - before))


def end_of(
    problem: Problem,
    which: Array | list[int],
    base: tuple[Array, Array],
    wrench: Array,
    lengths: Array,
    steps: int = STEPS,
    line_force: Array | None = None,
) -> tuple[Array, Array, Array]:
    """Integrate the rods ``which`` from their bases; leading axes of the arguments are a batch.

    Parameters
    ----------
    base : (position (..., k, 3), rotation (..., k, 3, 3))
    wrench : array, shape (..., k, 6)
        Internal force and moment at the base, base axes.
    lengths : array, shape (..., k)
    line_force : array, shape (..., k, 3), optional
        In place of the problem's own [N/m].

    Returns
    -------
    position, rotation, wrench at the ends
    """
    position, rotation = base
    p = problem
    along = 1.0 / p.axial[which]
    across = 1.0 / p.shear[which]
    bend = 1.0 / p.bending[which]
    twist = 1.0 / p.torsion[which]
    couple = p.extension_twist[which]
    strain_law = np.stack([across, across, along], axis=-1)
    curvature_law = np.stack([bend, bend, twist], axis=-1)
    line_moment = p.line_moment[which]
    if line_force is None:
        line_force = p.line_force[which]
    loaded = bool(np.any(line_force) or np.any(line_moment))
    shape = np.broadcast_shapes(position.shape, (*wrench.shape[:-1], 3))
    kind = np.result_type(position, rotation, wrench, lengths)

    # Rows of the state: position, the three directors (columns of the rotation), force, moment.
    state = np.empty((6, *shape), dtype=kind)
    state[0], state[4], state[5] = position, wrench[..., :3], wrench[..., 3:]
    state[1:4] = np.moveaxis(np.broadcast_to(rotation, (*shape, 3)), -1, 0)
    step = (np.asarray(lengths) / steps)[..., None]

    def rate(y: Array) -> Array:
        directors, n, m = y[1:4], y[4], y[5]
        force = np.moveaxis((directors * n).sum(axis=-1), 0, -1)  # section axes
        moment = np.moveaxis((directors * m).sum(axis=-1), 0, -1)
        v = force * strain_law
        u = moment * curvature_law
        v[..., 2] += 1.0 + couple * moment[..., 2]
        u[..., 2] += p.rest_twist[which] + couple * force[..., 2]
        slope = np.empty_like(y)
        slope[0] = (np.moveaxis(v, -1, 0)[..., None] * directors).sum(axis=0)
        spin = (np.moveaxis(u, -1, 0)[..., None] * directors).sum(axis=0)
        slope[1:4] = _cross(spin[None], directors)
        slope[4] = -line_force if loaded else 0.0
        slope[5] = -_cross(slope[0], n)
        if loaded:
            slope[5] -= line_moment
        return slope

    for _ in range(steps):
        k1 = rate(state)
        k2 = rate(state + 0.5 * step * k1)
        k3 = rate(state + 0.5 * step * k2)
        k4 = rate(state + step * k3)
        state = state + (step / 6.0) * (k1 + 2.0 * (k2 + k3) + k4)
    return state[0], np.moveaxis(state[1:4], 0, -1), np.concatenate([state[4], state[5]], axis=-1)
