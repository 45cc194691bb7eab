"""Paths of equilibria: a posture followed while one parameter of its scene changes, through folds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from softlimb import _core
from softlimb.arguments import one_finite
from softlimb.posture import Posture

__all__ = ["Path", "PathEvent"]

Array = NDArray[np.float64]

_ENDS = {
    "stop": "the parameter reached {stop:.6g}",
    "start": "the path came back to {start:.6g}: the same scene has another posture",
    "event": "the path was to end at its first fold or bifurcation",
    "no_scene": "beyond {last:.6g} the scene does not exist: an actuator has no stable state",
    "lost": "the path was lost at {last:.6g}: no step is small enough",
    "max_points": "the number of points or the budget of work ran out at {last:.6g}",
}


@dataclass(frozen=True)
class PathEvent:
    """Where a path loses or regains stability.

    Parameters
    ----------
    kind : {"fold", "bifurcation"}
        At a fold the parameter turns back: beyond it there is no posture near. At a bifurcation the number of unstable
        modes changes while the parameter goes on: another path of postures crosses here.
    parameter : float
        Where; a fold to 1e-8 of the range that was asked for.
    posture : Posture
        The equilibrium there. Its stiffness is singular: it counts as unstable, and has no compliance and no Jacobian.
    after : int
        The event lies between points ``after`` and ``after + 1`` of the path.
    """

    kind: Literal["fold", "bifurcation"]
    parameter: float
    posture: Posture
    after: int


class Path:
    """Equilibria along one parameter, in the order in which the path meets them.

    Made by `Limb.follow`. The parameter need not be monotonic: it turns at every fold. A path pickles as its points and
    events; what it was made from, a function of the parameter, stays behind, and with it `at` between points.
    """

    def __init__(
        self,
        followed: _core.FollowedPath,
        start: float,
        stop: float,
        posture_of: Callable[[float, _core.Posture], Posture],
        first: Posture,
    ) -> None:
        self.start = start
        self.stop = stop
        self.end = followed.end
        self._first = first
        self._followed: _core.FollowedPath | None = followed
        self._posture_of: Callable[[float, _core.Posture], Posture] | None = posture_of

    start: float
    """Value of the parameter at the first point."""
    stop: float
    """Where the path was to go."""
    end: str
    """Why the path ends: ``stop``, ``start``, ``event``, ``no_scene``, ``lost`` or ``max_points``."""

    def __getstate__(self) -> dict[str, Any]:
        whole = {name: getattr(self, name) for name in ("parameters", "arclengths", "postures", "events")}
        return {**self.__dict__, **whole, "_followed": None, "_posture_of": None}

    def _made_of(self) -> tuple[_core.FollowedPath, Callable[[float, _core.Posture], Posture]]:
        if self._followed is None or self._posture_of is None:
            raise RuntimeError("a path that was pickled has its points but no postures between them: follow it again")
        return self._followed, self._posture_of

    @cached_property
    def parameters(self) -> Array:
        """Value of the parameter at each point, shape (K,)."""
        return np.array(self._made_of()[0].parameters)

    @cached_property
    def arclengths(self) -> Array:
        """Arclength at each point, shape (K,); see ``largest_step`` of `Limb.follow`."""
        return np.array(self._made_of()[0].arclengths)

    @cached_property
    def postures(self) -> tuple[Posture, ...]:
        """Posture at each point, solved to the tolerance asked for."""
        followed, posture_of = self._made_of()
        return tuple(
            posture_of(float(parameter), followed.posture(number))
            for number, parameter in enumerate(self.parameters)
        )

    @property
    def tips(self) -> Array:
        """Pose of the tip at each point, shape (K, 4, 4)."""
        return np.array([posture.tip for posture in self.postures]).reshape(-1, 4, 4)

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Which points are stable, shape (K,)."""
        return np.array([posture.stable for posture in self.postures], dtype=bool)

    @cached_property
    def events(self) -> tuple[PathEvent, ...]:
        """Folds and bifurcations in the order in which they are met."""
        followed, posture_of = self._made_of()
        return tuple(
            PathEvent(
                "fold" if kind == "fold" else "bifurcation",
                parameter,
                posture_of(parameter, followed.event_posture(number)),
                after,
            )
            for number, (kind, after, parameter) in enumerate(followed.events)
        )

    @property
    def folds(self) -> tuple[PathEvent, ...]:
        """The folds alone."""
        return tuple(event for event in self.events if event.kind == "fold")

    @property
    def bifurcations(self) -> tuple[PathEvent, ...]:
        """The bifurcations alone."""
        return tuple(event for event in self.events if event.kind == "bifurcation")

    @property
    def success(self) -> bool:
        """True when the path reached ``stop``, came back to ``start``, or ended at an event because it was to."""
        return self.end in ("stop", "start", "event")

    @property
    def message(self) -> str:
        """The end in words, and how many folds and bifurcations were met."""
        if not self.parameters.size:
            return f"the first posture is no equilibrium that could be followed: {self._first.message}"
        text = _ENDS[self.end].format(start=self.start, stop=self.stop, last=self.parameters[-1])
        for kind, events in (("fold", self.folds), ("bifurcation", self.bifurcations)):
            if events:
                text += f"; {len(events)} {kind}{'s' if len(events) > 1 else ''}"
        return text

    def at(self, parameter: float) -> tuple[Posture, ...]:
        """All postures of the path at a value of the parameter, in the order in which the path meets them.

        Raises
        ------
        ValueError
            ``parameter`` is not a finite number.
        RuntimeError
            The path was pickled, and the parameter lies between two of its points.
        """
        value = one_finite("parameter", parameter)
        found = []
        for number, here in enumerate(self.parameters):
            if here == value:
                found.append(self.postures[number])
            if number + 1 < self.parameters.size:
                followed, posture_of = self._made_of()
                found.extend(posture_of(value, solved) for solved in followed.between(number, value))
        return tuple(found)

    def __len__(self) -> int:
        return int(self.parameters.size)

    def __repr__(self) -> str:
        return f"Path({len(self)} points, {self.message})"
