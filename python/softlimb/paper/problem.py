"""A scene as plain arrays, and what is asked of its matrices."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softlimb.posture import Posture

__all__ = ["Answer", "Array", "Problem", "condition", "rotation_gap"]

Array = NDArray[Any]  # of floats; of complex numbers where a method differentiates by complex steps


@dataclass(frozen=True)
class Problem:
    """Rods between plates; flat arrays over the R rods, ``segment[i]`` says between which plates rod i stands.

    Parameters
    ----------
    segment : array, shape (R,)
    base_frames, end_frames : array, shape (R, 4, 4)
        In the frame of the face below, and of the plate above.
    axial, shear, bending, torsion, rest_twist, extension_twist : array, shape (R,)
    lengths : array, shape (R,)
        Rest lengths [m].
    line_force, line_moment : array, shape (R, 3)
        Per rest length, weight included [N/m], [N].
    spread_force : array, shape (R, 3)
        On each rod as a whole, evenly along whatever its length is [N]: where lengths are unknown.
    thickness : array, shape (J,)
    weight : array, shape (J, 3)
        Weight of each plate, acting half a thickness along its z [N].
    wrenches : array, shape (J, 6)
        Dead force and moment on each plate at its origin.
    scale : float
        The limb's length [m].
    """

    segment: Array
    base_frames: Array
    end_frames: Array
    axial: Array
    shear: Array
    bending: Array
    torsion: Array
    rest_twist: Array
    extension_twist: Array
    lengths: Array
    line_force: Array
    line_moment: Array
    thickness: Array
    weight: Array
    wrenches: Array
    scale: float
    spread_force: Array | float = 0.0

    @property
    def plates(self) -> int:
        return len(self.thickness)

    @property
    def rods(self) -> int:
        return len(self.lengths)

    @property
    def unit_force(self) -> Array:
        """EI/l^2 of each rod [N]."""
        unit: Array = self.bending / self.lengths**2
        return unit

    @property
    def unit_moment(self) -> Array:
        """EI/l of each rod [N m]."""
        unit: Array = self.bending / self.lengths
        return unit

    @property
    def unit_wrenches(self) -> Array:
        """Both, three times each, shape (R, 6)."""
        return np.stack([self.unit_force] * 3 + [self.unit_moment] * 3, axis=1)

    @classmethod
    def of(cls, posture: Posture) -> Problem:
        """The problem that a posture of the package answers: its own sections, rest lengths, dead loads."""
        limb, loads = posture.limb, posture.loads
        if loads["frame"] != "base":
            raise ValueError("following wrenches are not part of the compared methods")
        rods = [rod for row in posture.rods for rod in row]
        gravity = loads["gravity"]
        wrenches = loads["plate_wrenches"].copy()
        wrenches[-1] += np.concatenate([loads["tip_force"], loads["tip_moment"]])

        def each(name: str) -> Array:
            return np.array([getattr(rod.section, name) for rod in rods])

        return cls(
            segment=np.array([rod.segment for rod in rods]),
            base_frames=np.concatenate([segment.base_frames for segment in limb]),
            end_frames=np.concatenate([segment.end_frames for segment in limb]),
            axial=each("axial"),
            shear=each("shear"),
            bending=each("bending"),
            torsion=each("torsion"),
            rest_twist=each("rest_twist"),
            extension_twist=each("extension_twist"),
            lengths=np.array([rod.length for rod in rods]),
            line_force=loads["rod_forces"].reshape(-1, 3) + each("mass_per_length")[:, None] * gravity,
            line_moment=loads["rod_moments"].reshape(-1, 3),
            thickness=np.array([segment.plate.thickness for segment in limb]),
            weight=np.array([segment.plate.mass * gravity for segment in limb]),
            wrenches=wrenches,
            scale=limb.length,
        )


@dataclass
class Answer:
    """What a method found: ``plates`` (J, 4, 4), ``wrenches`` at the bases (R, 6), ``lengths`` (R,), how it ended.

    Arrays that a method does not find are empty.
    """

    converged: bool
    outcome: str
    plates: Array = field(default_factory=lambda: np.empty(0))
    wrenches: Array = field(default_factory=lambda: np.empty(0))
    lengths: Array = field(default_factory=lambda: np.empty(0))
    iterations: int = 0
    residual: float = np.nan


def rotation_gap(turn: Array) -> Array:
    """Axis times sine of the angle of a rotation matrix: half its skew part."""
    gap: Array = 0.5 * np.stack(
        [
            turn[..., 2, 1] - turn[..., 1, 2],
            turn[..., 0, 2] - turn[..., 2, 0],
            turn[..., 1, 0] - turn[..., 0, 1],
        ],
        axis=-1,
    )
    return gap


def condition(matrix: Array) -> tuple[float, int]:
    """Condition number, and the rank: the number of singular values above 1e-12 of the largest."""
    if not np.isfinite(matrix).all():
        return np.inf, 0
    values = np.linalg.svd(matrix, compute_uv=False)
    if values[0] == 0.0:
        return np.inf, 0
    return float(values[0] / max(values[-1], 1e-300 * values[0])), int((values > 1e-12 * values[0]).sum())
