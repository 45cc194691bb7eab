"""A tube at a pressure: how long it is, by the package and by the balance of stresses through its wall."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from softlimb.bench import checks
from softlimb.bench.methods import wall
from softlimb.paper.rods import extrapolated
from softlimb.report.methods import (
    CONSTANT_CURVATURE,
    LEAST_SQUARES,
    OURS,
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
from softlimb.tube import Tube, TubeState

__all__ = ["TubeScene"]

_HALVINGS = (10, 20, 40, 80)
"""RK4 steps a layer of the reference, extrapolated to steps of no length."""

_ROUNDING = 1e-12
"""A tube is solved to rounding, no tolerance can be asked for; near a limit point rounding grows by some decades."""


@dataclass(frozen=True)
class TubeScene:
    """A closed tube under pressure alone [Pa]."""

    name: str
    what: str
    tube: Callable[[], Tube]
    pressure: float

    def prepare(self, quick: bool) -> Prepared:
        """As `report.methods.Scene` says."""
        tube, pressure = self.tube(), self.pressure
        state = tube.inflate(pressure)
        fault = checks.state_fault(tube, tube.inflate(np.full(1, pressure)))
        if fault is not None:
            raise NoAnswer(fault)
        reference = _reference(tube, state)
        length = tube.length

        def found(answer: wall.Found) -> Array:
            if not answer.converged:
                raise NoAnswer(answer.outcome)
            return np.array([answer.stretch * length])

        def inflated(answer: TubeState) -> Array:
            if not answer.success:
                raise NoAnswer(answer.message)
            return np.array([answer.stretch * length])

        def as_it_is(answer: float) -> Array:
            return np.array([answer])

        ours = [
            Setting("inflate", "inflate", lambda _: tube.inflate(pressure), inflated, _ROUNDING),
            Setting("section, from its tables", "section", lambda _: tube.rest_length(pressure), as_it_is, _ROUNDING),
        ]
        shots = [
            Setting(f"{steps} steps a layer", str(steps), partial(_shoot, tube, pressure, steps), found)
            for steps in (QUICK_STEPS if quick else STEPS)
        ]
        squares = Setting(
            f"{wall.STEPS} steps a layer",
            str(wall.STEPS),
            lambda limit: wall.by_least_squares(tube, pressure, limit),
            found,
        )
        collocated = [
            Setting(f"tolerance {power(t)}", power(t), partial(_collocate, tube, pressure, t), found)
            for t in ((1e-3, 1e-6) if quick else (1e-3, 1e-6, 1e-9))
        ]
        reduced = Setting("eq. 3 alone", "eq. 3", lambda _: tube.inflate(pressure, model="paper_reduced"), inflated)
        methods = [
            Method(OURS, ours),
            Method(SHOOTING, shots),
            Method(SOLVE_BVP, collocated, needs="scipy.integrate"),
            Method(LEAST_SQUARES, [squares], needs="scipy.optimize"),
            Method(PAPER_CONSTANTS, [reduced]),
            Method(CONSTANT_CURVATURE, unable="takes lengths as given, knows no pressure"),
        ]
        return Prepared(reference, methods, [f"Stretch {state.stretch:.4f}.", *_sentences(state)])


def _sentences(state: TubeState) -> list[str]:
    return [f"{remark[:1].upper()}{remark[1:]}." for remark in state.warnings]


def _reference(tube: Tube, state: TubeState) -> Reference:
    shots = [wall.by_shooting(tube, state.pressure, steps) for steps in _HALVINGS]
    if not all(shot.converged for shot in shots):
        raise NoAnswer("no second method confirms the tube's length")
    stretch, _ = extrapolated([np.array([shot.stretch]) for shot in shots])
    names = (
        "energy of the wall by quadrature, Newton (softlimb)",
        f"balance of the wall's stresses, RK4 of up to {_HALVINGS[-1]} steps a layer, extrapolated (numpy)",
    )
    return Reference((np.array([state.stretch * tube.length]), stretch * tube.length), names, tube.length)


def _shoot(tube: Tube, pressure: float, steps: int, _: float) -> wall.Found:
    return wall.by_shooting(tube, pressure, steps)


def _collocate(tube: Tube, pressure: float, tolerance: float, limit: float) -> wall.Found:
    return wall.by_collocation(tube, pressure, limit, tolerance)
