"""The limb that stands there: not quite the one that its controller knows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb import _core
from softlimb.arguments import finite_array, finite_of_shape, of_type, one_not_negative, one_whole, positive_array
from softlimb.limb import Limb, _Scene
from softlimb.posture import Posture
from softlimb.sweep import rotation_matrix
from softlimb.units import deg, kPa

__all__ = ["Perturbation", "TrueLimb"]

Array = NDArray[np.float64]

_TOLERANCE = 1e-6  # of a posture, relative to the limb's length


@dataclass(frozen=True, eq=False)
class Perturbation:
    """By how much a limb differs from its model.

    Parameters
    ----------
    bending, axial : array, shape (A,)
        EI and EA over the model's.
    strain : array, shape (A,)
        Strain of an actuator over the model's at the same pressure.
    plate_mass : array, shape (J,)
        Over the model's.
    pressure_offset : array, shape (A,)
        What the pressure sensors read too much [Pa].
    tilt : array, shape (3,)
        Rotation vector of the base [rad].

    Raises
    ------
    ValueError
        A number is not finite or out of range, or arrays of actuators differ in length.
    """

    bending: Array
    axial: Array
    strain: Array
    plate_mass: Array
    pressure_offset: Array
    tilt: Array

    def __post_init__(self) -> None:
        for name in ("bending", "axial", "strain", "plate_mass", "pressure_offset", "tilt"):
            rule = positive_array if name in ("bending", "axial") else finite_array
            object.__setattr__(self, name, rule(f"{name} of a Perturbation", getattr(self, name)))
        for name in ("strain", "plate_mass"):
            if (getattr(self, name) < 0.0).any():
                raise ValueError(f"{name} of a Perturbation must not be negative, got {getattr(self, name).tolist()}")
        for name in ("bending", "plate_mass"):
            if getattr(self, name).ndim != 1:
                raise ValueError(f"{name} of a Perturbation must be a row, got shape {getattr(self, name).shape}")
        for name in ("axial", "strain", "pressure_offset"):
            finite_of_shape(f"{name} of a Perturbation", getattr(self, name), self.bending.shape)
        finite_of_shape("tilt of a Perturbation", self.tilt, (3,))
        if np.linalg.norm(self.tilt) > np.pi:
            raise ValueError(
                f"tilt of a Perturbation must be within a half turn, got {self.tilt.tolist()} (was it given in "
                "degrees? multiply by units.deg)"
            )

    @classmethod
    def none(cls, limb: Limb) -> Perturbation:
        """The limb as it is known."""
        count, plates = len(limb._tubes), len(limb.segments)
        ones = np.ones(count)
        return cls(ones, ones, ones, np.ones(plates), np.zeros(count), np.zeros(3))

    @classmethod
    def drawn(
        cls,
        limb: Limb,
        seed: int,
        *,
        stiffness: float = 0.2,
        strain: float = 0.1,
        plate_mass: float = 0.05,
        pressure: float = 1 * kPa,
        tilt: float = 1 * deg,
    ) -> Perturbation:
        """Draw one: every actuator and plate its own, uniform within the bounds.

        Sensors are off by the whole ``pressure``, up or down, and the base is tilted by the whole ``tilt`` about a
        horizontal axis that is drawn.

        Raises
        ------
        ValueError
            A bound is negative, or the seed is no whole number.
        """
        seed = one_whole("seed", seed, 0)
        names = {"stiffness": stiffness, "strain": strain, "plate_mass": plate_mass, "pressure": pressure, "tilt": tilt}
        bound = {name: one_not_negative(name, value) for name, value in names.items()}
        rng = np.random.default_rng(seed)
        count, plates = len(limb._tubes), len(limb.segments)
        axis = rng.uniform(0.0, 2.0 * np.pi)
        return cls(
            bending=1.0 + bound["stiffness"] * rng.uniform(-1.0, 1.0, count),
            axial=1.0 + bound["stiffness"] * rng.uniform(-1.0, 1.0, count),
            strain=1.0 + bound["strain"] * rng.uniform(-1.0, 1.0, count),
            plate_mass=1.0 + bound["plate_mass"] * rng.uniform(-1.0, 1.0, plates),
            pressure_offset=bound["pressure"] * rng.choice([-1.0, 1.0], count),
            tilt=bound["tilt"] * np.array([np.cos(axis), np.sin(axis), 0.0]),
        )


class TrueLimb:
    """Postures of a perturbed limb, in the frame that the controller takes for its base.

    Parameters
    ----------
    limb : Limb
        The model; of tubes only.
    perturbation : Perturbation
    gravity : array_like, shape (3,)
        In the controller's frame [m/s^2].

    Raises
    ------
    ValueError
        The limb has rods that are given directly.
    """

    def __init__(self, limb: Limb, perturbation: Perturbation, gravity: ArrayLike) -> None:
        if len(limb._tubes) != len(limb._members) or not limb._tubes:
            raise ValueError("a limb that is controlled by pressures must be made of tubes only")
        of_type("perturbation", perturbation, Perturbation)
        finite_of_shape("bending of a Perturbation", perturbation.bending, (len(limb._tubes),))
        finite_of_shape("plate_mass of a Perturbation", perturbation.plate_mass, (len(limb.segments),))
        self.limb = limb
        self.perturbation = perturbation
        self.base = rotation_matrix(perturbation.tilt)
        self._gravity = self.base.T @ finite_of_shape("gravity", gravity, (3,))
        self._lengths = np.array([tube.length for tube in limb._tubes])
        masses = perturbation.plate_mass * [segment.plate.mass for segment in limb.segments]
        self._geometry = _core.Geometry(
            [
                (segment.base_frames, segment.end_frames, segment.plate.thickness, mass)
                for segment, mass in zip(limb.segments, masses, strict=True)
            ],
            limb.length,
        )

    def solve(self, pressures: ArrayLike, tip_force: ArrayLike, start: Posture | None = None) -> Posture:
        """Posture at true pressures [Pa] under a force on the tip [N], near an earlier one.

        Returns
        -------
        Posture
            In the axes of the tilted base; `tip_of` has the controller's.
        """
        limb, off = self.limb, self.perturbation
        plates, rods = len(limb.segments), len(limb._members)
        sections, rest, refusal = limb._core_members.at_pressures(np.asarray(pressures, dtype=float), "tangent", "open")
        made = [
            _core.Section(
                axial=float(off.axial[i]) * one.axial,
                bending=float(off.bending[i]) * one.bending,
                shear=one.shear,
                torsion=one.torsion,
                mass_per_length=one.mass_per_length,
                rest_twist=one.rest_twist,
                extension_twist=one.extension_twist,
            )
            for i, one in enumerate(sections)
        ]
        lengths = self._lengths + off.strain * (rest - self._lengths)
        force = self.base.T @ finite_of_shape("tip_force", tip_force, (3,))
        wrenches = np.zeros((plates, 6))
        wrenches[-1, :3] = force
        core = self._geometry.scene(
            sections=made,
            rest_lengths=lengths,
            gravity=self._gravity,
            wrenches=wrenches,
            following=False,
            line_forces=np.zeros((rods, 3)),
            line_moments=np.zeros((rods, 3)),
            held=np.zeros((plates, 6), dtype=bool),
            hold_poses=np.tile(np.eye(4), (plates, 1, 1)),
        )
        if refusal is None:
            first = None if start is None else start._solved
            solved = self._geometry.solve(
                core, tolerance=_TOLERANCE, prefer_stable=True, start=first, start_plates=None
            )
        else:
            solved = self._geometry.refused(core, status=refusal[0], message=refusal[1])
        loads: dict[str, Any] = {"gravity": self._gravity, "tip_force": force, "tip_moment": np.zeros(3)}
        loads |= {"plate_wrenches": np.zeros((plates, 6)), "frame": "base"}
        loads |= {"rod_forces": np.zeros((rods, 3)), "rod_moments": np.zeros((rods, 3))}
        scene = _Scene(core, np.array(pressures, dtype=float), lengths, loads, ("tangent", "open"), refusal)
        return limb._posture(scene, solved, _TOLERANCE)

    def tip_of(self, posture: Posture) -> Array:
        """Pose of the tip in the controller's frame, shape (4, 4)."""
        turned = np.eye(4)
        turned[:3, :3] = self.base
        found: Array = turned @ posture.tip
        return found
