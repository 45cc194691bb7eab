"""A second model of a posture: rods as many short elements, their energy, its slope and its Hessian, in plain numpy.

It shares nothing with the package. An element joins two poses a rest length h apart. Its strains are the rotation
vector phi between the frames over h, and the chord w = R_mid^T (p_b - p_a)/h seen from the frame half way, drawn out to
its arc, v = w - phi x (phi x w)/24; its energy is quadratic in them. Both strains are right to second order in h, so
every answer is, too. The slope is written by hand, the Hessian is its complex step, exact to rounding, and symmetric
only if the slope is that of an energy.

The number of negative eigenvalues at a stationary point is the number of unstable modes: no rod is condensed, no
conjugate point is looked for.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from scipy.sparse import coo_array, csc_array
from scipy.sparse.linalg import splu

import softlimb as sl


def series(square: np.ndarray, ratios: Any, terms: int) -> np.ndarray:
    """1 + r(1) x^2 (1 + r(2) x^2 (1 + ...)): smooth through zero, and for complex numbers."""
    total = np.ones_like(square)
    for k in range(terms, 0, -1):
        total = 1.0 + ratios(k) * square * total
    return total


def sine_ratio(square: np.ndarray) -> np.ndarray:
    """sin(x)/x; 14 terms leave 1e-18 at x = pi."""
    return series(square, lambda k: -1.0 / (2 * k * (2 * k + 1)), 14)


def versine_ratio(square: np.ndarray) -> np.ndarray:
    """(1 - cos x)/x^2."""
    return 0.5 * sine_ratio(0.25 * square) ** 2


def cubic_ratio(square: np.ndarray) -> np.ndarray:
    """(x - sin x)/x^3."""
    return series(square, lambda k: -1.0 / ((2 * k + 2) * (2 * k + 3)), 14) / 6.0


def arctangent_ratio(square: np.ndarray) -> np.ndarray:
    """atan(x)/x; 60 terms leave 1e-16 at x = 0.75, a turn of 73 degrees where x is the tangent of half the angle."""
    return series(square, lambda k: -(2.0 * k - 1.0) / (2.0 * k + 1.0), 60)


def hat(vector: np.ndarray) -> np.ndarray:
    x, y, z = np.moveaxis(vector, -1, 0)
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=-1).reshape(*vector.shape, 3)


def turn(vector: np.ndarray) -> np.ndarray:
    """Rotation matrices of rotation vectors."""
    k, square = hat(vector), (vector * vector).sum(axis=-1)[..., None, None]
    matrix: np.ndarray = np.eye(3) + sine_ratio(square) * k + versine_ratio(square) * k @ k
    return matrix


def turning(vector: np.ndarray) -> np.ndarray:
    """What a change of a rotation vector turns by, base axes: the left Jacobian."""
    k, square = hat(vector), (vector * vector).sum(axis=-1)[..., None, None]
    matrix: np.ndarray = np.eye(3) + versine_ratio(square) * k + cubic_ratio(square) * k @ k
    return matrix


def times(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    product: np.ndarray = (matrix @ vector[..., None])[..., 0]
    return product


def transposed_times(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    return times(matrix.swapaxes(-1, -2), vector)


class DiscreteLimb:
    """The energy of a posture's limb, loads and holds on a mesh of its own, starting from the posture's curves.

    Bodies are the plates, then the nodes inside the rods, then the ground. A body's rotation is that of its rotation
    vector times a reference; a held plate keeps the hold as its reference, because holds speak of that vector.
    """

    def __init__(self, posture: sl.Posture, elements: int, held: Any = None, hold_poses: Any = None) -> None:
        loads, segments = posture.loads, posture.limb.segments
        assert posture.conservative and loads["frame"] == "base"
        plates = len(segments)
        self.held = np.zeros((plates, 6), dtype=bool) if held is None else np.asarray(held, dtype=bool)
        poses = [np.array(plate) for plate in posture.plates]
        bodies, offsets, lengths, stiffness, rest, line = [], [], [], [], [], []
        for j, (segment, row) in enumerate(zip(segments, posture.rods, strict=True)):
            step = np.eye(4)
            step[2, 3] = segments[j - 1].plate.thickness if j else 0.0
            for i, rod in enumerate(row):
                nodes = range(len(poses), len(poses) + elements - 1)
                poses += list(rod.along(elements + 1)[0][1:-1])
                chain = [j - 1, *nodes, j]
                places = [step @ segment.base_frames[i], *[np.eye(4)] * (elements - 1), segment.end_frames[i]]
                bodies += pairwise(chain)
                offsets += pairwise(places)
                section = rod.section
                assert not section.nonlinear
                compliance = np.diag(
                    [1.0 / section.shear] * 2 + [1.0 / section.axial] + [1.0 / section.bending] * 2
                    + [1.0 / section.torsion]
                )  # fmt: skip
                compliance[2, 5] = compliance[5, 2] = section.extension_twist
                flat = len(lengths) // elements
                lengths += [rod.length / elements] * elements
                stiffness += [np.linalg.inv(compliance)] * elements
                rest += [[0.0, 0.0, 1.0, 0.0, 0.0, section.rest_twist]] * elements
                line += [loads["rod_forces"][flat] + section.mass_per_length * loads["gravity"]] * elements
        self.bodies = len(poses)
        pose = np.array([*poses, np.eye(4)])
        self.position, self.reference = pose[:, :3, 3].copy(), pose[:, :3, :3].copy()
        self.vector = np.zeros((self.bodies + 1, 3))
        self.by_hold = np.zeros(self.bodies + 1, dtype=bool)
        self.by_hold[:plates] = self.held[:, 3:].any(axis=1)
        for j in np.flatnonzero(self.by_hold):
            hold = np.asarray(hold_poses[j])[:3, :3]
            self.vector[j], self.reference[j] = rotation_vector(self.reference[j] @ hold.T), hold
        self.ends = np.array(bodies) % (self.bodies + 1)  # -1 is the ground
        self.offsets = np.array(offsets)
        self.h, self.stiffness = np.array(lengths), np.array(stiffness)
        self.rest, self.line = np.array(rest), np.array(line)
        self.plate_force = loads["plate_wrenches"][:, :3].copy()
        self.plate_force[-1] += loads["tip_force"]
        self.plate_weight = np.array([s.plate.mass for s in segments])[:, None] * loads["gravity"]
        self.plate_centre = np.array([[0.0, 0.0, 0.5 * s.plate.thickness] for s in segments])
        free = np.ones((self.bodies, 6), dtype=bool)
        free[:plates] = ~self.held
        self.free = np.flatnonzero(free.ravel())

    def _strain(self, p_a: Any, r_a: Any, p_b: Any, r_b: Any) -> tuple[np.ndarray, ...]:
        between = r_a.swapaxes(-1, -2) @ r_b
        trace = np.trace(between, axis1=-2, axis2=-1)[..., None]
        skew = between - between.swapaxes(-1, -2)
        tangent = np.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], axis=-1) / (1.0 + trace)
        assert np.abs(tangent).max() < 0.7, "an element turns too far for these series"
        angle = 2.0 * tangent * arctangent_ratio((tangent * tangent).sum(axis=-1)[..., None])
        middle = r_a @ turn(0.5 * angle)
        chord = transposed_times(middle, p_b - p_a)
        arc = chord - np.cross(angle, np.cross(angle, chord)) / 24.0
        return np.concatenate([arc, angle], axis=-1) / self.h[:, None] - self.rest, angle, middle, chord

    def _ends(self, moves: np.ndarray) -> list[tuple[np.ndarray, ...]]:
        """Position, rotation, lever arm and turning of the two ends of all elements moved by (..., E, 12)."""
        found = []
        for end in (0, 1):
            body, move = self.ends[:, end], moves[..., 6 * end : 6 * end + 6]
            vector = self.vector[body] + move[..., 3:]
            frame = turn(vector) @ self.reference[body]
            arm = times(frame, self.offsets[:, end, :3, 3])
            rotation = frame @ self.offsets[:, end, :3, :3]
            found.append((self.position[body] + move[..., :3] + arm, rotation, arm, turning(vector)))
        return found

    def _element_slopes(self, moves: np.ndarray) -> np.ndarray:
        (p_a, r_a, arm_a, turning_a), (p_b, r_b, arm_b, turning_b) = self._ends(moves)
        strain, angle, middle, chord = self._strain(p_a, r_a, p_b, r_b)
        inside = times(self.stiffness, strain)
        n = inside[..., :3]
        force = times(middle, n - np.cross(angle, np.cross(angle, n)) / 24.0)
        drawn = 2.0 * angle * (chord * n).sum(axis=-1)[..., None]
        drawn = drawn - n * (angle * chord).sum(axis=-1)[..., None] - chord * (angle * n).sum(axis=-1)[..., None]
        # The frame half way turns with the first end and by half of what the angle grows.
        couple = np.cross(p_b - p_a, force)
        by_middle = transposed_times(turning(0.5 * angle), transposed_times(r_a, couple))
        moment = inside[..., 3:] + drawn / 24.0 - 0.5 * by_middle
        # d(angle) = J_r^-1 R_b^T (dtheta_b - dtheta_a), and J_r(angle) = J_l(-angle).
        torque = times(r_b, np.linalg.solve(turning(-angle).swapaxes(-1, -2), moment[..., None])[..., 0])
        half_load = 0.5 * self.h[:, None] * self.line
        force_a, force_b = -force - half_load, force - half_load
        moment_a = -torque - couple + np.cross(arm_a, force_a)
        moment_b = torque + np.cross(arm_b, force_b)
        parts = [force_a, transposed_times(turning_a, moment_a), force_b, transposed_times(turning_b, moment_b)]
        return np.concatenate(parts, axis=-1)

    def _plate_slopes(self, moves: np.ndarray) -> np.ndarray:
        count = len(self.plate_weight)
        vector = self.vector[:count] + moves[..., 3:]
        arm = times(turn(vector) @ self.reference[:count], self.plate_centre)
        force = np.zeros_like(moves[..., :3]) - self.plate_force - self.plate_weight
        moment = transposed_times(turning(vector), np.cross(arm, -self.plate_weight))
        return np.concatenate([force, moment], axis=-1)

    def energy(self) -> float:
        """Elastic energy and the potential of all loads."""
        (p_a, r_a, _, _), (p_b, r_b, _, _) = self._ends(np.zeros((len(self.h), 12)))
        strain = self._strain(p_a, r_a, p_b, r_b)[0]
        elastic = 0.5 * self.h * (times(self.stiffness, strain) * strain).sum(axis=-1)
        line = 0.5 * self.h * ((p_a + p_b) * self.line).sum(axis=-1)
        count = len(self.plate_weight)
        centre = times(turn(self.vector[:count]) @ self.reference[:count], self.plate_centre) + self.position[:count]
        plates = (self.position[:count] * self.plate_force).sum() + (centre * self.plate_weight).sum()
        return float(elastic.sum() - line.sum() - plates)

    def slope_and_hessian(self) -> tuple[np.ndarray, csc_array]:
        """Of the energy, over all moves of all bodies but the ground, held ones included."""
        size = 6 * self.bodies
        slope = np.zeros(size + 6)
        freedoms = np.arange(6)
        elements = np.concatenate([6 * self.ends[:, :1] + freedoms, 6 * self.ends[:, 1:] + freedoms], axis=1)
        plates = 6 * np.arange(len(self.plate_weight))[:, None] + freedoms
        values, rows, columns = [], [], []
        for slopes, indices in ((self._element_slopes, elements), (self._plate_slopes, plates)):
            count = indices.shape[1]
            zero = np.zeros((len(indices), count))
            np.add.at(slope, indices, slopes(zero))
            local = np.moveaxis(slopes(zero + 1e-30j * np.eye(count)[:, None, :]).imag / 1e-30, 0, -1)
            values.append(local.ravel())
            rows.append(np.broadcast_to(indices[:, :, None], local.shape).ravel())
            columns.append(np.broadcast_to(indices[:, None, :], local.shape).ravel())
        entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
        hessian = coo_array(entries, shape=(size + 6, size + 6)).tocsc()[:size, :size]
        gap = abs(hessian - hessian.T).max()
        assert gap < 1e-9 * abs(hessian).max(), "the slope is not that of an energy"
        return slope[:size], (0.5 * (hessian + hessian.T)).tocsc()

    def settle(self) -> csc_array:
        """Newton's method to the stationary point next to the posture; returns the Hessian there, on free moves."""
        size = np.inf
        for _ in range(15):
            slope, hessian = self.slope_and_hessian()
            free = hessian[self.free][:, self.free].tocsc()
            step = np.zeros(6 * self.bodies)
            step[self.free] = -splu(free).solve(slope[self.free])
            moves = step.reshape(-1, 6)
            size = max(np.abs(moves[:, :3]).max() / self.h.max(), np.abs(moves[:, 3:]).max())
            if size < 1e-7:  # the next step would be its square
                return free
            moves *= min(1.0, 0.3 / size)
            self.position[:-1] += moves[:, :3]
            keep = self.by_hold[:-1]
            self.vector[:-1][keep] += moves[keep, 3:]
            self.reference[:-1][~keep] = turn(moves[~keep, 3:]) @ self.reference[:-1][~keep]
        raise AssertionError(f"no stationary point next to the posture: the last step was {size:.3g}")

    def plates(self) -> np.ndarray:
        """Poses of the plates, shape (J, 4, 4)."""
        count = len(self.plate_weight)
        poses = np.tile(np.eye(4), (count, 1, 1))
        poses[:, :3, 3] = self.position[:count]
        poses[:, :3, :3] = turn(self.vector[:count]) @ self.reference[:count]
        return poses


def rotation_vector(rotation: np.ndarray) -> np.ndarray:
    """Of a rotation by less than half a turn."""
    skew = 0.5 * (rotation - rotation.T)
    axial = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
    sine = float(np.linalg.norm(axial))
    angle = float(np.arctan2(sine, 0.5 * (np.trace(rotation) - 1.0)))
    return axial * (1.0 if sine == 0.0 else angle / sine)


def unstable_modes(hessian: csc_array) -> int:
    """Number of negative eigenvalues: that of negative pivots of L D L^T (Sylvester), without exchanges."""
    scale = 1.0 / np.sqrt(abs(hessian.diagonal()))
    scaled = (hessian * scale).T * scale  # each freedom by its own stiffness: the signs stay
    factors = splu(scaled.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    assert np.array_equal(factors.perm_r, factors.perm_c), "rows were exchanged: the pivots tell nothing"
    return int((factors.U.diagonal() < 0.0).sum())
