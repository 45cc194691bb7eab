"""Weights for the pressure controllers: by a rule, or the best that NLopt finds; and where learning fails."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb.arguments import finite_of_shape, of_type, one_positive, one_whole, positive_array
from softlimb.control.controllers import PID, Learning, NeuralPID
from softlimb.control.disturbances import follow
from softlimb.control.metrics import metrics
from softlimb.control.pneumatics import Pneumatics
from softlimb.control.signals import Signal, staircase
from softlimb.units import kPa

__all__ = [
    "LearningLimit",
    "StepTest",
    "Tuned",
    "adjusted",
    "best_pid",
    "best_rates",
    "learning_from",
    "learning_limit",
    "mean_iae",
    "simc",
    "step_test",
]

Array = NDArray[np.float64]

_SCALE = 100 * kPa  # of errors, as the controllers have it


@dataclass(frozen=True)
class StepTest:
    """An integrator with dead time, fitted to a chamber that fills.

    Parameters
    ----------
    gain : float
        Rise of the pressure at full command [Pa/s].
    delay : float
        From the command to the fitted line [s].
    """

    gain: float
    delay: float


def step_test(
    pneumatics: Pneumatics, *, command: float = 0.5, between: tuple[float, float] = (2e3, 10e3)
) -> list[StepTest]:
    """Open each valve by a step from the atmosphere, and fit a line to the pressure between two values [Pa].

    The values are low, because a chamber softens as it grows: a line through its later rise says nothing of the delay.

    Raises
    ------
    ValueError
        The command is not within 0 and 1, the values are not two that rise, or a pressure does not pass both of them
        within five seconds.
    """
    if one_positive("command", command) > 1.0:
        raise ValueError(f"command must be at most 1, a valve that is fully open, got {command:g}")
    low, high = finite_of_shape("between", between, (2,))
    if not 0.0 < low < high:
        raise ValueError(f"between must be two rising pressures above zero, got {low:g} and {high:g}")
    plant = pneumatics.plant()
    rows = []
    for _ in range(round(5.0 / pneumatics.period)):
        plant.advance(np.full(len(pneumatics), command))
        rows.append(plant.pressures)
        if rows[-1].min() > high:
            break
    pressures = np.array(rows)
    time = np.arange(1, len(rows) + 1) * pneumatics.period
    found = []
    for channel, row in enumerate(pressures.T):
        inside = (row > low) & (row < high)
        if row[-1] <= high or inside.sum() < 3:
            raise ValueError(
                f"channel {channel} does not rise through {low:g} to {high:g} Pa at a command of {command:g}"
            )
        slope, offset = np.polyfit(time[inside], row[inside], 1)
        # The loop acts once a period: half of it is a delay of its own.
        found.append(StepTest(float(slope / command), float(-offset / slope + 0.5 * pneumatics.period)))
    return found


def simc(pneumatics: Pneumatics, **options: Any) -> list[PID]:
    """A PI controller for each chamber by the SIMC rule, from its own step test.

    Of an integrator with gain k' and delay theta, with the closed loop's time constant equal to theta:
    K = 1/(2 k' theta), T_I = 8 theta (Skogestad, J. Process Control 13 (2003) 291).

    Parameters
    ----------
    **options
        Other options of `PID`.
    """
    made = []
    for test in step_test(pneumatics):
        gain = _SCALE / (2.0 * test.gain * test.delay)
        made.append(PID((gain, gain / (8.0 * test.delay), 0.0), period=pneumatics.period, scale=_SCALE, **options))
    return made


def mean_iae(pneumatics: Pneumatics, controllers: Sequence[PID | NeuralPID], signals: Sequence[Signal]) -> float:
    """Mean over the signals of the integral of |error| [Pa s], no disturbance; ValueError where there is no signal."""
    if not len(signals):
        raise ValueError("signals must be at least one, got none")
    return float(np.mean([metrics(follow(pneumatics, controllers, signal), signal).iae for signal in signals]))


@dataclass(frozen=True, eq=False)
class Tuned:
    """What a search found.

    Parameters
    ----------
    numbers : tuple of float
        What was searched: gain over the rule's, T_I [s], T_D [s]; or three rates.
    iae : float
        Mean over the signals [Pa s].
    evaluations : int
        Runs of all signals that the search took.
    """

    numbers: tuple[float, ...]
    iae: float
    evaluations: int


def _searched(
    make: Callable[[Array], Sequence[PID | NeuralPID]],
    pneumatics: Pneumatics,
    signals: Sequence[Signal],
    low: ArrayLike,
    high: ArrayLike,
    start: ArrayLike,
    evaluations: int,
) -> Tuned:
    """Half the evaluations by locally biased DIRECT within the bounds, the rest by Subplex from the best of all."""
    evaluations = one_whole("evaluations", evaluations, 10)
    of_type("signals", signals, Sequence)
    try:
        nlopt: Any = import_module("nlopt")
    except ModuleNotFoundError:
        raise ModuleNotFoundError(
            "a search for the best controller needs NLopt: pip install 'softlimb[design]'"
        ) from None
    best: list[tuple[float, Array]] = []

    def cost(x: Array, _: Array) -> float:
        value = mean_iae(pneumatics, make(10.0**x), signals)
        if not best or value < best[0][0]:
            best[:] = [(value, np.array(x, dtype=float))]
        return value

    first = np.asarray(start, dtype=float)
    cost(first, first)
    done = 1
    for algorithm, count in (
        (nlopt.GN_DIRECT_L, evaluations // 2),
        (nlopt.LN_SBPLX, evaluations - evaluations // 2 - 1),
    ):
        search = nlopt.opt(algorithm, len(first))
        search.set_min_objective(cost)
        search.set_lower_bounds(np.asarray(low, dtype=float))
        search.set_upper_bounds(np.asarray(high, dtype=float))
        search.set_maxeval(count)
        search.optimize(best[0][1])
        done += search.get_numevals()
    return Tuned(tuple(float(x) for x in 10.0 ** best[0][1]), best[0][0], done)


def best_pid(pneumatics: Pneumatics, signals: Sequence[Signal], *, evaluations: int = 200) -> Tuned:
    """The fixed PID with the least mean IAE over signals, no disturbance, that NLopt finds.

    Three numbers for all chambers, on top of `simc`: its gain times 0.05 to 5, T_I from 0.02 to 10 s, T_D from 0.01 to
    30 ms.

    Raises
    ------
    ModuleNotFoundError
        NLopt is missing.
    """
    rule = simc(pneumatics)

    start = [0.0, np.log10(rule[0].weights[0] / rule[0].weights[1]), -5.0]
    low, high = np.log10([0.05, 0.02, 1e-5]), np.log10([5.0, 10.0, 0.03])
    return _searched(lambda numbers: adjusted(rule, numbers), pneumatics, signals, low, high, start, evaluations)


def adjusted(rule: Sequence[PID], numbers: ArrayLike) -> list[PID]:
    """The rule's gains times a factor, with T_I and T_D for all."""
    factor, integral_time, derivative_time = np.asarray(numbers, dtype=float)
    gains = [float(factor) * one.weights[0] for one in rule]
    return [
        one.replaced(weights=(gain, gain / integral_time, gain * derivative_time / one.options["period"]))
        for one, gain in zip(rule, gains, strict=True)
    ]


def best_rates(
    pneumatics: Pneumatics,
    start: Sequence[PID],
    signals: Sequence[Signal],
    *,
    learning: Learning = "gradient",
    evaluations: int = 200,
) -> Tuned:
    """The learning rates with the least mean IAE over signals that NLopt finds, from given weights; 1e-6 to 1e6 each.

    Raises
    ------
    ModuleNotFoundError
        NLopt is missing.
    """

    return _searched(
        lambda rates: learning_from(start, rates, learning=learning),
        pneumatics,
        signals,
        np.full(3, -6.0),
        np.full(3, 6.0),
        np.full(3, -3.0),
        evaluations,
    )


def learning_from(start: Sequence[PID], rates: ArrayLike, **options: Any) -> list[NeuralPID]:
    """Neural PIDs that start at the weights of fixed ones."""
    return [NeuralPID(**{**one.options, "rates": rates, **options}) for one in start]


@dataclass(frozen=True, eq=False)
class LearningLimit:
    """Where learning stops to settle.

    A valve has limits, so a pressure does not run away where the weights do: the valve slams between its limits, a
    thousand times a second if it must. What tells is the command while the target stands still, beside that of the
    same weights that do not learn: where those do not hold the target either, no learning rate is to blame.

    Parameters
    ----------
    rates : array, shape (n,)
        Tried, rising.
    chatter : array, shape (n,)
        Root mean square of the command in the last second of a constant target; mean over the chambers.
    unlearned : float
        The same at a rate of zero.
    growth : array, shape (n,)
        Largest weight at the end over the largest at the start.
    iae : array, shape (n,)
        Mean over the chambers of the integral of |error| [Pa s].
    limit : float or None
        Least rate found with a chatter above ``threshold``, by bisection; None where there is none, or where the target
        is not held without learning, see `held`.
    threshold : float
    """

    rates: Array
    chatter: Array
    growth: Array
    iae: Array
    limit: float | None
    threshold: float
    unlearned: float

    @property
    def held(self) -> bool:
        """The first weights hold the target without learning."""
        return self.unlearned <= self.threshold


def learning_limit(
    pneumatics: Pneumatics,
    start: Sequence[PID],
    *,
    goal: float = 50 * kPa,
    rates: ArrayLike | None = None,
    threshold: float = 0.5,
    **options: Any,
) -> LearningLimit:
    """Find the learning rate beyond which a constant target is no longer held in peace.

    Parameters
    ----------
    start : sequence of PID
        Weights to start from.
    goal : float
        Four seconds up and down a staircase to this, then four seconds at it [Pa].
    rates : array_like, optional
        Common rates of the three weights to try, rising. Default: 1e-4 to 1e6, two a decade.
    threshold : float
        Chatter of a command that no longer settles, between 0 and 1; of noise alone it is a few hundredths.
    **options
        Of `NeuralPID`: ``learning``, ``sign``, ``slope``. Weights are free up to 1e12 either way.

    Raises
    ------
    ValueError
        Rates that are not positive or do not rise; a threshold that no command exceeds, or every one.
    """
    if not one_positive("threshold", threshold) < 1.0:
        raise ValueError(f"threshold must be below 1, the largest command, got {threshold:g}")
    tried = positive_array("rates", 10.0 ** np.arange(-4.0, 6.01, 0.5) if rates is None else rates)
    if tried.ndim != 1 or not len(tried) or not (np.diff(tried) > 0.0).all():
        raise ValueError(f"rates must be a rising row, got {tried.tolist()}")
    goals = np.full(len(pneumatics), one_positive("goal", goal))
    stairs = staircase(goals, period=pneumatics.period)
    # Three seconds before it counts: what is still on its way then, is so without learning as well.
    held = np.tile(goals, (round(4.0 / pneumatics.period), 1))
    signal = Signal("hold", np.vstack([stairs.targets, held]), pneumatics.period)
    last = round(1.0 / pneumatics.period)

    def looked_at(rate: float) -> tuple[float, float, float]:
        trace = follow(pneumatics, learning_from(start, rate, **{"lowest": -1e12, "highest": 1e12, **options}), signal)
        chatter = np.sqrt((trace.commands[-last:] ** 2).mean(axis=0)).mean()
        growth = np.abs(trace.weights[-1]).max() / max(max(np.abs(one.weights)) for one in start)
        return float(chatter), float(growth), metrics(trace, signal).iae

    unlearned = looked_at(0.0)[0]
    rows = np.array([looked_at(rate) for rate in tried])
    wild = np.flatnonzero(rows[:, 0] > threshold)
    limit: float | None = None
    if wild.size and unlearned <= threshold:
        high = float(tried[wild[0]])
        low = float(tried[wild[0] - 1]) if wild[0] > 0 else high
        for _ in range(5):  # half a decade in 32 parts: to 4 %
            middle = float(np.sqrt(low * high))
            low, high = (low, middle) if looked_at(middle)[0] > threshold else (middle, high)
        limit = high
    return LearningLimit(tried, rows[:, 0], rows[:, 1], rows[:, 2], limit, threshold, unlearned)
