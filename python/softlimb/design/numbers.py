"""The numbers that a limb is made of, by the names that derivatives have: changed one by one, and built from."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from softlimb.derivatives import columns, names_of_design
from softlimb.limb import Limb, Plate, Segment
from softlimb.tube import Fibres, Layer, Tube

__all__ = ["LimbNumbers", "design_names", "real"]


def real(value: Any) -> float:
    """The number itself, where it carries an imaginary part for the sake of a derivative."""
    return float(value.real)


@dataclass(frozen=True)
class _Read:
    """What a limb gives once: the number of every label, and where it belongs."""

    values: Mapping[str, float]
    units: Mapping[str, str]
    places: Mapping[str, tuple[int, Any]]  # segment, part as the derivatives name it

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
        changed: dict[int, dict[Any, float]] = {}
        for label, value in self._values.items():
            if value != self._read.values[label]:
                segment, part = self._read.places[label]
                changed.setdefault(segment, {})[part] = real(value)
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
    made = columns(limb, design_names(limb), "segment")
    values, units, places = {}, {}, {}
    for label, unit, parts in zip(made.labels.columns, made.labels.column_units, made.parts, strict=True):
        j = int(label.split("[", 1)[1].split("]", 1)[0])
        if not isinstance(limb.segments[j].members[0], Tube) and "rod" in parts[0].kind:
            continue  # rods given directly stay as they are
        part = (parts[0].kind, parts[0].layer, parts[0].number, parts[0].twin, parts[0].factor)
        values[label], units[label], places[label] = _number(limb.segments[j], part), unit, (j, part)
    return _Read(values, units, places)


def _number(segment: Segment, part: Any) -> float:
    kind, layer, number, _, factor = part
    if kind == "placement":
        return float(segment.ring_radius or 0.0)
    if kind.startswith("plate "):
        return float(getattr(segment.plate, kind.removeprefix("plate ")))
    tube, name = segment.members[0], kind.removeprefix("tube ")
    assert isinstance(tube, Tube)
    if name in ("length", "cap_length", "mass"):
        return float(getattr(tube, name))
    if name == "radius":
        return float(tube.layers[0].inner if number == 0 else tube.layers[number - 1].outer)
    if name == "density":
        return float(tube.layers[layer].law.density)
    if name == "coefficient":
        return float(_coefficients(tube.layers[layer].law)[number])
    return float(factor * getattr(tube.layers[layer].fibres[number], name))


def _coefficients(law: Any) -> list[float]:
    """Numbers of a law in the order in which the core names them."""
    flat: list[float] = []
    for value in law.parameters.values():
        flat.extend(np.atleast_1d(value).tolist())
    return flat


def _changed(segment: Segment, numbers: Mapping[Any, float]) -> Segment:
    """The segment with some of its numbers replaced."""
    given = {part[0]: value for part, value in numbers.items()}
    plate = segment.plate
    if "plate mass" in given or "plate thickness" in given:
        plate = Plate(given.get("plate thickness", plate.thickness), given.get("plate mass", plate.mass))
    members = segment.members
    first = members[0]
    of_tube = {part: value for part, value in numbers.items() if part[0].startswith("tube ")}
    if of_tube and isinstance(first, Tube):
        members = (_changed_tube(first, of_tube),) * len(members)
    if segment.ring_radius is None:
        place: dict[str, Any] = {"base_frames": segment.base_frames, "end_frames": segment.end_frames}
    else:
        place = {"ring_radius": given.get("placement", segment.ring_radius)}
    if isinstance(first, Tube):
        return Segment(actuators=_tubes(members), plate=plate, **place)
    return Segment(rods=segment.rods, plate=plate, **place)


def _tubes(members: Sequence[Any]) -> list[Tube]:
    return [member for member in members if isinstance(member, Tube)]


def _changed_tube(tube: Tube, numbers: Mapping[Any, float]) -> Tube:
    faces = [tube.layers[0].inner, *(layer.outer for layer in tube.layers)]
    families: list[list[list[Any]]] = [
        [[f.angle, f.modulus, f.fraction, f.stiffness] for f in layer.fibres] for layer in tube.layers
    ]
    coefficients: list[list[float]] = [_coefficients(layer.law) for layer in tube.layers]
    densities = [layer.law.density for layer in tube.layers]
    whole = {"length": tube.length, "cap_length": tube.cap_length, "mass": tube._given_mass}
    for (kind, layer, number, twin, factor), value in numbers.items():
        name = kind.removeprefix("tube ")
        if name in whole:
            whole[name] = value
        elif name == "radius":
            faces[number] = value
        elif name == "density":
            densities[layer] = value
        elif name == "coefficient":
            coefficients[layer][number] = value
        else:
            field = ("angle", "modulus", "fraction", "stiffness").index(name)
            families[layer][number][field] = factor * value
            if twin >= 0:
                families[layer][twin][field] = -factor * value if name == "angle" else value
    layers = [
        Layer(
            faces[n],
            faces[n + 1],
            _law(layer.law, coefficients[n], densities[n]),
            fibres=[_family(*family) for family in families[n]],
        )
        for n, layer in enumerate(tube.layers)
    ]
    length, cap_length, mass = whole["length"], whole["cap_length"], whole["mass"]
    ends: Any = tube.ends
    return Tube(float(length or 0.0), layers, tube.tension_only, ends, mass, float(cap_length or 0.0))


def _family(angle: Any, modulus: Any, fraction: Any, stiffness: Any) -> Fibres:
    if modulus is None:
        return Fibres(angle=angle, stiffness=stiffness)
    return Fibres(angle=angle, modulus=modulus, fraction=fraction)


def _law(law: Any, coefficients: Sequence[float], density: float) -> Any:
    if list(coefficients) == _coefficients(law) and density == law.density:
        return law
    arguments: dict[str, Any] = {}
    rest = list(coefficients)
    for name, value in law.parameters.items():
        if np.ndim(value):
            arguments[name], rest = rest[: len(value)], rest[len(value) :]
        else:
            arguments[name], rest = rest[0], rest[1:]
    return type(law)(**arguments, density=density, max_strain=law.max_strain)
