"""A limb of actuators of any kind: at given pressures it is a limb of rods, with derivatives to what it is made of."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb.arguments import finite_of_shape, joined, one_not_negative, shown
from softlimb.identify.actuators import (
    SECTION_FIELDS,
    Actuator,
    RodSlopes,
    ScaledTube,
    changed_actuator,
    require_actuator,
    rod_slopes,
    unpressurised_length,
    values_of,
)
from softlimb.limb import Limb, Plate, Posture, Segment

__all__ = ["DrivenLimb", "DrivenSegment"]

Array = NDArray[np.float64]

_LABEL = re.compile(r"(?:segments\[(\d+)\]\.)?(?:actuators\[(\d+)\]\.)?(.+)")
_OF_SEGMENT = ("ring_radius", "plate_mass", "plate_thickness")


@dataclass(frozen=True)
class DrivenSegment:
    """Actuators in parallel, of any kind, and the plate at their end.

    Parameters
    ----------
    actuators : sequence of Tube, ScaledTube or EmpiricalActuator
    ring_radius : float, optional
        Places them on a ring, as in `Segment`.
    places : array_like, shape (n, 2), optional
        Or x and y of each on both plates [m], all along z.
    plate : Plate

    Raises
    ------
    ValueError
        No actuators, or not exactly one of ``ring_radius`` and ``places``.
    """

    actuators: Sequence[Actuator]
    ring_radius: float | None = None
    places: Sequence[tuple[float, float]] | None = None
    plate: Plate = field(default_factory=Plate)

    def __post_init__(self) -> None:
        object.__setattr__(self, "actuators", tuple(self.actuators))
        if not self.actuators:
            raise ValueError("actuators of a segment must be at least one, got none")
        for actuator in self.actuators:
            require_actuator("actuators", actuator)
        if (self.ring_radius is None) == (self.places is None):
            raise ValueError("a segment takes either ring_radius or places: give exactly one of the two")
        if self.ring_radius is not None:
            object.__setattr__(self, "ring_radius", one_not_negative("ring_radius", self.ring_radius))
        else:
            given = finite_of_shape("places", np.asarray(self.places), (len(self.actuators), 2))
            object.__setattr__(self, "places", tuple((x, y) for x, y in given.tolist()))

    def at(self, slopes: Sequence[RodSlopes]) -> Segment:
        """The segment of the rods that its actuators are at some pressures."""
        rods = [found.rod for found in slopes]
        if self.ring_radius is not None:
            return Segment(rods=rods, ring_radius=self.ring_radius, plate=self.plate)
        frames = np.tile(np.eye(4), (len(rods), 1, 1))
        frames[:, :2, 3] = self.places
        return Segment(rods=rods, base_frames=frames, end_frames=frames, plate=self.plate)


class _Target(NamedTuple):
    """What a label stands for: actuators by flat number, or segments; and the name within them."""

    actuators: tuple[int, ...]
    segments: tuple[int, ...]
    name: str


class Moves(NamedTuple):
    """A posture with the moves of all its plates and of points of its centreline.

    ``by_pressures`` (rows, A), ``by_values`` (rows, labels): rows are (dp, dtheta) of each plate in base axes, then
    the points' three coordinates each.
    """

    posture: Posture
    by_pressures: Array
    by_values: Array


@dataclass(frozen=True)
class DrivenLimb:
    """Segments in series whose actuators may be of any kind: tubes, tubes with factors, or empirical ones.

    Parameters
    ----------
    segments : sequence of DrivenSegment

    Raises
    ------
    ValueError
        There is no segment.
    """

    segments: Sequence[DrivenSegment]

    def __post_init__(self) -> None:
        object.__setattr__(self, "segments", tuple(self.segments))
        if not self.segments:
            raise ValueError("segments of a limb must be at least one, got none")
        for segment in self.segments:
            if type(segment) is not DrivenSegment:
                raise TypeError(f"segments must each be a DrivenSegment, got {type(segment).__name__}")

    @classmethod
    def of(cls, limb: Limb, *, factors: bool = False) -> DrivenLimb:
        """A limb of tubes as one of driven segments, on request with stiffness factors of 1.

        Raises
        ------
        ValueError
            A segment has rods instead of tubes, or its actuators do not stand along z, at the same places of both
            plates.
        TypeError
            The limb is none.
        """
        if not isinstance(limb, Limb):
            raise TypeError(f"limb must be a Limb, got {type(limb).__name__}")
        segments = []
        for segment in limb.segments:
            if not segment.actuators:
                raise ValueError("a limb of rods has no actuators to identify: give a limb of tubes")
            places = None
            if segment.ring_radius is None:
                straight = np.tile(np.eye(4), (len(segment.members), 1, 1))
                straight[:, :2, 3] = segment.base_frames[:, :2, 3]
                if not (np.array_equal(straight, segment.base_frames) and np.array_equal(straight, segment.end_frames)):
                    raise ValueError("actuators must stand along z, at the same places of both plates")
                places = tuple((float(x), float(y)) for x, y in segment.base_frames[:, :2, 3])
            actuators = [ScaledTube(tube) if factors else tube for tube in segment.actuators]
            segments.append(DrivenSegment(tuple(actuators), segment.ring_radius, places, segment.plate))
        return cls(tuple(segments))

    @property
    def actuators(self) -> tuple[Actuator, ...]:
        """All of them, segment by segment."""
        return tuple(actuator for segment in self.segments for actuator in segment.actuators)

    @property
    def length(self) -> float:
        """Unpressurised actuators plus the plates between them [m]."""
        means = [float(np.mean([unpressurised_length(a) for a in segment.actuators])) for segment in self.segments]
        return sum(means) + sum(segment.plate.thickness for segment in self.segments[:-1])

    def _pressures(self, pressures: ArrayLike) -> Array:
        flat = joined("pressures", pressures).ravel()
        return finite_of_shape("pressures", flat, (len(self.actuators),))

    def _rods(self, pressures: Array, names: Sequence[Sequence[str]] | None = None) -> list[RodSlopes]:
        asked = [()] * len(pressures) if names is None else names
        known: dict[Any, RodSlopes] = {}  # equal actuators at one pressure are solved once
        found = []
        for actuator, pressure, of_it in zip(self.actuators, pressures.tolist(), asked, strict=True):
            key = (id(actuator), pressure, tuple(of_it))
            if key not in known:
                known[key] = rod_slopes(actuator, pressure, of_it)
            found.append(known[key])
        return found

    def _limb(self, rods: Sequence[RodSlopes]) -> Limb:
        segments, first = [], 0
        for segment in self.segments:
            last = first + len(segment.actuators)
            segments.append(segment.at(rods[first:last]))
            first = last
        return Limb(segments)

    def at(self, pressures: ArrayLike) -> Limb:
        """The limb of rods that it is at given pressures.

        Parameters
        ----------
        pressures : array_like, shape (A,) or (J, n), or a list of J arrays
            Gauge pressures [Pa].

        Raises
        ------
        ValueError
            Not finite, of another shape, or an actuator has no state at its pressure.
        """
        return self._limb(self._rods(self._pressures(pressures)))

    def solve(self, pressures: ArrayLike, **scene: Any) -> Posture:
        """The posture at given pressures; other arguments, result and errors as for `Limb.solve`."""
        return self.at(pressures).solve(**scene)

    def _target(self, label: str) -> _Target:
        found = _LABEL.fullmatch(label) if isinstance(label, str) else None
        if found is None:
            raise ValueError(f"{shown(label)} is no name of a number of this limb")
        which, actuator, name = found.groups()
        chosen = range(len(self.segments)) if which is None else (int(which),)
        firsts = np.cumsum([0, *(len(segment.actuators) for segment in self.segments)])
        if which is not None and int(which) >= len(self.segments):
            raise ValueError(f"{label}: the limb has {len(self.segments)} segments, counted from 0")
        if name in _OF_SEGMENT:
            if actuator is not None:
                raise ValueError(f"{label}: {name} belongs to a segment, not to an actuator")
            having = [j for j in chosen if name != "ring_radius" or self.segments[j].ring_radius is not None]
            if not having:
                raise ValueError(f"{label}: no segment is placed by a ring radius")
            return _Target((), tuple(having), name)
        flat = []
        for j in chosen:
            own = self.segments[j].actuators
            for i in range(len(own)) if actuator is None else (int(actuator),):
                if i >= len(own):
                    raise ValueError(f"{label}: segment {j} has {len(own)} actuators, counted from 0")
                if name in values_of(own[i]):
                    flat.append(int(firsts[j]) + i)
        if not flat:
            known = sorted({name for one in self.actuators for name in values_of(one)} | set(_OF_SEGMENT))
            raise ValueError(f"no part of the limb has a number {shown(label)}; there are {', '.join(known)}")
        return _Target(tuple(flat), (), name)

    def value(self, label: str) -> float:
        """The number that a label stands for, SI; where it stands for several, they must be equal.

        A label is a name of `values_of`, or ``ring_radius``, ``plate_mass``, ``plate_thickness``; alone it stands for
        that number in the whole limb, after ``segments[0].`` in a segment, after ``segments[0].actuators[1].`` (or
        ``actuators[1].`` in every segment) in one actuator.

        Raises
        ------
        ValueError
            Nothing has this name, or the numbers differ.
        """
        target = self._target(label)
        values = [values_of(self.actuators[i])[target.name] for i in target.actuators]
        for j in target.segments:
            segment = self.segments[j]
            own = {"plate_mass": segment.plate.mass, "plate_thickness": segment.plate.thickness}
            values.append(own.get(target.name, segment.ring_radius or 0.0))
        if len(set(values)) > 1:
            differ = sorted(set(values))
            raise ValueError(f"{label} stands for numbers that differ, {differ}: name one segment or actuator")
        return values[0]

    def changed(self, values: Mapping[str, float]) -> DrivenLimb:
        """The limb with other values of what labels stand for.

        Raises
        ------
        ValueError
            A label is unknown, or a value is not legal.
        """
        actuators, segments = list(self.actuators), list(self.segments)
        per_actuator: dict[int, dict[str, float]] = {}
        for label, value in values.items():
            target = self._target(label)
            for i in target.actuators:
                per_actuator.setdefault(i, {})[target.name] = value
            for j in target.segments:
                if target.name == "ring_radius":
                    segments[j] = replace(segments[j], ring_radius=value)
                else:
                    plate = replace(segments[j].plate, **{target.name.removeprefix("plate_"): value})
                    segments[j] = replace(segments[j], plate=plate)
        made: dict[Any, Any] = {}  # what was one object stays one, so that it is solved once
        for i, own in per_actuator.items():
            key = (id(actuators[i]), tuple(own.items()))
            if key not in made:
                made[key] = changed_actuator(actuators[i], own)
            actuators[i] = made[key]
        first = 0
        for j, segment in enumerate(segments):
            last = first + len(segment.actuators)
            segments[j] = replace(segment, actuators=tuple(actuators[first:last]))
            first = last
        return DrivenLimb(tuple(segments))

    def moves(
        self, pressures: ArrayLike, labels: Sequence[str], *, at: ArrayLike | None = None, **scene: Any
    ) -> Moves | None:
        """A posture and how plates and points of the centreline move with pressures and numbers; None where it fails.

        Parameters
        ----------
        pressures : array_like, shape (A,)
            [Pa]
        labels : sequence of str
            As for `value`.
        at : array_like, shape (n,), optional
            Shares of the centreline whose points are wanted.
        **scene
            Loads and options of `Limb.solve`.

        Raises
        ------
        ValueError
            A label is unknown, or the arguments do not make a scene.
        """
        given = self._pressures(pressures)
        targets = [self._target(label) for label in labels]
        names = [list(dict.fromkeys(t.name for t in targets if i in t.actuators)) for i in range(len(given))]
        try:
            rods = self._rods(given, names)
            limb = self._limb(rods)
        except ValueError:
            return None  # no actuator of these numbers has a state at this pressure
        posture = limb.solve(**scene)
        if not (posture.success and posture.stable):
            return None
        of = ("plates",) if at is None else ("plates", "centreline")
        by_rods = posture.derivative(of, ("length", "section"), each="actuator", at=[1.0] if at is None else at)
        rows = len(by_rods.rows)
        # Columns segment by segment and rod by rod: length, then the section's fields.
        blocks = _blocks(by_rods, limb, rows)
        by_pressures = np.stack([block @ one.by_pressure for block, one in zip(blocks, rods, strict=True)], axis=1)
        by_values = np.zeros((rows, len(labels)))
        kinds = sorted({t.name for t in targets if t.segments})
        by_segments = posture.derivative(of, kinds, each="segment", at=[1.0] if at is None else at) if kinds else None
        for k, target in enumerate(targets):
            for i in target.actuators:
                by_values[:, k] += blocks[i] @ rods[i].by_values[names[i].index(target.name)]
            for j in target.segments:
                assert by_segments is not None
                by_values[:, k] += by_segments[f"segments[{j}].{target.name}"]
        return Moves(posture, by_pressures, by_values)


def _blocks(by_rods: Any, limb: Limb, rows: int) -> list[Array]:
    """For each rod the columns of its length and section fields, shape (rows, 8), from the labels."""
    place = {label: k for k, label in enumerate(by_rods.columns)}
    blocks = []
    for j, segment in enumerate(limb.segments):
        for i in range(len(segment.members)):
            prefix = f"segments[{j}].rods[{i}]."
            fields = ["length", *(f"section.{name}" for name in SECTION_FIELDS)]
            blocks.append(by_rods.matrix[:, [place[prefix + name] for name in fields]])
    assert all(block.shape == (rows, 8) for block in blocks)
    return blocks
