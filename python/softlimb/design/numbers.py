"""The numbers that a limb is made of, by the names that derivatives have: changed one by one, and built from."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from softlimb.changed import changed_tube, tube_values
from softlimb.derivatives import columns, names_of_design
from softlimb.limb import Limb, Plate, Segment

__all__ = ["LimbNumbers", "design_names", "real"]


def real(value: Any) -> float:
    """The number itself, where it carries an imaginary part for the sake of a derivative."""
    return float(value.real)


@dataclass(frozen=True)
class _Read:
    """What a limb gives once: the number of every label, and where it belongs."""

    values: Mapping[str, float]
    units: Mapping[str, str]
    places: Mapping[str, tuple[int, str]]  # segment, name within it


class LimbNumbers:
    """Numbers of a limb by label, as the columns of `Posture.derivative` with ``each="segment"`` name them.

    ``numbers["segments[0].radii[2]"]`` is the outer radius of a proximal tube of three faces. Parameters read and set
    them; `limb` builds a limb. Numbers may carry an imaginary part, by which derivatives of parameters are taken.

    Parameters
    ----------
    template : Limb
        The limb that the numbers start from. What has no number (kinds of law, frames given one by one) stays.

    Raises
    ------
    ValueError
        The tubes of a segment differ: one number a segment would not say which.
    """

    def __init__(self, template: Limb) -> None:
        if not isinstance(template, Limb):
            raise TypeError(f"template must be a Limb, got {type(template).__name__}")
        self.template = template
        self._read = _read(template)
        self._values: dict[str, Any] = dict(self._read.values)

    @property
    def labels(self) -> tuple[str, ...]:
        """All names."""
        return tuple(self._values)

    def unit(self, label: str) -> str:
        """Unit of a number; KeyError as for reading it."""
        self._known(label)
        return self._read.units[label]

    def given(self, label: str) -> float:
        """The template's own number."""
        self._known(label)
        return self._read.values[label]

    def matching(self, pattern: str) -> tuple[str, ...]:
        """Labels that a pattern with ``*`` covers: ``segments[*].radii[*]``.

        Raises
        ------
        ValueError
            There is none.
        """
        if pattern in self._values:
            return (pattern,)
        expression = re.compile(re.escape(pattern).replace(r"\*", ".*"))
        found = tuple(label for label in self._values if expression.fullmatch(label))
        if not found:
            raise ValueError(f"no number of the limb is called {pattern!r}; there are {_listed(self._values)}")
        return found

    def _known(self, label: str) -> None:
        if label not in self._values:
            raise KeyError(f"no number of the limb is called {label!r}; there are {_listed(self._values)}")

    def __contains__(self, label: str) -> bool:
        return label in self._values

    def __getitem__(self, label: str) -> Any:
        self._known(label)
        return self._values[label]

    def __setitem__(self, label: str, value: Any) -> None:
        self._known(label)
        self._values[label] = value

    def copy(self) -> LimbNumbers:
        """The same numbers, to change apart."""
        other = object.__new__(LimbNumbers)
        other.template, other._read, other._values = self.template, self._read, dict(self._values)
        return other

    def limb(self) -> Limb:
        """The limb that has these numbers.

        Raises
        ------
        ValueError
            There is no such limb: faces that do not ascend, a negative number, an angle beyond a right angle.
        """
        if any(not np.isfinite(real(value)) for value in self._values.values()):
            wrong = next(label for label, value in self._values.items() if not np.isfinite(real(value)))
            raise ValueError(f"{wrong} must be finite, got {real(self._values[wrong])}")
        changed: dict[int, dict[str, float]] = {}
        for label, value in self._values.items():
            if value != self._read.values[label]:
                segment, name = self._read.places[label]
                changed.setdefault(segment, {})[name] = real(value)
        if not changed:
            return self.template
        return Limb(
            [_changed(segment, changed[j]) if j in changed else segment for j, segment in enumerate(self.template)]
        )

    def __repr__(self) -> str:
        return f"LimbNumbers({len(self._values)} numbers of {len(self.template)} segments)"


def _listed(labels: Iterable[str]) -> str:
    return ", ".join(labels)


def design_names(limb: Limb) -> tuple[str, ...]:
    """Names of ``to`` that `LimbNumbers` has numbers of."""
    return tuple(name for name in names_of_design(limb) if name != "section")


@lru_cache(maxsize=64)
def _read(limb: Limb) -> _Read:
    for j, segment in enumerate(limb):
        if any(member != segment.members[0] for member in segment.members):
            raise ValueError(f"the members of segment {j} differ: a design changes those of a segment together")
    own = [{**_segment_values(segment), **_member_values(segment)} for segment in limb]
    labels = columns(limb, design_names(limb), "segment").labels
    values, units, places = {}, {}, {}
    for label, unit in zip(labels.columns, labels.column_units, strict=True):
        number, name = label.removeprefix("segments[").split("].", 1)
        j = int(number)
        if limb.segments[j].rods and name not in own[j]:
            continue  # rods given directly stay as they are
        values[label], units[label], places[label] = own[j][name], unit, (j, name)
    return _Read(values, units, places)


def _segment_values(segment: Segment) -> dict[str, float]:
    """Numbers of a segment that are not its members', by name within it."""
    ring = {} if segment.ring_radius is None else {"ring_radius": float(segment.ring_radius)}
    return {"plate_mass": segment.plate.mass, "plate_thickness": segment.plate.thickness, **ring}


def _member_values(segment: Segment) -> dict[str, float]:
    return tube_values(segment.actuators[0]) if segment.actuators else {}


def _changed(segment: Segment, numbers: Mapping[str, float]) -> Segment:
    """The segment with some of its numbers replaced, by name within it."""
    new = {**_segment_values(segment), **numbers}
    if "ring_radius" in new:
        place: dict[str, Any] = {"ring_radius": new["ring_radius"]}
    else:
        place = {"base_frames": segment.base_frames, "end_frames": segment.end_frames}
    plate = Plate(new["plate_thickness"], new["plate_mass"])
    if segment.rods:
        return Segment(rods=segment.rods, plate=plate, **place)
    of_tube = {name: value for name, value in numbers.items() if name in _member_values(segment)}
    tubes = segment.actuators
    if of_tube:
        tubes = (changed_tube(tubes[0], of_tube),) * len(tubes)
    return Segment(actuators=tubes, plate=plate, **place)
