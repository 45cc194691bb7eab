"""What is wrong with an answer, asked before anything is timed: a text, or None where nothing is."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softlimb.limb import Limb
from softlimb.posture import Posture
from softlimb.sweep import Batch
from softlimb.tube import Tube, TubeState

__all__ = [
    "batch_fault",
    "distance_fault",
    "first",
    "jacobian_fault",
    "posture_fault",
    "same_bits_fault",
    "section_fault",
    "state_fault",
]

Array = NDArray[np.float64]

# The tolerance bounds the estimated error of a tip; two answers may be off to both sides, and estimates by a factor.
_MARGIN = 10.0


def first(faults: Iterable[str | None]) -> str | None:
    """The first fault of several, if any."""
    return next((fault for fault in faults if fault is not None), None)


def distance_fault(found: Array, true: Array, within: float, what: str = "the tip") -> str | None:
    """Two points that should be one; ``within`` in their unit [m]."""
    distance = float(np.linalg.norm(found - true))
    if distance <= within:  # false where a number is missing
        return None
    return f"{what} is off by {distance:.2g} m, more than {within:.2g} m"


def posture_fault(posture: Posture, truth: Posture | None = None) -> str | None:
    """A posture that is no stable equilibrium, fails its independent re-integration, or is not the true one.

    Parameters
    ----------
    truth : Posture, optional
        The same scene solved in another way or to a finer tolerance.
    """
    if not posture.success:
        return f"no equilibrium: {posture.message}"
    if not posture.stable:
        return f"not stable: {posture.message}"
    check = posture.verify()
    if not check.success:
        return f"verification finds an error of {check.largest_error:.1e} for a tolerance of {check.tolerance:.0e}"
    if truth is None:
        return None
    within = _MARGIN * posture.tolerance * posture.limb.length
    return distance_fault(posture.tip[:3, 3], truth.tip[:3, 3], within)


def state_fault(tube: Tube, state: TubeState) -> str | None:
    """States of an array of pressures that failed, do not meet their pressure, or that the inverse does not return."""
    pressures = np.asarray(state.pressure)
    if not np.all(state.success):
        return "a tube found no state"
    sample = slice(None, None, max(1, len(pressures) // 5))
    if not np.allclose(tube.pressure_for(state.stretch[sample]), pressures[sample], rtol=1e-8, atol=0.0):
        return "the stretch does not give the pressure back"
    middle = state[len(pressures) // 2]
    radial = float(middle.stress(middle.inner_radius).radial)
    if not abs(radial + middle.pressure) <= 1e-7 * middle.pressure:
        return f"the wall's stress inside is {radial:.6g} Pa at a pressure of {middle.pressure:.6g} Pa"
    return None


def section_fault(tube: Tube, pressure: float, section: Any) -> str | None:
    """A section whose stiffness is not the change of the tube's axial force with its stretch."""
    stretch = float(tube.inflate(pressure).stretch)
    step = 1e-2  # [N]: moves the stretch by 1e-5, of which rounding leaves eight digits
    more, less = (float(tube.inflate(pressure, axial_force=force).stretch) for force in (step, -step))
    axial = 2.0 * step * stretch / (more - less)  # EA is per rest length, the rest length stretched by the pressure
    if not abs(section.axial - axial) <= 1e-4 * axial:
        return f"EA is {section.axial:.6g} N, the tube's own states say {axial:.6g} N"
    return None


def jacobian_fault(posture: Posture) -> str | None:
    """A Jacobian that differences of two more solves an actuator do not confirm."""
    pressures = posture.pressures
    if pressures is None:
        return "the posture has no pressures"
    loads = {name: posture.loads[name] for name in ("gravity", "tip_force", "tip_moment")}
    step = 10.0  # [Pa]: curvature over it is below 1e-6 of the slope, a tolerance of 1e-10 below 1e-5
    jacobian = posture.jacobian
    for actuator in (0, len(pressures) - 1):
        ends = []
        for sign in (1.0, -1.0):
            moved = pressures.copy()
            moved[actuator] += sign * step
            ends.append(posture.limb.solve(moved, start=posture, tolerance=1e-10, **loads).tip[:3, 3])
        slope = (ends[0] - ends[1]) / (2.0 * step)
        if not np.allclose(jacobian[:3, actuator], slope, rtol=0.0, atol=1e-3 * np.abs(slope).max()):
            return f"column {actuator} of the Jacobian is off the differences of two solves"
    return None


def batch_fault(limb: Limb, batch: Batch, loads: dict[str, Any], sample: int = 4) -> str | None:
    """A sweep with rows that failed, or whose tips are not those of single solves (of some rows, spread evenly)."""
    if not batch.success.all():
        row, message = next(iter(batch.failures.items()))
        return f"{int((~batch.success).sum())} of {len(batch)} rows failed, row {row}: {message}"
    for row in np.linspace(0, len(batch) - 1, sample).astype(int).tolist():
        posture = limb.solve(batch.pressures[row], tolerance=1e-9, **loads)
        tolerance = 1e-6  # of a sweep that is not told otherwise
        fault = posture_fault(posture) or distance_fault(
            batch.tip[row, :3, 3], posture.tip[:3, 3], _MARGIN * tolerance * limb.length, f"the tip of row {row}"
        )
        if fault is not None:
            return fault
    return None


def same_bits_fault(one: Batch, other: Batch) -> str | None:
    """Two runs of a sweep that should agree in every bit of every array and in every text."""
    for field in dataclasses.fields(one):
        first, second = getattr(one, field.name), getattr(other, field.name)
        if isinstance(first, np.ndarray):
            if first.tobytes() != second.tobytes():
                return f"{field.name} differs"
        elif isinstance(first, Sequence) and list(first) != list(second):
            return f"{field.name} differs"
    return None
