"""Single shooting: every rod in one shot from its base by RK4, Newton on base wrenches and plate poses together.

Unknowns: 6 a rod (internal wrench at the base) and 6 a plate (pose). Equations: the end of every rod meets its plate,
every plate is in balance (Zhang et al. eq. 7-10 with levers in the moments and poses in vector form). The rods'
sensitivities are exact (complex step through RK4), the plates' by hand; a full Newton step, its turns capped.
"""

from __future__ import annotations

import time

import numpy as np

from softlimb.bench.methods import constant_curvature
from softlimb.bench.methods.judging import hat
from softlimb.paper.problem import Answer, Array, Problem, rotation_gap
from softlimb.paper.rods import STEPS, end_of

__all__ = ["base_frames", "refine", "residual_and_jacobian", "scaled_jacobian", "sensitivities", "solve", "starts"]

_LARGEST_TURN = 0.5  # [rad] of a plate in one step; translations as far as half a rod
_TOLERANCE = 1e-6
_COMPLEX_STEP = 1e-30


def _turn(vector: Array) -> Array:
    angle = np.linalg.norm(vector)
    k = hat(vector)
    turn: Array = np.eye(3) + np.sinc(angle / np.pi) * k + 0.5 * np.sinc(0.5 * angle / np.pi) ** 2 * k @ k
    return turn


def _straight_plates(problem: Problem) -> Array:
    foot, plates = np.eye(4), []
    for j in range(problem.plates):
        here = problem.segment == j
        rise = np.eye(4)
        rise[2, 3] = problem.lengths[here].mean()
        # Where each rod alone would put the plate, straight; placements that are no ring average out.
        each = problem.base_frames[here] @ rise @ np.linalg.inv(problem.end_frames[here])
        plate = np.eye(4)
        plate[:3, 3] = each[:, :3, 3].mean(axis=0)
        plates.append(foot @ plate)
        face = np.eye(4)
        face[2, 3] = problem.thickness[j]
        foot = plates[-1] @ face
    return np.array(plates)


def _footings(problem: Problem, plates: Array) -> tuple[Array, Array]:
    """Face on which each segment's rods start: position and rotation, shape (J, 3) and (J, 3, 3)."""
    positions = np.vstack([np.zeros(3), plates[:-1, :3, 3] + problem.thickness[:-1, None] * plates[:-1, :3, 2]])
    return positions, np.concatenate([np.eye(3)[None], plates[:-1, :3, :3]])


def _bent_wrenches(problem: Problem, plates: Array) -> Array:
    """Base wrench of each rod from the bend that constant curvature gives it: moment only, base axes."""
    _, rotations = _footings(problem, plates)
    wrenches = np.zeros((problem.rods, 6))
    for i, j in enumerate(problem.segment):
        base = rotations[j] @ problem.base_frames[i, :3, :3]
        end = plates[j, :3, :3] @ problem.end_frames[i, :3, :3]
        turn = end @ base.T
        gap = rotation_gap(turn)
        angle = np.arctan2(np.linalg.norm(gap), 0.5 * (np.trace(turn) - 1.0))
        if angle > 0.0:
            wrenches[i, 3:] = problem.bending[i] / problem.lengths[i] * angle * gap / np.linalg.norm(gap)
    return wrenches


def base_frames(problem: Problem, plates: Array) -> tuple[Array, Array]:
    """Where the rods start, given the plates: positions (R, 3) and rotations (R, 3, 3)."""
    positions, rotations = _footings(problem, plates)
    foot, axes = positions[problem.segment], rotations[problem.segment]
    return (
        foot + np.einsum("rij,rj->ri", axes, problem.base_frames[:, :3, 3]),
        axes @ problem.base_frames[:, :3, :3],
    )


def sensitivities(
    problem: Problem,
    which: Array,
    base_position: Array,
    base_rotation: Array,
    base_wrench: Array,
    lengths: Array,
    steps: int,
) -> tuple[tuple[Array, Array, Array], tuple[Array, Array, Array]]:
    """Ends (position, rotation, wrench) and their slopes to base pose (dp, dtheta) and wrench, twelve columns last."""
    position, rotation, wrench = (
        np.broadcast_to(part.astype(complex), (12, *part.shape)).copy()
        for part in (base_position, base_rotation, base_wrench)
    )
    for k in range(3):
        position[k, ..., k] += 1j * _COMPLEX_STEP
        rotation[3 + k] += 1j * _COMPLEX_STEP * (hat(np.eye(3)[k]) @ base_rotation)
    for k in range(6):
        wrench[6 + k, ..., k] += 1j * _COMPLEX_STEP
    end_p, end_r, end_w = end_of(problem, which, (position, rotation), wrench, lengths, steps)
    ends = end_p[0].real, end_r[0].real, end_w[0].real
    # The change of the end's rotation as a rotation vector: dR R^T. RK4 leaves R orthonormal only to its own error.
    turned = rotation_gap(end_r.imag @ np.swapaxes(ends[1], -1, -2))
    slope_p, slope_r, slope_w = (np.moveaxis(part, 0, -1) / _COMPLEX_STEP for part in (end_p.imag, turned, end_w.imag))
    return ends, (slope_p, slope_r, slope_w)


def residual_and_jacobian(problem: Problem, plates: Array, wrenches: Array, steps: int = STEPS) -> tuple[Array, Array]:
    """Gaps of the rods' ends, then balances of the plates; columns by base wrenches, then by moves of the plates."""
    rods, count = problem.rods, problem.plates
    residual = np.zeros(6 * (rods + count))
    jacobian = np.zeros((residual.size, residual.size))
    base_position, base_rotation = base_frames(problem, plates)
    (end_p, end_r, end_w), (slope_p, slope_r, slope_w) = sensitivities(
        problem, np.arange(rods), base_position, base_rotation, wrenches, problem.lengths, steps
    )
    for j in range(count):
        row = slice(6 * (rods + j), 6 * (rods + j + 1))
        force = -problem.wrenches[j, :3] - problem.weight[j]
        arm = 0.5 * problem.thickness[j] * plates[j, :3, 2]
        residual[row] += np.concatenate([force, -problem.wrenches[j, 3:] - np.cross(arm, problem.weight[j])])
        jacobian[row, row][3:, 3:] -= -hat(problem.weight[j]) @ -hat(arm)  # d(arm x w) = -hat(w) (dtheta x arm)
    for i, j in enumerate(problem.segment):
        plate = plates[j]
        own, rod = slice(6 * i, 6 * i + 6), slice(6 * i, 6 * i + 6)
        above = slice(6 * (rods + j), 6 * (rods + j + 1))
        lever = plate[:3, :3] @ problem.end_frames[i, :3, 3]
        n, m = end_w[i, :3], end_w[i, 3:]
        # The rod's end meets its plate.
        turn = end_r[i] @ (plate[:3, :3] @ problem.end_frames[i, :3, :3]).T
        residual[own] = np.concatenate([end_p[i] - plate[:3, 3] - lever, rotation_gap(turn)])
        # d of half the skew part of E: of hat(x) E it is (tr E - E) x / 2, of E hat(x) it is (tr E - E^T) x / 2.
        by_end = 0.5 * (np.trace(turn) * np.eye(3) - turn)
        gap_slope = np.vstack([slope_p[i], by_end @ slope_r[i]])
        jacobian[own, above] -= np.block([[np.eye(3), -hat(lever)], [np.zeros((3, 3)), by_end.T]])
        # Its end wrench enters the balance of the plate, moments about the plate's origin.
        carry = np.block([[np.eye(3), np.zeros((3, 3))], [hat(lever), np.eye(3)]])
        residual[above] += np.concatenate([n, m + np.cross(lever, n)])
        jacobian[above, above][3:, 3:] += -hat(n) @ -hat(lever)
        wrench_slope = carry @ slope_w[i]
        jacobian[own, rod] += gap_slope[:, 6:]
        jacobian[above, rod] += wrench_slope[:, 6:]
        if j == 0:
            continue
        # Its base turns with the plate below, and pulls at it.
        below = slice(6 * (rods + j - 1), 6 * (rods + j))
        foot = base_position[i] - plates[j - 1, :3, 3]
        follow = np.block([[np.eye(3), -hat(foot)], [np.zeros((3, 3)), np.eye(3)]])
        jacobian[own, below] += gap_slope[:, :6] @ follow
        jacobian[above, below] += wrench_slope[:, :6] @ follow
        n, m = wrenches[i, :3], wrenches[i, 3:]
        residual[below] -= np.concatenate([n, m + np.cross(foot, n)])
        jacobian[below, below][3:, 3:] -= -hat(n) @ -hat(foot)
        jacobian[below, rod] -= np.block([[np.eye(3), np.zeros((3, 3))], [hat(foot), np.eye(3)]])
    return residual, jacobian


def scaled_jacobian(problem: Problem, plates: Array, wrenches: Array, steps: int = STEPS) -> Array:
    """The Jacobian without units: lengths by the limb's, wrenches by EI/l^2 and EI/l, balances by the largest."""
    jacobian = residual_and_jacobian(problem, plates, wrenches, steps)[1]
    gap = np.tile([problem.scale] * 3 + [1.0] * 3, problem.rods)
    balance = np.tile([problem.unit_force.max()] * 3 + [problem.unit_moment.max()] * 3, problem.plates)
    move = np.tile([problem.scale] * 3 + [1.0] * 3, problem.plates)
    rows, columns = np.concatenate([gap, balance]), np.concatenate([problem.unit_wrenches.ravel(), move])
    scaled: Array = jacobian / rows[:, None] * columns
    return scaled


def _newton(
    problem: Problem, plates: Array, wrenches: Array, steps: int, deadline: float, most_iterations: int
) -> Answer:
    rods = problem.rods
    answer = Answer(False, "no convergence")
    reach = problem.lengths.mean()
    previous = np.inf
    for answer.iterations in range(1, most_iterations + 1):
        residual, jacobian = residual_and_jacobian(problem, plates, wrenches, steps)
        if not (np.isfinite(residual).all() and np.isfinite(jacobian).all()):
            answer.outcome = "overflow"
            return answer
        answer.plates, answer.wrenches = plates, wrenches
        # Relative: gaps to the limb's length, balances to the largest force and moment inside.
        force = max(np.abs(wrenches[:, :3]).max(), problem.unit_force.max())
        moment = max(np.abs(wrenches[:, 3:]).max(), problem.unit_moment.max())
        gaps, balances = residual[: 6 * rods].reshape(-1, 6), residual[6 * rods :].reshape(-1, 6)
        answer.residual = max(
            np.abs(gaps[:, :3]).max() / problem.scale,
            np.abs(gaps[:, 3:]).max(),
            np.abs(balances[:, :3]).max() / force,
            np.abs(balances[:, 3:]).max() / moment,
        )
        try:
            # Columns scaled by their length: forces and metres share a matrix.
            size = np.linalg.norm(jacobian, axis=0)
            size[size == 0.0] = 1.0
            step = -np.linalg.solve(jacobian / size, residual) / size
        except np.linalg.LinAlgError:
            answer.outcome = "singular"
            return answer
        moves = step[6 * rods :].reshape(-1, 6)
        turn = max(np.abs(moves[:, 3:]).max(), np.abs(moves[:, :3]).max() / reach)
        if not np.isfinite(turn):
            answer.outcome = "overflow"
            return answer
        done = turn <= _TOLERANCE and answer.residual <= _TOLERANCE and previous <= 1e3 * _TOLERANCE
        previous = turn
        factor = min(1.0, _LARGEST_TURN / turn) if turn > 0.0 else 1.0
        wrenches = wrenches + factor * step[: 6 * rods].reshape(-1, 6)
        plates = plates.copy()
        for j, move in enumerate(factor * moves):
            plates[j, :3, 3] += move[:3]
            plates[j, :3, :3] = _turn(move[3:]) @ plates[j, :3, :3]
        if done:
            answer.converged, answer.outcome = True, "converged"
            answer.plates, answer.wrenches = plates, wrenches
            return answer
        if time.perf_counter() > deadline:
            answer.outcome = "gave up"
            return answer
    return answer


def starts(problem: Problem) -> list[tuple[Array, Array]]:
    """Plates and base wrenches to start from: by constant curvature where it applies, then straight and unloaded."""
    arcs = constant_curvature.solve(problem)
    found = [(_straight_plates(problem), np.zeros((problem.rods, 6)))]
    if arcs.converged:
        found.insert(0, (arcs.plates, _bent_wrenches(problem, arcs.plates)))
    return found


def solve(problem: Problem, limit: float = 20.0, steps: int = STEPS, most_iterations: int = 50) -> Answer:
    """Newton from the constant-curvature plates, and if that fails from the straight ones with no wrenches.

    Parameters
    ----------
    limit : float
        Time after which it gives up [s].
    """
    deadline = time.perf_counter() + limit
    iterations = 0
    with np.errstate(all="ignore"):
        for plates, wrenches in starts(problem):
            answer = _newton(problem, plates, wrenches, steps, deadline, most_iterations)
            iterations += answer.iterations
            answer.iterations, answer.lengths = iterations, problem.lengths
            if answer.converged or answer.outcome == "gave up":
                break
    return answer


def refine(problem: Problem, answer: Answer, steps: int = 200, limit: float = 20.0) -> Answer:
    """Newton with finer RK4 steps from an answer: is there an equilibrium?"""
    with np.errstate(all="ignore"):
        return _newton(problem, answer.plates, answer.wrenches, steps, time.perf_counter() + limit, 8)
