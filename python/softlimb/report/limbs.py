"""A limb under pressures and loads, of one rod or of many: where its tip is, from nothing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from softlimb.bench import checks, others
from softlimb.bench.methods import collocation, constant_curvature, least_squares, multiple_shooting, single_shooting
from softlimb.limb import Limb
from softlimb.paper.problem import Answer, Problem
from softlimb.posture import Posture
from softlimb.report.methods import (
    CONSTANT_CURVATURE,
    LEAST_SQUARES,
    OURS,
    PAPER,
    PAPER_CONSTANTS,
    QUICK_STEPS,
    SHOOTING,
    SOLVE_BVP,
    STEPS,
    Array,
    Method,
    NoAnswer,
    Prepared,
    Reference,
    Setting,
    power,
)

__all__ = ["LimbScene"]

_FINEST = (1e-12, 1e-11, 1e-10)
"""Tolerances of the reference; the first at which the package succeeds."""
_FEWEST_PIECES = 8
"""Pieces of a rod of the second method."""
_SAME = 1e-2
"""Distance of tips, over the limb's length, within which they belong to one equilibrium: coarse steps err by less."""


@dataclass(frozen=True)
class LimbScene:
    """A limb, and the arguments of `Limb.solve`."""

    name: str
    what: str
    limb: Callable[[], Limb]
    options: dict[str, Any]

    def prepare(self, quick: bool) -> Prepared:
        """As `report.methods.Scene` says."""
        limb = self.limb()
        posture = _finest(limb, self.options)
        # Pieces in which nothing grows by much more than e: then steps, not growth, limit the second method.
        pieces = max(_FEWEST_PIECES, round(_growth(posture)))
        refined = multiple_shooting.refine(posture, pieces, levels=3 if quick else 4)
        if not refined.converged:
            raise NoAnswer("no second method confirms the posture")
        reference = Reference(
            (posture.tip[:3, 3], refined.tip),
            (
                f"softlimb at a tolerance of {posture.tolerance:g}",
                f"multiple shooting, RK4 of up to {refined.steps} steps a rod, extrapolated (numpy)",
            ),
            limb.length,
        )
        methods = [_ours(limb, self.options, quick), *_others(limb, self.options, posture, quick)]
        return Prepared(reference, methods, _remarks(posture))


def _finest(limb: Limb, options: dict[str, Any]) -> Posture:
    fault: str | None = None
    for tolerance in _FINEST:
        posture = limb.solve(**options, tolerance=tolerance)
        fault = checks.posture_fault(posture)
        if fault is None:
            return posture
    raise NoAnswer(f"at a tolerance of {_FINEST[-1]:g}: {fault}")


def _growth(posture: Posture) -> float:
    """Exponent by which a disturbance of a rod's base grows along it, at most: what single shooting has to bear."""
    return max(
        float(rod.length * np.sqrt(np.linalg.norm(rod.base_wrench[:3]) / rod.section.bending))
        for row in posture.rods
        for rod in row
    )


def _remarks(posture: Posture) -> list[str]:
    check = posture.verify()
    tilt = np.degrees(np.arccos(np.clip(posture.tip[2, 2], -1.0, 1.0)))
    facts = f"The tip is tilted by {tilt:.0f} deg, disturbances grow along a rod by up to e^{_growth(posture):.1f}."
    third = f"An integration by a third code finds errors up to {check.largest_error:.0e} in the reference posture."
    return [facts, third, *(f"{warning[:1].upper()}{warning[1:]}." for warning in posture.warnings)]


def _ours(limb: Limb, options: dict[str, Any], quick: bool) -> Method:
    def run(tolerance: float, _: float) -> Posture:
        return limb.solve(**options, tolerance=tolerance)

    def tip(posture: Posture) -> Array:
        fault = checks.posture_fault(posture)
        if fault is not None:
            raise NoAnswer(fault)
        at: Array = posture.tip[:3, 3]
        return at

    tolerances = (1e-4, 1e-6, 1e-10) if quick else (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
    return Method(OURS, [Setting(f"tolerance {power(t)}", power(t), partial(run, t), tip, asked=t) for t in tolerances])


def _others(limb: Limb, options: dict[str, Any], posture: Posture, quick: bool) -> list[Method]:
    problem = Problem.of(posture)
    where = partial(_where, posture)

    def shoot(steps: int, limit: float) -> Answer:
        return single_shooting.solve(problem, limit, steps)

    def collocate(tolerance: float, limit: float) -> Answer:
        return collocation.solve(problem, limit, tolerance)

    def squares(steps: int, limit: float) -> Answer:
        return least_squares.solve(problem, limit, steps)

    steps = QUICK_STEPS if quick else STEPS
    shots = [_stepped(count, partial(shoot, count)) for count in steps]
    collocated = [
        Setting(f"tolerance {power(t)}", power(t), partial(collocate, t), _tip)
        for t in ((1e-3,) if quick else (1e-3, 1e-6))
    ]
    squared = [_stepped(count, partial(squares, count)) for count in ((10,) if quick else (10, 40))]
    found = Setting("", "", partial(others.by_paper, posture), partial(_tip_at_lengths, posture))
    return [
        Method(SHOOTING, shots, where=where),
        Method(SOLVE_BVP, collocated, needs="scipy.integrate", where=where),
        Method(LEAST_SQUARES, squared, needs="scipy.optimize", where=where),
        Method(PAPER, [found]),
        _by_constants(limb, options, posture),
        _by_arcs(problem),
    ]


def _stepped(steps: int, run: Callable[[float], Answer]) -> Setting:
    return Setting(f"{steps} steps", str(steps), run, _tip)


def _by_constants(limb: Limb, options: dict[str, Any], posture: Posture) -> Method:
    if not all(segment.actuators for segment in limb):
        return Method(PAPER_CONSTANTS, unable="rods without pressure: the constants are those of tubes")
    plain = limb.solve(**options, section="paper")
    if not plain.success:
        return Method(PAPER_CONSTANTS, unable=f"no posture with its constants: {plain.message}")
    loads = {name: value for name, value in options.items() if name != "pressures"}

    def tip(answer: Answer) -> Array:
        _require(answer)
        # The lengths that it asks for, made by tubes that are as stiff as they are.
        there = limb.solve(rest_lengths=np.abs(answer.lengths), start=answer.plates, **loads)
        if not there.success:
            raise NoAnswer(f"no posture at its lengths: {there.message}")
        # It is asked for the pose that its constants predict at the scene's pressures (another one would in general be
        # out of its reach), so what it misses that pose by is its error.
        at: Array = posture.tip[:3, 3] + (there.tip[:3, 3] - plain.tip[:3, 3])
        return at

    return Method(PAPER_CONSTANTS, [Setting("", "", partial(others.by_paper, plain), tip)])


def _by_arcs(problem: Problem) -> Method:
    if constant_curvature.solve(problem).converged:
        return Method(CONSTANT_CURVATURE, [Setting("", "", lambda _: constant_curvature.solve(problem), _tip)])
    return Method(CONSTANT_CURVATURE, unable="needs rods that stand parallel on both plates")


def _require(answer: Answer) -> None:
    if not answer.converged:
        raise NoAnswer(answer.outcome)


def _tip(answer: Answer) -> Array:
    _require(answer)
    at: Array = answer.plates[-1, :3, 3]
    return at


def _tip_at_lengths(posture: Posture, answer: Answer) -> Array:
    """Where a limb of the lengths that were found has its tip: the answer's own plates are where they should be."""
    _require(answer)
    there = others.at_lengths(posture, answer)
    if not there.success:
        raise NoAnswer(f"no posture at its lengths: {there.message}")
    at: Array = there.tip[:3, 3]
    return at


def _where(posture: Posture, answer: Answer) -> str:
    there = others.at_lengths(posture, answer)
    off = np.linalg.norm(there.tip[:3, 3] - answer.plates[-1, :3, 3]) / posture.limb.length
    if not (there.success and off <= _SAME):
        return "no equilibrium there"
    return "another equilibrium, stable too" if there.stable else "another equilibrium, unstable"
