"""What happens to the plant while it is controlled: loads, leaks, a weak supply, bad sensors, other valves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from softlimb import _core
from softlimb.arguments import function, of_type, one_finite, one_of
from softlimb.control.controllers import PID, NeuralPID
from softlimb.control.loop import Guard, PressureLoop, Trace
from softlimb.control.pneumatics import Pneumatics
from softlimb.control.signals import Signal
from softlimb.units import kPa, ms

__all__ = ["DISTURBANCES", "Disturbance", "Event", "follow"]


@dataclass(frozen=True)
class Event:
    """Something that happens to the plant.

    Parameters
    ----------
    share : float
        When, as a share of the signal's time, 0 to 1.
    happens : callable
        Takes the plant and changes it.

    Raises
    ------
    TypeError
        ``happens`` is no function.
    ValueError
        The share is not within 0 and 1.
    """

    share: float
    happens: Callable[[_core.Plant], None]

    def __post_init__(self) -> None:
        object.__setattr__(self, "share", one_finite("share of an Event", self.share))
        if not 0.0 <= self.share <= 1.0:
            raise ValueError(f"share of an Event must be within [0, 1], got {self.share!r}")
        function("happens of an Event", self.happens)


@dataclass(frozen=True)
class Disturbance:
    """A plant that is not the one that was tuned for.

    Parameters
    ----------
    name : str
    events : sequence of Event
        In the order of their times.
    other : callable, optional
        From the plant's parameters to those it really has.

    Raises
    ------
    TypeError
        Events that are none, or ``other`` is no function.
    """

    name: str
    events: tuple[Event, ...] = ()
    other: Callable[[Pneumatics], Pneumatics] | None = None

    def __post_init__(self) -> None:
        of_type("name of a Disturbance", self.name, str)
        of_type("events of a Disturbance", self.events, Sequence)
        object.__setattr__(self, "events", tuple(self.events))
        for number, event in enumerate(self.events):
            of_type(f"events[{number}] of a Disturbance", event, Event)
        if self.other is not None:
            function("other of a Disturbance", self.other)


def follow(
    pneumatics: Pneumatics,
    controllers: PID | NeuralPID | Sequence[PID | NeuralPID],
    signal: Signal,
    disturbance: Disturbance | str | None = None,
    *,
    guard: Guard | None = None,
) -> Trace:
    """Let controllers follow a signal while the plant is disturbed.

    Parameters
    ----------
    pneumatics : Pneumatics
    controllers : PID or NeuralPID, or a sequence with one a chamber
    signal : Signal
    disturbance : Disturbance or str, optional
        One of `DISTURBANCES` by its name.
    guard : Guard, optional
        None: nobody watches.

    Raises
    ------
    TypeError
        An argument is something else.
    ValueError
        The signal has not one column a chamber, or another period than the plant; or the name is unknown.
    """
    of_type("pneumatics", pneumatics, Pneumatics)
    of_type("signal", signal, Signal)
    if isinstance(disturbance, str):
        one_of("disturbance", disturbance, tuple(DISTURBANCES))
        disturbance = DISTURBANCES[disturbance]
    elif disturbance is not None:
        of_type("disturbance", disturbance, Disturbance, str)
    if signal.period != pneumatics.period:
        raise ValueError(f"period of the signal must be the plant's {pneumatics.period:g} s, got {signal.period:g}")
    events = () if disturbance is None else disturbance.events
    if disturbance is not None and disturbance.other is not None:
        pneumatics = disturbance.other(pneumatics)
    loop = PressureLoop(pneumatics, controllers, guard=guard)
    parts, done = [], 0
    for event in sorted(events, key=lambda one: one.share):
        until = round(event.share * len(signal.targets))
        if until > done:
            parts.append(loop.run(signal.targets[done:until]))
            done = until
        event.happens(loop.plant)
    if done < len(signal.targets):
        parts.append(loop.run(signal.targets[done:]))
    return Trace.joined(parts)


def _each(change: Callable[[_core.Plant, int], None]) -> Callable[[_core.Plant], None]:
    def happens(plant: _core.Plant) -> None:
        for channel in range(len(plant.pressures)):
            change(plant, channel)

    return happens


def _squeezed(scale: float) -> Callable[[_core.Plant], None]:
    return _each(lambda plant, channel: plant.set_volume_scale(channel, scale))


def _noisy(pneumatics: Pneumatics) -> Pneumatics:
    return pneumatics.replaced(sensor=[replace(sensor, noise=5.0 * sensor.noise) for sensor in pneumatics.sensors])


def _scaled(conductance: float = 1.0, time: float = 1.0) -> Callable[[Pneumatics], Pneumatics]:
    def other(pneumatics: Pneumatics) -> Pneumatics:
        valves = [
            replace(
                valve,
                conductance=conductance * valve.conductance,
                exhaust_conductance=conductance * valve.exhaust_conductance,
                time_constant=time * valve.time_constant,
                # the dead time counts in sub-steps: a whole number of milliseconds is one of them for any number
                dead_time=round(time * valve.dead_time / ms) * ms,
            )
            for valve in pneumatics.valves
        ]
        return pneumatics.replaced(valve=valves)

    return other


DISTURBANCES = {
    found.name: found
    for found in (
        Disturbance("none"),
        # a load squeezes all chambers by 5 % within 40 ms, and goes again
        Disturbance(
            "load change",
            (
                *(Event(0.3 + 0.0025 * k, _squeezed(1.0 - 0.0125 * k)) for k in range(1, 5)),
                *(Event(0.7 + 0.0025 * k, _squeezed(0.95 + 0.0125 * k)) for k in range(1, 5)),
            ),
        ),
        # a hole with 2 % of a valve's conductance in every chamber
        Disturbance("leak", (Event(0.3, _each(lambda plant, channel: plant.set_leak(channel, 2e-11))),)),
        # the reservoir loses about half its pressure, and the pump gives a fifth from then on
        Disturbance(
            "supply drop",
            (
                Event(0.3, lambda plant: plant.set_supply(pump_share=0.0, leak=5e-8)),
                Event(0.5, lambda plant: plant.set_supply(pump_share=0.2, leak=0.0)),
            ),
        ),
        Disturbance("noise x 5", (), _noisy),
        Disturbance("bias 2 kPa", (Event(0.3, _each(lambda plant, channel: plant.set_sensor(channel, bias=2 * kPa))),)),
        Disturbance("valve x 0.5", (), _scaled(conductance=0.5)),
        Disturbance("valve x 1.5", (), _scaled(conductance=1.5)),
        Disturbance("lag x 1.5", (), _scaled(time=1.5)),
    )
}
"""By name; the last three are parameters off by half."""
