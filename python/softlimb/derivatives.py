"""Derivatives of a posture to pressures, loads, and everything that the limb is made of, with names and units."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb import _core
from softlimb.arguments import finite_of_shape, one_finite, one_of, shown
from softlimb.changed import fibre_groups
from softlimb.tube import Tube

if TYPE_CHECKING:
    from softlimb.limb import Limb
    from softlimb.posture import Posture

__all__ = ["DESIGN", "LOADS", "Derivative", "Gradient"]

Array = NDArray[np.float64]
Each = Literal["actuator", "segment", "limb"]


class _Part(NamedTuple):
    """One number of the limb or its loads, as the core names it."""

    kind: str
    place: int = 0
    layer: int = 0
    number: int = 0
    twin: int = -1  # another family of fibres, whose angle changes the other way
    direction: list[float] | None = None
    factor: float = 1.0


_XYZ = ("x", "y", "z")
_WRENCH = (("fx", "N"), ("fy", "N"), ("fz", "N"), ("mx", "N m"), ("my", "N m"), ("mz", "N m"))
_POSE = (("x", "m"), ("y", "m"), ("z", "m"), ("rx", "rad"), ("ry", "rad"), ("rz", "rad"))
_SECTION = (
    ("axial", "N"),
    ("shear", "N"),
    ("bending", "N m^2"),
    ("torsion", "N m^2"),
    ("mass_per_length", "kg/m"),
    ("rest_twist", "rad/m"),
    ("extension_twist", "1/(N m)"),
)

LOADS = ("gravity", "tip_force", "tip_moment")
DESIGN = (
    "length",
    "radii",
    "fibre_angle",
    "fibre_fraction",
    "law",
    "ring_radius",
    "plate_mass",
    "plate_thickness",
)
"""Loads, and what the design of a limb of tubes chooses: sets of names for ``to``."""


@dataclass(frozen=True)
class _Columns:
    """Labels of columns.

    Parameters
    ----------
    columns : tuple of str
        What each column is the derivative to, as ``segments[0].radii[1]``.
    column_units : tuple of str
    column_names : tuple of str
        The name in ``to`` that each column came from.
    """

    columns: tuple[str, ...]
    column_units: tuple[str, ...]
    column_names: tuple[str, ...]

    def _chosen(self, name: str) -> list[int]:
        if name in self.columns:
            return [self.columns.index(name)]
        found = [k for k, asked in enumerate(self.column_names) if asked == name]
        if not found:
            known = sorted({*self.column_names, *self.columns})
            raise KeyError(f"no column of {name!r}; there are {', '.join(known)}")
        return found


@dataclass(frozen=True)
class Derivative(_Columns):
    """Derivative of answers (rows) to parameters (columns).

    Parameters
    ----------
    matrix : array, shape (rows, columns)
        Unit of an entry: that of its row over that of its column.
    rows : tuple of str
        ``tip.x`` ... ``tip.rz``: translation and rotation vector in base axes at the origin of the plate, as in
        `Posture.jacobian`; ``plates[0].x`` ...; ``centreline[0].x`` ...; ``energy``.
    row_units : tuple of str
    """

    matrix: Array
    rows: tuple[str, ...]
    row_units: tuple[str, ...]

    def __getitem__(self, name: str) -> Array:
        """Columns of one name of ``to``, shape (rows, n), or one column by its label, shape (rows,).

        Raises
        ------
        KeyError
            There is no such column.
        """
        chosen = self._chosen(name)
        found: Array = self.matrix[:, chosen[0]] if name in self.columns else self.matrix[:, chosen]
        return found

    def __repr__(self) -> str:
        return f"Derivative({len(self.rows)} rows by {len(self.columns)} columns: {', '.join(self.columns)})"


@dataclass(frozen=True)
class Gradient(_Columns):
    """Derivative of one number to parameters.

    Parameters
    ----------
    values : array, shape (columns,)
        Unit: that of the number over that of the column.
    """

    values: Array

    def __getitem__(self, name: str) -> Any:
        """Values of one name of ``to``, shape (n,), or one value by its label; KeyError as for `Derivative`."""
        chosen = self._chosen(name)
        return float(self.values[chosen[0]]) if name in self.columns else self.values[chosen]

    def __repr__(self) -> str:
        pairs = zip(self.columns, self.values, strict=True)
        return f"Gradient({', '.join(f'{label}={value:.6g}' for label, value in pairs)})"


class _Column(NamedTuple):
    label: str
    unit: str
    parts: tuple[_Part, ...]


class _Made(NamedTuple):
    """Columns as the core wants them, with their labels."""

    core: _core.Parameters
    labels: _Columns
    parts: list[tuple[_Part, ...]]
    thickness: Array  # of each plate by each column


def ring_directions(count: int) -> Array:
    """Unit vectors from the axis to ``count`` rods on a ring, the first along x, shape (count, 3)."""
    angles = 2.0 * np.pi * np.arange(count) / count
    return np.stack([np.cos(angles), np.sin(angles), np.zeros(count)], axis=1)


# What each name stands for. A source yields columns; those of members and segments with their place, for `each`.


def _pressures(limb: Limb) -> Iterator[_Column]:
    driven = [i for i, member in enumerate(limb._members) if isinstance(member, Tube)]
    for number, i in enumerate(driven):
        yield _Column(f"pressures[{number}]", "Pa", (_Part("tube pressure", i),))


def _gravity(limb: Limb) -> Iterator[_Column]:
    for k, name in enumerate(_XYZ):
        yield _Column(f"gravity.{name}", "m/s^2", (_Part("gravity", number=k),))


def _tip(first: int, unit: str, name: str) -> Callable[[Limb], Iterator[_Column]]:
    def source(limb: Limb) -> Iterator[_Column]:
        for k, along in enumerate(_XYZ):
            part = _Part("wrench", len(limb.segments) - 1, number=first + k)
            yield _Column(f"{name}.{along}", unit, (part,))

    return source


def _plate_wrenches(limb: Limb) -> Iterator[_Column]:
    for j in range(len(limb.segments)):
        for k, (name, unit) in enumerate(_WRENCH):
            yield _Column(f"plate_wrenches[{j}].{name}", unit, (_Part("wrench", j, number=k),))


def _rod_forces(limb: Limb) -> Iterator[_Column]:
    for i in range(len(limb._members)):
        for k, name in enumerate(_XYZ):
            yield _Column(f"rod_forces[{i}].{name}", "N/m", (_Part("line force", i, number=k),))


_GLOBAL: dict[str, Callable[[Limb], Iterator[_Column]]] = {
    "pressures": _pressures,
    "gravity": _gravity,
    "tip_force": _tip(0, "N", "tip_force"),
    "tip_moment": _tip(3, "N m", "tip_moment"),
    "plate_wrenches": _plate_wrenches,
    "rod_forces": _rod_forces,
}


def _of_member(member: Any, place: int, name: str) -> Iterator[_Column]:
    """Columns of one member of a segment, labelled within it."""
    if not isinstance(member, Tube):
        if name == "length":
            yield _Column("length", "m", (_Part("rod length", place),))
        if name == "section":
            for k, (field, unit) in enumerate(_SECTION):
                yield _Column(f"section.{field}", unit, (_Part("rod section", place, number=k),))
        return
    layers = member.layers
    if name in ("length", "cap_length") or (name == "mass" and member._given_mass is not None):
        yield _Column(name, "kg" if name == "mass" else "m", (_Part(f"tube {name}", place),))
    if name == "radii":
        for k in range(len(layers) + 1):
            yield _Column(f"radii[{k}]", "m", (_Part("tube radius", place, number=k),))
    for n, layer in enumerate(layers):
        if name == "density":
            yield _Column(f"layers[{n}].density", "kg/m^3", (_Part("tube density", place, n),))
        if name == "law":
            for k, coefficient in enumerate(_core.law_coefficients(layer.law)):
                # Exponents, and Gent's limit of I1 - 3, are plain numbers.
                unit = "1" if coefficient.startswith(("alpha", "jm")) else "Pa"
                yield _Column(f"layers[{n}].{coefficient}", unit, (_Part("tube coefficient", place, n, k),))
        if name in _OF_FIBRES:
            yield from _of_families(layer.fibres, place, n, name)


_OF_FIBRES = {"fibre_angle": "rad", "fibre_fraction": "1", "fibre_modulus": "Pa", "fibre_stiffness": "Pa"}


def _of_families(fibres: Sequence[Any], place: int, layer: int, name: str) -> Iterator[_Column]:
    """Families at opposite angles change together: the angle is then the size of both."""
    kind = f"tube {name.removeprefix('fibre_')}"
    for family, twin, mark in fibre_groups(fibres):
        by_modulus = fibres[family].modulus is not None
        if name == "fibre_angle" or by_modulus == (name != "fibre_stiffness"):
            # The size of a negative angle grows as the angle falls.
            factor = -1.0 if name == "fibre_angle" and fibres[family].angle < 0.0 else 1.0
            part = _Part(kind, place, layer, family, twin, None, factor)
            yield _Column(f"layers[{layer}].{name}{mark}", _OF_FIBRES[name], (part,))


_MEMBER = ("length", "cap_length", "mass", "radii", "density", "law", *_OF_FIBRES, "section")
_SEGMENT = ("ring_radius", "plate_mass", "plate_thickness")


def _of_segment(limb: Limb, j: int, first: int, name: str) -> Iterator[_Column]:
    segment = limb.segments[j]
    if name != "ring_radius":
        yield _Column(name, "kg" if name == "plate_mass" else "m", (_Part(name.replace("_", " "), j),))
    elif segment.ring_radius is not None:
        outwards = [[*direction, 0.0, 0.0, 0.0] for direction in ring_directions(len(segment.members)).tolist()]
        parts = tuple(_Part("placement", first + k, direction=2 * out) for k, out in enumerate(outwards))
        yield _Column(name, "m", parts)


def _columns_of(limb: Limb, name: str, each: Each) -> list[_Column]:
    if name in _GLOBAL:
        return list(_GLOBAL[name](limb))
    found: dict[str, _Column] = {}

    def add(prefix: str, column: _Column) -> None:
        label = prefix + column.label
        before = found[label].parts if label in found else ()
        found[label] = _Column(label, column.unit, before + column.parts)

    place = 0
    for j, segment in enumerate(limb.segments):
        of_segment = "" if each == "limb" else f"segments[{j}]."
        if name in _SEGMENT:
            for column in _of_segment(limb, j, place, name):
                add(of_segment, column)
        for k, member in enumerate(segment.members):
            kind = "actuators" if isinstance(member, Tube) else "rods"
            prefix = f"{of_segment}{kind}[{k}]." if each == "actuator" else of_segment
            for column in _of_member(member, place, name) if name in _MEMBER else ():
                add(prefix, column)
            place += 1
    return list(found.values())


def names_of_design(limb: Limb) -> tuple[str, ...]:
    """All names of ``to`` that stand for something that the limb is made of, loads and pressures left out."""
    return tuple(name for name in (*_MEMBER, *_SEGMENT) if _columns_of(limb, name, "segment"))


def _names(name: str, value: Any) -> tuple[Any, ...]:
    """One name or several, as a tuple."""
    if isinstance(value, str):
        return (value,)
    if isinstance(value, bytes) or not isinstance(value, Iterable):
        raise ValueError(f"{name} must be a name or a sequence of names, got {shown(value)}")
    return tuple(value)


def columns(limb: Limb, to: str | Sequence[str], each: Each) -> _Made:
    """The parameters that names stand for; kept with the limb.

    Raises
    ------
    ValueError
        A name is unknown, given twice, or no part of the limb has it; ``each`` is unknown.
    """
    one_of("each", each, ("actuator", "segment", "limb"))
    names = _names("to", to)
    kept: dict[Any, _Made] = limb.__dict__.setdefault("_derivative_columns", {})
    if (names, each) in kept:
        return kept[names, each]
    known = (*_GLOBAL, *_MEMBER, *_SEGMENT)
    for name in names:
        if not isinstance(name, str) or name not in known:
            raise ValueError(f"to must be names among {', '.join(known)}, got {shown(name)}")
    if not names or len(set(names)) != len(names):
        raise ValueError(f"to must name each kind of parameter once, and at least one, got {names}")
    found = [(name, _columns_of(limb, name, each)) for name in names]
    for name, of_name in found:
        if not of_name:
            raise ValueError(f"to names {name!r}, but no part of the limb has it")
    flat = [(name, column) for name, of_name in found for column in of_name]
    parts = [
        (*part[:-1], k, part.factor) for k, (_, column) in enumerate(flat) for part in column.parts
    ]
    thickness = np.zeros((len(limb.segments), len(flat)))
    for k, (_, column) in enumerate(flat):
        for part in column.parts:
            if part.kind == "plate thickness":
                thickness[part.place, k] += part.factor
    labels = _Columns(
        tuple(column.label for _, column in flat),
        tuple(column.unit for _, column in flat),
        tuple(name for name, _ in flat),
    )
    core = _core.Parameters(parts, len(flat))
    return kept.setdefault((names, each), _Made(core, labels, [column.parts for _, column in flat], thickness))


class _Answers(NamedTuple):
    """Rows of answers: combinations of plates' moves and of points, and how points slide along the centreline."""

    weights: Array  # (rows, 6 plates + 3 points)
    rods: list[int]
    fractions: list[float]
    sliding: Array | None  # (rows, 2 plates): by the bounds between rods and plates along the centreline
    energy: Array | None  # (rows,): shares of the energy


def _labels(plates: int, of: Sequence[str], points: int) -> Iterator[tuple[str, str]]:
    for name in of:
        if name == "energy":
            yield "energy", "J"
        elif name == "centreline":
            yield from ((f"centreline[{k}].{along}", "m") for k in range(points) for along in _XYZ)
        elif name == "tip":
            yield from ((f"tip.{along}", unit) for along, unit in _POSE)
        else:
            yield from ((f"plates[{j}].{along}", unit) for j in range(plates) for along, unit in _POSE)


def _answers(posture: Posture, of: Sequence[str], shares: Array) -> _Answers:
    plates, n = len(posture.limb.segments), len(shares)
    line = posture._centreline_places(shares) if "centreline" in of else None
    points = 0 if line is None else len(line.rods)
    counts = {"tip": 6, "plates": 6 * plates, "centreline": 3 * n, "energy": 1}
    rows = sum(counts[name] for name in of)
    weights = np.zeros((rows, 6 * plates + 3 * points))
    sliding = None if line is None else np.zeros((rows, 2 * plates))
    energy = np.zeros(rows) if "energy" in of else None
    first = 0
    for name in of:
        last = first + counts[name]
        if name == "energy" and energy is not None:
            energy[first] = 1.0
        elif name == "centreline" and line is not None and sliding is not None:
            for along in range(3):
                weights[first + 3 * line.owner + along, 6 * plates + 3 * np.arange(points) + along] = line.weight
            slide = line.tangent[:, :, None] * line.by_bounds[:, None, :]
            sliding[first:last] = slide.reshape(3 * n, 2 * plates)
        else:
            weights[first:last, 6 * plates - counts[name] : 6 * plates] = np.eye(counts[name])
        first = last
    if line is None:
        return _Answers(weights, [], [], None, energy)
    return _Answers(weights, line.rods, line.fractions, sliding, energy)


def _made(posture: Posture) -> tuple[_core.Members, Array, str, str]:
    pressures = posture._solved_pressures
    if pressures is None:
        pressures = np.empty(0)
    return (posture.limb._core_members, pressures, *posture._model)


def _matrix(posture: Posture, answers: _Answers, to: _Made) -> Array:
    made, count = _made(posture), len(to.labels.columns)
    linear = posture._linear
    # A row of the adjoint costs about twice a column: it starts with another factorisation.
    if 2 * len(answers.weights) <= count:
        found = linear.adjoint(answers.weights, to.core, made, answers.rods, answers.fractions)
    else:
        found = answers.weights @ linear.forward(to.core, made, answers.rods, answers.fractions)
    if answers.sliding is not None:
        # The points stand at equal shares of rods and plates together, which lengthen.
        by_rod = _core.rest_length_slopes(posture._solved, to.core, made)
        bounds, first = np.zeros((2 * len(posture.limb.segments), count)), 0
        for j, segment in enumerate(posture.limb.segments):
            last = first + len(segment.members)
            bounds[2 * j : 2 * j + 2] = by_rod[first:last].mean(axis=0), to.thickness[j]
            first = last
        bounds[-1] = 0.0  # the tip's plate is beyond the centreline
        found = found + answers.sliding @ np.cumsum(bounds, axis=0)
    if answers.energy is not None:
        try:
            slopes = _core.potential_energy_slopes(posture._solved, to.core, made)
        except RuntimeError as error:
            posture.energy  # noqa: B018  (raises where the posture's own loads are the reason)
            raise RuntimeError(
                "to names a load that has no potential (as a moment on a plate that may turn), so the energy "
                f"has no derivative to it, among {', '.join(dict.fromkeys(to.labels.column_names))}"
            ) from error
        found = found + np.outer(answers.energy, slopes)
    return found


def tip_by_pressures(posture: Posture) -> Array:
    """As `Posture.jacobian`."""
    solved = posture._solved
    if solved.followed:
        # Pressures that were not given by way of Python are the core's own.
        pressures = posture.__dict__.get("_solved_pressures")
        return _core.tip_by_pressures(solved, posture.limb._core_members, *posture._model, pressures)
    found: Array = posture._linear.tip_by_pressures(_made(posture))
    return found


def derivative(
    posture: Posture, of: str | Sequence[str], to: str | Sequence[str], each: Each, shares: Array
) -> Derivative:
    """As `Posture.derivative`."""
    asked = _names("of", of)
    for name in asked:
        one_of("of", name, ("tip", "plates", "centreline", "energy"))
    if not asked or len(set(asked)) != len(asked):
        raise ValueError(f"of must name each answer once, and at least one, got {asked}")
    made = columns(posture.limb, to, each)
    matrix = _matrix(posture, _answers(posture, asked, shares), made)
    rows, units = zip(*_labels(len(posture.limb.segments), asked, len(shares)), strict=True)
    of_columns = made.labels
    return Derivative(
        of_columns.columns, of_columns.column_units, of_columns.column_names, matrix, rows, units
    )


def gradient(
    posture: Posture,
    to: str | Sequence[str],
    each: Each,
    tip: ArrayLike | None,
    plates: ArrayLike | None,
    centreline: ArrayLike | None,
    energy: float | None,
) -> Gradient:
    """As `Posture.gradient`."""
    weights: dict[str, Array] = {}
    n = 2
    if tip is not None:
        weights["tip"] = finite_of_shape("tip", tip, (6,))
    if plates is not None:
        weights["plates"] = finite_of_shape("plates", plates, (len(posture.limb.segments), 6))
    if centreline is not None:
        n = max(2, len(np.atleast_1d(np.asarray(centreline, dtype=object))))
        weights["centreline"] = finite_of_shape("centreline", centreline, (n, 3))
    if energy is not None:
        weights["energy"] = np.array([one_finite("energy", energy)])
    if not weights:
        raise ValueError("a gradient needs weights: give tip, plates, centreline or energy")
    made = columns(posture.limb, to, each)
    answers = _answers(posture, tuple(weights), np.linspace(0.0, 1.0, n))
    row = np.concatenate([weight.ravel() for weight in weights.values()])
    one = _Answers(
        (row @ answers.weights)[None],
        answers.rods,
        answers.fractions,
        None if answers.sliding is None else (row @ answers.sliding)[None],
        None if answers.energy is None else np.array([row @ answers.energy]),
    )
    of_columns = made.labels
    values = _matrix(posture, one, made)[0]
    return Gradient(of_columns.columns, of_columns.column_units, of_columns.column_names, values)
