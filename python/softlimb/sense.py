"""Sensed force: the wrench on the tip that explains where the limb is seen to be, and how well."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb.arguments import finite_of_shape, one_of, one_positive, real_array
from softlimb.limb import Limb, _require_pose
from softlimb.posture import Posture
from softlimb.sweep import rotation_vector
from softlimb.text_tables import signed_parts
from softlimb.units import deg, mm

__all__ = ["Sensed", "sense"]

Array = NDArray[np.float64]
Unknown = Literal["wrench", "force"]

_LABELS = ("fx", "fy", "fz", "mx", "my", "mz")
_NUMERICAL_RANK = 1e-9  # of the largest singular value: what is smaller is rounding of postures and derivatives
_NOT_SENSED = ("prefer_stable", "tip_pose", "tip_held", "plate_poses", "plate_held", "pressures")
_MOST_STEPS = 50
# A step may move the tip by so much, by the linear response: farther away the posture is seldom found from the last.
_FARTHEST_MOVE, _LARGEST_TURN = 0.5, 1.0  # of the limb's length; [rad]
# Iterations of all postures together, about a second: a pose that no stable limb takes would need them without end.
# A search that comes to its end takes some five a step, and where the limb bends far a hundred or two in all.
_MOST_EFFORT = 1500
# Standard deviations of the measurement (or shares of the residual, where that is larger) by which a step would change
# it: the search ends at the first, and at the second where the step brings no gain.
_SMALL_STEP, _NO_GAIN = 1e-7, 1e-4


@dataclass(frozen=True)
class Sensed:
    """The wrench on the tip that explains a measurement.

    Parameters
    ----------
    wrench : array, shape (6,)
        Force and moment on the tip at its origin [N, N m], beside the loads that were given; axes as ``frame`` says.
        No step goes along the unseen directions, so it is small there, which says nothing.
    covariance : array, shape (6, 6)
        Of the wrench along the directions that are seen, from the covariance of the measurement; to first order, the
        model held for true. The variance along the ``unseen`` ones, which is larger than ``largest_force`` squared, is
        left out.
    unseen : array, shape (k, 6)
        Directions of (force, moment) that cannot be seen: along one of them a wrench of the size ``largest_force``
        (moments: times the limb's length) moves the measurement by less than one standard deviation. Each has norm one
        when moments are divided by the limb's length.
    singular_values : array, shape (6,), or (3,) where only the force is unknown
        Standard deviations by which such a wrench moves the measurement, from the best to the worst seen direction. The
        unseen directions are those with a value below one, or below 1e-9 of the largest.
    largest_force : float
        What counts as a large force here [N].
    posture : Posture
        Of the limb under the sensed wrench.
    residual : array, shape (m,)
        Measurement less posture: of the tip's pose (translation [m], rotation vector [rad]), then of the points [m].
    chi_square : float
        The residual's square in units of the covariance: about ``degrees_of_freedom`` where model and covariance hold.
    degrees_of_freedom : int
        Numbers measured less directions seen.
    status : str
        ``converged``, ``max_iterations`` or ``no_progress``; where no posture was found to start from, that solve's.
    message : str
        Outcome in words.
    iterations : int
        Wrenches taken over on the way, each nearer to the measurement; that of the tip held where it was seen is one.
    """

    wrench: Array
    covariance: Array
    unseen: Array
    singular_values: Array
    largest_force: float
    posture: Posture
    residual: Array
    chi_square: float
    degrees_of_freedom: int
    status: str
    message: str
    iterations: int

    @property
    def force(self) -> Array:
        """The first half of the wrench [N], shape (3,)."""
        return self.wrench[:3]

    @property
    def moment(self) -> Array:
        """The second half of the wrench [N m], shape (3,)."""
        return self.wrench[3:]

    @property
    def standard_deviations(self) -> Array:
        """Of each number of the wrench, from ``covariance``, shape (6,)."""
        found: Array = np.sqrt(np.diagonal(self.covariance))
        return found

    @property
    def success(self) -> bool:
        """True when no small change of the wrench explains the measurement better, at a stable posture."""
        return self.status == "converged"

    def __repr__(self) -> str:
        return f"Sensed({self.message}, force={self.force.round(6).tolist()}, moment={self.moment.round(8).tolist()})"


def _inverse_right_jacobian(vector: Array) -> Array:
    """How a rotation vector changes when its rotation is followed from the right by a small turn, shape (3, 3)."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector
    turn = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    # 1/a^2 - (1 + cos a)/(2 a sin a) = 1/12 + a^2/720 + ...: below 1e-2 the next term is 1e-12 of it.
    half = 0.5 * angle
    factor = 1.0 / 12.0 + angle**2 / 720.0 if angle < 1e-2 else (1.0 - half / np.tan(half)) / angle**2
    inverse: Array = np.eye(3) + 0.5 * turn + factor * turn @ turn
    return inverse


@dataclass(frozen=True)
class _Measured:
    """What was measured, and how it is compared with a posture."""

    tip: Array | None
    points: Array | None
    at: Array | None
    whiten: Array  # (m, m): turns a residual into standard deviations

    def residual(self, posture: Posture) -> Array:
        parts = []
        if self.tip is not None:
            turned = rotation_vector(self.tip[:3, :3] @ posture.tip[:3, :3].T)
            parts += [self.tip[:3, 3] - posture.tip[:3, 3], turned]
        if self.points is not None:
            parts.append((self.points - posture.centreline(at=self.at)).ravel())
        return np.concatenate(parts)

    def slope(self, posture: Posture, residual: Array) -> Array:
        """Of the residual by the wrench on the tip, shape (m, 6)."""
        of = ["tip"] * (self.tip is not None) + ["centreline"] * (self.points is not None)
        # Without points `at` is of no use, but must be some.
        at = [1.0] if self.at is None else self.at
        slope = -posture.derivative(of, ("tip_force", "tip_moment"), at=at).matrix
        if self.tip is not None:
            slope[3:6] = _inverse_right_jacobian(residual[3:6]) @ slope[3:6]
        found: Array = slope
        return found


def sense(
    limb: Limb,
    pressures: ArrayLike | Sequence[ArrayLike] | None,
    *,
    tip_pose: ArrayLike | None,
    covariance: ArrayLike | None,
    points: ArrayLike | None,
    at: ArrayLike | None,
    points_covariance: ArrayLike | None,
    unknown: Unknown,
    largest_force: float | None,
    tolerance: float,
    start: Posture | None,
    **scene: Any,
) -> Sensed:
    """See `Limb.sense`."""
    allowed = [name for name in limb._scene.__kwdefaults__ or {} if name not in _NOT_SENSED]
    for name in scene:
        if name in _NOT_SENSED:
            raise TypeError(f"{name} does not apply: a force is sensed at a free tip of a stable posture")
        if name not in allowed:
            raise TypeError(f"{name!r} is no load where a force is sensed: expected one of {', '.join(allowed)}")
    one_of("unknown", unknown, ("wrench", "force"))
    measured = _measurement(tip_pose, covariance, points, at, points_covariance)
    known = np.concatenate(
        [finite_of_shape(name, scene.pop(name, (0.0, 0.0, 0.0)), (3,)) for name in ("tip_force", "tip_moment")]
    )
    count = 6 if unknown == "wrench" else 3

    def solve(wrench: Array, near: Posture | None) -> Posture:
        total = known + wrench
        # Next to a posture another stable one is of no use.
        return limb.solve(
            pressures,
            **scene,
            tip_force=total[:3],
            tip_moment=total[3:],
            tolerance=tolerance,
            start=near,
            prefer_stable=near is None or near is start,
        )

    posture = solve(np.zeros(6), start)
    if not posture.success or not posture.stable:
        status = posture.status if not posture.success else "no_progress"
        message = f"not converged: no stable posture without the force: {posture.message}"
        none = np.full(len(measured.whiten), np.nan)
        return Sensed(
            wrench=np.full(6, np.nan),
            covariance=np.full((6, 6), np.nan),
            unseen=np.zeros((0, 6)),
            singular_values=np.full(count, np.nan),
            largest_force=np.nan,
            posture=posture,
            residual=none,
            chi_square=np.nan,
            degrees_of_freedom=0,
            status=status,
            message=message,
            iterations=0,
        )
    if largest_force is None:
        # The force that would bend the limb by its own length, were it linear.
        largest_force = limb.length / float(np.linalg.norm(posture.compliance[:3, :3], 2))
    size = one_positive("largest_force", largest_force)
    scale = size * np.array([1.0] * 3 + [limb.length] * 3)[:count]
    search = _Search(solve, measured, scale)
    search.begin(np.zeros(6), posture)
    if measured.tip is not None and unknown == "wrench":
        _from_held_tip(limb, pressures, measured.tip, known, tolerance, scene, posture, search)
    return _answer(search, search.run(), size, limb.length)


def _from_held_tip(
    limb: Limb,
    pressures: Any,
    tip: Array,
    known: Array,
    tolerance: float,
    scene: dict[str, Any],
    free: Posture,
    search: _Search,
) -> None:
    """Held where it is seen the tip needs a reaction: where the pose is exact this is the wrench at once."""
    force, moment = known[:3], known[3:]
    held = limb.solve(
        pressures, **scene, tip_force=force, tip_moment=moment, tip_pose=tip, start=free, tolerance=tolerance
    )
    if not held.success:
        return
    wrench = held.tip_reaction
    if scene.get("frame", "base") == "plate":
        wrench = np.concatenate([held.tip[:3, :3].T @ wrench[:3], held.tip[:3, :3].T @ wrench[3:]])
    _, _, right, seen = search.decompose()
    shares = right[:seen].T @ (right[:seen] @ (wrench / search.scale))
    search.try_wrench(search.scale * shares, held)


class _Search:
    """Gauss-Newton with Levenberg's damping on the wrench in units of what counts as large."""

    def __init__(self, solve: Any, measured: _Measured, scale: Array) -> None:
        self._solve, self._measured, self.scale = solve, measured, scale
        self.steps, self.effort = 0, 0

    def begin(self, wrench: Array, posture: Posture) -> None:
        self.wrench, self.posture = wrench, posture
        self.residual = self._measured.residual(posture)
        self.whitened = self._measured.whiten @ self.residual
        self.error = float(self.whitened @ self.whitened)

    def try_wrench(self, wrench: Array, near: Posture) -> bool:
        """Takes a wrench over where it has a stable posture that explains the measurement better."""
        found = self._solve(wrench, near)
        self.effort += found.iterations
        if not found.success or not found.stable:
            return False
        before = self.wrench, self.posture, self.residual, self.whitened, self.error
        self.begin(wrench, found)
        if self.error < before[4]:
            self.steps += 1
            return True
        self.wrench, self.posture, self.residual, self.whitened, self.error = before
        return False

    def decompose(self) -> tuple[Array, Array, Array, int]:
        """Singular values and vectors of the whitened, scaled slope, and how many directions are seen."""
        count = len(self.scale)
        slope = self._measured.slope(self.posture, self.residual)[:, :count] * self.scale
        left, values, right = np.linalg.svd(self._measured.whiten @ slope, full_matrices=len(slope) < count)
        values = np.concatenate([values, np.zeros(count - len(values))])
        seen = int(np.count_nonzero((values >= 1.0) & (values > _NUMERICAL_RANK * values[0])))
        return left, values, right, seen

    def run(self) -> str:
        """Goes on until there is no gain; the status."""
        damping = 0.0
        while self.steps < _MOST_STEPS:
            left, values, right, seen = self.decompose()
            along = left[:, :seen].T @ self.whitened
            unit = max(1.0, np.sqrt(self.error))
            # What a full step would change the whitened residual by.
            if np.linalg.norm(along) <= _SMALL_STEP * unit:
                return "converged"
            at_once = True
            while True:
                amount = -along * values[:seen] / (values[:seen] ** 2 + damping)
                change = np.zeros(6)
                change[: len(self.scale)] = self.scale * (right[:seen].T @ amount)
                if self.try_wrench(self.wrench + self._shortened(change), self.posture):
                    # Less damping has just failed where it was tried: a failure costs hundreds of steps that gain.
                    if at_once:
                        damping = 0.1 * damping if damping > 1e-6 * values[0] ** 2 else 0.0
                    break
                at_once = False
                if np.linalg.norm(along) <= _NO_GAIN * unit:
                    # No gain by a step so small: what is left is the rounding of the postures.
                    return "converged"
                if np.linalg.norm(values[:seen] * amount) <= _NO_GAIN * unit:
                    return "no_progress"
                if self.effort > _MOST_EFFORT:
                    return "max_iterations"
                damping = max(10.0 * damping, 1e-3 * values[0] ** 2)
        return "max_iterations"

    def _shortened(self, change: Array) -> Array:
        """The change of the wrench, as far as the linear response may be followed."""
        move = self.posture.compliance @ change
        length = self.posture.limb.length
        distance, angle = float(np.linalg.norm(move[:3])), float(np.linalg.norm(move[3:]))
        shortened: Array = change / max(distance / (_FARTHEST_MOVE * length), angle / _LARGEST_TURN, 1.0)
        return shortened

    def left(self) -> str:
        """How far the posture is from what was measured, in words."""
        parts, points = [], self.residual
        if self._measured.tip is not None:
            distance, angle = (np.linalg.norm(part) for part in (points[:3], points[3:6]))
            parts.append(f"the tip {distance / mm:.4g} mm and {angle / deg:.4g} deg from its measured pose")
            points = points[6:]
        if len(points):
            farthest = np.linalg.norm(points.reshape(-1, 3), axis=1).max()
            parts.append(f"points up to {farthest / mm:.4g} mm from where they were measured")
        return " and ".join(parts)


_CAUSES = {
    "max_iterations": "the effort ran out before a wrench was found that explains the measurement",
    "no_progress": "no further step leads to a stable posture that explains the measurement better",
}


def _answer(search: _Search, status: str, size: float, length: float) -> Sensed:
    _, values, right, seen = search.decompose()
    count = len(search.scale)
    spread = np.zeros((6, seen))
    spread[:count] = search.scale[:, None] * right[:seen].T / values[:seen]
    unseen = np.zeros((count - seen, 6))
    unseen[:, :count] = right[seen:] * np.array([1.0] * 3 + [length] * 3)[:count]
    if status != "converged":
        message = f"not converged: {_CAUSES[status]}; the best stable posture found has {search.left()}"
    elif len(unseen):
        message = f"converged; not seen: {'; '.join(signed_parts(row, _LABELS) for row in unseen)}"
    else:
        message = "converged"
    return Sensed(
        wrench=search.wrench,
        covariance=spread @ spread.T,
        unseen=unseen,
        singular_values=values,
        largest_force=size,
        posture=search.posture,
        residual=search.residual,
        chi_square=search.error,
        degrees_of_freedom=len(search.residual) - seen,
        status=status,
        message=message,
        iterations=search.steps,
    )


def _measurement(
    tip_pose: ArrayLike | None,
    covariance: ArrayLike | None,
    points: ArrayLike | None,
    at: ArrayLike | None,
    points_covariance: ArrayLike | None,
) -> _Measured:
    if tip_pose is None and points is None:
        raise ValueError("nothing was measured: give tip_pose, or points and where they are (at), or both")
    for name, given, needed, value in (
        ("covariance", covariance, "tip_pose", tip_pose),
        ("at", at, "points", points),
        ("points_covariance", points_covariance, "points", points),
    ):
        if (given is None) != (value is None):
            raise ValueError(f"{needed} and {name} belong together: give both or neither")
    blocks, tip, places, shares = [], None, None, None
    if tip_pose is not None and covariance is not None:
        tip = finite_of_shape("tip_pose", tip_pose, (4, 4))
        _require_pose("tip_pose", tip)
        blocks.append(_whitening("covariance", finite_of_shape("covariance", covariance, (6, 6))))
    if points is not None and at is not None and points_covariance is not None:
        shares = real_array("at", at)
        if shares.ndim != 1 or not shares.size or not ((shares >= 0.0) & (shares <= 1.0)).all():
            raise ValueError(f"at must be shares of the centreline, within 0 and 1, got {shares.tolist()}")
        places = finite_of_shape("points", points, (len(shares), 3))
        blocks += _of_points(real_array("points_covariance", points_covariance), len(shares))
    whiten = np.zeros((sum(map(len, blocks)),) * 2)
    first = 0
    for block in blocks:
        last = first + len(block)
        whiten[first:last, first:last] = block
        first = last
    return _Measured(tip, places, shares, whiten)


def _of_points(covariance: Array, count: int) -> list[Array]:
    name, shape = "points_covariance", covariance.shape
    if shape not in ((3, 3), (count, 3, 3), (3 * count, 3 * count)):
        raise ValueError(
            f"{name} has shape {shape}: expected (3, 3) for every point, ({count}, 3, 3), or ({3 * count}, {3 * count})"
        )
    if shape == (3 * count, 3 * count):
        return [_whitening(name, covariance)]
    if shape == (3, 3):
        return [_whitening(name, covariance)] * count
    return [_whitening(f"{name}[{k}]", one) for k, one in enumerate(covariance)]


def _whitening(name: str, covariance: Array) -> Array:
    """The inverse of Cholesky's factor."""
    if not np.isfinite(covariance).all():
        raise ValueError(f"{name} must be finite, got {covariance.tolist()}")
    largest = np.abs(covariance).max()
    if not np.allclose(covariance, covariance.T, rtol=0.0, atol=1e-9 * largest):
        raise ValueError(f"{name} must be symmetric, got {covariance.tolist()}")
    # Metres and radians differ: positive definite is judged in units of the standard deviations.
    deviations = np.sqrt(np.abs(np.diagonal(covariance)))
    with np.errstate(divide="ignore", invalid="ignore"):
        correlation = covariance / deviations[:, None] / deviations
    lowest = np.linalg.eigvalsh(correlation)[0] if np.isfinite(correlation).all() else 0.0
    if not lowest > 1e-12 or not (np.diagonal(covariance) > 0.0).all():
        raise ValueError(
            f"{name} must be positive definite, got variances {np.diagonal(covariance).tolist()} and a smallest "
            f"eigenvalue of the correlations of {lowest:.3g}"
        )
    inverse: Array = np.linalg.inv(np.linalg.cholesky(0.5 * (covariance + covariance.T)))
    return inverse
