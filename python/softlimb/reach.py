"""Which pressures put the tip where it is wanted, and what keeps it away where none do."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb import _core
from softlimb.arguments import finite_of_shape, one_finite, shown
from softlimb.limb import Limb, _flat, _require_pose, _tolerance
from softlimb.posture import Posture
from softlimb.tube import SectionModel, Tube, TubeState, Valve
from softlimb.units import deg, kPa, mm

__all__ = ["Reach", "ReachError", "bounds_of", "reach", "target_of"]

Array = NDArray[np.float64]
Bound = Literal["min", "max", "limit"]

STARTS = 16  # as ReachSettings of the core has it
_TIGHTEST = 1e-9  # the preference may leave some 1e-11 at the target
_SHORT_OF_LIMIT = 1e-3
# Of the weights over the largest. The search takes a target for met where the weighted gap is below 1e-3: with less the
# limb may be at its other end. Targets in reach were found with a tenth of it as well.
_LEAST_WEIGHT = 1e-3
_NOT_OF_A_REACH = ("pressures", "rest_lengths", "prefer_stable")
_PLAIN = {"gravity", "tip_force", "tip_moment", "frame", "section", "valve"}


_READ = (
    *("posture", "pressures", "reached", "target", "weights", "gap", "min_pressures", "max_pressures"),
    *("least", "status", "iterations", "starts", "remarks"),
)


@dataclass(frozen=True)
class ReachError:
    """How far a tip is from its target; freedoms of weight zero do not count.

    Parameters
    ----------
    position : float
        Distance [m].
    rotation : float or None
        Angle [rad]; None where the target was a position.
    relative : float
        The distance over ``limb.length``.
    """

    position: float
    rotation: float | None
    relative: float

    def in_words(self, length: float) -> str:
        """Distance, its share of the limb's length [m] where that has digits, and angle."""
        said = distance_in_words(self.position)
        if 1e-4 <= self.relative < 10.0:  # with two decimals
            said += f" ({self.relative:.2%} of {distance_in_words(length)})"
        return said if self.rotation is None else f"{said} and {self.rotation / deg:.4g} deg"


def distance_in_words(distance: float) -> str:
    """In mm, and in m from where four digits of mm would need an exponent."""
    return f"{distance / mm:.4g} mm" if distance < 9.999 else f"{distance:.4g} m"


class Reach:
    """Pressures for a target of the tip, and the posture that they give. Made by `Limb.reach`."""

    def __init__(
        self,
        limb: Limb,
        found: _core.Reached,
        tolerance: float,
        model: tuple[SectionModel, Valve],
        loads: dict[str, Any] | None = None,
        limited: tuple[int, ...] = (),
    ) -> None:
        self._limb = limb
        self._found: _core.Reached | None = found
        self._made_with = tolerance, model, loads
        self._limited = limited

    # Read out of the core when first asked for: on a path of targets that is not for every answer.

    @property
    def _answer(self) -> _core.Reached:
        assert self._found is not None
        return self._found

    @cached_property
    def posture(self) -> Posture:
        """The whole solve at the pressures found; stable wherever one was found at all."""
        return Posture(self._limb, self._answer.posture, *self._made_with)

    @cached_property
    def reached(self) -> bool:
        """True when the posture succeeded, is stable, and its tip is within the tolerance of the target."""
        return self._answer.reached

    @cached_property
    def target(self) -> Array:
        """Pose wanted, shape (4, 4); of a target position with the base's axes."""
        return self._answer.target

    @cached_property
    def weights(self) -> Array:
        """Of the tip's errors, shape (6,), see `Limb.reach`; zero where a freedom does not count."""
        return self._answer.weights

    @cached_property
    def gap(self) -> Array:
        """Tip minus target [m], and the rotation vector from the target to the tip [rad], base axes, shape (6,)."""
        return self._answer.gap

    @cached_property
    def min_pressures(self) -> Array:
        """Lower bounds [Pa], shape (A,)."""
        return self._answer.lower

    @cached_property
    def max_pressures(self) -> Array:
        """Upper bounds [Pa], shape (A,): those asked for, or just below what an actuator carries."""
        return self._answer.upper

    @cached_property
    def least(self) -> bool:
        """True when no other pressures near these reach and are nearer to the preferred ones."""
        return self._answer.least

    @cached_property
    def status(self) -> str:
        """Outcome: converged where the target was reached.

        no_progress where no change of the pressures within their bounds comes nearer; singular_jacobian where a fold is
        in the way; else the search ended before it knew.
        """
        return self._answer.status

    @cached_property
    def iterations(self) -> int:
        """Postures that the search looked at."""
        return self._answer.iterations

    @cached_property
    def starts(self) -> int:
        """Starts from nothing; none where the given start led to the target."""
        return self._answer.starts

    @cached_property
    def remarks(self) -> tuple[str, ...]:
        """What to know besides."""
        said = [
            f"actuator {number} carries no more than {self.max_pressures[number] / kPa:.4g} kPa"
            for number in self._limited
        ]
        if self._answer.another_from_nothing:
            said.append(
                "a solve of these pressures without a start ends in another posture: give it start=reach.posture"
            )
        return tuple(said)

    @property
    def success(self) -> bool:
        """The same as ``reached``."""
        return self.reached

    @cached_property
    def pressures(self) -> Array:
        """Gauge pressure in each actuator [Pa], shape (A,)."""
        assert self.posture.pressures is not None
        return self.posture.pressures

    @cached_property
    def error(self) -> ReachError:
        """How far the tip is from the target."""
        counted = np.where(self.weights > 0.0, self.gap, 0.0)
        position = math.hypot(*counted[:3].tolist())  # squares of a far target overflow
        rotation = float(np.linalg.norm(counted[3:])) if self.weights[3:].any() else None
        return ReachError(position, rotation, position / self.posture.limb.length)

    @cached_property
    def active(self) -> dict[int, Bound]:
        """Actuators at a bound: "min", "max", or "limit" where the actuator itself carries no more."""
        bounds: dict[int, Bound] = {}
        for number, pressure in enumerate(self.pressures.tolist()):
            if pressure >= self.max_pressures[number]:
                bounds[number] = "limit" if number in self._limited else "max"
            elif pressure <= self.min_pressures[number]:
                bounds[number] = "min"
        return bounds

    @property
    def _miss(self) -> str:
        return self.error.in_words(self.posture.limb.length)

    @property
    def _refusal(self) -> str:
        """Why there is no posture; where not even the actuators have a state the core left no words."""
        if self.posture.message:
            return self.posture.message
        section, valve = self.posture._model
        return self.posture.limb.solve(self.pressures, section=section, valve=valve).message

    @property
    def _outcome(self) -> str:
        return "reached" if self.least else "reached; the preference may allow better pressures"

    @cached_property
    def message(self) -> str:
        """Outcome in words."""
        parts = []
        if self.reached:
            parts.append(self._outcome)
        else:
            if not (self.posture.success and self.posture.stable):
                parts.append(f"no stable posture was found within the bounds: {self._refusal}")
            elif self.status in ("no_progress", "singular_jacobian"):
                fold = ", and a fold is in the way" if self.status == "singular_jacobian" else ""
                parts.append(f"out of reach: the nearest stable posture found misses by {self._miss}{fold}")
            else:
                parts.append(f"not reached: the search ended at a miss of {self._miss}")
            held = [f"{number} ({bound})" for number, bound in self.active.items()]
            if held:
                parts.append(f"actuators at a bound: {', '.join(held)}")
        return "; ".join([*parts, *self.remarks])

    def __getstate__(self) -> dict[str, Any]:
        # What the search learned stays behind, and with it what has not been read.
        read = {name: getattr(self, name) for name in _READ}
        return {**self.__dict__, **read, "_found": None}

    def __repr__(self) -> str:
        values = " ".join(f"{pressure / kPa:.4g}" for pressure in self.pressures)
        outcome = "reached" if self.reached else f"missed by {distance_in_words(self.error.position)}"
        return f"Reach({outcome}, pressures {values} kPa)"


def reach(
    limb: Limb,
    *,
    position: ArrayLike | None = None,
    pose: ArrayLike | None = None,
    max_pressure: Any,
    min_pressure: Any = 0.0,
    weights: ArrayLike | None = None,
    prefer: Any = None,
    tolerance: float = 1e-6,
    start: Posture | Reach | None = None,
    starts: int = STARTS,
    **scene: Any,
) -> Reach:
    """See `Limb.reach`."""
    if starts == STARTS and weights is None and prefer is None and type(min_pressure) is float and min_pressure == 0.0:
        plain = scene.keys() <= _PLAIN and _plain(limb, position, pose, max_pressure, tolerance, start, **scene)
        # Where the core's quick way missed, an upper bound beyond what an actuator carries may be why.
        if plain and (plain.reached or np.array_equal(plain.max_pressures, bounds_of(limb, 0.0, max_pressure)[1])):
            return plain
    if not limb._tubes:
        raise ValueError("the limb has no actuators: no pressure moves its tip")
    target, counted = target_of(position, pose, weights)
    lower, upper, limited = bounds_of(limb, min_pressure, max_pressure)
    preferred = np.zeros(len(limb._tubes)) if prefer is None else _preferred(limb, prefer)
    tolerance = _tolerance(tolerance, _TIGHTEST)
    if start is not None and not isinstance(start, Posture | Reach):
        raise TypeError(f"start must be a Posture or a Reach, got {type(start).__name__}")
    if not isinstance(starts, int) or isinstance(starts, bool) or not (start is None) <= starts <= STARTS:
        rule = f"a whole number up to {STARTS}, and at least 1 where no start is given"
        raise ValueError(f"starts must be {rule}, got {shown(starts)}")
    learned = start._found if isinstance(start, Reach) else None
    first = start.posture if isinstance(start, Reach) else start
    if first is not None:
        limb._start(first)
        if first.pressures is None:
            raise ValueError("start must be a posture that was solved from pressures")
    for name in _NOT_OF_A_REACH:
        if name in scene:
            raise TypeError(f"{name} does not apply to a reach: it finds pressures of stable postures")
    core, model, loads = _loads(limb, first, **scene)
    found = _core.reach(
        limb._geometry,
        limb._core_members,
        core,
        target=target,
        weights=counted / counted.max(),  # a common factor means nothing
        lower=lower,
        upper=upper,
        preferred=preferred,
        tolerance=tolerance,
        section=model[0],
        valve=model[1],
        start=None if first is None else first._solved,
        start_pressures=None if first is None else first._solved_pressures,
        learned=learned,
        starts=starts,
    )
    answer = Reach(limb, found, tolerance, model, loads, limited)
    answer.weights = counted
    return answer


def _plain(
    limb: Limb,
    position: Any,
    pose: Any,
    max_pressure: Any,
    tolerance: Any,
    start: Any,
    *,
    gravity: Any = (0.0, 0.0, 0.0),
    tip_force: Any = (0.0, 0.0, 0.0),
    tip_moment: Any = (0.0, 0.0, 0.0),
    frame: Any = "base",
    section: Any = "tangent",
    valve: Any = "open",
) -> Reach | None:
    """Plain numbers, which the core reads as they are, for paths of targets. None where it cannot."""
    scene = limb._plain.loads(gravity, tip_force, tip_moment, frame)
    if scene is None:
        return None
    if type(start) is Reach and start._found is not None:
        start = start._found
    elif type(start) is Posture:
        start = start._solved
    found = _core.plain_reach(
        limb._geometry, limb._core_members, scene, position, pose, max_pressure, tolerance, section, valve, start
    )
    return None if found is None else Reach(limb, found, tolerance, (section, valve))


def target_of(position: ArrayLike | None, pose: ArrayLike | None, weights: ArrayLike | None) -> tuple[Array, Array]:
    """Pose and six weights of what was asked for."""
    if (position is None) == (pose is None):
        raise ValueError("a reach needs either position or pose: give exactly one of the two")
    target, counted, freedoms = np.eye(4), np.zeros(6), 3
    if pose is None:
        target[:3, 3] = finite_of_shape("position", position, (3,))  # type: ignore[arg-type]
    else:
        target, freedoms = finite_of_shape("pose", pose, (4, 4)), 6
        _require_pose("pose", target)
    given = np.ones(freedoms) if weights is None else finite_of_shape("weights", weights, (freedoms,))
    if (given < 0.0).any() or not given.any():
        raise ValueError(f"weights must not be negative, and not all zero, got {given.tolist()}")
    if (given[given > 0.0] < _LEAST_WEIGHT * given.max()).any():
        rule = f"zero, or at least {_LEAST_WEIGHT:g} of the largest"
        raise ValueError(f"weights must each be {rule}, got {given.tolist()}")
    counted[:freedoms] = given
    return target, counted


def _per_actuator(limb: Limb, name: str, value: Any) -> Array:
    """One number for all actuators, or one each."""
    if np.ndim(value) == 0:
        return np.full(len(limb._tubes), one_finite(name, value))
    return _flat(name, value, limb._counts, "actuators")


@lru_cache(maxsize=64)
def _state_at(tube: Tube, pressure: float) -> TubeState:
    """Kept: the targets of a path share their bounds."""
    return tube.inflate(pressure)


def bounds_of(limb: Limb, lowest: Any, highest: Any) -> tuple[Array, Array, tuple[int, ...]]:
    """Bounds of the pressures, and the actuators that carry less than was allowed.

    Raises
    ------
    ValueError
        Not finite, of a wrong shape, reversed, a lower bound at which an actuator has ballooned, or an upper one at
        which it has no stable state and none is known to it below.
    """
    lower, upper = _per_actuator(limb, "min_pressure", lowest), _per_actuator(limb, "max_pressure", highest)
    reversed_ = np.flatnonzero(lower > upper)
    if reversed_.size:
        number = int(reversed_[0])
        raise ValueError(
            f"min_pressure must not exceed max_pressure, got {lower[number]:.6g} and {upper[number]:.6g} Pa "
            f"for actuator {number}"
        )
    limited = []
    for number, tube in enumerate(limb._tubes):
        limit = tube.limit_pressure
        if limit is None:
            state = _state_at(tube, float(upper[number]))
            if state.success and state.stable:
                continue
            # Where the fibres carry the wall, only the search at that pressure finds where it balloons.
            limit = state.limit_pressure
            if not limit > 0.0:
                raise ValueError(
                    f"max_pressure must be one that the actuators carry, got {upper[number]:.6g} Pa for actuator "
                    f"{number}: {state.message}"
                )
        if upper[number] < limit:
            continue
        # At the limit itself the stiffness is gone.
        upper[number] = (1.0 - _SHORT_OF_LIMIT) * limit
        limited.append(number)
        if lower[number] > upper[number]:
            raise ValueError(
                f"min_pressure must be below what the actuator carries, got {lower[number]:.6g} Pa for actuator "
                f"{number}, which loses stability at {limit:.6g} Pa"
            )
    return lower, upper, tuple(limited)


def _preferred(limb: Limb, prefer: Any) -> Array:
    if isinstance(prefer, Posture | Reach):
        posture = prefer.posture if isinstance(prefer, Reach) else prefer
        pressures = posture._solved_pressures
        if pressures is None or len(pressures) != len(limb._tubes):
            raise ValueError("prefer must be a posture of this limb that was solved from pressures")
        return pressures
    return _per_actuator(limb, "prefer", prefer)


def _loads(
    limb: Limb, start: Posture | None, **scene: Any
) -> tuple[_core.Scene, tuple[SectionModel, Valve], dict[str, Any] | None]:
    """Loads and holds as the core wants them, the tubes' model, and what a posture cannot read out of the core."""
    allowed = [name for name in limb._scene.__kwdefaults__ or {} if name not in _NOT_OF_A_REACH]
    for name in scene:
        if name not in allowed:
            raise TypeError(f"{name!r} is no load of a reach: expected one of {', '.join(allowed)}")
    made = limb._scene(None if start is None else start._solved, None, pressures=np.zeros(len(limb._tubes)), **scene)
    return made.core, made.model, {"loads": made.loads}
