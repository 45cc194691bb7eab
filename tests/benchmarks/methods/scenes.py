"""Scenes that break methods: growth, slenderness, stiffness ratios, turns, buckling, sizes, symmetry, and plain ones.

``scenes()`` lists them in order. Where a closed form exists the scene carries the tip's position by it. ``round`` marks
a posture that any turn about the base's z axis maps to an equal one: its tip is then compared by radius and height,
its rotation by the tilt.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import softlimb as sl
from softlimb import presets
from softlimb.bench.limbs import six_legs
from softlimb.units import kPa

__all__ = ["Scene", "scenes"]

HANGING = (0.0, 0.0, 9.81)
SOFT = sl.Section(axial=400.0, shear=130.0, bending=0.08, torsion=0.06, mass_per_length=0.4)
THIN = sl.Section(axial=60.0, shear=20.0, bending=0.003, torsion=0.002, mass_per_length=0.1)
KEVLAR = sl.Section(axial=4e5, shear=1.5e5, bending=8.0, torsion=6.0, mass_per_length=1.0)


@dataclass(frozen=True)
class Scene:
    name: str
    limb: Callable[[], sl.Limb]
    options: dict[str, Any] = field(default_factory=dict)
    exact: tuple[float, float, float] | None = None  # position of the tip by a closed form
    round: bool = False


def single(section, length=1.0):
    return sl.Limb([sl.Segment(rods=[sl.Rod(section, length)], ring_radius=0.0)])


def inextensible(bending=1.0):
    """A section that bends as the elastica does, exactly: with EA = GA a force strains the rod along itself."""
    return sl.Section(axial=1e9, shear=1e9, bending=bending, torsion=0.8 * bending)


def ring(section, lengths, radius=0.03, thickness=0.02, mass=0.02):
    rods = [sl.Rod(section, length) for length in lengths]
    return sl.Segment(rods=rods, ring_radius=radius, plate=sl.Plate(thickness=thickness, mass=mass))


# --- growth ------------------------------------------------------------------------------------------------------


def pulled_sideways(growth):
    """A rod of length and EI one, clamped along z and pulled along x by the force growth^2: an elastica of infinite
    length up to e^-growth. With the angle to the force t: tan(t/4) = tan(pi/8) e^(-growth s)."""
    force = growth**2
    t = 0.5 * np.pi
    along = 1.0 - 2.0 / growth * (1.0 - np.cos(0.5 * t)) + force / 1e9
    across = 2.0 / growth * np.sin(0.5 * t)
    exact = (along, 0.0, across) if growth >= 20.0 else None  # below, the end of the rod is felt
    options = {"tip_force": (force, 0.0, 0.0)}
    return Scene(f"growth e^{growth:.0f}, one rod", lambda: single(inextensible()), options, exact)


def pulled_limb(growth):
    """Two segments of three unequal rods; the pull makes every rod grow by about e^growth."""
    section = sl.Section(axial=4e4, shear=1.3e4, bending=0.01, torsion=0.008)

    def limb():
        return sl.Limb([ring(section, lengths, 0.02, 0.02) for lengths in ((0.2, 0.204, 0.2), (0.2, 0.2, 0.196))])

    force = 3.0 * section.bending * (growth / 0.2) ** 2
    return Scene(f"growth e^{growth:.0f}, six rods", limb, {"tip_force": (0.05 * force, 0.0, force)})


# --- stiffness ---------------------------------------------------------------------------------------------------


def slender(ratio):
    """Three round steel-like rods, length over radius as given, pushed sideways and down."""
    radius = 1.0 / ratio
    area, second = np.pi * radius**2, 0.25 * np.pi * radius**4
    bending = 1.0
    modulus = bending / second
    section = sl.Section(
        axial=modulus * area, shear=0.4 * modulus * area, bending=bending, torsion=0.8 * bending, mass_per_length=0.1
    )

    def limb():
        return sl.Limb([ring(section, (1.0, 1.01, 1.0), 0.05, 0.0)])

    return Scene(f"slenderness {ratio:.0f}", limb, {"tip_force": (2.0, 1.0, -2.0), "gravity": HANGING})


def axial_ratio(ratio):
    section = sl.Section(axial=ratio, shear=0.4 * ratio, bending=1.0, torsion=0.8)

    def limb():
        return sl.Limb([ring(section, (1.0, 1.02, 1.0), 0.1, 0.0)])

    return Scene(f"EA l^2/EI {ratio:.0e}", limb, {"tip_force": (1.0, 0.5, -1.0)})


def mixed():
    def limb():
        rods = [sl.Rod(KEVLAR, 0.2), sl.Rod(THIN, 0.2), sl.Rod(THIN, 0.21)]
        return sl.Limb([sl.Segment(rods=rods, ring_radius=0.03, plate=sl.Plate(0.02, 0.02)) for _ in range(2)])

    return Scene("Kevlar beside silicone", limb, {"tip_force": (1.0, 0.0, 5.0), "gravity": HANGING})


# --- turns -------------------------------------------------------------------------------------------------------


def circle(turns):
    angle = 2.0 * np.pi * turns
    exact = ((1.0 - np.cos(angle)) / angle, 0.0, np.sin(angle) / angle)
    options = {"tip_moment": (0.0, angle, 0.0)}
    return Scene(f"circle, {turns:.0f} turn{'s' if turns > 1 else ''}", lambda: single(inextensible()), options, exact)


def tilted():
    options = {"pressures": [[90.0 * kPa, 0.0, 0.0]] * 3, "tip_force": (0.5, 0.0, 0.0)}
    return Scene("tip turned beyond 180 deg", presets.reference_limb, options)


# --- buckling ----------------------------------------------------------------------------------------------------


def _elliptic(k):
    """Complete elliptic integrals K and E of modulus k by the arithmetic-geometric mean."""
    a, b, c, power, total = 1.0, np.sqrt(1.0 - k * k), k, 1.0, 0.5 * k * k
    for _ in range(12):  # digits double each round
        a, b, c = 0.5 * (a + b), np.sqrt(a * b), 0.5 * (a - b)
        power *= 2.0
        total += 0.5 * power * c * c
    first = 0.5 * np.pi / a
    return first, first * (1.0 - total)


def column(share):
    """A cantilever of length and EI one under a dead axial push, as a share of Euler's load."""
    force = share * 0.25 * np.pi**2
    root = np.sqrt(force)
    if share <= 1.0:
        exact = (0.0, 0.0, 1.0 - force / 1e9)
    else:
        low, high = 0.0, 1.0 - 1e-15
        for _ in range(200):
            k = 0.5 * (low + high)
            low, high = (k, high) if _elliptic(k)[0] < root else (low, k)
        exact = (2.0 * k / root, 0.0, 2.0 * _elliptic(k)[1] / root - 1.0 - force / 1e9)
    options = {"tip_force": (0.0, 0.0, -force)}
    return Scene(f"column at {share:.4g} of buckling", lambda: single(inextensible()), options, exact, round=True)


def crushed_segment():
    """Three rods between plates pushed to three times the load at which they buckle together, slightly aside."""
    section = sl.Section(axial=1e5, shear=4e4, bending=1.0, torsion=0.8)
    options = {"tip_force": (0.3, 0.1, -3.0 * 3.0 * np.pi**2)}
    return Scene("segment at 3 times buckling", lambda: sl.Limb([ring(section, (1.0,) * 3, 0.1, 0.0)]), options)


# --- counts, sizes, loads ----------------------------------------------------------------------------------------


def chain(segments, rods):
    def limb():
        lengths = 0.2 + 0.01 * np.sin(1.0 + np.arange(rods))
        return sl.Limb([ring(SOFT, np.roll(lengths, j)) for j in range(segments)])

    name = f"{segments} segment{'s' if segments > 1 else ''} of {rods} rod{'s' if rods > 1 else ''}"
    return Scene(name, limb, {"gravity": (3.0, 0.0, 9.0)})


def tapered(ratio):
    """Three segments whose radii fall to the given ratio along the limb, stiffness as their second and fourth power."""

    def limb():
        parts = []
        for j in range(3):
            s = ratio ** (j / 2.0)
            section = sl.Section(
                axial=400.0 * s**2, shear=130.0 * s**2, bending=0.08 * s**4, torsion=0.06 * s**4,
                mass_per_length=0.4 * s**2,
            )  # fmt: skip
            parts.append(ring(section, (0.2, 0.2 * (1.0 + 0.05 * s), 0.2), 0.03 * s, 0.02, 0.02 * s**3))
        return sl.Limb(parts)

    return Scene(f"radius ratio {ratio:.1f}", limb, {"gravity": (1.0, 0.0, 9.0)})


def sized(length):
    """The same shape at another size; stiffness, weight and load as size squared, like a limb of one material whose
    gravity is scaled along."""
    a = length / 0.45
    b = a * a

    def section(s):
        return sl.Section(
            axial=b * s.axial, shear=b * s.shear, bending=b * a * a * s.bending, torsion=b * a * a * s.torsion,
            mass_per_length=b / a * s.mass_per_length,
        )  # fmt: skip

    def limb():
        lengths = [a * x for x in (0.2, 0.215, 0.205)]
        return sl.Limb([ring(section(s), lengths, 0.03 * a, 0.025 * a, 0.05 * b) for s in (SOFT, SOFT)])

    unit = "1 mm" if length < 0.01 else "10 m" if length > 1.0 else f"{length} m"
    return Scene(f"limb of {unit}", limb, {"gravity": HANGING, "tip_force": (0.2 * b, 0.1 * b, 0.0)})


COMPLEX = np.array([[90.0, 60.0, 30.0], [60.0, 40.0, 20.0], [50.0, 50.0, 50.0]]) * kPa


def reference(name, pressures, exact=None, **options):
    return Scene(name, presets.reference_limb, {"pressures": np.asarray(pressures), **options}, exact)


def equal_lengths():
    """Rest lengths equal to the last bit; a tip force alone bends the limb."""
    options = {"pressures": np.full(9, 30.0 * kPa), "tip_force": (0.3, 0.1, 0.0)}
    return Scene("rest lengths equal to a bit", presets.reference_limb, options)


def stewart_gough():
    lengths = [0.4, 0.405, 0.4, 0.4, 0.405, 0.4]
    return Scene("Stewart-Gough robot", lambda: six_legs(lengths), {"tip_force": (1.0, 0.5, -5.0)})


def random_scene(number):
    """As in bench_cold_starts.py: pressures to 90 kPa, gravity and a tip force to 1 N in any direction."""
    generator = np.random.default_rng([20261122, number])
    pressures = generator.uniform(0.0, 90.0 * kPa, (3, 3))
    gravity, push = generator.normal(size=3), generator.normal(size=3)
    options = {
        "gravity": 9.81 * gravity / np.linalg.norm(gravity),
        "tip_force": generator.uniform(0.0, 1.0) * push / np.linalg.norm(push),
    }
    return reference(f"random scene {number}", pressures, **options)


def scenes() -> list[Scene]:
    limb = presets.reference_limb()
    rests = [sum(s.actuators[0].rest_length(p) for s in limb) + 0.05 for p in (0.0, 55.0 * kPa)]
    return [
        *(pulled_sideways(growth) for growth in (5.0, 20.0, 40.0, 80.0)),
        *(pulled_limb(growth) for growth in (20.0, 80.0)),
        *(slender(ratio) for ratio in (20.0, 200.0, 2000.0)),
        *(axial_ratio(ratio) for ratio in (1e1, 1e3, 1e6, 1e9)),
        mixed(),
        *(circle(turns) for turns in (1.0, 3.0)),
        tilted(),
        *(column(share) for share in (0.999, 1.0, 1.001, 3.0)),
        crushed_segment(),
        *(chain(*counts) for counts in ((1, 1), (1, 2), (1, 3), (1, 12), (3, 6), (5, 3), (10, 3))),
        *(tapered(ratio) for ratio in (0.1, 0.5, 1.0)),
        *(sized(length) for length in (1e-3, 0.45, 10.0)),
        reference("gravity times 20", COMPLEX, gravity=(0.0, 0.0, 196.2)),
        reference("zero pressure", np.zeros(9), exact=(0.0, 0.0, rests[0])),
        reference("equal pressures", np.full(9, 55.0 * kPa), exact=(0.0, 0.0, rests[1])),
        reference("vacuum in three actuators", [[-20.0 * kPa, 0.0, 0.0]] * 3, gravity=HANGING),
        equal_lengths(),
        stewart_gough(),
        reference("the paper's complex posture, hanging", COMPLEX, gravity=HANGING),
        reference("the paper's complex posture, no weight", COMPLEX),
        *(random_scene(number) for number in range(4)),
    ]
