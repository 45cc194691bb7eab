"""The paper's Algorithm 1: the tip's pose is given, the rods' lengths are unknown, Levenberg-Marquardt finds them.

Unknowns: 7 a rod (length, base force, base moment): 63 for three segments of three rods. Residuals: for every plate
between segments the rods' ends agree in pairs (6 a pair) and the plate is in balance (6); at the tip every rod's end is
where the tip's pose has it (6 a rod) and the tip is in balance (6): 72. No plate is an unknown: a rod starts where the
rod below it ends. Tolerance 1e-6 on the norm of the residual in SI units.

Sections do not change with the lengths. Corrected only where the algorithm cannot run as printed (MECHANICS, "The
paper's Algorithm 1"): (a) eq. 9 gets its p x n; (b) the pairwise conditions of eq. 10 compare poses, not distances, and
stay a dependent cycle; (c) the balance of the plate takes the place of n_(j,i)(0) = n_(j-1,i)(l); (d) the update has
the sign -J; (e) weights, thickness and loads on plates are added, so that it solves the same problem; (f) residuals and
unknowns are scaled for the damping, which starts below the smallest of 60 singular values that span five decades, and
derivatives are exact: with normal equations or differences the small ones drown. The dependent cycle costs 6 a plate:
rank 60 for 63 unknowns, hence a family of answers with three parameters, of which one near the start is found.
"""

from __future__ import annotations

import time

import numpy as np

from softlimb.paper.plates import balance, less, pair_gaps, plate_of_each
from softlimb.paper.problem import Answer, Array, Problem, rotation_gap
from softlimb.paper.rods import STEPS, end_of

__all__ = ["residual", "residual_sizes", "scaled_jacobian", "solve"]

_TOLERANCE = 1e-6
_COMPLEX_STEP = 1e-30
_FIRST_DAMPING, _LARGEST_DAMPING = 1e-13, 1e12  # of the largest singular value's square


def residual(
    problem: Problem, tip: Array | None, unknowns: Array, steps: int = STEPS
) -> tuple[Array, list[tuple[Array, Array]]]:
    """Residuals and plates (of each segment's first rod) at unknowns (..., 7R): lengths, then wrenches rod by rod.

    Without a tip pose the last plate is like the others: its rods' ends agree in pairs.
    """
    rods = problem.rods
    lengths = unknowns[..., :rods]
    wrenches = unknowns[..., rods:].reshape(*unknowns.shape[:-1], rods, 6)
    batch = unknowns.shape[:-1]
    rows, plates, below = [], [], None
    for j in range(problem.plates):
        here = np.flatnonzero(problem.segment == j)
        frames, ends = problem.base_frames[here], problem.end_frames[here]
        if below is None:
            base = (
                np.broadcast_to(frames[:, :3, 3], (*batch, len(here), 3)),
                np.broadcast_to(frames[:, :3, :3], (*batch, len(here), 3, 3)),
            )
        else:
            # Each rod starts on the plate as the rod below it has it.
            under = np.arange(len(here)) % below[0].shape[-2]
            origin, axes = below[0][..., under, :], below[1][..., under, :, :]
            foot = frames[:, :3, 3] + [0.0, 0.0, problem.thickness[j - 1]]
            base = origin + np.einsum("...rij,rj->...ri", axes, foot), axes @ frames[:, :3, :3]
            rows[-1] = less(rows[-1], base[0] - below[0][..., :1, :], wrenches[..., here, :])
        # A rod's weight stays whatever its length is.
        spread = np.broadcast_to(problem.spread_force, (rods, 3))[here] / lengths[..., here, None]
        line_force = problem.line_force[here] + spread
        end_p, end_r, end_w = end_of(problem, here, base, wrenches[..., here, :], lengths[..., here], steps, line_force)
        origin, axes = plate_of_each(end_p, end_r, ends)
        if tip is None or j + 1 < problem.plates:
            rows.append(pair_gaps(origin, axes, *_pairs(len(here))))
        else:
            turn = axes @ tip[:3, :3].T
            rows.append(np.concatenate([origin - tip[:3, 3], rotation_gap(turn)], axis=-1))
        rows.append(balance(problem, j, origin[..., 0, :], axes[..., 0, :, 2], end_p, end_w))
        below = origin, axes
        plates.append((origin[..., 0, :], axes[..., 0, :, :]))
    return np.concatenate([part.reshape(*batch, -1) for part in rows], axis=-1), plates


def _pairs(count: int) -> tuple[Array, Array]:
    """Pairs of neighbours around the ring; three rods have three, which depend on each other."""
    if count == 1:
        return np.array([], dtype=int), np.array([], dtype=int)
    if count == 2:
        return np.array([0]), np.array([1])
    return np.arange(count), (np.arange(count) + 1) % count


def _typical(problem: Problem) -> Array:
    """Size of each unknown: a length, EI/l^2, EI/l."""
    return np.concatenate([problem.lengths, problem.unit_wrenches.ravel()])


def scaled_jacobian(problem: Problem, tip: Array, unknowns: Array, steps: int = STEPS) -> Array:
    """The Jacobian without units, by complex steps."""
    columns = unknowns + 1j * _COMPLEX_STEP * np.diag(_typical(problem))
    jacobian = (residual(problem, tip, columns, steps)[0].imag / _COMPLEX_STEP).T
    scaled: Array = jacobian / residual_sizes(problem, True)[:, None]
    return scaled


def residual_sizes(problem: Problem, with_tip: bool) -> Array:
    """Size of each residual, with a tip pose or without: the limb's length, one radian, the largest EI/l^2 and EI/l."""
    pose = [problem.scale] * 3 + [1.0] * 3
    held = [float(problem.unit_force.max())] * 3 + [float(problem.unit_moment.max())] * 3
    sizes: list[float] = []
    for j in range(problem.plates):
        count = int((problem.segment == j).sum())
        sizes += pose * (count if with_tip and j + 1 == problem.plates else len(_pairs(count)[0])) + held
    return np.array(sizes)


def solve(
    problem: Problem,
    tip: Array,
    start_lengths: Array,
    limit: float = 20.0,
    steps: int = STEPS,
    most_iterations: int = 50,
    start_wrenches: Array | None = None,
    tolerance: float = _TOLERANCE,
) -> Answer:
    """Lengths for a tip pose (4, 4), from given lengths, and wrenches (R, 6) or none.

    Parameters
    ----------
    limit : float
        Time after which it gives up [s].
    tolerance : float
        On the norm of the residuals in SI units; the paper's unless given.
    """
    deadline = time.perf_counter() + limit
    unit, sizes = _typical(problem), residual_sizes(problem, True)
    x = np.concatenate([start_lengths, np.zeros(6 * problem.rods)])
    if start_wrenches is not None:
        x[problem.rods :] = start_wrenches.ravel()
    answer = Answer(False, "no convergence")
    damping, growth = 0.0, 2.0
    with np.errstate(all="ignore"):
        error = residual(problem, tip, x, steps)[0] / sizes
        jacobian = None
        while True:
            if np.linalg.norm(error * sizes) <= tolerance:
                answer.converged, answer.outcome = True, "converged"
                break
            if answer.iterations >= most_iterations:
                break
            if time.perf_counter() > deadline:
                answer.outcome = "gave up"
                break
            if jacobian is None:
                jacobian = scaled_jacobian(problem, tip, x, steps)
                answer.iterations += 1
                if not np.isfinite(jacobian).all() or not np.isfinite(error).all():
                    answer.outcome = "overflow"
                    break
                left, values, right = np.linalg.svd(jacobian, full_matrices=False)
                along = left.T @ error
                if answer.iterations == 1:
                    damping = _FIRST_DAMPING * float(values[0]) ** 2
            step = -right.T @ (values / (values**2 + damping) * along)
            there = residual(problem, tip, x + unit * step, steps)[0] / sizes
            promised = error @ error - float(np.sum((error + jacobian @ step) ** 2))
            gain = (error @ error - there @ there) / promised
            if gain > 0.0:  # false for what is not finite
                x, error, jacobian = x + unit * step, there, None
                damping *= max(1.0 / 3.0, 1.0 - (2.0 * float(gain) - 1.0) ** 3)
                growth = 2.0
                continue
            damping *= growth
            growth *= 2.0
            if damping > _LARGEST_DAMPING * float(values[0]) ** 2:
                answer.outcome = "stalled"
                break
        answer.residual = float(np.linalg.norm(error * sizes))
        answer.lengths, answer.wrenches = x[: problem.rods], x[problem.rods :].reshape(-1, 6)
        answer.plates = np.tile(np.eye(4), (problem.plates, 1, 1))
        for j, (origin, axes) in enumerate(residual(problem, tip, x, steps)[1]):
            answer.plates[j, :3, 3], answer.plates[j, :3, :3] = origin, axes
    return answer
