"""Multiple shooting: rods cut into pieces, each shot by RK4, all states of all cuts unknown at once.

A second opinion on a posture, not a way to find one: it starts from a posture and says where the equilibrium nearest to
it is. It shares no code with the package's solver: rods with three directors instead of a tangent, RK4 of fixed steps,
nothing condensed, no derivative written by hand (complex steps). Pieces are short, so that growth along a rod, which
ruins single shooting, does no harm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softlimb.bench.methods.judging import hat
from softlimb.bench.methods.single_shooting import sensitivities
from softlimb.paper.plates import balance, less
from softlimb.paper.problem import Array, Problem, rotation_gap
from softlimb.paper.rods import end_of, extrapolated
from softlimb.posture import Posture

__all__ = ["Refined", "refine"]

_COMPLEX_STEP = 1e-30
_MOST_ITERATIONS = 12
_STEPS = 10
"""RK4 steps a piece of the derivatives, and of the coarsest answer."""


@dataclass(frozen=True)
class Refined:
    """Where the nearest equilibrium has its tip.

    Parameters
    ----------
    tip : array, shape (3,)
        Position [m], extrapolated to steps of no length.
    spread : float
        Change of that by the last halving of the steps, over the limb's length: what is left of the steps' error.
    steps : int
        RK4 steps a rod of the finest answer.
    converged : bool
        Every Newton iteration came to rest.
    """

    tip: Array
    spread: float
    steps: int
    converged: bool


@dataclass(frozen=True)
class _States:
    """Plates, and states where pieces begin: (J, ...) and (pieces, rods, ...) after the axes of a batch."""

    plate_position: Array
    plate_rotation: Array
    position: Array
    rotation: Array
    wrench: Array


def _turned(vector: Array, rotation: Array) -> Array:
    """Rotation matrices turned further, by Cayley's formula: rational, so that a complex step may go through it."""
    k = hat(vector)
    square = (vector * vector).sum(axis=-1)[..., None, None]
    turned: Array = rotation + (k + 0.5 * k @ k) @ rotation / (1.0 + 0.25 * square)
    return turned


class _System:
    """Unknown moves away from a posture: base wrenches (6 a rod), plates (6 each), states of the cuts (12 each).

    Moves count in limb lengths, radians, EI/l^2 and EI/l of each rod; so do the gaps.
    """

    def __init__(self, posture: Posture, pieces: int) -> None:
        self.problem = p = Problem.of(posture)
        self.pieces = pieces
        along = [rod.along(pieces + 1) for row in posture.rods for rod in row]
        poses = np.stack([curve[0][:-1] for curve in along], axis=1)
        wrench = np.stack([np.concatenate(curve[1:3], axis=-1)[:-1] for curve in along], axis=1)
        self.at = _States(
            posture.plates[:, :3, 3], posture.plates[:, :3, :3], poses[..., :3, 3], poses[..., :3, :3], wrench
        )
        self.unit = p.unit_wrenches
        self.pose_unit = np.array([p.scale] * 3 + [1.0] * 3)
        self.held_unit = np.array([p.unit_force.max()] * 3 + [p.unit_moment.max()] * 3)
        self.size = 6 * p.rods + 6 * p.plates + 12 * (pieces - 1) * p.rods

    def states(self, moves: Array) -> _States:
        """After moves (..., size)."""
        p, at, cuts = self.problem, self.at, self.pieces - 1
        batch = moves.shape[:-1]
        base, plates, nodes = np.split(moves, [6 * p.rods, 6 * (p.rods + p.plates)], axis=-1)
        plate = plates.reshape(*batch, p.plates, 6) * self.pose_unit
        plate_position = at.plate_position + plate[..., :3]
        plate_rotation = _turned(plate[..., 3:], at.plate_rotation)
        node = nodes.reshape(*batch, cuts, p.rods, 12)
        pose = node[..., :6] * self.pose_unit
        first = base.reshape(*batch, 1, p.rods, 6)
        wrench = at.wrench + self.unit * np.concatenate([first, node[..., 6:]], axis=-3)
        foot, axes = self._feet(plate_position, plate_rotation)
        position = np.concatenate([foot[..., None, :, :], at.position[1:] + pose[..., :3]], axis=-3)
        rotation = np.concatenate([axes[..., None, :, :, :], _turned(pose[..., 3:], at.rotation[1:])], axis=-4)
        return _States(plate_position, plate_rotation, position, rotation, wrench)

    def _feet(self, position: Array, rotation: Array) -> tuple[Array, Array]:
        """Where the rods begin: on the base, or on the plate below."""
        p = self.problem
        foot = np.zeros((*position.shape[:-2], p.rods, 3), dtype=position.dtype)
        axes = np.zeros((*position.shape[:-2], p.rods, 3, 3), dtype=position.dtype)
        for j in range(p.plates):
            here = p.segment == j
            frames = p.base_frames[here]
            if j == 0:
                foot[..., here, :], axes[..., here, :, :] = frames[:, :3, 3], frames[:, :3, :3]
                continue
            lever = frames[:, :3, 3] + [0.0, 0.0, p.thickness[j - 1]]
            below = rotation[..., j - 1, None, :, :]
            foot[..., here, :] = position[..., j - 1, None, :] + (below @ lever[..., None])[..., 0]
            axes[..., here, :, :] = below @ frames[:, :3, :3]
        return foot, axes

    def ends(self, states: _States, steps: int) -> tuple[Array, Array, Array]:
        """Position, rotation and wrench where pieces end, shape (pieces, rods, ...)."""
        p = self.problem
        base = states.position, states.rotation
        return end_of(p, np.arange(p.rods), base, states.wrench, p.lengths / self.pieces, steps)

    def gaps(self, states: _States, ends: tuple[Array, Array, Array]) -> Array:
        """Everything that vanishes: pieces meet the next one or their plate, plates are in balance."""
        p = self.problem
        position, rotation, wrench = ends
        batch = np.broadcast_shapes(states.plate_position.shape[:-2], position.shape[:-3])
        turn = rotation[..., :-1, :, :, :] @ np.swapaxes(states.rotation[..., 1:, :, :, :], -1, -2)
        cut = np.concatenate(
            [
                (position[..., :-1, :, :] - states.position[..., 1:, :, :]) / p.scale,
                rotation_gap(turn),
                (wrench[..., :-1, :, :] - states.wrench[..., 1:, :, :]) / self.unit,
            ],
            axis=-1,
        )
        parts = [np.broadcast_to(cut, (*batch, *cut.shape[-3:])).reshape(*batch, -1)]
        last_p, last_r, last_w = position[..., -1, :, :], rotation[..., -1, :, :, :], wrench[..., -1, :, :]
        for j in range(p.plates):
            here = np.flatnonzero(p.segment == j)
            origin, axes = states.plate_position[..., j, :], states.plate_rotation[..., j, :, :]
            frames = p.end_frames[here]
            lever = (axes[..., None, :, :] @ frames[:, :3, 3, None])[..., 0]
            turn = last_r[..., here, :, :] @ np.swapaxes(axes[..., None, :, :] @ frames[:, :3, :3], -1, -2)
            gap = [(last_p[..., here, :] - origin[..., None, :] - lever) / p.scale, rotation_gap(turn)]
            held = balance(p, j, origin, axes[..., :, 2], last_p[..., here, :], last_w[..., here, :])
            if j + 1 < p.plates:
                above = np.flatnonzero(p.segment == j + 1)
                arms = states.position[..., 0, above, :] - origin[..., None, :]
                held = less(held, arms, states.wrench[..., 0, above, :])
            for part in (np.concatenate(gap, axis=-1), held / self.held_unit):
                parts.append(np.broadcast_to(part, (*batch, *part.shape[-2:])).reshape(*batch, -1))
        return np.concatenate(parts, axis=-1)

    def slope(self, steps: int) -> Array:
        """Derivative of the gaps to the moves at the posture: through the ends of the pieces, and past them."""
        p, here = self.problem, self.states(np.zeros(self.size))
        moved = self.states(1j * _COMPLEX_STEP * np.eye(self.size))
        which, lengths = np.arange(p.rods), p.lengths / self.pieces
        ends, slopes = sensitivities(p, which, here.position, here.rotation, here.wrench, lengths, steps)
        by_start = np.concatenate(slopes, axis=-2)  # (pieces, rods, 12, 12)
        turned = rotation_gap(moved.rotation.imag @ np.swapaxes(here.rotation, -1, -2))
        starts = np.concatenate([moved.position.imag, turned, moved.wrench.imag], axis=-1) / _COMPLEX_STEP
        along = np.einsum("kiab,nkib->nkia", by_start, starts) * _COMPLEX_STEP
        # The ends move by what their starts do; the states themselves enter the gaps as well.
        changed = (
            ends[0] + 1j * along[..., :3],
            ends[1] + 1j * hat(along[..., 3:6]) @ ends[1],
            ends[2] + 1j * along[..., 6:],
        )
        rows: Array = self.gaps(moved, changed).imag.T / _COMPLEX_STEP
        return rows


def refine(posture: Posture, pieces: int = 8, levels: int = 4) -> Refined:
    """The equilibrium next to a posture, with steps halved ``levels`` - 1 times and extrapolated to none.

    Parameters
    ----------
    posture : Posture
        Of dead loads and sections with a linear axial law.
    pieces : int
        Of every rod: enough that a piece grows by less than e^5 or so.
    levels : int
        At least 3.

    Raises
    ------
    ValueError
        Following wrenches.
    """
    system = _System(posture, pieces)
    inverse = np.linalg.inv(system.slope(_STEPS))
    moves, converged, tips = np.zeros(system.size), True, []
    for level in range(levels):
        steps = _STEPS << level
        before = np.inf
        for _ in range(_MOST_ITERATIONS):
            states = system.states(moves)
            step = inverse @ system.gaps(states, system.ends(states, steps))
            size = float(np.abs(step).max())
            # The slope is not quite that of these steps, so steps shrink by a constant factor, down to rounding.
            if not size < 0.5 * before:
                break
            moves, before = moves - step, size
        # Forces in units of EI/l^2 may be large: what counts is that the poses stopped.
        converged = converged and before < 1e-7
        tips.append(system.states(moves).plate_position[-1])
    tip, change = extrapolated(tips)
    return Refined(tip, change / system.problem.scale, (_STEPS << (levels - 1)) * pieces, converged)
