"""The largest tip force that a limb carries, and what limits it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb.arguments import finite_of_shape, one_of, one_positive, one_whole
from softlimb.limb import Limb
from softlimb.path import Path
from softlimb.posture import Posture

__all__ = ["Payload", "PayloadRose", "payload", "payload_in_few_steps", "payload_rose"]

Array = NDArray[np.float64]
Plane = Literal["xy", "xz", "yz"]
Limit = Literal["fold", "bifurcation", "deflection", "pressure", "force", "lost"]

_NEAR_LIMIT = 1e-6  # of the deflection allowed, where the tip itself is known better than that
_NEAR_EVENT = 1e-4  # of the force at which stability ends

_LIMITS: dict[Limit, str] = {
    "fold": "beyond it no posture is near: the limb snaps",
    "bifurcation": "beyond it the posture is unstable: the limb buckles",
    "deflection": "the tip has moved as far as allowed",
    "pressure": "from there no small change of the pressures within their limit keeps the tip in place",
    "force": "the search ended here: the limb carries more",
    "lost": "the path of postures was lost here: the limb may carry more",
}


@dataclass(frozen=True)
class Payload:
    """What a limb carries at its tip.

    Parameters
    ----------
    force : float
        The largest force in the direction asked for [N]; with the tip kept in place to 1e-4 of it.
    limit : {"fold", "bifurcation", "deflection", "pressure", "force", "lost"}
        What keeps it from being larger.
    posture : Posture
        At that force.
    unloaded : Posture
        Without it.
    """

    force: float
    limit: Limit
    posture: Posture
    unloaded: Posture

    @property
    def message(self) -> str:
        """The limit in words."""
        return f"{self.force:.4g} N; {_LIMITS[self.limit]}"

    @property
    def deflection(self) -> float:
        """Distance of the tip from where it is without the force [m]."""
        return _distance(self.posture, self.unloaded)


@dataclass(frozen=True, eq=False)
class PayloadRose:
    """Payloads by direction in a plane.

    Parameters
    ----------
    plane : {"xy", "xz", "yz"}
        Axes of the base frame.
    angles : array of float, shape (D,)
        Of the forces, from the plane's first axis towards its second [rad].
    payloads : tuple of Payload, length D
    """

    plane: Plane
    angles: Array
    payloads: tuple[Payload, ...]

    @property
    def forces(self) -> Array:
        """[N], shape (D,)."""
        return np.array([found.force for found in self.payloads])

    @property
    def directions(self) -> Array:
        """Unit vectors, base axes, shape (D, 3)."""
        return _in_plane(self.plane, self.angles)

    @property
    def weakest(self) -> Payload:
        """The smallest of the payloads."""
        return self.payloads[int(np.argmin(self.forces))]


def payload_rose(limb: Limb, plane: Plane = "xz", *, count: int = 24, **options: Any) -> PayloadRose:
    """What a limb carries at its tip in evenly spread directions of a plane.

    Parameters
    ----------
    limb : Limb
    plane : {"xy", "xz", "yz"}
        Through the tip, axes of the base frame.
    count : int
        Directions.
    **options
        Limits and scene as for `Limb.payload`.

    Returns
    -------
    PayloadRose

    Raises
    ------
    ValueError
        The plane is none of the three, fewer than 3 directions, or as for `Limb.payload`.
    RuntimeError
        The limb has no stable posture without the force.
    """
    one_of("plane", plane, ("xy", "xz", "yz"))
    angles = 2.0 * np.pi * np.arange(one_whole("count", count, 3)) / count
    return PayloadRose(plane, angles, tuple(payload(limb, along, **options) for along in _in_plane(plane, angles)))


def _in_plane(plane: Plane, angles: Array) -> Array:
    axes = np.eye(3)[["xyz".index(name) for name in plane]]
    return np.stack([np.cos(angles), np.sin(angles)], axis=1) @ axes


def payload(
    limb: Limb,
    direction: ArrayLike,
    *,
    max_force: float | None = None,
    max_deflection: float | None = None,
    max_pressure: float | None = None,
    tolerance: float = 1e-6,
    **scene: Any,
) -> Payload:
    """See `Limb.payload`.

    Raises
    ------
    RuntimeError
        The limb has no stable posture without the force.
    """
    along = _unit(direction)
    if max_pressure is not None and max_deflection is not None:
        raise ValueError("give either max_pressure (the tip stays) or max_deflection (the tip moves), got both")
    if "start" in scene or "prefer_stable" in scene:
        raise TypeError("start and prefer_stable do not apply: a payload starts from the stable unloaded posture")
    base = finite_of_shape("tip_force", scene.pop("tip_force", (0.0, 0.0, 0.0)), (3,))
    unloaded = limb.solve(**scene, tip_force=base, tolerance=tolerance)
    if not unloaded.success or not unloaded.stable:
        raise RuntimeError(f"the limb has no stable posture without the force: {unloaded.message}")
    largest = one_positive("max_force", _default_force(unloaded) if max_force is None else max_force)
    if max_pressure is not None:
        limit = one_positive("max_pressure", max_pressure)
        return _with_tip_in_place(limb, unloaded, base, along, largest, limit, tolerance, scene)

    allowed = None if max_deflection is None else one_positive("max_deflection", max_deflection)

    def loads(force: float) -> dict[str, Any]:
        return {"tip_force": base + force * along}

    # Stretch by stretch, from what bends the limb a little to the end of the search: the steps of a path are in units
    # of its range.
    reached, posture = 0.0, unloaded
    stop = min(0.1 * _bending_force(unloaded), largest)
    while True:
        path = limb.follow(loads, reached, stop, posture=posture, tolerance=tolerance, through_events=False, **scene)
        if allowed is not None:
            bracket = _first_beyond(path, unloaded, allowed)
            if bracket is not None:
                before, low, high = bracket

                def at(force: float, start: Posture = before) -> Posture:
                    return limb.solve(**scene, **loads(force), start=start, tolerance=tolerance)

                force, posture = _crossing(at, lambda p: _distance(p, unloaded) - allowed, low, high)
                return Payload(force, "deflection", posture, unloaded)
        unstable = next((k for k, each in enumerate(path.postures) if not each.stable), len(path))
        if path.events and path.events[0].after < unstable:
            event = path.events[0]
            return Payload(event.parameter, event.kind, event.posture, unloaded)
        if unstable < len(path):
            # Two modes of a symmetric limb lose their stiffness at once: a path may pass there without an event.
            low, high = (float(path.parameters[k]) for k in (unstable - 1, unstable))

            def along_path(force: float, start: Posture = path.postures[unstable - 1]) -> Posture:
                return limb.solve(**scene, **loads(force), start=start, prefer_stable=False, tolerance=tolerance)

            force, posture = _crossing(along_path, lambda p: -1.0 if p.stable else 1.0, low, high)
            return Payload(force, "bifurcation", posture, unloaded)
        if len(path):
            reached, posture = float(path.parameters[-1]), path.postures[-1]
        if path.end != "stop" or stop == largest:
            return Payload(reached, "force" if path.end == "stop" else "lost", posture, unloaded)
        stop = min(4.0 * stop, largest)


def payload_in_few_steps(
    unloaded: Posture,
    direction: ArrayLike,
    *,
    max_deflection: float,
    max_force: float | None = None,
) -> Payload:
    """As `Limb.payload` to a deflection, for many limbs: Newton steps of the force, not a path.

    A step of the force goes where the compliance says that the tip is at its limit, and counts where the tip ends
    within half a step of the prediction; else it is halved. Stability lost and won back within a step is passed over,
    and so is a fold whose other side is that near. Three or four solves where the deflection is the limit.

    Parameters
    ----------
    unloaded : Posture
        Without the force; its loads stay, and so do tolerance and section.
    direction : array_like, shape (3,)
        Of the force, base axes; its length does not matter.
    max_deflection : float
        Largest distance of the tip from where it is without the force [m].
    max_force : float, optional
        As for `Limb.payload`.

    Returns
    -------
    Payload
        Where the deflection limits the force, it is met to the tolerance of the posture (of the limb's length, 1e-6 of
        the deflection at best); where stability does, the force is found to 1e-4 of itself.

    Raises
    ------
    ValueError
        The direction is zero, or a limit is not positive.
    RuntimeError
        The posture is no stable equilibrium.
    """
    along = _unit(direction)
    allowed = one_positive("max_deflection", max_deflection)
    if not unloaded.success or not unloaded.stable:
        raise RuntimeError(f"the limb has no stable posture without the force: {unloaded.message}")
    largest = one_positive("max_force", _default_force(unloaded) if max_force is None else max_force)
    limb, loads, (section, valve) = unloaded.limb, unloaded.loads, unloaded._model
    common: dict[str, Any] = {name: value for name, value in loads.items() if name != "tip_force"}
    common |= {"section": section, "valve": valve, "tolerance": unloaded.tolerance, "prefer_stable": False}
    if not any(common[name].any() for name in ("plate_wrenches", "rod_forces", "rod_moments")):
        # Without these a call goes the short way.
        common = {k: v for k, v in common.items() if k not in ("plate_wrenches", "rod_forces", "rod_moments")}
    given: dict[str, Any] = {"pressures": unloaded.pressures} if unloaded.pressures is not None else {}
    if unloaded.pressures is None and limb._tubes:
        given = {"rest_lengths": unloaded.rest_lengths}

    def at(force: float, start: Posture) -> Posture:
        return limb.solve(**given, **common, tip_force=loads["tip_force"] + force * along, start=start)

    force, posture = 0.0, unloaded
    passed = [(force, posture)]
    near = max(_NEAR_LIMIT * allowed, unloaded.tolerance * limb.length)
    while True:
        moved = posture.tip[:3, 3] - unloaded.tip[:3, 3]
        distance = float(np.linalg.norm(moved))
        done = abs(distance - allowed) <= near
        if (done or force >= largest) and (len(passed) == 1 or _stands(posture)):
            return Payload(force, "deflection" if done else "force", posture, unloaded)
        if done or force >= largest or not posture.stable:
            stands = [each for each in passed if each[0] < force and _stands(each[1])]
            falls = [each for each in passed if not stands or each[0] > stands[-1][0]]
            return _where_stability_ends(at, unloaded, along, stands[-1] if stands else passed[0], falls[0])
        rate = posture.compliance[:3, :3] @ along
        growth = float(np.linalg.norm(rate) if distance == 0.0 else moved @ rate / distance)
        step = (allowed - distance) / growth if growth > 0.0 else np.inf
        # Where the tip moves across, its distance grows by the square of the force: no step moves it beyond the limit.
        step = min(step, allowed / float(np.linalg.norm(rate)), largest - force)
        while True:
            found = at(force + step, posture)
            off = found.tip[:3, 3] - posture.tip[:3, 3] - step * rate
            if found.success and np.linalg.norm(off) <= 0.5 * np.linalg.norm(step * rate) + near:
                break
            if abs(step) <= _NEAR_EVENT * (force + abs(step)):
                return Payload(force, "fold", posture, unloaded)
            step *= 0.5
        force, posture = force + step, found
        passed.append((force, posture))


def _stands(posture: Posture) -> bool:
    """Stable, and not by a margin: modes are counted with one for rounding, which the smallest stiffness needs not."""
    return posture.success and posture.stable and posture.smallest_stiffness > 0.0


def _where_stability_ends(
    at: Callable[[float, Posture], Posture],
    unloaded: Posture,
    along: Array,
    stands: tuple[float, Posture],
    falls: tuple[float, Posture],
) -> Payload:
    """Between a force that is carried and one that is not: false position on the smallest stiffness, or halving."""
    (low, posture), (high, other) = stands, falls
    below = posture.smallest_stiffness
    above = other.smallest_stiffness if other.success else np.nan
    while high - low > _NEAR_EVENT * high:
        share = below / (below - above) if above < 0.0 else 0.5
        # A tenth at least from each end: the smallest stiffness need not be straight.
        middle = low + min(max(share, 0.1), 0.9) * (high - low)
        found = at(middle, posture)
        if _stands(found):
            low, posture, below = middle, found, found.smallest_stiffness
        else:
            high, above = middle, found.smallest_stiffness if found.success else np.nan
    mode = posture.mode_shape[-1, :3]
    # The force does work on the mode that gives way: the path turns. Else another path crosses it.
    works = abs(mode @ along) > 1e-3 * np.linalg.norm(mode)
    return Payload(low, "fold" if works else "bifurcation", posture, unloaded)


def _unit(direction: ArrayLike) -> Array:
    along = finite_of_shape("direction", direction, (3,))
    length = float(np.linalg.norm(along))
    if length == 0.0:
        raise ValueError("direction must not be zero, got (0, 0, 0)")
    unit: Array = along / length
    return unit


def _first_beyond(path: Path, unloaded: Posture, allowed: float) -> tuple[Posture, float, float] | None:
    """The last posture of the path within a deflection, its force, and a force beyond; None where all are within."""
    event = path.events[0] if path.events else None
    for number in range(1, len(path)):
        before = path.postures[number - 1]
        beyond, force = path.postures[number], float(path.parameters[number])
        if event is not None and number == event.after + 1:
            # The path may turn in this step: its posture at the event decides.
            beyond, force = event.posture, event.parameter
        if _distance(beyond, unloaded) > allowed:
            return before, float(path.parameters[number - 1]), force
    return None


def _distance(a: Posture, b: Posture) -> float:
    return float(np.linalg.norm(a.tip[:3, 3] - b.tip[:3, 3]))


def _bending_force(posture: Posture) -> float:
    """What bends the limb's softest segment by about its length."""
    return min(sum(rod.section.bending / rod.length**2 for rod in row) for row in posture.rods)


def _default_force(posture: Posture) -> float:
    return min(sum(rod.section.axial for rod in row) for row in posture.rods)


def _crossing(
    solve: Callable[[float], Posture], excess: Callable[[Posture], float], low: float, high: float
) -> tuple[float, Posture]:
    """Where the excess, negative at ``low`` and positive at ``high``, vanishes: bisection to 1e-9 of the bracket."""
    best, posture = low, solve(low)
    width = high - low
    while high - low > 1e-9 * width:
        middle = 0.5 * (low + high)
        found = solve(middle)
        if found.success and excess(found) <= 0.0:
            low, best, posture = middle, middle, found
        else:
            high = middle
    return best, posture


def _with_tip_in_place(
    limb: Limb,
    unloaded: Posture,
    base: Array,
    along: Array,
    largest: float,
    limit: float,
    tolerance: float,
    scene: dict[str, Any],
) -> Payload:
    """Steps of the force; at each one the pressures move as little as they can to bring the tip back."""
    if unloaded.pressures is None:
        raise ValueError("max_pressure was given, but the limb was not given by pressures")
    if (unloaded.pressures < 0.0).any() or (unloaded.pressures > limit).any():
        raise ValueError(f"pressures must start within 0 and max_pressure {limit!r}, got {unloaded.pressures.tolist()}")
    others = {name: value for name, value in scene.items() if name not in ("pressures", "rest_lengths")}
    goal = unloaded.tip[:3, 3].copy()
    force, posture = 0.0, unloaded
    step = 1e-3 * largest  # of a force that would double its length any limb carries a thousandth
    growth = 1.5
    while force < largest and step > max(1e-4 * force, 1e-9 * largest):
        trial = min(force + step, largest)
        held = _brought_back(limb, posture, goal, base + trial * along, limit, tolerance, others)
        if held is None:
            step *= 0.3
            growth = 1.0  # near the limit longer steps would only fail again
            continue
        force, posture = trial, held
        step *= growth
    if force >= largest:
        return Payload(force, "force", posture, unloaded)
    assert posture.pressures is not None
    at_bound = (posture.pressures >= limit * (1.0 - 1e-6)) | (posture.pressures <= limit * 1e-6)
    return Payload(force, "pressure" if at_bound.any() else "lost", posture, unloaded)


def _brought_back(
    limb: Limb, start: Posture, goal: Array, tip_force: Array, limit: float, tolerance: float, scene: dict[str, Any]
) -> Posture | None:
    """The stable posture next to ``start`` with its tip at the goal, its pressures within bounds, or None."""
    assert start._solved_pressures is not None
    pressures, posture = start._solved_pressures.copy(), start
    near = 10.0 * tolerance * limb.length
    previous = np.inf
    for _ in range(20):
        # What is not stable next to the start is of no use: no search for another posture.
        posture = limb.solve(
            pressures, tip_force=tip_force, start=posture, tolerance=tolerance, prefer_stable=False, **scene
        )
        if not posture.success or not posture.stable:
            return None
        miss = goal - posture.tip[:3, 3]
        distance = float(np.linalg.norm(miss))
        if distance <= near:
            return posture
        if distance > 0.8 * previous:  # far from Newton's pace: the step of the force was too long
            return None
        previous = distance
        change = _least_change(posture.jacobian[:3], miss, -pressures, limit - pressures)
        if change is None:
            return None
        pressures = np.clip(pressures + change, 0.0, limit)
    return None


def _least_change(jacobian: Array, miss: Array, low: Array, high: Array) -> Array | None:
    """The smallest change within bounds that the jacobian turns into ``miss``; None where bounds leave none."""
    change = np.zeros(jacobian.shape[1])
    free = np.ones(jacobian.shape[1], dtype=bool)
    while free.any():
        rest = miss - jacobian[:, ~free] @ change[~free]
        change[free] = np.linalg.lstsq(jacobian[:, free], rest, rcond=None)[0]
        beyond = free & ((change < low) | (change > high))
        if not beyond.any():
            reached = np.linalg.norm(jacobian @ change - miss) <= 1e-6 * np.linalg.norm(miss)
            return change if reached else None
        # The worst offender goes to its bound, the others share what is left.
        excess = np.where(beyond, np.maximum(low - change, change - high), -np.inf)
        worst = int(np.argmax(excess))
        change[worst] = np.clip(change[worst], low[worst], high[worst])
        free[worst] = False
    return None
