"""Unstable modes of an equilibrium: negative eigenvalues of the second variation of its rods cut into short pieces.

Each rod is cut into short pieces; their stiffness follows from shooting's sensitivities, and one dense symmetric matrix
of all nodes and plates holds the second variation. Nothing is condensed. The nodes come from one shot along the rod, so
growth beyond about e^20 spoils the count.
"""

from __future__ import annotations

import numpy as np

from softlimb.bench.methods.judging import hat
from softlimb.bench.methods.single_shooting import base_frames, sensitivities
from softlimb.paper.rods import end_of

__all__ = ["unstable_modes"]


def unstable_modes(problem, plates, wrenches, pieces=16, steps=24):
    """Negative eigenvalues at an equilibrium with dead forces: plates (J, 4, 4) and base wrenches (R, 6)."""
    rods, count = problem.rods, problem.plates
    everything, lengths = np.arange(rods), problem.lengths / pieces
    position, rotation = base_frames(problem, plates)
    wrench, states = wrenches, []
    for _ in range(pieces):
        states.append((position, rotation, wrench))
        position, rotation, wrench = end_of(problem, everything, (position, rotation), wrench, lengths, steps)
    nodes = tuple(np.stack(part) for part in zip(*states, strict=True))  # (pieces, rods, ...)
    (_, _, end_wrench), slopes = sensitivities(problem, everything, *nodes, lengths, steps)
    pose_slope = np.concatenate(slopes[:2], axis=-2)  # (pieces, rods, 6, 12)
    by_base, by_wrench = pose_slope[..., :6], pose_slope[..., 6:]
    end_by_base, end_by_wrench = slopes[2][..., :6], slopes[2][..., 6:]
    inverse = np.linalg.inv(by_wrench)

    # Moves: interior nodes rod by rod, then plates. Forces on the nodes of a piece: -w at its base, +w_end at its end.
    size = 6 * (rods * (pieces - 1) + count)
    stiffness = np.zeros((size, size))
    first_plate = 6 * rods * (pieces - 1)

    def plate(j):
        return slice(first_plate + 6 * j, first_plate + 6 * j + 6)

    for i, j in enumerate(problem.segment):
        end_lever = plates[j, :3, :3] @ problem.end_frames[i, :3, 3]
        for k in range(pieces):
            here = inverse[k, i] @ by_base[k, i]
            blocks = [
                [here, -inverse[k, i]],
                [end_by_base[k, i] - end_by_wrench[k, i] @ here, end_by_wrench[k, i] @ inverse[k, i]],
            ]
            ends = []  # (where in the matrix, how the node follows it)
            for node in (k, k + 1):
                if 0 < node < pieces:
                    at = 6 * (i * (pieces - 1) + node - 1)
                    ends.append((slice(at, at + 6), np.eye(6)))
                elif node == pieces:
                    ends.append((plate(j), _follow(end_lever)))
                elif j > 0:
                    ends.append((plate(j - 1), _follow(nodes[0][0, i] - plates[j - 1, :3, 3])))
                else:
                    ends.append(None)
            for a, one in enumerate(ends):
                for b, other in enumerate(ends):
                    if one is not None and other is not None:
                        stiffness[one[0], other[0]] += one[1].T @ blocks[a][b] @ other[1]
        # Levers turn with the plates: (dtheta x b) x n.
        stiffness[plate(j), plate(j)][3:, 3:] += hat(end_wrench[-1, i, :3]) @ hat(end_lever)
        if j > 0:
            lever = nodes[0][0, i] - plates[j - 1, :3, 3]
            stiffness[plate(j - 1), plate(j - 1)][3:, 3:] -= hat(wrenches[i, :3]) @ hat(lever)
    for j in range(count):
        arm = 0.5 * problem.thickness[j] * plates[j, :3, 2]
        stiffness[plate(j), plate(j)][3:, 3:] -= hat(problem.weight[j]) @ hat(arm)
    symmetric = 0.5 * (stiffness + stiffness.T)
    # A congruence keeps the inertia and takes the units out.
    scale = 1.0 / np.sqrt(np.abs(np.diag(symmetric)))
    return int((np.linalg.eigvalsh(scale[:, None] * symmetric * scale) < -1e-10).sum())


def _follow(lever):
    return np.block([[np.eye(3), -hat(lever)], [np.zeros((3, 3)), np.eye(3)]])
