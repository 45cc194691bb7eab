"""What stands between two plates, as a function of pressure and of numbers that can be identified.

Each kind gives a rod at a pressure, and how its rest length and section change with the numbers that it is made of.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb._core import Section
from softlimb.arguments import finite_array, one_finite, one_not_negative, one_positive, shown
from softlimb.changed import changed_tube, tube_values
from softlimb.derivatives import _of_member
from softlimb.limb import Rod
from softlimb.tube import Tube

__all__ = ["Actuator", "EmpiricalActuator", "RodSlopes", "ScaledTube", "changed_actuator", "rod_slopes", "values_of"]

Array = NDArray[np.float64]

SECTION_FIELDS = ("axial", "shear", "bending", "torsion", "mass_per_length", "rest_twist", "extension_twist")
_FACTORS = ("axial_factor", "bending_factor", "shear_factor", "torsion_factor")
_TERMS = ("length", "length_denominator", "axial", "bending")
_TERM = re.compile(r"(length|length_denominator|axial|bending)\[(\d+)\]")


class RodSlopes(NamedTuple):
    """A rod at a pressure, with derivatives to the pressure and to named numbers.

    ``by_pressure`` and the rows of ``by_values`` hold the rest length, then the section's fields in the order of
    `SECTION_FIELDS`; shapes (8,) and (names, 8).
    """

    rod: Rod
    by_pressure: Array
    by_values: Array


def _polynomial(coefficients: Sequence[float], x: float) -> float:
    return float(np.polynomial.polynomial.polyval(x, coefficients))


def _slope(coefficients: Sequence[float], x: float) -> float:
    return sum(k * coefficients[k] * x ** (k - 1) for k in range(1, len(coefficients)))


@dataclass(frozen=True)
class EmpiricalActuator:
    """An actuator known by measurement alone: rest length and stiffness as functions of the gauge pressure.

    For robots whose actuators are no fibre-reinforced tubes. Polynomials, with coefficients from the constant one
    upwards in powers of ``pressure / unit_pressure``, so that all of them have the unit of the quantity. A rest length
    that saturates is a ratio of two.

    Parameters
    ----------
    length : sequence of float
        Rest length [m].
    length_denominator : sequence of float
        b1, b2, ...: the rest length is the polynomial ``length`` over 1 + b1 x + b2 x^2 + ... [1].
    axial, bending : sequence of float
        EA [N] and EI [N m^2], per rest length.
    shear_ratio, torsion_ratio : float
        GA over EA and GJ over EI. Default: 1/3 and 2/3, of an incompressible round section.
    mass : float
        [kg]
    radius : float, optional
        Outer radius [m], for clearance and pictures.
    unit_pressure : float
        [Pa]
    max_pressure : float, optional
        End of the range of the measurements [Pa]; a pressure beyond it raises, because a polynomial says nothing there.

    Raises
    ------
    ValueError
        No coefficients, a number that is not finite, or a length or stiffness that is not positive at zero pressure.
    """

    length: tuple[float, ...]
    axial: tuple[float, ...]
    bending: tuple[float, ...]
    shear_ratio: float = 1.0 / 3.0
    torsion_ratio: float = 2.0 / 3.0
    mass: float = 0.0
    radius: float | None = None
    unit_pressure: float = 1e5
    max_pressure: float | None = None
    length_denominator: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for name in ("length", "axial", "bending"):
            given = finite_array(name, getattr(self, name))
            if given.ndim != 1 or not given.size:
                raise ValueError(f"{name} must be a list of coefficients, got shape {given.shape}")
            if not given[0] > 0.0:
                raise ValueError(f"{name} must be positive at zero pressure, got {given[0]:.6g}")
            object.__setattr__(self, name, tuple(given.tolist()))
        below = finite_array("length_denominator", self.length_denominator)
        object.__setattr__(self, "length_denominator", tuple(below.ravel().tolist()))
        for name in ("shear_ratio", "torsion_ratio", "unit_pressure"):
            object.__setattr__(self, name, one_positive(name, getattr(self, name)))
        object.__setattr__(self, "mass", one_not_negative("mass", self.mass))
        for name in ("radius", "max_pressure"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, one_positive(name, getattr(self, name)))

    @property
    def outer_radius(self) -> float | None:
        """The same as ``radius``, under the name that tubes have."""
        return self.radius

    def at(self, pressure: float) -> tuple[float, float, float]:
        """Rest length [m], EA [N] and EI [N m^2] at a pressure [Pa].

        Raises
        ------
        ValueError
            The pressure is not finite or beyond ``max_pressure``, or one of the three is not positive there.
        """
        p = one_finite("pressure", pressure)
        if self.max_pressure is not None and p > self.max_pressure:
            raise ValueError(f"pressure must be at most max_pressure {self.max_pressure:.6g} Pa, got {p:.6g}")
        found = []
        for name in ("length", "axial", "bending"):
            value = _polynomial(getattr(self, name), p / self.unit_pressure)
            if name == "length":
                below = _polynomial((1.0, *self.length_denominator), p / self.unit_pressure)
                value = value / below if below > 0.0 else -np.inf
            if not value > 0.0:
                raise ValueError(f"{name} of the actuator is {value:.6g} at {p:.6g} Pa: it must be positive")
            found.append(value)
        return found[0], found[1], found[2]

    def section(self, pressure: float) -> Section:
        """Section of the rod at a pressure; errors as for `at`."""
        return self.rod(pressure).section

    def rod(self, pressure: float) -> Rod:
        """The rod that stands for the actuator at a pressure, at its rest length; errors as for `at`."""
        length, axial, bending = self.at(pressure)
        section = Section(
            axial=axial,
            shear=self.shear_ratio * axial,
            bending=bending,
            torsion=self.torsion_ratio * bending,
            mass_per_length=self.mass / length,
        )
        return Rod(section, length, radius=self.radius)


@dataclass(frozen=True)
class ScaledTube:
    """A tube whose stiffnesses are the model's times factors: what is left when the law is known and the limb is not.

    Parameters
    ----------
    tube : Tube
    axial_factor, bending_factor, shear_factor, torsion_factor : float
        Of EA, EI, GA and GJ; the rest length stays the tube's.

    Raises
    ------
    ValueError
        A factor is not positive and finite.
    """

    tube: Tube
    axial_factor: float = 1.0
    bending_factor: float = 1.0
    shear_factor: float = 1.0
    torsion_factor: float = 1.0

    def __post_init__(self) -> None:
        if not isinstance(self.tube, Tube):
            raise TypeError(f"tube must be a Tube, got {type(self.tube).__name__}")
        for name in _FACTORS:
            object.__setattr__(self, name, one_positive(name, getattr(self, name)))

    @property
    def outer_radius(self) -> float:
        """Of the unpressurised tube [m]."""
        return self.tube.outer_radius

    def rod(self, pressure: float) -> Rod:
        """The rod at a pressure, at its rest length; errors as for `Tube.section`."""
        return rod_slopes(self, pressure, ()).rod


Actuator: TypeAlias = Tube | ScaledTube | EmpiricalActuator


def require_actuator(name: str, value: object) -> None:
    """TypeError unless the value is an actuator."""
    if not isinstance(value, (Tube, ScaledTube, EmpiricalActuator)):
        raise TypeError(f"{name} must be Tube, ScaledTube or EmpiricalActuator, got {type(value).__name__}")


def unpressurised_length(actuator: Actuator) -> float:
    """[m]"""
    if isinstance(actuator, EmpiricalActuator):
        return actuator.length[0]
    return actuator.tube.length if isinstance(actuator, ScaledTube) else actuator.length


def values_of(actuator: Actuator) -> dict[str, float]:
    """Numbers that an actuator is made of, by name, SI.

    Of a tube the labels of its derivatives (``layers[0].c1``, ``radii[1]``, ...); with factors also these; of an
    empirical one ``length[0]``, ``length_denominator[0]`` (b1), ``axial[1]``, ``bending[0]``, ..., ``shear_ratio``,
    ``torsion_ratio``, ``mass``.
    """
    if isinstance(actuator, Tube):
        return tube_values(actuator)
    if isinstance(actuator, ScaledTube):
        return {**tube_values(actuator.tube), **{name: getattr(actuator, name) for name in _FACTORS}}
    terms = {
        f"{name}[{k}]": value
        for name in _TERMS
        for k, value in enumerate(getattr(actuator, name))
    }
    return {**terms, **{name: getattr(actuator, name) for name in ("shear_ratio", "torsion_ratio", "mass")}}


def changed_actuator(actuator: Any, values: Mapping[str, float]) -> Any:
    """The actuator with other values of some of its numbers; ValueError for an unknown name or an illegal value."""
    if isinstance(actuator, Tube):
        return changed_tube(actuator, values)
    if isinstance(actuator, ScaledTube):
        factors = {name: value for name, value in values.items() if name in _FACTORS}
        rest = {name: value for name, value in values.items() if name not in _FACTORS}
        return replace(actuator, tube=changed_tube(actuator.tube, rest) if rest else actuator.tube, **factors)
    known = values_of(actuator)
    given: dict[str, Any] = {}
    for name, value in values.items():
        if name not in known:
            raise ValueError(f"an empirical actuator has no number {shown(name)}; this one has {', '.join(known)}")
        if term := _TERM.fullmatch(name):
            given.setdefault(term[1], list(getattr(actuator, term[1])))[int(term[2])] = value
        else:
            given[name] = value
    return replace(actuator, **given)


def _numbers(length: float, section: Section) -> Array:
    return np.array([length, *(getattr(section, name) for name in SECTION_FIELDS)])


def rod_slopes(actuator: Actuator, pressure: float, names: Sequence[str]) -> RodSlopes:
    """The rod at a pressure and its exact derivatives.

    Parameters
    ----------
    actuator : Tube, ScaledTube or EmpiricalActuator
    pressure : float
        [Pa]
    names : sequence of str
        Among those of `values_of`.

    Raises
    ------
    ValueError
        There is no equilibrium at this pressure, or a name is unknown.
    """
    if isinstance(actuator, EmpiricalActuator):
        return _of_polynomials(actuator, pressure, names)
    tube = actuator.tube if isinstance(actuator, ScaledTube) else actuator
    at = tube.section_at(pressure)
    value, by_pressure = _numbers(at.rest_length, at.section), _numbers(at.d_rest_length, at.d_section)
    factor = np.ones(8)
    if isinstance(actuator, ScaledTube):
        factor[[1, 2, 3, 4]] = [getattr(actuator, f"{name}_factor") for name in SECTION_FIELDS[:4]]
        # The coupling is a compliance: it falls as the geometric mean of the stiffnesses that it couples grows.
        factor[7] = (factor[1] * factor[4]) ** -0.5
    rows = []
    for name in names:
        if name in _FACTORS and isinstance(actuator, ScaledTube):
            k = 1 + SECTION_FIELDS.index(name.removesuffix("_factor"))
            row = np.zeros(8)
            row[k] = value[k]
            if k in (1, 4):
                row[7] = -0.5 * value[7] * factor[7] / factor[k]
        else:
            row = factor * _by_tube_number(tube, pressure, name)
        rows.append(row)
    scaled = factor * value
    section = Section(**dict(zip(SECTION_FIELDS, scaled[1:].tolist(), strict=True)))
    rod = Rod(section, at.rest_length, radius=tube.outer_radius)
    return RodSlopes(rod, factor * by_pressure, np.array(rows).reshape(len(names), 8))


def _by_tube_number(tube: Tube, pressure: float, name: str) -> Array:
    """Rest length and section by one number of the tube, from the core."""
    kind = re.sub(r"\[\d+\]$", "", name.rpartition(".")[2])
    kind = kind if kind in ("length", "cap_length", "mass", "radii", "density") or kind.startswith("fibre_") else "law"
    column = next((column for column in _of_member(tube, 0, kind) if column.label == name), None)
    if column is None:
        raise ValueError(f"a tube has no number {shown(name)}; this one has {', '.join(tube_values(tube))}")
    total = np.zeros(8)
    for part in column.parts:
        slope = tube._section_slope(
            pressure, "tangent", "open", part.kind.removeprefix("tube "), part.layer, part.number, part.twin
        )
        total += part.factor * _numbers(*slope)
    return total


def _of_polynomials(actuator: EmpiricalActuator, pressure: float, names: Sequence[str]) -> RodSlopes:
    rod = actuator.rod(pressure)
    x = pressure / actuator.unit_pressure

    def changes(length: float = 0.0, axial: float = 0.0, bending: float = 0.0) -> Array:
        mass = -rod.section.mass_per_length / rod.length * length
        return np.array(
            [length, axial, actuator.shear_ratio * axial, bending, actuator.torsion_ratio * bending, mass, 0.0, 0.0]
        )

    divisor = (1.0, *actuator.length_denominator)
    below = _polynomial(divisor, x)
    rows = []
    for name in names:
        if term := _TERM.fullmatch(name):
            if term[1] == "length":
                rows.append(changes(length=x ** int(term[2]) / below))
            elif term[1] == "length_denominator":
                rows.append(changes(length=-rod.length * x ** (int(term[2]) + 1) / below))
            else:
                rows.append(changes(**{term[1]: x ** int(term[2])}))
        elif name in ("shear_ratio", "torsion_ratio", "mass"):
            row = np.zeros(8)
            place = {"shear_ratio": 2, "torsion_ratio": 4, "mass": 5}[name]
            row[place] = {2: rod.section.axial, 4: rod.section.bending, 5: 1.0 / rod.length}[place]
            rows.append(row)
        else:
            raise ValueError(
                f"an empirical actuator has no number {shown(name)}; this one has {', '.join(values_of(actuator))}"
            )
    lengthens = (_slope(actuator.length, x) - rod.length * _slope(divisor, x)) / below
    by_pressure = changes(lengthens, _slope(actuator.axial, x), _slope(actuator.bending, x)) / actuator.unit_pressure
    return RodSlopes(rod, by_pressure, np.array(rows).reshape(len(names), 8))


def twist_and_slopes(actuator: Actuator, pressures: ArrayLike, names: Sequence[str]) -> tuple[Array, Array, Array]:
    """Length [m] and end twist [rad] of a free actuator at pressures, and their derivatives.

    Returns
    -------
    tuple of arrays
        Length and twist, shape (n, 2), by the pressure (n, 2), by the numbers (n, 2, names). NaN where the actuator
        has no state.
    """
    given = finite_array("pressures", pressures)
    values, by_pressure = np.full((len(given), 2), np.nan), np.zeros((len(given), 2))
    by_values = np.zeros((len(given), 2, len(names)))
    for i, pressure in enumerate(given.tolist()):
        try:
            found = rod_slopes(actuator, pressure, names)
        except ValueError:  # no equilibrium: its row stays NaN
            continue
        length, rate = found.rod.length, found.rod.section.rest_twist
        values[i] = length, rate * length
        for to, slopes in ((by_pressure[i], found.by_pressure), *zip(by_values[i].T, found.by_values, strict=True)):
            to[:] = slopes[0], slopes[6] * length + rate * slopes[0]
    return values, by_pressure, by_values
