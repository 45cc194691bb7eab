"""What designs are judged by: numbers of a limb with a name and a unit, to be made large or small, or kept in bounds.

Every criterion is a small object: ``criterion.value(limb)`` is its number, `Criterion.evaluate` gives the exact
derivative to the limb's numbers as well where the core has it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb.arguments import (
    finite_array,
    finite_of_shape,
    joined,
    one_finite,
    one_not_negative,
    one_of,
    one_positive,
    one_whole,
    shown,
)
from softlimb.design.numbers import LimbNumbers, design_names
from softlimb.design.parameters import limb_mass
from softlimb.limb import Limb
from softlimb.payload import Payload as LimbPayload
from softlimb.payload import payload_in_few_steps
from softlimb.posture import Posture
from softlimb.sweep import Batch, bending_angle
from softlimb.tube import TubeState
from softlimb.workspace.hull import convex_hull

__all__ = [
    "SIX_DIRECTIONS",
    "BallooningMargin",
    "Bending",
    "Clearance",
    "Compliance",
    "Criterion",
    "DesignFailure",
    "LawMargin",
    "Mass",
    "Measure",
    "Payload",
    "PressureSet",
    "Product",
    "RingGap",
    "StabilityMargin",
    "TaskPressure",
    "WeightedSum",
    "WorkspaceBox",
    "WorkspaceReach",
    "WorkspaceVolume",
]

Array = NDArray[np.float64]
Slopes = Mapping[str, float]
_Answer = TypeVar("_Answer")

SIX_DIRECTIONS = tuple(tuple(sign * float(k == axis) for k in range(3)) for axis in range(3) for sign in (1.0, -1.0))
"""Along the axes of the base frame, both ways."""


class DesignFailure(RuntimeError):
    """A design whose criterion has no value: no stable posture, a target out of reach. Recorded; the run goes on."""


class Criterion(ABC):
    """A number by which designs are judged."""

    @property
    @abstractmethod
    def name(self) -> str:
        """For tables and messages; different for different criteria of one problem."""

    @property
    @abstractmethod
    def unit(self) -> str:
        """Unit of the value; "1" where it has none."""

    @abstractmethod
    def evaluate(self, limb: Limb, slopes: bool) -> tuple[float, Slopes | None]:
        """Value, and where asked for its derivatives to the numbers of the limb, by label; what is missing is zero.

        None in place of derivatives: not asked for, or not known exactly; differences then take their place.

        Raises
        ------
        DesignFailure
            The limb has no such number.
        """

    def require(self, limb: Limb) -> None:
        """ValueError where no design of this limb could have the number: that is a mistake and no failed design."""
        pressures = getattr(self, "pressures", None)
        if pressures is None or isinstance(pressures, PressureSet):
            return
        for row in pressures if isinstance(self, Clearance) and np.ndim(pressures) == 2 else [pressures]:
            given, wanted = len(joined("pressures", row).ravel()), len(limb._tubes)
            if given != wanted:
                raise ValueError(f"pressures of {self.name} must be {wanted}, one an actuator, got {given}")

    def value(self, limb: Limb) -> float:
        """The number alone; errors as for `evaluate`."""
        return self.evaluate(limb, False)[0]


def _analytic(function: Callable[[LimbNumbers], Any], limb: Limb) -> Slopes:
    """Derivatives of a function of a limb's numbers by each of them, by steps along the imaginary axis."""
    numbers, step, found = LimbNumbers(limb), 1e-100, {}
    for label in numbers.labels:
        moved = numbers.copy()
        moved[label] = complex(moved[label], step)
        slope = float(np.imag(function(moved))) / step
        if slope:
            found[label] = slope
    return found


def _check_pressures(value: Any) -> None:
    finite_array("pressures", joined("pressures", value))


def _by_numbers(posture: Posture, **weights: Any) -> dict[str, float]:
    found = posture.gradient(design_names(posture.limb), each="segment", **weights)
    return dict(zip(found.columns, found.values.tolist(), strict=True))


def _kept(limb: Limb, key: tuple[Any, ...], make: Callable[[], _Answer]) -> _Answer:
    """An answer of a limb that several criteria ask for, computed once."""
    answers: dict[Any, _Answer] = limb.__dict__.setdefault("_design_answers", {})
    if key not in answers:
        answers[key] = make()
    return answers[key]


def _posture(limb: Limb, pressures: Any, scene: Mapping[str, Any]) -> Posture:
    key = ("posture", joined("pressures", pressures).tobytes(), repr(scene))
    posture = _kept(limb, key, lambda: limb.solve(pressures, **scene))
    if not posture.success or not posture.stable:
        raise DesignFailure(f"no stable posture: {posture.message}")
    return posture


def _inflated(limb: Limb, pressure: float) -> list[TubeState]:
    """States of the limb's different tubes, all at one pressure."""
    states = [tube.inflate(pressure) for tube in dict.fromkeys(limb._tubes)]
    for state in states:
        if not state.success:
            raise DesignFailure(f"a tube has no state at {pressure:.6g} Pa: {state.message}")
    return states


def _added(parts: Sequence[tuple[Any, Slopes]]) -> dict[str, float]:
    total: dict[str, float] = {}
    for factor, slopes in parts:
        for label, value in slopes.items():
            total[label] = total.get(label, 0.0) + factor * value
    return total


@dataclass(frozen=True)
class Mass(Criterion):
    """Mass of the limb, base plate excluded [kg]."""

    name = "mass"
    unit = "kg"

    def evaluate(self, limb: Limb, slopes: bool) -> tuple[float, Slopes | None]:
        """Exact."""
        return limb.mass, _analytic(limb_mass, limb) if slopes else None


@dataclass(frozen=True)
class RingGap(Criterion):
    """Gap between neighbouring tubes of a segment's ring, unpressurised and straight [m]; negative: they overlap.

    Parameters
    ----------
    segment : int
        From the base, 0 first; of three tubes or more on a ring.
    """

    segment: int
    unit = "m"

    @property
    def name(self) -> str:
        """With the segment's number."""
        return f"ring gap of segment {self.segment}"

    def require(self, limb: Limb) -> None:
        """The limb has the segment."""
        if one_whole("segment", self.segment, 0) >= len(limb):
            raise ValueError(f"segment of a ring gap must be below {len(limb)}, got {self.segment}")

    def evaluate(self, limb: Limb, slopes: bool) -> tuple[float, Slopes | None]:
        """Exact."""
        gap = _analytic(self._gap, limb) if slopes else None
        return float(self._gap(LimbNumbers(limb))), gap

    def _gap(self, numbers: LimbNumbers) -> Any:
        radius = numbers[numbers.matching(f"segments[{self.segment}].radii[*]")[-1]]
        count = len(numbers.template.segments[self.segment].members)
        return 2.0 * (numbers[f"segments[{self.segment}].ring_radius"] * np.sin(np.pi / count) - radius)


@dataclass(frozen=True)
class Payload(Criterion):
    """Force at the tip at which it has moved by a limit, or before stability ends [N].

    Parameters
    ----------
    pressures : array_like, shape (A,)
        Of the posture that is loaded [Pa].
    max_deflection : float
        Largest distance of the tip from where it is without the force [m].
    directions : array_like, shape (D, 3)
        Base axes; their lengths do not matter. Default: along the six half axes.
    combine : {"smallest", "mean"}
        Of the directions.
    scene : mapping
        Other arguments of `Limb.solve`: gravity, tolerance.

    Notes
    -----
    `payload_in_few_steps`. Where the deflection is the limit the derivative is that of the deflection at the force
    held, over the growth of the deflection by the force; where stability is the limit there is none.
    """

    pressures: ArrayLike
    max_deflection: float
    directions: ArrayLike = SIX_DIRECTIONS
    combine: Literal["smallest", "mean"] = "smallest"
    scene: Mapping[str, Any] = field(default_factory=dict)
    unit = "N"

    def __post_init__(self) -> None:
        _check_pressures(self.pressures)
        one_positive("max_deflection", self.max_deflection)
        one_of("combine", self.combine, ("smallest", "mean"))
        count = len(np.atleast_2d(np.asarray(self.directions, dtype=object)))
        along = finite_of_shape("directions", self.directions, (count, 3))
        if not count or not np.linalg.norm(along, axis=1).all():
            raise ValueError(f"directions must be at least one, and none of them zero, got {shown(self.directions)}")

    @property
    def name(self) -> str:
        """With the number of directions."""
        along = np.asarray(self.directions, dtype=float)
        if len(along) == 1:
            return f"payload along ({', '.join(f'{x:g}' for x in along[0])})"
        return f"{self.combine} payload of {len(along)} directions"

    def by_direction(self, limb: Limb) -> list[LimbPayload]:
        """Force, limit and posture of each direction; DesignFailure as for the value."""
        unloaded = _posture(limb, self.pressures, self.scene)

        def one(along: Array) -> LimbPayload:
            key = ("payload", id(unloaded), self.max_deflection, along.tobytes())
            make = partial(payload_in_few_steps, unloaded, along, max_deflection=self.max_deflection)
            return _kept(limb, key, make)

        return [one(along) for along in np.asarray(self.directions, dtype=float)]

    def evaluate(self, limb: Limb, slopes: bool) -> tuple[float, Slopes | None]:
        """Exact where the deflection is the limit."""
        found = self.by_direction(limb)
        forces = np.array([each.force for each in found])
        if self.combine == "smallest":
            least = int(np.argmin(forces))
            chosen = [(1.0, least)]
            value = float(forces[least])
        else:
            chosen = [(1.0 / len(found), k) for k in range(len(found))]
            value = float(forces.mean())
        if not slopes or any(found[k].limit != "deflection" for _, k in chosen):
            return value, None
        along = np.asarray(self.directions, dtype=float)
        return value, _added([(share, _payload_slopes(found[k], along[k])) for share, k in chosen])


def _payload_slopes(found: LimbPayload, direction: Array) -> Slopes:
    moved = found.posture.tip[:3, 3] - found.unloaded.tip[:3, 3]
    outwards = moved / np.linalg.norm(moved)
    growth = outwards @ found.posture.compliance[:3, :3] @ (direction / np.linalg.norm(direction))
    weights = np.concatenate([outwards, np.zeros(3)])
    loaded, unloaded = _by_numbers(found.posture, tip=weights), _by_numbers(found.unloaded, tip=weights)
    return _added([(-1.0 / growth, loaded), (1.0 / growth, unloaded)])


@dataclass(frozen=True)
class Compliance(Criterion):
    """Displacement of the tip along a force on it, by the force, in the mean over all its directions [m/N].

    A third of the trace of the compliance; the displacement across the force does not count.

    Parameters
    ----------
    pressures : array_like, shape (A,)
        [Pa]
    scene : mapping
        Other arguments of `Limb.solve`.
    """

    pressures: ArrayLike
    scene: Mapping[str, Any] = field(default_factory=dict)
    name = "compliance"
    unit = "m/N"

    def __post_init__(self) -> None:
        _check_pressures(self.pressures)

    def evaluate(self, limb: Limb, slopes: bool) -> tuple[float, Slopes | None]:
        """By differences."""
        posture = _posture(limb, self.pressures, self.scene)
        return float(np.trace(posture.compliance[:3, :3]) / 3.0), None


@dataclass(frozen=True)
class StabilityMargin(Criterion):
    """Smallest stiffness of the plates in a posture, as `Posture.smallest_stiffness` [N m].

    Parameters
    ----------
    pressures : array_like, shape (A,)
        [Pa]
    scene : mapping
        Other arguments of `Limb.solve`, the load among them.
    """

    pressures: ArrayLike
    scene: Mapping[str, Any] = field(default_factory=dict)
    name = "smallest stiffness"
    unit = "N m"

    def __post_init__(self) -> None:
        _check_pressures(self.pressures)

    def evaluate(self, limb: Limb, slopes: bool) -> tuple[float, Slopes | None]:
        """By differences."""
        return _posture(limb, self.pressures, self.scene).smallest_stiffness, None


@dataclass(frozen=True)
class Clearance(Criterion):
    """Smallest gap between two tubes in some postures [m]; negative where they overlap.

    Parameters
    ----------
    pressures : array_like, shape (N, A)
        One row a posture [Pa].
    scene : mapping
        Other arguments of `Limb.solve`.
    """

    pressures: ArrayLike
    scene: Mapping[str, Any] = field(default_factory=dict)
    name = "clearance"
    unit = "m"

    def __post_init__(self) -> None:
        _check_pressures(self.pressures)

    def evaluate(self, limb: Limb, slopes: bool) -> tuple[float, Slopes | None]:
        """By differences."""
        gaps = [_posture(limb, row, self.scene).clearance for row in np.atleast_2d(np.asarray(self.pressures))]
        known = [gap for gap in gaps if gap is not None]
        if not known:
            raise DesignFailure("the limb has no two tubes whose gap could be measured")
        return min(known), None


@dataclass(frozen=True)
class LawMargin(Criterion):
    """How far the walls of all tubes stay within the strains that their laws were fitted to, at a pressure [1].

    The smallest difference between a law's ``max_strain`` and the largest principal strain of its layer, which one of
    its faces has; negative beyond the fit. Laws without a range do not count.

    Parameters
    ----------
    pressure : float
        Gauge pressure of every tube [Pa].
    """

    pressure: float
    name = "margin of law range"
    unit = "1"

    def __post_init__(self) -> None:
        one_not_negative("pressure", self.pressure)

    def evaluate(self, limb: Limb, slopes: bool) -> tuple[float, Slopes | None]:
        """By differences."""
        margins = []
        for state in _inflated(limb, self.pressure):
            volume, layers = state.stretch * state.inner_radius**2, state.tube.layers
            for layer in layers:
                if not layer.law.max_strain:
                    continue
                for face in (layer.inner, layer.outer):
                    radius = np.sqrt((volume + face**2 - layers[0].inner ** 2) / state.stretch)
                    hoop_axial = [[radius / face, radius * state.twist_rate], [0.0, state.stretch]]
                    largest = max(np.linalg.norm(hoop_axial, 2), face / (radius * state.stretch))
                    margins.append(layer.law.max_strain + 1.0 - largest)
        if not margins:
            raise DesignFailure("no law of the limb states the strains that it was fitted to")
        return float(min(margins)), None


@dataclass(frozen=True)
class BallooningMargin(Criterion):
    """Smallest eigenvalue of the tubes' energy at a pressure, as `TubeState.smallest_eigenvalue` [N].

    Positive where every tube stands; zero where the first one balloons. Past that a design fails.

    Parameters
    ----------
    pressure : float
        Gauge pressure of every tube [Pa], with the safety that is wanted.
    """

    pressure: float
    name = "ballooning margin"
    unit = "N"

    def __post_init__(self) -> None:
        one_not_negative("pressure", self.pressure)

    def evaluate(self, limb: Limb, slopes: bool) -> tuple[float, Slopes | None]:
        """By differences."""
        return float(min(state.smallest_eigenvalue for state in _inflated(limb, self.pressure))), None


@dataclass(frozen=True)
class TaskPressure(Criterion):
    """Largest pressure that some targets of the tip need, each with the least effort [Pa].

    Parameters
    ----------
    positions : array_like, shape (N, 3)
        Targets [m]. One that is out of reach fails the design.
    max_pressure : float
        What no actuator may exceed [Pa].
    scene : mapping
        Loads, as `Limb.reach` takes them.
    """

    positions: ArrayLike
    max_pressure: float
    scene: Mapping[str, Any] = field(default_factory=dict)
    name = "pressure for tasks"
    unit = "Pa"

    def __post_init__(self) -> None:
        one_positive("max_pressure", self.max_pressure)
        finite_of_shape("positions", self.positions, (len(np.atleast_2d(np.asarray(self.positions))), 3))

    def evaluate(self, limb: Limb, slopes: bool) -> tuple[float, Slopes | None]:
        """By differences."""
        needed = 0.0
        for place in np.asarray(self.positions, dtype=float):
            found = limb.reach(position=place, max_pressure=self.max_pressure, **self.scene)
            if not found.reached:
                raise DesignFailure(f"the target {place.tolist()} is not reached: {found.message}")
            needed = max(needed, float(found.pressures.max()))
        return needed, None


@dataclass(frozen=True, eq=False)
class PressureSet:
    """A fixed set of pressures for workspaces: a path that fills the box from zero to a largest pressure.

    Every actuator's pressure rises and falls evenly, so that it takes all values alike, at a pace of its own between
    two and ``fastest`` rounds and from a phase of its own, both seeded. Rows that follow each other are neighbours,
    which a sweep makes use of (``ordered=True``).

    Parameters
    ----------
    max_pressure : float
        [Pa]
    count : int
        Number of postures.
    seed : int
    fastest : float
        Rounds of the fastest actuator; more fill the box better and make neighbours differ more.
    scene : mapping
        Other arguments of `Limb.solve`: gravity, tolerance.
    """

    max_pressure: float
    count: int = 512
    seed: int = 0
    fastest: float = 8.0
    scene: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        one_positive("max_pressure", self.max_pressure)
        one_positive("fastest", self.fastest)
        one_whole("count", self.count, 4)
        one_whole("seed", self.seed, 0)

    def rows(self, actuators: int) -> Array:
        """The pressures [Pa], shape (count, actuators)."""
        generator = np.random.default_rng(self.seed)
        pace = generator.permutation(np.geomspace(2.0, max(self.fastest, 2.0), actuators))
        phase = generator.uniform(size=actuators)
        place = phase + np.linspace(0.0, 1.0, self.count)[:, None] * pace
        rows: Array = self.max_pressure * (1.0 - np.abs(1.0 - 2.0 * (place % 1.0)))
        return rows

    def sweep(self, limb: Limb) -> Batch:
        """Postures of a limb at these pressures, kept with the limb.

        Raises
        ------
        DesignFailure
            A row has no stable posture.
        """
        return _kept(limb, ("sweep", repr(self)), lambda: _swept(limb, self))

    def __repr__(self) -> str:
        scene = f", scene={dict(self.scene)!r}" if self.scene else ""
        return f"PressureSet({self.max_pressure!r}, {self.count}, {self.seed}, {self.fastest!r}{scene})"


def _swept(limb: Limb, pressures: PressureSet) -> Batch:
    rows = pressures.rows(len(limb._tubes))
    batch = limb.sweep(rows, threads=1, progress=False, ordered=True, **pressures.scene)
    bad = np.flatnonzero(~(batch.success & batch.stable))
    if bad.size:
        first = int(bad[0])
        why = batch.message[first] if not batch.success[first] else "unstable"
        raise DesignFailure(f"{bad.size} of {len(rows)} postures of the workspace, row {first} first: {why}")
    return batch


class _OfWorkspace(Criterion):
    """A number of the tips' poses in a workspace, with its derivatives to them."""

    pressures: PressureSet

    @abstractmethod
    def _of_tips(self, tips: Array, slopes: bool) -> tuple[float, dict[int, Array]]:
        """Value, and where asked for by number of a posture its tip's weights (6,), those that are zero left out."""

    def __post_init__(self) -> None:
        if not isinstance(self.pressures, PressureSet):
            raise TypeError(f"pressures must be a PressureSet, got {shown(self.pressures)}")

    def evaluate(self, limb: Limb, slopes: bool) -> tuple[float, Slopes | None]:
        """Exact: postures that count are solved once more for their derivatives."""
        tips = self.pressures.sweep(limb).tip
        value, weights = self._of_tips(tips, slopes)
        if not slopes:
            return value, None
        rows = self.pressures.rows(len(limb._tubes))
        parts = []
        for number, weight in weights.items():
            near = self.pressures.sweep(limb).plates[number]
            posture = limb.solve(rows[number], start=near, **self.pressures.scene)
            if not posture.success or not posture.stable:
                raise DesignFailure(f"row {number} of the workspace is not found again: {posture.message}")
            parts.append((1.0, _by_numbers(posture, tip=weight)))
        return value, _added(parts)


@dataclass(frozen=True)
class WorkspaceVolume(_OfWorkspace):
    """Volume of the convex hull of the tip's positions [m^3]; needs scipy."""

    pressures: PressureSet
    name = "workspace volume"
    unit = "m^3"

    def _of_tips(self, tips: Array, slopes: bool) -> tuple[float, dict[int, Array]]:
        hull = convex_hull(tips[:, :3, 3])
        if hull is None:
            raise DesignFailure("the tips of the workspace lie in a plane: they enclose no volume")
        weights: dict[int, Array] = {}
        for corners, plane in zip(hull.simplices, hull.equations, strict=True) if slopes else ():
            # Six volumes of the pyramid over a facet are a determinant, linear in each corner.
            a, b, c = (hull.points[k] for k in corners)
            sign = np.sign(np.cross(b - a, c - a) @ plane[:3])
            for corner, (p, q) in zip(corners, ((b, c), (c, a), (a, b)), strict=True):
                weight = weights.setdefault(int(corner), np.zeros(6))
                weight[:3] += sign * np.cross(p, q) / 6.0
        return float(hull.volume), weights


@dataclass(frozen=True)
class WorkspaceBox(_OfWorkspace):
    """Extent of the tip's positions along one axis of the base frame [m].

    Parameters
    ----------
    pressures : PressureSet
    axis : {"x", "y", "z"}
    """

    pressures: PressureSet
    axis: Literal["x", "y", "z"] = "x"
    unit = "m"

    def __post_init__(self) -> None:
        super().__post_init__()
        one_of("axis", self.axis, ("x", "y", "z"))

    @property
    def name(self) -> str:
        """With the axis."""
        return f"workspace along {self.axis}"

    def _of_tips(self, tips: Array, slopes: bool) -> tuple[float, dict[int, Array]]:
        along = "xyz".index(self.axis)
        places = tips[:, along, 3]
        low, high, one = int(np.argmin(places)), int(np.argmax(places)), np.eye(6)[along]
        return float(places[high] - places[low]), {low: -one, high: one}


@dataclass(frozen=True)
class WorkspaceReach(_OfWorkspace):
    """Largest distance of the tip from the base's z axis [m]."""

    pressures: PressureSet
    name = "workspace reach"
    unit = "m"

    def _of_tips(self, tips: Array, slopes: bool) -> tuple[float, dict[int, Array]]:
        sideways = np.linalg.norm(tips[:, :2, 3], axis=1)
        far = int(np.argmax(sideways))
        weight = np.zeros(6)
        weight[:2] = tips[far, :2, 3] / sideways[far]
        return float(sideways[far]), {far: weight}


@dataclass(frozen=True)
class Bending(_OfWorkspace):
    """Flexibility: mean angle between the tip's axis and the base's over a set of pressures [rad]."""

    pressures: PressureSet
    name = "mean bending angle"
    unit = "rad"

    def _of_tips(self, tips: Array, slopes: bool) -> tuple[float, dict[int, Array]]:
        axes = tips[:, :3, 2]
        sideways = np.linalg.norm(axes[:, :2], axis=1)
        weights = {}
        for k in np.flatnonzero(sideways > 0.0) if slopes else ():
            # The angle grows by the rotation about the axis e_z x t.
            weights[int(k)] = np.array([0, 0, 0, -axes[k, 1], axes[k, 0], 0]) / sideways[k] / len(tips)
        return float(bending_angle(tips).mean()), weights


@dataclass(frozen=True)
class WeightedSum(Criterion):
    """Sum of criteria, each times a weight that brings it to a common unit.

    Parameters
    ----------
    terms : sequence of (Criterion, float)
        Criteria and weights; a weight's unit is one over the criterion's.
    """

    terms: Sequence[tuple[Criterion, float]]
    unit = "1"

    def __post_init__(self) -> None:
        object.__setattr__(self, "terms", _terms(self.terms))

    @property
    def name(self) -> str:
        """With its terms."""
        return " + ".join(f"{weight:g} {criterion.name}" for criterion, weight in self.terms)

    def require(self, limb: Limb) -> None:
        """As each term requires."""
        _require_terms(self.terms, limb)

    def evaluate(self, limb: Limb, slopes: bool) -> tuple[float, Slopes | None]:
        """Exact where all terms are."""
        found = [(weight, criterion.evaluate(limb, slopes)) for criterion, weight in self.terms]
        parts = [(weight, each[1]) for weight, each in found if each[1] is not None]
        value = sum(weight * each[0] for weight, each in found)
        return value, _added(parts) if slopes and len(parts) == len(found) else None


@dataclass(frozen=True)
class Product(Criterion):
    """Product of powers of criteria: a weighting that no unit and no range changes.

    Parameters
    ----------
    terms : sequence of (Criterion, float)
        Criteria, whose values must be positive, and exponents.
    """

    terms: Sequence[tuple[Criterion, float]]
    unit = "1"

    def __post_init__(self) -> None:
        object.__setattr__(self, "terms", _terms(self.terms))

    @property
    def name(self) -> str:
        """With its terms."""
        return " x ".join(f"({criterion.name})^{power:g}" for criterion, power in self.terms)

    def require(self, limb: Limb) -> None:
        """As each term requires."""
        _require_terms(self.terms, limb)

    def evaluate(self, limb: Limb, slopes: bool) -> tuple[float, Slopes | None]:
        """Exact where all terms are."""
        found = [(power, criterion, criterion.evaluate(limb, slopes)) for criterion, power in self.terms]
        for _, criterion, (value, _) in found:
            if value <= 0.0:
                raise DesignFailure(f"a product needs positive values, {criterion.name} is {value:.6g}")
        product = float(np.prod([value**power for power, _, (value, _) in found]))
        parts = [(product * power / value, each) for power, _, (value, each) in found if each is not None]
        return product, _added(parts) if slopes and len(parts) == len(found) else None


def _require_terms(terms: Sequence[tuple[Criterion, float]], limb: Limb) -> None:
    for criterion, _ in terms:
        criterion.require(limb)


def _terms(terms: Sequence[tuple[Criterion, float]]) -> tuple[tuple[Criterion, float], ...]:
    checked = []
    for term in terms:
        if not isinstance(term, Sequence) or len(term) != 2 or not isinstance(term[0], Criterion):
            raise TypeError(f"terms must be pairs of a criterion and a number, got {shown(term)}")
        criterion, weight = term
        checked.append((criterion, one_finite("weight", weight)))
    if not checked:
        raise ValueError("terms must be at least one, got none")
    return tuple(checked)


@dataclass(frozen=True)
class Measure(Criterion):
    """A criterion of one's own.

    Parameters
    ----------
    title : str
        Its name.
    function : callable
        Limb -> number. May raise `DesignFailure`.
    dimension : str
        Its unit.
    """

    title: str
    function: Callable[[Limb], float]
    dimension: str = "1"

    def __post_init__(self) -> None:
        if not callable(self.function):
            raise TypeError(f"function of {self.title} must be a callable, got {type(self.function).__name__}")

    @property
    def name(self) -> str:
        """The title."""
        return self.title

    @property
    def unit(self) -> str:
        """The dimension."""
        return self.dimension

    def evaluate(self, limb: Limb, slopes: bool) -> tuple[float, Slopes | None]:
        """By differences."""
        return one_finite(self.title, self.function(limb)), None
