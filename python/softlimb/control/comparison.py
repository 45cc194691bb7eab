"""Controllers side by side: the same signals, the same disturbances, whoever wins."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb.arguments import finite_of_shape
from softlimb.control.controllers import PID, Learning, NeuralPID
from softlimb.control.disturbances import DISTURBANCES, Disturbance, follow
from softlimb.control.metrics import Metrics, metrics
from softlimb.control.pneumatics import Pneumatics
from softlimb.control.signals import SIGNALS, Signal
from softlimb.control.tuning import adjusted, best_pid, best_rates, learning_from, simc

__all__ = ["Comparison", "Row", "candidates", "compare"]

Array = NDArray[np.float64]

_RULES: tuple[Learning, ...] = ("gradient", "normalised")
WEAK = 0.1
"""Share of the rule's weights that the badly tuned candidates start from."""


@dataclass(frozen=True)
class Row:
    """One run."""

    controller: str
    signal: str
    disturbance: str
    metrics: Metrics


@dataclass(frozen=True, eq=False)
class Comparison:
    """All runs, and the controllers as they were at the start of each."""

    rows: tuple[Row, ...]
    controllers: Mapping[str, tuple[PID | NeuralPID, ...]]

    def found(self, controller: str, signal: str, disturbance: str = "none") -> Metrics:
        """Metrics of one run; KeyError when there was none."""
        for row in self.rows:
            if (row.controller, row.signal, row.disturbance) == (controller, signal, disturbance):
                return row.metrics
        raise KeyError((controller, signal, disturbance))


def _representatives(pneumatics: Pneumatics, goal: Array) -> list[int]:
    """One actuator for each kind of chamber: that with the highest goal."""
    kinds: dict[int, int] = {}
    for number, chamber in enumerate(pneumatics.chambers):
        best = kinds.get(id(chamber))
        if best is None or goal[number] > goal[best]:
            kinds[id(chamber)] = number
    return list(kinds.values())


def candidates(
    pneumatics: Pneumatics, goal: ArrayLike, *, evaluations: int = 120
) -> dict[str, tuple[PID | NeuralPID, ...]]:
    """Fixed and neural PIDs for a plant, one controller an actuator.

    The searches run on one actuator of each kind of chamber, on all signals, undisturbed; the neural ones start from
    the rule's weights, and search their three rates with as many evaluations as the fixed PID its three numbers.

    Parameters
    ----------
    goal : array_like, shape (A,)
        Gauge pressures of the signals [Pa].
    evaluations : int
        Of each search. Zero: no search, and no need of NLopt; the neural ones then have the rates 1 (gradient) and 0.1
        (normalised).
    """
    pressures = finite_of_shape("goal", goal, (len(pneumatics),))
    rule = simc(pneumatics)
    weak = [one.replaced(weights=tuple(WEAK * weight for weight in one.weights)) for one in rule]
    rates: dict[str, ArrayLike] = {"gradient": np.full(3, 1.0), "normalised": np.full(3, 0.1)}
    found: dict[str, Sequence[PID | NeuralPID]] = {"fixed, SIMC": rule}
    if evaluations:
        few = _representatives(pneumatics, pressures)
        part = pneumatics.replaced(
            **{
                name: [getattr(pneumatics, plural)[k] for k in few]
                for name, plural in (
                    ("chambers", "chambers"),
                    ("valve", "valves"),
                    ("line", "lines"),
                    ("sensor", "sensors"),
                )
            }
        )
        signals = [make(pressures[few], period=pneumatics.period) for make in SIGNALS.values()]
        found["fixed, best found"] = adjusted(rule, best_pid(part, signals, evaluations=evaluations).numbers)
        for learning in _RULES:
            rates[learning] = best_rates(part, simc(part), signals, learning=learning, evaluations=evaluations).numbers
    for learning in _RULES:
        found[f"neural, {learning}"] = learning_from(rule, rates[learning], learning=learning)
    found["fixed, SIMC/10"] = weak
    for learning in _RULES:
        found[f"neural, {learning}, from SIMC/10"] = learning_from(weak, rates[learning], learning=learning)
    return {name: tuple(controllers) for name, controllers in found.items()}


def compare(
    pneumatics: Pneumatics,
    goal: ArrayLike,
    controllers: Mapping[str, Sequence[PID | NeuralPID]],
    *,
    signals: Sequence[str] = tuple(SIGNALS),
    disturbances: Sequence[str] = tuple(DISTURBANCES),
    disturbed: str = "staircase",
) -> Comparison:
    """Run every controller on every signal undisturbed, and on one signal with every disturbance.

    Parameters
    ----------
    goal : array_like, shape (A,)
        Gauge pressures of the signals [Pa].
    controllers
        As `candidates` gives them.
    signals, disturbances : sequence of str
        Names in `SIGNALS` and `DISTURBANCES`.
    disturbed : str
        The signal of the disturbed runs.

    Raises
    ------
    ValueError
        A name is unknown, or the goal has not one pressure an actuator.
    """
    for kind, names, known in (("signal", (*signals, disturbed), SIGNALS), ("disturbance", disturbances, DISTURBANCES)):
        for name in names:
            if name not in known:
                raise ValueError(f"unknown {kind} {name!r}: known are {', '.join(known)}")
    pressures = finite_of_shape("goal", goal, (len(pneumatics),))
    rows = []
    pairs = [(signal, "none") for signal in signals]
    pairs += [(disturbed, name) for name in disturbances if (disturbed, name) not in pairs]
    made: dict[str, Signal] = {name: SIGNALS[name](pressures, period=pneumatics.period) for name, _ in pairs}
    for title, group in controllers.items():
        for signal, name in pairs:
            disturbance: Disturbance = DISTURBANCES[name]
            trace = follow(pneumatics, group, made[signal], disturbance)
            if not trace.solved:
                raise RuntimeError(f"the plant was not solved: {title}, {signal}, {name}")
            rows.append(Row(title, signal, name, metrics(trace, made[signal])))
    return Comparison(tuple(rows), {title: tuple(group) for title, group in controllers.items()})
