"""All rods as one boundary value problem for `scipy.integrate.solve_bvp`, as one would write it without derivatives.

Each rod has position, quaternion, force and moment over its own fraction of length, 13 unknown functions: 117 for nine
rods. The first rod of a segment carries its plate: the segment's other rods agree with it, the plate is in balance, and
the next rods stand on it. Everything is counted in limb lengths, EI/l^2 and EI/l.
"""

from __future__ import annotations

import time

import numpy as np

from softlimb.bench.methods import single_shooting
from softlimb.bench.methods.least_squares import GaveUp
from softlimb.paper.plates import balance, less, pair_gaps, plate_of_each
from softlimb.paper.problem import Answer, Array, Problem, rotation_gap
from softlimb.paper.rods import end_of

__all__ = ["solve"]

_NODES = 11  # of the first mesh
_MOST_NODES = 1000


def _rotation_of(q: Array) -> Array:
    """Rotation matrices (..., 3, 3) of quaternions (..., 4), w first, of any length near one."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    rows = [
        [w * w + x * x - y * y - z * z, 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def _quaternion_of(rotation: Array) -> Array:
    """A quaternion of each rotation matrix: the best conditioned column of 4 q q^T."""
    r = np.moveaxis(rotation, (-2, -1), (0, 1))
    trace = r[0, 0] + r[1, 1] + r[2, 2]
    square = np.empty((4, 4, *trace.shape))
    square[0, 0] = 1.0 + trace
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        square[1 + i, 1 + i] = 1.0 - trace + 2.0 * r[i, i]
        square[0, 1 + i] = square[1 + i, 0] = r[k, j] - r[j, k]
        square[1 + i, 1 + j] = square[1 + j, 1 + i] = r[i, j] + r[j, i]
    largest = np.argmax(np.einsum("ii...->i...", square), axis=0)
    column = np.take_along_axis(square, largest[None, None], axis=1)[:, 0]
    q: Array = np.moveaxis(column / np.linalg.norm(column, axis=0), 0, -1)
    return q


def solve(problem: Problem, limit: float = 20.0, tolerance: float = 1e-6) -> Answer:
    """From the arcs of constant curvature where they apply, else straight.

    Parameters
    ----------
    limit : float
        Time after which it gives up [s].
    tolerance : float
        Relative residual of the collocation, as scipy defines it.

    Raises
    ------
    ModuleNotFoundError
        scipy is missing.
    """
    from scipy.integrate import solve_bvp  # type: ignore[import-untyped, unused-ignore]

    deadline = time.perf_counter() + limit
    p, rods = problem, problem.rods
    unit = np.concatenate([[p.scale] * 3, [1.0] * 4, [p.unit_force.max()] * 3, [p.unit_moment.max()] * 3])
    first_of = [np.flatnonzero(p.segment == j) for j in range(p.plates)]

    def split(y: Array) -> tuple[Array, Array, Array, Array]:
        """Position, quaternion, force and moment, shape (..., R, 3 or 4), in SI."""
        state = y.reshape(*y.shape[:-1], rods, 13) * unit
        return state[..., :3], state[..., 3:7], state[..., 7:10], state[..., 10:]

    def rate(_: Array, y: Array) -> Array:
        if time.perf_counter() > deadline:
            raise GaveUp
        _, q, n, m = split(y.T)
        t = _rotation_of(q)[..., :, 2]
        along, twist = (t * n).sum(axis=-1), (t * m).sum(axis=-1)
        stretch = 1.0 + (1.0 / p.axial - 1.0 / p.shear) * along + p.extension_twist * twist
        torsion = p.rest_twist + (1.0 / p.torsion - 1.0 / p.bending) * twist + p.extension_twist * along
        strain = n / p.shear[:, None] + stretch[..., None] * t
        spin = m / p.bending[:, None] + torsion[..., None] * t
        slope = np.empty((*n.shape[:-1], 13))
        slope[..., :3] = strain
        slope[..., 3] = -0.5 * (spin * q[..., 1:]).sum(axis=-1)
        slope[..., 4:7] = 0.5 * (q[..., :1] * spin + np.cross(spin, q[..., 1:]))
        slope[..., 7:10] = -p.line_force
        slope[..., 10:] = -np.cross(strain, n) - p.line_moment
        rows: Array = (slope * p.lengths[:, None] / unit).reshape(len(y.T), -1).T
        return rows

    def conditions(at_base: Array, at_end: Array) -> Array:
        base_p, base_q, base_n, base_m = split(at_base)
        end_p, end_q, end_n, end_m = split(at_end)
        base_w, end_w = np.concatenate([base_n, base_m], axis=-1), np.concatenate([end_n, end_m], axis=-1)
        end_r = _rotation_of(end_q)
        plates, rows = np.tile(np.eye(4), (p.plates, 1, 1)), []
        for j, here in enumerate(first_of):
            origin, axes = plate_of_each(end_p[here], end_r[here], p.end_frames[here])
            plates[j, :3, 3], plates[j, :3, :3] = origin[0], axes[0]
            others = np.arange(1, len(here))
            gaps = pair_gaps(origin, axes, 0 * others, others) / ([p.scale] * 3 + [1.0] * 3)
            held = balance(p, j, origin[0], axes[0, :, 2], end_p[here], end_w[here])
            if j + 1 < p.plates:
                above = first_of[j + 1]
                held = less(held, base_p[above] - origin[0], base_w[above])
            rows += [gaps.ravel(), held.ravel() / unit[7:]]
        position, rotation = single_shooting.base_frames(p, plates)
        base_r = _rotation_of(base_q)
        rows += [
            ((base_p - position) / p.scale).ravel(),
            rotation_gap(base_r @ np.swapaxes(rotation, -1, -2)).ravel(),
            (base_q**2).sum(axis=-1) - 1.0,
        ]
        return np.concatenate(rows)

    plates, wrenches = single_shooting.starts(problem)[0]
    fractions = np.linspace(0.0, 1.0, _NODES)
    base = single_shooting.base_frames(p, plates)
    guess = np.empty((_NODES, rods, 13))
    at_p, at_r, at_w = end_of(
        p, np.arange(rods), base, np.broadcast_to(wrenches, (_NODES, rods, 6)), fractions[:, None] * p.lengths
    )
    guess[..., :3], guess[..., 3:7], guess[..., 7:] = at_p, _quaternion_of(at_r), at_w
    for k in range(1, _NODES):  # q and -q are one rotation: no jumps along a rod
        flip = (guess[k, :, 3:7] * guess[k - 1, :, 3:7]).sum(axis=-1) < 0.0
        guess[k, flip, 3:7] *= -1.0

    answer = Answer(False, "no convergence", lengths=problem.lengths)
    with np.errstate(all="ignore"):
        try:
            found = solve_bvp(
                rate, conditions, fractions, (guess / unit).reshape(_NODES, -1).T, tol=tolerance, max_nodes=_MOST_NODES
            )
        except GaveUp:
            answer.outcome = "gave up"
            return answer
    answer.iterations = int(found.niter)
    answer.residual = float(found.rms_residuals.max())
    answer.converged, answer.outcome = bool(found.success), "converged" if found.success else "no convergence"
    end_p, end_q, _, _ = split(found.y[:, -1])
    answer.wrenches = np.concatenate(split(found.y[:, 0])[2:], axis=-1)
    answer.plates = np.tile(np.eye(4), (p.plates, 1, 1))
    for j, here in enumerate(first_of):
        origin, axes = plate_of_each(end_p[here[:1]], _rotation_of(end_q[here[:1]]), p.end_frames[here[:1]])
        answer.plates[j, :3, 3], answer.plates[j, :3, :3] = origin[0], axes[0]
    return answer
