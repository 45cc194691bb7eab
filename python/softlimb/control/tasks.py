"""What the tip is to do: places and times, and the load that it meets on its way."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb.arguments import (
    finite_of_shape,
    function,
    of_type,
    one_finite,
    one_not_negative,
    one_positive,
    real_array,
)
from softlimb.units import mm

__all__ = ["TASKS", "Task", "carry", "circle", "eight", "still"]

Array = NDArray[np.float64]

HOME = (0.0, 0.0, 730 * mm)
"""Where the tip of the reference limb hangs at 30 kPa in all actuators, about."""

LENGTH = 650 * mm
"""Of the reference limb, which the offsets below are for; see `Task.scaled`."""


@dataclass(frozen=True)
class Task:
    """A path of the tip and a force on it.

    Parameters
    ----------
    name : str
    seconds : float
    offset : callable
        Time [s] to the intended offset of the tip from its home [m], shape (3,).
    load : callable
        Time [s] to the force on the tip, which the controller does not know [N], shape (3,).
    home : tuple of 3 float
        Where the offsets count from [m].
    phases : tuple of (float, str)
        When what begins [s], for pictures.

    Raises
    ------
    TypeError
        ``offset`` or ``load`` is no function, a name no text.
    ValueError
        The time is not finite and positive, or ``home`` no place.
    """

    name: str
    seconds: float
    offset: Callable[[float], Array]
    load: Callable[[float], Array]
    home: tuple[float, float, float] = HOME
    phases: tuple[tuple[float, str], ...] = ()

    def __post_init__(self) -> None:
        of_type("name of a Task", self.name, str)
        object.__setattr__(self, "seconds", one_positive("seconds of a Task", self.seconds))
        for name in ("offset", "load"):
            function(f"{name} of a Task", getattr(self, name))
        home = finite_of_shape("home of a Task", self.home, (3,))
        object.__setattr__(self, "home", (float(home[0]), float(home[1]), float(home[2])))
        for time, phase in self.phases:
            one_finite("time of a phase of a Task", time)
            of_type("name of a phase of a Task", phase, str)

    def place(self, time: float) -> Array:
        """Where the tip is wanted [m]; before the start and after the end it is where the path starts and ends.

        Raises
        ------
        ValueError
            The offset is not three numbers; they may be NaN.
        """
        return np.asarray(self.home) + _three("offset", self.offset(min(max(time, 0.0), self.seconds)))

    def scaled(self, factor: float) -> Task:
        """The same with all offsets times a factor, for a limb of another length than the one it was made for."""
        times = one_positive("factor", factor)
        return replace(self, offset=lambda time: times * _three("offset", self.offset(time)))

    def force(self, time: float) -> Array:
        """Load at a time [N], shape (3,); errors as for `place`."""
        return _three("load", self.load(time))


def _three(name: str, value: ArrayLike) -> Array:
    """Three numbers that a task gave; where they are NaN it is for the loop to say what follows."""
    array = real_array(f"{name} of the task", value)
    if array.shape != (3,):
        raise ValueError(f"{name} of the task has shape {array.shape}: expected (3,)")
    return array


def _no_load(_: float) -> Array:
    return np.zeros(3)


def _smooth(share: float) -> float:
    """From 0 to 1 without speed or acceleration at both ends: the quintic of least jerk."""
    s = min(max(share, 0.0), 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s**2)


def _through(points: Sequence[tuple[float, Array]]) -> Callable[[float], Array]:
    def offset(time: float) -> Array:
        for (start, here), (end, there) in pairwise(points):
            if time <= end:
                share = _smooth((time - start) / (end - start)) if end > start else 1.0
                return here + share * (there - here)
        return points[-1][1]

    return offset


def still(offset: ArrayLike = (0.0, 0.0, 0.0), *, seconds: float = 2.0) -> Task:
    """Stay at an offset [m]."""
    place = finite_of_shape("offset", offset, (3,))
    return Task("still", one_positive("seconds", seconds), lambda _: place, _no_load)


def carry(
    pick: ArrayLike = (100 * mm, 50 * mm, 10 * mm),
    drop: ArrayLike = (-60 * mm, 90 * mm, -15 * mm),
    *,
    weight: float = 0.1,
    direction: ArrayLike = (0.0, 0.0, 1.0),
    pace: float = 1.0,
) -> Task:
    """Approach, grasp a load, carry it, release it: eleven seconds.

    Parameters
    ----------
    pick, drop : array_like, shape (3,)
        Offsets from home where the load is taken and left [m].
    weight : float
        Of the load [N].
    direction : array_like, shape (3,)
        Of its weight; the limb hangs, and grows along +z.
    pace : float
        Seconds of the task for each of its seconds: below one is faster.
    """
    first, last = finite_of_shape("pick", pick, (3,)), finite_of_shape("drop", drop, (3,))
    pace = one_positive("pace", pace)
    down = finite_of_shape("direction", direction, (3,))
    if not down.any():
        raise ValueError("direction of the load's weight must not be zero")
    force = one_not_negative("weight", weight) * down / np.linalg.norm(down)
    home = np.zeros(3)
    times = pace * np.array([0.0, 3.0, 5.0, 9.0, 11.0])
    points = list(zip(times.tolist(), [home, first, first, last, last], strict=True))
    grasp, release = 4.0 * pace, 10.0 * pace
    return Task(
        "carry",
        11.0 * pace,
        _through(points),
        lambda time: force if grasp <= time < release else np.zeros(3),
        phases=((0.0, "approach"), (grasp, "grasp"), (5.0 * pace, "carry"), (release, "release")),
    )


def _round(name: str, curve: Callable[[float], Array], lead: float, seconds: float) -> Task:
    """A smooth way from home to the start of a closed curve, then once around it, starting and stopping smoothly."""

    def offset(time: float) -> Array:
        if time < lead:
            return _smooth(time / lead) * curve(0.0)
        return curve(2.0 * np.pi * _smooth((time - lead) / seconds))

    return Task(name, lead + seconds + 1.0, offset, _no_load, phases=((0.0, "lead"), (lead, name)))


def circle(radius: float = 80 * mm, *, seconds: float = 10.0) -> Task:
    """A level circle about home."""
    r = one_positive("radius", radius)
    return _round(
        "circle", lambda a: np.array([r * np.cos(a), r * np.sin(a), 0.0]), 2.0, one_positive("seconds", seconds)
    )


def eight(width: float = 80 * mm, depth: float = 50 * mm, height: float = 15 * mm, *, seconds: float = 12.0) -> Task:
    """A figure eight in space: one wave along x, two along y, and one along z out of step."""
    x, y, z = one_positive("width", width), one_positive("depth", depth), one_not_negative("height", height)
    return _round(
        "eight",
        lambda a: np.array([x * np.sin(a), y * np.sin(2.0 * a), z * (1.0 - np.cos(a))]),
        0.5,
        one_positive("seconds", seconds),
    )


TASKS: dict[str, Callable[..., Task]] = {"carry": carry, "circle": circle, "eight": eight}
"""By name."""
