"""Quantities in files: the unit stands at the end of the name, and is converted here and nowhere else.

``length_mm = 200``, ``pressure_kPa = 55``: a name is `<quantity>_<unit>`, and every unit of the right dimension is
accepted when reading. Writing picks the customary unit unless the number would not come back bit for bit; then it picks
the SI unit, with which it always does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import TypeAlias

from softlimb import units

Nested: TypeAlias = "float | list[Nested]"
"""A number, or a list of numbers and lists."""


@dataclass(frozen=True)
class Dimension:
    """What a quantity measures, and the units in which a file may give it.

    Parameters
    ----------
    name : str
        As it appears in messages: "pressure", "length".
    factors : mapping of str to float
        Unit as written in names, to its size in SI; the first is the one that files are written in, and one of them
        has the factor 1.
    """

    name: str
    factors: Mapping[str, float]

    @property
    def si(self) -> str:
        """The unit that needs no conversion."""
        return next(unit for unit, factor in self.factors.items() if factor == 1.0)

    def listed(self, quantity: str) -> str:
        """All names under which `quantity` can be given, for messages."""
        return ", ".join(f"`{quantity}_{unit}`" for unit in self.factors)


LENGTH = Dimension("length", {"mm": units.mm, "m": units.m, "cm": units.cm, "inch": units.inch})
PRESSURE = Dimension(
    "pressure",
    {
        "kPa": units.kPa,
        "Pa": units.Pa,
        "MPa": units.MPa,
        "GPa": units.GPa,
        "bar": units.bar,
        "psi": units.psi,
    },
)
ANGLE = Dimension("angle", {"deg": units.deg, "rad": units.rad})
FORCE = Dimension("force", {"N": units.N, "mN": units.mN, "kN": units.kN})
MOMENT = Dimension("moment", {"Nm": 1.0, "Nmm": 1e-3, "mNm": 1e-3})
MASS = Dimension("mass", {"g": units.g, "kg": units.kg})
ACCELERATION = Dimension("acceleration", {"m_s2": 1.0})
DENSITY = Dimension("density", {"kg_m3": 1.0, "g_cm3": 1e3})
FORCE_PER_LENGTH = Dimension("force per length", {"N_m": 1.0, "N_mm": 1e3, "mN_m": 1e-3})
MOMENT_PER_LENGTH = Dimension("moment per length", {"Nm_m": 1.0, "mNm_m": 1e-3})
MASS_PER_LENGTH = Dimension("mass per length", {"kg_m": 1.0, "g_m": 1e-3})
BENDING_STIFFNESS = Dimension("bending stiffness", {"Nm2": 1.0, "Nmm2": 1e-6})
TWIST_PER_LENGTH = Dimension("twist per length", {"rad_m": 1.0, "deg_m": units.deg})
COUPLING = Dimension("coupling compliance", {"per_Nm": 1.0})
COMPLIANCE = Dimension("compliance", {"per_N": 1.0})

DIMENSIONS = (
    LENGTH,
    PRESSURE,
    ANGLE,
    FORCE,
    MOMENT,
    MASS,
    ACCELERATION,
    DENSITY,
    FORCE_PER_LENGTH,
    MOMENT_PER_LENGTH,
    MASS_PER_LENGTH,
    BENDING_STIFFNESS,
    TWIST_PER_LENGTH,
    COUPLING,
    COMPLIANCE,
)


def scaled(number: Nested, factor: float) -> Nested:
    """Multiply a number, or every number of nested lists."""
    return [scaled(entry, factor) for entry in number] if isinstance(number, list) else number * factor


def named_quantity(
    quantity: str, value: Nested, dimension: Dimension, prefer: Sequence[str] = ()
) -> tuple[str, Nested]:
    """Name and number under which a file gives `value` so that reading returns the same bits.

    Parameters
    ----------
    quantity : str
        Name without unit.
    value : float or nested lists of float
        In SI.
    dimension : Dimension
        Gives the units.
    prefer : sequence of str
        Units to try first; after them comes the dimension's first unit, then the SI unit.

    Returns
    -------
    tuple of str and float or nested lists of float
        Such as ``("length_mm", 200.0)``.
    """
    for unit in (*prefer, next(iter(dimension.factors))):
        number = _in_unit(value, dimension.factors[unit])
        if number is not None:
            return f"{quantity}_{unit}", number
    return f"{quantity}_{dimension.si}", value


def _in_unit(value: Nested, factor: float) -> Nested | None:
    """`value` over `factor` as the shortest decimals that multiply back to the same bits; None where none does."""
    if isinstance(value, list):
        numbers = [_in_unit(entry, factor) for entry in value]
        return None if any(number is None for number in numbers) else [n for n in numbers if n is not None]
    # Twelve digits give 20.5 where the quotient is 20.500000000000004; more only where the bits need them.
    for digits in range(12, 18):
        number = float(f"{value / factor:.{digits}g}")
        if number * factor == value:
            return number
    return None


def unit_of(name: str, quantity: str) -> str | None:
    """The part of `name` after `quantity_`, or None when the name does not start so."""
    return name[len(quantity) + 1 :] if name.startswith(quantity + "_") else None


def explain_unknown(name: str, where: str, quantities: Mapping[str, Dimension], others: Sequence[str]) -> str:
    """Say what is wrong with a name that is not known: a missing unit, a wrong unit, or most likely a typing error.

    Parameters
    ----------
    name : str
        As found in the file.
    where : str
        Place, ready for print: "in [scene]".
    quantities : mapping of str to Dimension
        Names that take a unit.
    others : sequence of str
        Names that take none.
    """
    if name in quantities:
        return f"key `{name}` {where} needs its unit in the name: {quantities[name].listed(name)}"
    every_unit = {unit for dimension in DIMENSIONS for unit in dimension.factors}
    for quantity, dimension in quantities.items():
        unit = unit_of(name, quantity)
        if unit in every_unit:
            return f"key `{name}` {where}: `{unit}` is not a unit of {dimension.name}; use {dimension.listed(quantity)}"
    known = [f"{quantity}_{unit}" for quantity, dimension in quantities.items() for unit in dimension.factors]
    nearest = get_close_matches(name, [*known, *others], n=1)
    if nearest:
        return f"unknown key `{name}` {where}: did you mean `{nearest[0]}`?"
    customary = [f"{quantity}_{next(iter(dimension.factors))}" for quantity, dimension in quantities.items()]
    return f"unknown key `{name}` {where}: known are {', '.join(f'`{key}`' for key in sorted([*customary, *others]))}"
