"""What is benchmarked: limbs, their loads, and the pressures that they go through."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from softlimb._core import Section
from softlimb.limb import Limb, Rod, Segment
from softlimb.units import GPa, deg, kPa, mm

__all__ = [
    "HANGING",
    "HEAVY_STEEL",
    "LEG",
    "STEEL",
    "TIP_FORCE",
    "built_height",
    "clamped",
    "fine_grid",
    "joints",
    "loads",
    "random_pressures",
    "six_legs",
    "soft_rod",
    "walk",
    "zigzag",
]

Array = NDArray[np.float64]

HANGING = (0.0, 0.0, 9.81)
"""Gravity of a limb that hangs [m/s^2]."""
TIP_FORCE = (0.2, -0.1, 0.3)
"""Load on the tip of limbs of silicone [N]."""

LEG = 400 * mm
"""Length of a leg of `six_legs` as built [m]."""

_CIRCLE, _RADIUS = 87 * mm, 1 * mm
_YOUNG, _SHEAR, _STEEL_DENSITY = 200 * GPa, 77 * GPa, 7850.0
_AREA, _SECOND = np.pi * _RADIUS**2, 0.25 * np.pi * _RADIUS**4
_STIFFNESS = {
    "axial": _YOUNG * _AREA,
    "shear": _SHEAR * _AREA,
    "bending": _YOUNG * _SECOND,
    "torsion": _SHEAR * 2.0 * _SECOND,
}
STEEL = Section(**_STIFFNESS)
"""Section of a leg, without weight."""
HEAVY_STEEL = Section(**_STIFFNESS, mass_per_length=_STEEL_DENSITY * _AREA)
"""The same with its weight."""


def joints() -> tuple[Array, Array]:
    """Feet of six legs on the base and their heads on the platform, each in its own plane, shape (6, 3) [m].

    On circles of 87 mm, in pairs 20 degrees apart; the platform's pattern is turned by 60 degrees.
    """
    middle = np.repeat([0.0, 120.0, 240.0], 2)
    base = (middle + np.tile([-10.0, 10.0], 3)) * deg
    tip = (middle + np.tile([-50.0, 50.0], 3)) * deg
    feet, heads = (np.stack([np.cos(a), np.sin(a), 0.0 * a], axis=1) for a in (base, tip))
    return _CIRCLE * feet, _CIRCLE * heads


def built_height() -> float:
    """Height of the platform under six unloaded legs of equal length [m]."""
    base, tip = joints()
    return float(np.sqrt(LEG**2 - ((tip - base) ** 2).sum(axis=1)[0]))


def six_legs(lengths: ArrayLike, section: Section = STEEL) -> Limb:
    """A Stewart-Gough robot: six steel rods, clamped along the lines between the joints of the platform as built.

    Parameters
    ----------
    lengths : array_like, shape (6,)
        Rest lengths [m].
    section : Section
    """
    base, tip = joints()
    base_frames, end_frames = np.tile(np.eye(4), (2, 6, 1, 1))
    for i, (a, b) in enumerate(zip(base, tip, strict=True)):
        z = b - a + [0.0, 0.0, built_height()]
        z /= np.linalg.norm(z)
        x = np.cross([0.0, 1.0, 0.0], z)
        x /= np.linalg.norm(x)
        axes = np.stack([x, np.cross(z, x), z], axis=1)
        base_frames[i, :3, :3] = end_frames[i, :3, :3] = axes
        base_frames[i, :3, 3], end_frames[i, :3, 3] = a, b
    rods = [Rod(section, float(length)) for length in np.asarray(lengths)]
    return Limb([Segment(rods=rods, base_frames=base_frames, end_frames=end_frames)])


def random_pressures(rows: int, actuators: int, seed: int) -> Array:
    """Gauge pressures uniform from 0 to 60 kPa, shape (rows, actuators) [Pa]."""
    return np.random.default_rng([seed, actuators]).uniform(0.0, 60.0 * kPa, (rows, actuators))


def walk(steps: int, actuators: int, seed: int) -> Array:
    """Pressures that each change by 1 % from row to row, up or down at random, shape (steps + 1, actuators) [Pa]."""
    generator = np.random.default_rng([seed, actuators])
    start = generator.uniform(10.0 * kPa, 55.0 * kPa, actuators)
    up = generator.integers(0, 2, (steps, actuators))
    powers = np.vstack([np.zeros((1, actuators)), np.cumsum(2 * up - 1, axis=0)])
    # A walk of a hundred steps strays by about ten: 55 kPa to 61 kPa.
    rows: Array = start * 1.01**powers
    return rows


def zigzag(rows: int) -> Array:
    """Pressures between 20 and 54 kPa that change by 1 % from one to the next, shape (rows,) [Pa]."""
    power = np.abs((np.arange(rows) + 100) % 200 - 100)
    pressures: Array = 20.0 * kPa * 1.01**power
    return pressures


def fine_grid(rows: int, segments: int) -> Array:
    """About that many rows of a grid over one pressure a segment, 0 to 60 kPa, the last fastest, three actuators each.

    The first actuator of a segment moves; the others stay at 20 and 0 kPa. Shape (rows, 3 segments) [Pa].
    """
    points = max(2, round(rows ** (1.0 / segments)))
    axes = np.meshgrid(*[np.linspace(0.0, 60.0 * kPa, points)] * segments, indexing="ij")
    grid = np.tile([0.0, 20.0 * kPa, 0.0], (points**segments, segments))
    for j, axis in enumerate(axes):
        grid[:, 3 * j] = axis.ravel()
    return grid


def soft_rod() -> Rod:
    """A round silicone-like rod: 0.3 m long, radius 10 mm, E = 1 MPa, G = E/3, 1000 kg/m^3."""
    radius, young, density = 10 * mm, 1e6, 1000.0
    area, second = np.pi * radius**2, 0.25 * np.pi * radius**4
    shear_factor = 27.0 / 28.0  # of a round section, as PyElastica takes it
    section = Section(
        axial=young * area,
        shear=shear_factor * young / 3.0 * area,
        bending=young * second,
        torsion=young / 3.0 * 2.0 * second,
        mass_per_length=density * area,
    )
    return Rod(section, 0.3, radius=radius)


def clamped(rod: Rod) -> Limb:
    """A limb of one rod, clamped at the origin along z."""
    return Limb([Segment(rods=[rod], base_frames=np.eye(4)[None], end_frames=np.eye(4)[None])])


def loads() -> dict[str, Any]:
    """Gravity and tip force as `Limb.solve` takes them."""
    return {"gravity": HANGING, "tip_force": TIP_FORCE}
