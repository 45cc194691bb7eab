"""Numbers of an actuator or a limb from what was measured of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softlimb.arguments import one_finite, shown
from softlimb.identify.actuators import Actuator, EmpiricalActuator, ScaledTube, changed_actuator, values_of
from softlimb.identify.driven import DrivenLimb
from softlimb.identify.least_squares import HoldOut, Identified, Noise, _held_out, least_squares
from softlimb.identify.observations import ActuatorCurve, Observation, observations
from softlimb.identify.statistics import Loss
from softlimb.limb import Limb
from softlimb.tube import Tube

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class _Explained:
    """Measurements as a model of parameters: the first of the model's own numbers, then offsets."""

    model: Actuator | DrivenLimb
    data: tuple[Observation, ...]
    own: tuple[str, ...]
    zeros: tuple[str, ...]

    def changed(self, values: Array) -> Actuator | DrivenLimb:
        """The model with its own numbers at values."""
        new = dict(zip(self.own, values[: len(self.own)].tolist(), strict=True))
        return self.model.changed(new) if isinstance(self.model, DrivenLimb) else changed_actuator(self.model, new)

    def __call__(self, values: Array) -> tuple[Array, Array]:
        sizes = [one.values.size for one in self.data]
        predicted, slopes = np.full(sum(sizes), np.nan), np.zeros((sum(sizes), len(values)))
        try:
            model: Any = self.changed(values)
        except ValueError:
            return predicted, slopes  # numbers that make no actuator: the search does not go there
        zeros = dict(zip(self.zeros, values[len(self.own) :].tolist(), strict=True))
        first = 0
        for one, size in zip(self.data, sizes, strict=True):
            last = first + size
            found = one.predict(model, self.own, zeros)
            predicted[first:last] = found.values
            slopes[first:last, : len(self.own)] = found.by_values
            for k, name in enumerate(self.zeros, start=len(self.own)):
                slopes[first:last, k] = found.by_zeros.get(name, 0.0)
            first = last
        return predicted, slopes


def identify(
    model: Actuator | DrivenLimb | Limb,
    data: Observation | Sequence[Observation],
    free: Sequence[str] | Mapping[str, float | None],
    *,
    noise: Noise = "estimated",
    loss: Loss = "square",
    bounds: Mapping[str, tuple[float, float]] | None = None,
    scale: Mapping[str, float] | None = None,
    hold_out: HoldOut = None,
    confidence: float = 0.95,
) -> Identified:
    """Find numbers of an actuator or a limb from measurements.

    Parameters
    ----------
    model : Tube, ScaledTube or EmpiricalActuator; DrivenLimb, or Limb of tubes
        With values to begin from.
    data : ActuatorCurve for an actuator; LimbCurve, Points or TipPoses for a limb; or several
    free : sequence of str, or mapping of str to float or None
        What is to be found, by name: numbers of the model (`DrivenLimb.value` says how they are called; of an actuator
        those of its own, as ``layers[0].c1`` or ``length[1]``), and offsets of the measurements, as ``pressure_zero``.
        With a mapping a number is the value to begin from.
    noise, loss, bounds, scale, confidence
        As for `least_squares`. Offsets have scales by themselves.
    hold_out : array of bool, array of int, or slice, optional
        States (rows of pressures, of all measurements one after the other) that the fit must not see.

    Returns
    -------
    Identified
        ``model`` has the estimates in it.

    Raises
    ------
    ValueError
        A name is unknown, a measurement does not belong to this kind of model, or as for `least_squares`.
    """
    known: Any = DrivenLimb.of(model) if isinstance(model, Limb) else model
    if not isinstance(known, (Tube, ScaledTube, EmpiricalActuator, DrivenLimb)):
        raise TypeError(f"model must be an actuator or a limb, got {type(model).__name__}")
    if bounds is not None and not isinstance(bounds, Mapping):
        raise TypeError(f"bounds must be a mapping of names to two numbers, got {type(bounds).__name__}")
    given = observations(data)
    for one in given:
        if isinstance(one, ActuatorCurve) is isinstance(known, DrivenLimb):
            raise ValueError(f"{type(one).__name__} does not belong to a {type(known).__name__}")
        if isinstance(known, DrivenLimb) and one.pressures.shape[1] != len(known.actuators):
            found = one.pressures.shape[1]
            raise ValueError(f"pressures have {found} columns but the limb has {len(known.actuators)} actuators")
    offsets = {name: size for one in given for name, size in one.zeros.items()}
    asked = dict(free) if isinstance(free, Mapping) else dict.fromkeys((free,) if isinstance(free, str) else free)
    own = tuple(name for name in asked if name not in offsets)
    zeros = tuple(name for name in asked if name in offsets)
    start = {name: _start(known, name, asked[name], offsets) for name in (*own, *zeros)}
    explained = _Explained(known, given, own, zeros)
    blocks, first = [], 0
    for one in given:
        blocks.append((first, one))
        first += one.states
    states = None if hold_out is None else _held_out(hold_out, first)
    mask = None
    if states is not None:
        mask = np.concatenate(
            [np.repeat(states[begin : begin + one.states], one.values.shape[1]) for begin, one in blocks]
        )
    found = least_squares(
        explained,
        np.concatenate([one.values.ravel() for one in given]),
        start,
        sigma=np.concatenate([one.sigma.ravel() for one in given]),
        noise=noise,
        loss=loss,
        bounds=bounds,
        scale={**{name: offsets[name] for name in zeros}, **(scale or {})},
        hold_out=mask,
        confidence=confidence,
    )
    ended = explained.changed(found.estimates) if np.isfinite(found.estimates).all() else None
    return replace(found, model=ended)


def _start(model: Any, name: str, given: float | None, offsets: Mapping[str, float]) -> float:
    if given is not None:
        return one_finite(f"start of {name}", given)
    if name in offsets:
        return 0.0
    if isinstance(model, DrivenLimb):
        return model.value(name)
    own = values_of(model)
    if name not in own:
        raise ValueError(f"there is no number {shown(name)} to identify; there are {', '.join([*own, *offsets])}")
    return own[name]
