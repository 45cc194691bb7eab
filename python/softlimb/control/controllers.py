"""Pressure controllers: the code of the freestanding headers in ``softlimb/control``, with checked arguments."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from softlimb import _core
from softlimb.arguments import finite_of_shape, one_finite, one_not_negative, one_of, one_positive
from softlimb.units import kPa

__all__ = ["PID", "NeuralPID"]

Sign = Literal["descending", "printed"]
AntiWindup = Literal["none", "conditional", "back_calculation"]
Learning = Literal["gradient", "normalised"]
Three = tuple[float, float, float]

_SIGNS, _ANTI_WINDUP = ("descending", "printed"), ("none", "conditional", "back_calculation")
_LEARNING, _SLOPES = ("gradient", "normalised"), ("one", "secant", "given")


def _three(name: str, value: ArrayLike) -> Three:
    numbers = finite_of_shape(name, value, (3,))
    return float(numbers[0]), float(numbers[1]), float(numbers[2])


def _per_weight(name: str, value: ArrayLike) -> Three:
    return _three(name, np.full(3, one_finite(name, value)) if np.ndim(value) == 0 else value)


def _pair(name: str, value: ArrayLike) -> tuple[float, float]:
    low, high = finite_of_shape(name, value, (2,))
    if not low < high:
        raise ValueError(f"{name} must rise, got {float(low)!r} and {float(high)!r}")
    return float(low), float(high)


class _Controller:
    """What both kinds share: their options, and the compiled controller behind them."""

    _core: _core.Pid | _core.NeuralPid
    _options: dict[str, Any]

    def reset(self) -> None:
        """Back to the start: first weights, no memory."""
        self._core.reset()

    @property
    def options(self) -> dict[str, Any]:
        """The arguments that it was made with."""
        return dict(self._options)

    @property
    def weights(self) -> Three:
        """w1, w2, w3 as they are now."""
        return _three("weights", self._core.weights)

    @property
    def inputs(self) -> Three:
        """x1, x2, x3 of the last step."""
        return _three("inputs", self._core.inputs)

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and isinstance(other, _Controller) and self._options == other._options

    def __hash__(self) -> int:
        return hash((type(self).__name__, *self._options.items()))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in self._options.items())})"


def _common(
    weights: ArrayLike,
    period: float,
    scale: float,
    limits: ArrayLike,
    sign: Sign,
    anti_windup: AntiWindup,
    tracking_time: float,
    filter_time: float,
) -> dict[str, Any]:
    one_of("sign", sign, _SIGNS)
    one_of("anti_windup", anti_windup, _ANTI_WINDUP)
    return {
        "weights": _three("weights", weights),
        "period": one_positive("period", period),
        "scale": one_positive("scale", scale),
        "limits": _pair("limits", limits),
        "sign": sign,
        "anti_windup": anti_windup,
        "tracking_time": one_positive("tracking_time", tracking_time),
        "filter_time": one_not_negative("filter_time", filter_time),
    }


class PID(_Controller):
    """PID in positional form: u = w1 x1 + w2 x2 + w3 x3 of x1 = e, x2 = T sum e, x3 = e_k - e_(k-1).

    Parameters
    ----------
    weights : array_like, shape (3,)
        w1, w2 [1/s], w3, of the scaled error. In the usual gains: K, K/T_I and K T_D/T.
    period : float
        T [s].
    scale : float
        Errors are divided by it [Pa].
    limits : array_like, shape (2,)
        Of the command.
    sign : {"descending", "printed"}
        Error as target - measured, or measured - target as the paper prints it.
    anti_windup : {"none", "conditional", "back_calculation"}
        What the sum of errors does while the command is at a limit: grow on, stand still, be drawn back within
        ``tracking_time`` [s].
    filter_time : float
        Time constant of a first-order filter on x3 [s]; zero: none.

    Raises
    ------
    ValueError
        A number is not finite or out of range, limits do not rise, a name is unknown.

    Notes
    -----
    Zhang et al. eq. 11; MECHANICS, "Control". A target or reading that is no number repeats the command.
    """

    def __init__(
        self,
        weights: ArrayLike,
        *,
        period: float = 1e-3,
        scale: float = 100 * kPa,
        limits: ArrayLike = (-1.0, 1.0),
        sign: Sign = "descending",
        anti_windup: AntiWindup = "conditional",
        tracking_time: float = 0.1,
        filter_time: float = 0.0,
    ) -> None:
        self._options = _common(weights, period, scale, limits, sign, anti_windup, tracking_time, filter_time)
        self._core: _core.Pid = _core.Pid(**self._options)

    def step(self, target: float, measured: float) -> float:
        """The next command for a target and a reading [Pa]."""
        return self._core.step(target, measured)

    def replaced(self, **changes: Any) -> PID:
        """A fresh one with some options changed."""
        return PID(**{**self._options, **changes})

    def __reduce__(self) -> tuple[Any, ...]:
        return _made, (PID, self._options)


class NeuralPID(_Controller):
    """PID whose weights a single neuron adapts: w_i += eta_i e x_i s after each step, s = d measured / d command.

    Parameters
    ----------
    weights : array_like, shape (3,)
        At the start, see `PID`.
    rates : float or array_like, shape (3,)
        eta_i, of the scaled error.
    learning : {"gradient", "normalised"}
        The rule as printed, or over ``epsilon`` + s^2 |x|^2, so that one rate suits small and large errors.
    slope : {"one", "secant", "given"}
        s: one; the secant of the last two steps within ``slope_limits``, read where the command moved by
        ``smallest_move``; or the argument of `step`. In units of ``scale`` over command.
    lowest, highest : float or array_like, shape (3,)
        Bounds of the weights.
    sign : {"descending", "printed"}
        With "descending" the rule goes down the squared error where s is positive; with the paper's error it feeds back
        positively, and the rule climbs.
    period, scale, limits, anti_windup, tracking_time, filter_time
        As for `PID`. At a limit of the command nothing is learned, except with ``anti_windup="none"``.

    Raises
    ------
    ValueError
        As for `PID`; a rate is negative, or bounds are reversed.

    Notes
    -----
    Zhang et al. eq. 11-12; MECHANICS, "Control".
    """

    def __init__(
        self,
        weights: ArrayLike,
        *,
        rates: ArrayLike,
        learning: Learning = "gradient",
        slope: Literal["one", "secant", "given"] = "one",
        lowest: ArrayLike = 0.0,
        highest: ArrayLike = 1e3,
        epsilon: float = 1e-3,
        slope_limits: ArrayLike = (0.01, 100.0),
        smallest_move: float = 1e-3,
        period: float = 1e-3,
        scale: float = 100 * kPa,
        limits: ArrayLike = (-1.0, 1.0),
        sign: Sign = "descending",
        anti_windup: AntiWindup = "conditional",
        tracking_time: float = 0.1,
        filter_time: float = 0.0,
    ) -> None:
        one_of("learning", learning, _LEARNING)
        one_of("slope", slope, _SLOPES)
        given, low, high = (
            _per_weight(name, value) for name, value in (("rates", rates), ("lowest", lowest), ("highest", highest))
        )
        if min(given) < 0.0:
            raise ValueError(f"rates must not be negative, got {given}")
        if any(a > b for a, b in zip(low, high, strict=True)):
            raise ValueError(f"lowest must not exceed highest, got {low} and {high}")
        self._options = _common(weights, period, scale, limits, sign, anti_windup, tracking_time, filter_time) | {
            "rates": given,
            "learning": learning,
            "slope": slope,
            "lowest": low,
            "highest": high,
            "epsilon": one_positive("epsilon", epsilon),
            "slope_limits": _pair("slope_limits", slope_limits),
            "smallest_move": one_positive("smallest_move", smallest_move),
        }
        self._core: _core.NeuralPid = _core.NeuralPid(**self._options)

    def step(self, target: float, measured: float, slope: float = 1.0) -> float:
        """The next command for a target and a reading [Pa]; ``slope`` counts with ``slope="given"``."""
        return self._core.step(target, measured, slope)

    def replaced(self, **changes: Any) -> NeuralPID:
        """A fresh one with some options changed."""
        return NeuralPID(**{**self._options, **changes})

    def __reduce__(self) -> tuple[Any, ...]:
        return _made, (NeuralPID, self._options)


def _made(kind: type[PID] | type[NeuralPID], options: dict[str, Any]) -> PID | NeuralPID:
    return kind(**options)
