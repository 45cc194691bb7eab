"""What was measured of an actuator or a limb, and what a model predicts of it, with derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb.arguments import finite_array, finite_of_shape, one_of, one_positive, one_whole, shown
from softlimb.identify.actuators import Actuator, twist_and_slopes
from softlimb.identify.driven import DrivenLimb, Moves
from softlimb.limb import _require_pose
from softlimb.sense import _inverse_right_jacobian
from softlimb.sweep import bending_angle, rotation_vector

Array = NDArray[np.float64]

_TIGHT = 1e-9  # tolerance of postures: slopes and residuals are then free of noise that a search could trip over


class Predicted(NamedTuple):
    """Numbers, shape (n,), and their derivatives to the model's own numbers and to offsets, by name."""

    values: Array
    by_values: Array  # (n, names)
    by_zeros: dict[str, Array]


def _pressures(value: ArrayLike) -> Array:
    given = finite_array("pressures", value)
    if given.ndim != 1 or not given.size:
        raise ValueError(f"pressures must be a list of numbers, got shape {given.shape}")
    return given


@dataclass(frozen=True, eq=False)
class ActuatorCurve:
    """Length and end twist of one free actuator over its pressure.

    Parameters
    ----------
    pressures : array_like, shape (n,)
        Gauge pressures in the order of the measurement [Pa].
    elongation : array_like, shape (n,), optional
        Gain of length over the unpressurised length [m].
    twist : array_like, shape (n,), optional
        Turn of the end [rad].
    elongation_sigma, twist_sigma : float
        Standard deviation of the noise [m], [rad]; with the noise estimated only their ratio counts.

    Offsets that `identify` can find: ``pressure_zero`` (the gauge shows this much too much), ``elongation_zero`` and
    ``twist_zero`` (what is shown of an unpressurised actuator).

    Raises
    ------
    ValueError
        Nothing was measured, shapes differ, or a number is not finite.
    """

    pressures: Array
    elongation: Array | None = None
    twist: Array | None = None
    elongation_sigma: float = 1.0
    twist_sigma: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "pressures", _pressures(self.pressures))
        if self.elongation is None and self.twist is None:
            raise ValueError("a curve of an actuator needs elongation, twist, or both")
        for name in ("elongation", "twist"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, finite_of_shape(name, getattr(self, name), self.pressures.shape))
            object.__setattr__(self, f"{name}_sigma", one_positive(f"{name}_sigma", getattr(self, f"{name}_sigma")))

    def _kinds(self) -> list[tuple[str, str, int]]:
        kinds = [("elongation", "m", 0), ("twist", "rad", 1)]
        return [kind for kind in kinds if getattr(self, kind[0]) is not None]

    @property
    def states(self) -> int:
        """Number of pressures."""
        return len(self.pressures)

    @property
    def values(self) -> Array:
        """Numbers of all states, state by state."""
        return np.stack([getattr(self, name) for name, *_ in self._kinds()], axis=1)

    @property
    def sigma(self) -> Array:
        """Noise of `values`, same shape."""
        return np.tile([getattr(self, f"{name}_sigma") for name, *_ in self._kinds()], (self.states, 1))

    @property
    def quantities(self) -> list[tuple[str, str]]:
        """Name and unit of each column of `values`."""
        return [(name, unit) for name, unit, _ in self._kinds()]

    @property
    def zeros(self) -> dict[str, float]:
        """Offsets, with what counts as a large one."""
        spreads = {f"{name}_zero": float(np.abs(getattr(self, name)).max()) for name, *_ in self._kinds()}
        return {"pressure_zero": float(np.abs(self.pressures).max()), **spreads}

    def predict(
        self, model: Actuator, names: Sequence[str], zeros: Mapping[str, float]
    ) -> Predicted:
        """What the actuator gives, at parameters that it has by now."""
        ends, by_pressure, by_values = twist_and_slopes(model, self.pressures - zeros.get("pressure_zero", 0.0), names)
        at_rest, _, rest_slopes = twist_and_slopes(model, [0.0], names)
        ends[:, 0] -= at_rest[0, 0]
        by_values[:, 0] -= rest_slopes[0, 0]
        chosen = [column for *_, column in self._kinds()]
        by_zeros = {"pressure_zero": -by_pressure[:, chosen].ravel()}
        for k, (name, *_) in enumerate(self._kinds()):
            ends[:, chosen[k]] += zeros.get(f"{name}_zero", 0.0)
            one = np.zeros((self.states, len(chosen)))
            one[:, k] = 1.0
            by_zeros[f"{name}_zero"] = one.ravel()
        values = ends[:, chosen]
        return Predicted(values.ravel(), by_values[:, chosen].reshape(values.size, len(names)), by_zeros)


@dataclass(frozen=True, eq=False)
class _OfLimb:
    """Something measured of a limb at many pressures; every kind adds how it is read off a posture.

    ``scene`` holds loads and options of `Limb.solve`, the same at all pressures.
    """

    pressures: Array  # (N, A)
    scene: Mapping[str, Any] = field(default_factory=dict, kw_only=True)

    def __post_init__(self) -> None:
        given = finite_array("pressures", self.pressures)
        if given.ndim != 2 or not given.size:
            rule = "one row a posture and one column an actuator"
            raise ValueError(f"pressures must have {rule}, got shape {given.shape}")
        object.__setattr__(self, "pressures", given)
        object.__setattr__(self, "scene", dict(self.scene))

    @property
    def states(self) -> int:
        """Number of postures."""
        return len(self.pressures)

    @property
    def values(self) -> Array:
        """Numbers measured, one row a posture."""
        raise NotImplementedError

    @property
    def zeros(self) -> dict[str, float]:
        """Offsets, with what counts as a large one."""
        return {"pressure_zero": float(np.abs(self.pressures).max()) or 1.0}

    def _shares(self) -> Array | None:
        return None

    def _read(self, moves: Moves, row: int) -> tuple[Array, Array]:
        """Numbers of one posture, and their derivative to the rows of `Moves`."""
        raise NotImplementedError

    def _add_zeros(self, values: Array, zeros: Mapping[str, float], by_zeros: dict[str, Array]) -> None:
        """Offsets of the numbers themselves."""

    def predict(
        self, model: DrivenLimb, names: Sequence[str], zeros: Mapping[str, float]
    ) -> Predicted:
        """What the limb gives, at parameters that it has by now."""
        size = self.values.shape[1]
        values = np.full((self.states, size), np.nan)
        by_values, by_pressure = np.zeros((self.states, size, len(names))), np.zeros((self.states, size))
        solved: dict[int, Moves] = {}
        known: dict[bytes, int] = {}  # holds of the same pressures have the same posture, and are often repeated
        for row in range(self.states):
            pressures = self.pressures[row] - zeros.get("pressure_zero", 0.0)
            before = known.setdefault(pressures.tobytes(), row)
            if before == row:
                # From the limb's own first posture every time: what a search tried before must not decide where two
                # postures are stable.
                moves = model.moves(pressures, names, at=self._shares(), **{"tolerance": _TIGHT, **self.scene})
                if moves is None:
                    break  # one that fails makes the parameters no candidate: the others need no solving
                solved[row] = moves
            moves = solved[before]
            numbers, matrix = self._read(moves, row)
            values[row], by_values[row] = numbers, matrix @ moves.by_values
            by_pressure[row] = matrix @ moves.by_pressures.sum(axis=1)
        by_zeros = {"pressure_zero": -by_pressure.ravel()}
        self._add_zeros(values, zeros, by_zeros)
        return Predicted(values.ravel(), by_values.reshape(values.size, len(names)), by_zeros)


@dataclass(frozen=True, eq=False)
class LimbCurve(_OfLimb):
    """Elongation or bending of a limb over rows of pressures.

    Parameters
    ----------
    pressures : array_like, shape (N, A)
        [Pa]
    measured : array_like, shape (N,)
        Height of the tip over the base [m] (``height``), or angle between the tip's and the base's axis [rad].
    kind : {"height", "bending"}
    noise : float
        Standard deviation [m] or [rad].
    scene : mapping

    Raises
    ------
    ValueError
        Shapes do not fit, a number is not finite, the kind is unknown.
    """

    measured: Array = field(kw_only=True)
    kind: Literal["height", "bending"] = field(kw_only=True)
    noise: float = field(default=1.0, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        one_of("kind", self.kind, ("height", "bending"))
        object.__setattr__(self, "measured", finite_of_shape("measured", self.measured, (self.states,)))
        object.__setattr__(self, "noise", one_positive("noise", self.noise))

    @property
    def values(self) -> Array:
        """As `ActuatorCurve.values`."""
        return self.measured[:, None]

    @property
    def sigma(self) -> Array:
        """As `ActuatorCurve.sigma`."""
        return np.full((self.states, 1), self.noise)

    @property
    def quantities(self) -> list[tuple[str, str]]:
        """As `ActuatorCurve.quantities`."""
        return [(self.kind, "m" if self.kind == "height" else "rad")]

    @property
    def zeros(self) -> dict[str, float]:
        """As `ActuatorCurve.zeros`."""
        return {**super().zeros, f"{self.kind}_zero": float(np.abs(self.measured).max()) or 1.0}

    def _read(self, moves: Moves, row: int) -> tuple[Array, Array]:
        tip = moves.posture.tip
        matrix = np.zeros((1, len(moves.by_pressures)))
        last = 6 * (len(moves.posture.plates) - 1)
        if self.kind == "height":
            matrix[0, last + 2] = 1.0
            return tip[2:3, 3], matrix
        # d(t_z) = (dtheta x t)_z. The angle is that of t with z; a straight limb, where its sine is zero, has no slope.
        axis = tip[:3, 2]
        sine = float(np.hypot(axis[0], axis[1]))
        if sine > 0.0:
            matrix[0, last + 3 : last + 5] = np.array([-axis[1], axis[0]]) / sine
        return np.array([bending_angle(tip)]).ravel(), matrix

    def _add_zeros(self, values: Array, zeros: Mapping[str, float], by_zeros: dict[str, Array]) -> None:
        values += zeros.get(f"{self.kind}_zero", 0.0)
        by_zeros[f"{self.kind}_zero"] = np.ones(values.size)


@dataclass(frozen=True, eq=False)
class Points(_OfLimb):
    """Positions of markers on plates, or of points of the centreline, at many pressures.

    Parameters
    ----------
    pressures : array_like, shape (N, A)
        [Pa]
    measured : array_like, shape (N, M, 3)
        In the base frame [m].
    plates : sequence of int, optional
        Plate that carries each marker, from 0 at the base end, or -1 for the tip.
    offsets : array_like, shape (M, 3), optional
        Place of each marker in its plate's frame [m]; default: the origin.
    at : array_like, shape (M,), optional
        Instead of ``plates``: shares of the centreline, as for `Posture.centreline`.
    noise : float
        Standard deviation of a coordinate [m].
    scene : mapping

    Offsets that `identify` can find: ``pressure_zero`` and ``offset.x``, ``offset.y``, ``offset.z``, of all points.

    Raises
    ------
    ValueError
        Shapes do not fit, a number is not finite, or not exactly one of ``plates`` and ``at``.
    """

    measured: Array = field(kw_only=True)
    plates: tuple[int, ...] | None = field(default=None, kw_only=True)
    offsets: Array | None = field(default=None, kw_only=True)
    at: Array | None = field(default=None, kw_only=True)
    noise: float = field(default=1.0, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.plates is None) == (self.at is None):
            raise ValueError("points are on plates or on the centreline: give exactly one of plates and at")
        if self.plates is not None:
            object.__setattr__(self, "plates", tuple(one_whole("plates", plate, -1) for plate in self.plates))
            count = len(self.plates)
        else:
            shares = finite_array("at", self.at if self.at is not None else [])
            object.__setattr__(self, "at", np.atleast_1d(shares))
            count = shares.size
        if self.offsets is not None:
            if self.plates is None:
                raise ValueError("offsets belong to markers on plates")
            object.__setattr__(self, "offsets", finite_of_shape("offsets", self.offsets, (count, 3)))
        shape = (self.states, count, 3)
        object.__setattr__(self, "measured", finite_of_shape("measured", self.measured, shape))
        object.__setattr__(self, "noise", one_positive("noise", self.noise))

    @property
    def values(self) -> Array:
        """As `ActuatorCurve.values`."""
        return self.measured.reshape(self.states, -1)

    @property
    def sigma(self) -> Array:
        """As `ActuatorCurve.sigma`."""
        return np.full(self.values.shape, self.noise)

    @property
    def quantities(self) -> list[tuple[str, str]]:
        """As `ActuatorCurve.quantities`."""
        return [(f"points[{k}].{along}", "m") for k in range(self.measured.shape[1]) for along in "xyz"]

    @property
    def zeros(self) -> dict[str, float]:
        """As `ActuatorCurve.zeros`."""
        spread = float(np.ptp(self.measured.reshape(-1, 3), axis=0).max()) or 1.0
        return {**super().zeros, **{f"offset.{along}": spread for along in "xyz"}}

    def _shares(self) -> Array | None:
        return self.at

    def _read(self, moves: Moves, row: int) -> tuple[Array, Array]:
        plates = moves.posture.plates
        count = self.measured.shape[1]
        points, matrix = np.empty((count, 3)), np.zeros((3 * count, len(moves.by_pressures)))
        if self.plates is None:
            points[:] = moves.posture.centreline(at=self.at)
            matrix[:, 6 * len(plates) :] = np.eye(3 * count)
            return points.ravel(), matrix
        for k, plate in enumerate(self.plates):
            if not -len(plates) <= plate < len(plates):
                raise ValueError(f"plates[{k}] must be below {len(plates)}, got {plate}")
            pose = plates[plate]
            arm = np.zeros(3) if self.offsets is None else pose[:3, :3] @ self.offsets[k]
            points[k] = pose[:3, 3] + arm
            first = 6 * (plate % len(plates))
            x, y, z = arm
            matrix[3 * k : 3 * k + 3, first : first + 3] = np.eye(3)
            matrix[3 * k : 3 * k + 3, first + 3 : first + 6] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
        return points.ravel(), matrix

    def _add_zeros(self, values: Array, zeros: Mapping[str, float], by_zeros: dict[str, Array]) -> None:
        for k, along in enumerate("xyz"):
            one = np.zeros_like(values)
            one[:, k::3] = 1.0
            values += zeros.get(f"offset.{along}", 0.0) * one
            by_zeros[f"offset.{along}"] = one.ravel()


@dataclass(frozen=True, eq=False)
class TipPoses(_OfLimb):
    """Poses of the tip at many pressures.

    Parameters
    ----------
    pressures : array_like, shape (N, A)
        [Pa]
    measured : array_like, shape (N, 4, 4)
        In the base frame.
    noise, angle_noise : float
        Standard deviations of a coordinate [m] and of a component of the rotation vector [rad].
    scene : mapping

    Raises
    ------
    ValueError
        Shapes do not fit, a number is not finite, or a pose is not rigid.
    """

    measured: Array = field(kw_only=True)
    noise: float = field(default=1e-3, kw_only=True)
    angle_noise: float = field(default=1e-2, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "measured", finite_of_shape("measured", self.measured, (self.states, 4, 4)))
        for k, pose in enumerate(self.measured):
            _require_pose(f"measured[{k}]", pose)
        for name in ("noise", "angle_noise"):
            object.__setattr__(self, name, one_positive(name, getattr(self, name)))

    @property
    def values(self) -> Array:
        """Positions, and zeros for the rotation from the measured pose."""
        return np.concatenate([self.measured[:, :3, 3], np.zeros((self.states, 3))], axis=1)

    @property
    def sigma(self) -> Array:
        """As `ActuatorCurve.sigma`."""
        return np.tile([self.noise] * 3 + [self.angle_noise] * 3, (self.states, 1))

    @property
    def quantities(self) -> list[tuple[str, str]]:
        """As `ActuatorCurve.quantities`."""
        return [(f"tip.{name}", "m" if len(name) == 1 else "rad") for name in ("x", "y", "z", "rx", "ry", "rz")]

    def _read(self, moves: Moves, row: int) -> tuple[Array, Array]:
        tip = moves.posture.tip
        turned = rotation_vector(self.measured[row, :3, :3] @ tip[:3, :3].T)
        matrix = np.zeros((6, len(moves.by_pressures)))
        last = 6 * (len(moves.posture.plates) - 1)
        matrix[:3, last : last + 3] = np.eye(3)
        matrix[3:, last + 3 : last + 6] = _inverse_right_jacobian(turned)
        return np.concatenate([tip[:3, 3], -turned]), matrix


Observation: TypeAlias = ActuatorCurve | LimbCurve | Points | TipPoses


def observations(data: Observation | Sequence[Observation]) -> tuple[Observation, ...]:
    """One or several measurements as a tuple.

    Raises
    ------
    TypeError, ValueError
        Something else, or none.
    """
    if not isinstance(data, (ActuatorCurve, _OfLimb, Sequence)):
        raise TypeError(f"data must be a measurement or a sequence of them, got {type(data).__name__}")
    given = (data,) if isinstance(data, (ActuatorCurve, _OfLimb)) else tuple(data)
    for one in given:
        if not isinstance(one, (ActuatorCurve, LimbCurve, Points, TipPoses)):
            raise TypeError(f"data must be ActuatorCurve, LimbCurve, Points or TipPoses, got {shown(one)}")
    if not given:
        raise ValueError("data must hold at least one measurement, got none")
    return given
