"""What a design may change: small objects that set numbers of a limb from one value each.

Parameters act one after the other in the order given. They compute with numbers that may carry an imaginary part, from
which the exact derivative of every number is read; so a function of one's own must be analytic (no ``abs``, no
comparison that decides the result).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from softlimb.arguments import one_finite, one_of
from softlimb.design.numbers import LimbNumbers

__all__ = [
    "Factor",
    "FibrePitch",
    "Number",
    "Parameter",
    "RadiusRatio",
    "Rule",
    "TubeScale",
    "at_values",
    "bulk_volume",
    "limb_mass",
    "radius_ratio_of",
    "slopes_at",
]

Array = NDArray[np.float64]
Held = Literal["proximal", "mass", "volume"]
HELD = ("proximal", "mass", "volume")

# f(x + i h) = f(x) + i h f'(x) + O(h^2): with this step the error is far below rounding, and nothing cancels.
_IMAGINARY_STEP = 1e-100


@runtime_checkable
class Parameter(Protocol):
    """One variable of a design: name, unit, bounds, where it starts, and what it does to the numbers of a limb."""

    @property
    def name(self) -> str:
        """For tables and messages."""

    @property
    def lower(self) -> float:
        """Smallest value."""

    @property
    def upper(self) -> float:
        """Largest value."""

    def unit(self, numbers: LimbNumbers) -> str:
        """Unit of the value; "1" where it has none."""

    def start(self, numbers: LimbNumbers) -> float:
        """The value that leaves a limb as it is."""

    def apply(self, numbers: LimbNumbers, value: Any) -> None:
        """Set the numbers."""


def _check_bounds(parameter: Any, lowest: float = -np.inf) -> None:
    name = parameter.name
    lower = one_finite(f"lower bound of {name}", parameter.lower)
    upper = one_finite(f"upper bound of {name}", parameter.upper)
    if not lower < upper:
        raise ValueError(f"bounds of {name} must ascend, got {lower!r} and {upper!r}")
    if lower <= lowest:
        raise ValueError(f"lower bound of {name} must be above {lowest:g}, got {lower!r}")
    object.__setattr__(parameter, "lower", lower)
    object.__setattr__(parameter, "upper", upper)


@dataclass(frozen=True)
class Number:
    """One number of the limb: a radius, a length, a ring radius, a coefficient of a law, a plate's mass.

    Parameters
    ----------
    label : str
        As `LimbNumbers` has it, for instance ``segments[0].ring_radius``; with ``*`` all that match are set alike.
    lower, upper : float
        In the number's SI unit.

    Raises
    ------
    ValueError
        Bounds that do not ascend, or are not finite; when used, a label that the limb does not have.
    """

    label: str
    lower: float
    upper: float

    def __post_init__(self) -> None:
        if not isinstance(self.label, str):
            raise TypeError(f"label must be a text, got {type(self.label).__name__}")
        _check_bounds(self)

    @property
    def name(self) -> str:
        """The label."""
        return self.label

    def unit(self, numbers: LimbNumbers) -> str:
        """That of the number."""
        return numbers.unit(numbers.matching(self.label)[0])

    def start(self, numbers: LimbNumbers) -> float:
        """The mean of the numbers that it sets."""
        return float(np.mean([numbers.given(label) for label in numbers.matching(self.label)]))

    def apply(self, numbers: LimbNumbers, value: Any) -> None:
        """Set the numbers."""
        for label in numbers.matching(self.label):
            numbers[label] = value


@dataclass(frozen=True)
class Factor:
    """A factor on numbers of the limb: all lengths, all coefficients of a skin's law.

    Parameters
    ----------
    labels : str or sequence of str
        As for `Number`: ``segments[*].layers[1].c*`` is the stiffness of all skins of Yeoh's or neo-Hooke's law.
    lower, upper : float
        Of the factor; 1 is the template.
    title : str, optional
        Name in tables. Default: the labels.

    Raises
    ------
    ValueError
        Bounds that do not ascend or are not positive; when used, a label that the limb does not have.
    """

    labels: str | Sequence[str]
    lower: float
    upper: float
    title: str | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.labels, str):
            object.__setattr__(self, "labels", tuple(self.labels))
        if not self.labels:
            raise ValueError("labels of a factor must be at least one, got none")
        _check_bounds(self, 0.0)

    @property
    def name(self) -> str:
        """The title, or what is multiplied."""
        return self.title or f"factor of {', '.join(self._patterns)}"

    @property
    def _patterns(self) -> tuple[str, ...]:
        return (self.labels,) if isinstance(self.labels, str) else tuple(self.labels)

    def unit(self, numbers: LimbNumbers) -> str:
        """None."""
        return "1"

    def start(self, numbers: LimbNumbers) -> float:
        """One."""
        return 1.0

    def apply(self, numbers: LimbNumbers, value: Any) -> None:
        """Multiply the numbers."""
        for label in dict.fromkeys(label for pattern in self._patterns for label in numbers.matching(pattern)):
            numbers[label] = numbers[label] * value


@dataclass(frozen=True)
class TubeScale:
    """A factor on all radii of a segment's tubes and on its ring; their length stays, and so does the thread.

    Thread and pitch are held, so the angle and the fraction of the fibres follow; a mass that was given goes with the
    area of the wall.

    Parameters
    ----------
    segment : int
        From the base, 0 first.
    lower, upper : float
        Of the factor; 1 is the template.
    """

    segment: int
    lower: float
    upper: float

    def __post_init__(self) -> None:
        _check_bounds(self, 0.0)

    @property
    def name(self) -> str:
        """With the segment's number."""
        return f"scale of segment {self.segment}"

    def unit(self, numbers: LimbNumbers) -> str:
        """None."""
        return "1"

    def start(self, numbers: LimbNumbers) -> float:
        """One."""
        return 1.0

    def apply(self, numbers: LimbNumbers, value: Any) -> None:
        """Scale the segment."""
        _scale_segment(numbers, self.segment, value)


@dataclass(frozen=True)
class FibrePitch:
    """The axial distance between turns of a family of thread; angle and fraction of the fibres follow.

    Parameters
    ----------
    segment : int
        From the base, 0 first.
    lower, upper : float
        Of the pitch [m].

    Notes
    -----
    As in `Tube.fibre_reinforced`: the thread lies at the inner face of its layer, tan(angle) = pitch / (2 pi R), and
    the fraction goes with 1 / (cos(angle) pitch).
    """

    segment: int
    lower: float
    upper: float

    def __post_init__(self) -> None:
        _check_bounds(self, 0.0)

    @property
    def name(self) -> str:
        """With the segment's number."""
        return f"fibre pitch of segment {self.segment}"

    def unit(self, numbers: LimbNumbers) -> str:
        """Metres."""
        return "m"

    def start(self, numbers: LimbNumbers) -> float:
        """The pitch of the template's first family of fibres."""
        label = numbers.matching(f"segments[{self.segment}].layers[*].fibre_angle*")[0]
        radius = numbers.given(_face_inside(self.segment, label))
        return float(2.0 * np.pi * radius * np.tan(numbers.given(label)))

    def apply(self, numbers: LimbNumbers, value: Any) -> None:
        """Wind the thread anew."""
        for angle in numbers.matching(f"segments[{self.segment}].layers[*].fibre_angle*"):
            radius = numbers[_face_inside(self.segment, angle)]
            _wind(numbers, angle, value / (2.0 * np.pi * radius), 1.0)


@dataclass(frozen=True)
class RadiusRatio:
    """The radius reduction ratio: inner radius of the last segment's tubes over that of the first's.

    Segment j of J gets the factor s_0 q_j on all radii and on its ring, q_j = (1 + (r - 1) j/(J-1)) over the same with
    the template's own ratio: a straight taper from base to tip, which gives the template back at its own ratio, and
    all segments alike at r = 1 where the template's taper is straight. Lengths, wall proportions, laws, thread and
    pitch stay; tube masses that were given go with the square of the factor; plates stay.

    Parameters
    ----------
    lower, upper : float
        Of the ratio.
    held : {"proximal", "mass", "volume"}
        What fixes s_0: the proximal radius (s_0 = 1), the mass of the whole limb, or the volume that the tubes take up
        (their outer cylinders).

    Raises
    ------
    ValueError
        Bounds that do not ascend or are not positive, an unknown ``held``; when used, a limb of one segment.
    """

    lower: float = 0.3
    upper: float = 1.0
    held: Held = "proximal"

    def __post_init__(self) -> None:
        one_of("held", self.held, HELD)
        _check_bounds(self, 0.0)

    @property
    def name(self) -> str:
        """With what is held."""
        return f"radius ratio ({self.held} held)"

    def unit(self, numbers: LimbNumbers) -> str:
        """None."""
        return "1"

    def start(self, numbers: LimbNumbers) -> float:
        """The template's own ratio."""
        return float(radius_ratio_of(numbers))

    def apply(self, numbers: LimbNumbers, value: Any) -> None:
        """Scale every segment."""
        count = len(numbers.template)
        own = radius_ratio_of(numbers)
        before = {"mass": limb_mass, "volume": bulk_volume}[self.held](numbers) if self.held != "proximal" else 0.0
        for j in range(count):
            share = j / (count - 1)
            _scale_segment(numbers, j, (1.0 + (value - 1.0) * share) / (1.0 + (own - 1.0) * share))
        if self.held == "proximal":
            return
        # What is held goes with the square of one more factor, plates apart.
        fixed = _plate_mass(numbers) if self.held == "mass" else 0.0
        after = {"mass": limb_mass, "volume": bulk_volume}[self.held](numbers)
        common = np.sqrt((before - fixed) / (after - fixed))
        for j in range(count):
            _scale_segment(numbers, j, common)


@dataclass(frozen=True)
class Rule:
    """A parameter of one's own.

    Parameters
    ----------
    name : str
    lower, upper : float
    function : callable
        ``function(numbers, value)`` sets numbers; analytic, and defined at the top of a module where designs are
        evaluated by several processes.
    initial : float
        The value that leaves the limb as it is.
    dimension : str
        Unit of the value, for tables.
    """

    name: str
    lower: float
    upper: float
    function: Callable[[LimbNumbers, Any], None]
    initial: float
    dimension: str = "1"

    def __post_init__(self) -> None:
        if not callable(self.function):
            raise TypeError(f"function of {self.name} must be a callable, got {type(self.function).__name__}")
        _check_bounds(self)

    def unit(self, numbers: LimbNumbers) -> str:
        """As given."""
        return self.dimension

    def start(self, numbers: LimbNumbers) -> float:
        """As given."""
        return self.initial

    def apply(self, numbers: LimbNumbers, value: Any) -> None:
        """Call the function."""
        self.function(numbers, value)


def at_values(template: LimbNumbers, parameters: Sequence[Parameter], values: Array) -> LimbNumbers:
    """The numbers at values of parameters, which act one after the other."""
    numbers = template.copy()
    for parameter, value in zip(parameters, values, strict=True):
        parameter.apply(numbers, float(value))
    return numbers


def slopes_at(template: LimbNumbers, parameters: Sequence[Parameter], values: Array) -> dict[str, Array]:
    """Derivatives of each number that changes to every parameter, by label, shape (parameters,); exact to rounding."""
    slopes: dict[str, Array] = {}
    for k in range(len(parameters)):
        moved = template.copy()
        for i, parameter in enumerate(parameters):
            parameter.apply(moved, complex(values[i], _IMAGINARY_STEP) if i == k else float(values[i]))
        for label in moved.labels:
            imaginary = moved[label].imag
            if imaginary:
                slopes.setdefault(label, np.zeros(len(parameters)))[k] = imaginary / _IMAGINARY_STEP
    return slopes


def radius_ratio_of(numbers: LimbNumbers) -> Any:
    """Inner radius of the last segment's tubes over that of the first's.

    Raises
    ------
    ValueError
        The limb has one segment, or its ends are not made of tubes.
    """
    count = len(numbers.template)
    ends = [f"segments[{j}].radii[0]" for j in (0, count - 1)]
    if count < 2 or any(label not in numbers for label in ends):
        raise ValueError(f"a radius ratio needs two segments of tubes or more, the limb has {numbers.template!r}")
    return numbers[ends[1]] / numbers[ends[0]]


def limb_mass(numbers: LimbNumbers) -> Any:
    """Actuators, rods given directly and plates, as `Limb.mass` [kg]."""
    total = _plate_mass(numbers)
    for j, segment in enumerate(numbers.template):
        if segment.rods:
            total = total + sum(rod.section.mass_per_length * rod.length for rod in segment.rods)
        elif f"segments[{j}].mass" in numbers:
            total = total + len(segment.members) * numbers[f"segments[{j}].mass"]
        else:
            layers = enumerate(_layer_volumes(numbers, j))
            each = sum(volume * numbers[f"segments[{j}].layers[{n}].density"] for n, volume in layers)
            total = total + len(segment.members) * each
    return total


def bulk_volume(numbers: LimbNumbers) -> Any:
    """Volume of the outer cylinders of all tubes, unpressurised [m^3]."""
    counts = [len(segment.actuators) for segment in numbers.template]
    return sum(
        count * np.pi * numbers[_faces(numbers, j)[-1]] ** 2 * numbers[f"segments[{j}].length"]
        for j, count in enumerate(counts)
        if count
    )


def _plate_mass(numbers: LimbNumbers) -> Any:
    return sum(numbers[f"segments[{j}].plate_mass"] for j in range(len(numbers.template)))


def _faces(numbers: LimbNumbers, segment: int) -> tuple[str, ...]:
    return numbers.matching(f"segments[{segment}].radii[*]")


def _layer_volumes(numbers: LimbNumbers, segment: int) -> list[Any]:
    faces, length = [numbers[label] for label in _faces(numbers, segment)], numbers[f"segments[{segment}].length"]
    return [np.pi * (outer**2 - inner**2) * length for inner, outer in pairwise(faces)]


def _face_inside(segment: int, label: str) -> str:
    layer = label.split("layers[", 1)[1].split("]", 1)[0]
    return f"segments[{segment}].radii[{layer}]"


def _scale_segment(numbers: LimbNumbers, segment: int, factor: Any) -> None:
    for label in _faces(numbers, segment):
        numbers[label] = numbers[label] * factor
    for name, power in (("ring_radius", 1), ("cap_length", 1), ("mass", 2)):
        label = f"segments[{segment}].{name}"
        if label in numbers:
            numbers[label] = numbers[label] * factor**power
    for label in [label for label in numbers.labels if label.startswith(f"segments[{segment}].layers[")]:
        if ".fibre_angle" in label:
            _wind(numbers, label, np.tan(numbers[label]) / factor, factor)


def _wind(numbers: LimbNumbers, angle: str, tangent: Any, scale: Any) -> None:
    """Give a family of fibres a new angle, and the share of its layer that the same thread then takes.

    The share goes with R / ((R_o^2 - R^2) cos(angle) pitch) at pitch = 2 pi R tan(angle): with 1 / (scale^2
    sin(angle)) where all radii are scaled alike.
    """
    old, new = numbers[angle], np.arctan(tangent)
    for name in ("fibre_fraction", "fibre_stiffness"):
        label = angle.replace("fibre_angle", name)
        if label in numbers:
            numbers[label] = numbers[label] * np.sin(old) / (np.sin(new) * scale**2)
    numbers[angle] = new
