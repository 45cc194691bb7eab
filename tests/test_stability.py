"""Stability: exact counts of unstable modes against closed forms, and against the energy of a second discretisation.

The columns are exact for rods that stretch and shear. Under a force F that compresses it, a straight rod has the
stretch a = 1 - F/EA and the factor b = a + F/GA, and a small tilt theta with a small side force h obeys

    EI theta'' = -b (F theta + h),      x' = a theta + (F theta + h)/GA.

With the wave k = sqrt(b F/EI), X = k l and r = a/b, every end condition has its equation in X, in which the shear
stiffness is left in r alone. The same with a torque T, in complex numbers, gives Greenhill's rod.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq
from scipy.special import airy, jv

import softlimb as sl
from discrete_rods import DiscreteLimb, turn, unstable_modes
from softlimb import presets
from softlimb.units import kPa

# A rod of length one. Axial and shear stiffness so low that the loads below are off Euler's by per cents.
SOFT = sl.Section(axial=3000.0, shear=900.0, bending=1.0, torsion=0.8)
# Equal axial and shear stiffness: b = 1, and a distributed force changes nothing in the equation of the tilt.
EQUAL = sl.Section(axial=2000.0, shear=2000.0, bending=1.0, torsion=0.8)
# This far from a critical load the smallest stiffness is still 1e-6 of the others, well above rounding.
NEAR = 1e-6


def column(section: sl.Section = SOFT, rods: int = 1, plate: sl.Plate | None = None) -> sl.Limb:
    return sl.Limb([sl.Segment(rods=[sl.Rod(section, 1.0)], ring_radius=0.0, plate=plate) for _ in range(rods)])


def stretch(force: float, section: sl.Section = SOFT) -> float:
    return 1.0 - force / section.axial


def factor(force: float, section: sl.Section = SOFT) -> float:
    return stretch(force, section) + force / section.shear


def wave(force: float, section: sl.Section = SOFT) -> float:
    """X = k l."""
    return float(np.sqrt(factor(force, section) * force / section.bending))


def ratio(force: float, section: sl.Section = SOFT) -> float:
    return stretch(force, section) / factor(force, section)


def roots(equation: Callable[[float], float], largest: float, smallest: float = 1e-3) -> list[float]:
    """Sign changes of a smooth function, found on a grid far finer than they are apart."""
    grid = np.linspace(smallest, largest, 4001)
    values = [equation(x) for x in grid]
    changes = [i for i in range(len(grid) - 1) if values[i] * values[i + 1] < 0.0]
    return [float(brentq(equation, grid[i], grid[i + 1], xtol=1e-14, rtol=1e-15)) for i in changes]


def moved(position: Any = (0.0, 0.0, 0.0), spin: float = 0.0) -> np.ndarray:
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(spin), -np.sin(spin)], [np.sin(spin), np.cos(spin)]]
    pose[:3, 3] = position
    return pose


def straight(limb: sl.Limb, plates: Any, **options: Any) -> sl.Posture:
    """The straight equilibrium, whatever its stability: started there, and checked to have stayed."""
    start = np.array(plates)
    found = limb.solve(**options, start=start, prefer_stable=False, tolerance=1e-9)
    assert found.success, found.message
    assert_allclose(found.plates, start, rtol=0.0, atol=1e-8)
    assert found.conservative
    assert found.stable == (found.unstable_modes == 0)
    return found


# --- Euler's columns ---------------------------------------------------------------------------------------------

# In each of the two planes the tip's place and its tilt may be free or held. Equations whose roots are critical.
PLANES: dict[str, tuple[Callable[[float, float], float], ...]] = {
    "free": (lambda x, r: np.cos(x),),
    "guided": (lambda x, r: np.sin(x),),
    "pinned": (lambda x, r: np.sin(x) - r * x * np.cos(x),),
    "clamped": (lambda x, r: np.sin(0.5 * x), lambda x, r: np.sin(0.5 * x) - r * 0.5 * x * np.cos(0.5 * x)),
}
HELD = {"free": (False, False), "guided": (False, True), "pinned": (True, False), "clamped": (True, True)}
LARGEST = 170.0  # beyond the third load of every plane but the clamped one, whose third is 16 pi^2 = 158


def critical_loads(plane: str, section: sl.Section = SOFT) -> list[float]:
    found = []
    for equation in PLANES[plane]:
        found += roots(lambda f, e=equation: e(wave(f, section), ratio(f, section)), LARGEST)
    return sorted(found)


@pytest.mark.parametrize("by_load", [True, False], ids=["loaded", "shortened"])
@pytest.mark.parametrize("second", PLANES)
@pytest.mark.parametrize("first", PLANES)
def test_every_column_that_a_plate_can_make_loses_one_mode_at_each_critical_load(
    first: str, second: str, by_load: bool
) -> None:
    # Planes x-z and y-z: places x, y and tilts about y, x. The spin about z does not matter to a rod without torque.
    held = [HELD[first][0], HELD[second][0], not by_load, HELD[second][1], HELD[first][1], first == "pinned"]
    loads = {plane: critical_loads(plane) for plane in (first, second)}
    assert all(len(found) >= 3 for found in loads.values())
    limb = column()
    for load in sorted({*loads[first], *loads[second]}):
        for force in (load * (1.0 - NEAR), load * (1.0 + NEAR)):
            tip = moved((0.0, 0.0, stretch(force)))
            options: dict[str, Any] = {"tip_pose": tip, "tip_held": held}
            if by_load:
                options["tip_force"] = (0.0, 0.0, -force)
            found = straight(limb, [tip], **options)
            expected = sum(critical < force for plane in (first, second) for critical in loads[plane])
            assert found.unstable_modes == expected, (load, force)


def test_the_loads_of_rods_that_hardly_stretch_or_shear_are_eulers() -> None:
    # A check of the equations above: r = 1 up to 1e-7.
    stiff = sl.Section(axial=1e9, shear=1e9, bending=1.0, torsion=1.0)
    pi = np.pi
    known = {
        "free": [(n - 0.5) ** 2 * pi**2 for n in (1, 2, 3, 4)],
        "guided": [n**2 * pi**2 for n in (1, 2, 3, 4)],
        "pinned": [4.493409458**2, 7.725251837**2, 10.904121659**2],
        "clamped": [4.0 * pi**2, 4.0 * 4.493409458**2, 16.0 * pi**2],
    }
    for plane, expected in known.items():
        assert_allclose(critical_loads(plane, stiff), expected, rtol=1e-6)


@pytest.mark.parametrize("share", [1e-4, 1e-2, 1.0, 100.0])
def test_a_column_on_a_plate_that_may_tilt_spans_from_pinned_to_clamped(share: float) -> None:
    # The plate at its foot is held in place; a rod below it, without load itself, resists its tilt as a spring:
    # c = EI/l (4 + phi)/(1 + phi), phi = 12 EI/(GA l^2), of that rod.
    below = sl.Section(
        axial=share * SOFT.axial, shear=share * SOFT.shear, bending=share * SOFT.bending, torsion=share * SOFT.torsion
    )
    phi = 12.0 * SOFT.bending / SOFT.shear
    spring = share * (4.0 + phi) / (1.0 + phi)
    segments = [sl.Segment(rods=[sl.Rod(s, 1.0)], ring_radius=0.0) for s in (below, SOFT)]
    limb = sl.Limb(segments)
    held = np.array([[1, 1, 1, 0, 0, 0], [1, 1, 0, 0, 0, 0]], dtype=bool)

    # theta + h/F = A cos + B sin with EI k B = c (A - h/F) below, no moment and no place above: B = A tan X and
    # tan X = r X (1 - EI k tan X/c).
    def equation(force: float) -> float:
        x, r = wave(force), ratio(force)
        return float(np.sin(x) - r * x * (np.cos(x) - x * np.sin(x) / spring))

    loads = roots(equation, 110.0)
    assert len(loads) == 3
    lowest, highest = roots(lambda f: float(np.sin(wave(f))), 15.0)[0], critical_loads("pinned")[0]
    assert lowest < loads[0] < highest
    # The foot's spring shifts the load by c/EI of it at most, from the pinned column, and by EI/c from the clamped.
    assert share != 1e-4 or loads[0] < lowest * (1.0 + 4.0 * share)
    assert share != 100.0 or loads[0] > highest * (1.0 - 4.0 / share)
    for modes, load in enumerate(loads):
        for force, expected in ((load * (1.0 - NEAR), 2 * modes), (load * (1.0 + NEAR), 2 * modes + 2)):
            plates = [moved((0.0, 0.0, 1.0)), moved((0.0, 0.0, 1.0 + stretch(force)))]
            options = {"plate_poses": plates, "plate_held": held, "tip_force": (0.0, 0.0, -force)}
            assert straight(limb, plates, **options).unstable_modes == expected


def test_a_column_of_two_spans_buckles_as_its_halves_do_pinned_or_clamped() -> None:
    # The middle plate may slide and tilt but not move sideways. Modes even about it tilt it not at all: clamped halves.
    # Odd ones put no moment on it: halves clamped at one end and pinned at the other.
    loads = sorted(critical_loads("pinned") + critical_loads("clamped"))
    assert len(loads) == 6
    held = np.array([[1, 1, 0, 0, 0, 0], [1, 1, 0, 1, 1, 1]], dtype=bool)
    limb = column(rods=2)
    for modes, load in enumerate(loads):
        for force, expected in ((load * (1.0 - NEAR), 2 * modes), (load * (1.0 + NEAR), 2 * modes + 2)):
            plates = [moved((0.0, 0.0, n * stretch(force))) for n in (1, 2)]
            options = {"plate_poses": plates, "plate_held": held, "tip_force": (0.0, 0.0, -force)}
            assert straight(limb, plates, **options).unstable_modes == expected, load


@pytest.mark.parametrize("parts", [2, 5, 10])
def test_cutting_a_column_into_segments_changes_no_count(parts: int) -> None:
    limb = sl.Limb([sl.Segment(rods=[sl.Rod(SOFT, 1.0 / parts)], ring_radius=0.0) for _ in range(parts)])
    for modes, load in enumerate(critical_loads("free")[:3]):
        for force, expected in ((load * (1.0 - NEAR), 2 * modes), (load * (1.0 + NEAR), 2 * modes + 2)):
            plates = [moved((0.0, 0.0, stretch(force) * (n + 1) / parts)) for n in range(parts)]
            assert straight(limb, plates, tip_force=(0.0, 0.0, -force)).unstable_modes == expected


@pytest.mark.parametrize("height", [0.0, 0.1, 1.0])
def test_a_heavy_plate_upon_a_column_topples_it_the_sooner_the_taller_it_is(height: float) -> None:
    # Its weight P acts half a thickness above the rod: EI theta' = P (t/2) theta there, so cot X = X t/(2 l) as b = 1.
    def equation(force: float) -> float:
        x = wave(force, EQUAL)
        return float(np.cos(x) - 0.5 * height * x * np.sin(x))

    loads = roots(equation, 110.0)
    assert len(loads) >= 3
    for modes, load in enumerate(loads[:3]):
        for force, expected in ((load * (1.0 - NEAR), 2 * modes), (load * (1.0 + NEAR), 2 * modes + 2)):
            limb = column(EQUAL, plate=sl.Plate(thickness=height, mass=force / 9.81))
            tip = moved((0.0, 0.0, stretch(force, EQUAL)))
            assert straight(limb, [tip], gravity=(0.0, 0.0, -9.81)).unstable_modes == expected


# --- heavy columns -----------------------------------------------------------------------------------------------


def heavy(section: sl.Section, weight: float, push: float, **options: Any) -> sl.Posture:
    """Standing under its own weight per length and a push at the tip, straight."""
    # n = -(P + q (l - s)): the tip sinks by (P + q/2)/EA.
    tip = moved((0.0, 0.0, 1.0 - (push + 0.5 * weight) / section.axial))
    if options:
        options["tip_pose"] = tip
    line = [(0.0, 0.0, -weight)]
    return straight(column(section), [tip], rod_forces=line, tip_force=(0.0, 0.0, -push), **options)


def test_a_heavy_column_loses_two_modes_at_each_zero_of_its_bessel_function() -> None:
    # Greenhill: q l^3/EI = (9/4) j^2 with the zeros j of J_{-1/3}: 7.837, 55.98, 148.5.
    loads = [2.25 * j**2 for j in roots(lambda j: float(jv(-1.0 / 3.0, j)), 9.0)]
    assert loads[0] == pytest.approx(7.837347, abs=1e-6)
    # The same from Airy's functions, which the next test needs.
    assert_allclose(roots(lambda q: heavy_equation(q, 0.0, "free"), 160.0), loads, rtol=1e-9)
    for modes, load in enumerate(loads):
        for weight, expected in ((load * (1.0 - NEAR), 2 * modes), (load * (1.0 + NEAR), 2 * modes + 2)):
            assert heavy(EQUAL, weight, 0.0).unstable_modes == expected


def heavy_equation(weight: float, push: float, tip: str) -> float:
    """EI theta'' = -(P + q (l - s)) theta with theta(0) = 0, and a free (theta' = 0) or guided (theta = 0) tip."""
    c = weight ** (1.0 / 3.0)
    foot, top = airy(-c * (1.0 + push / weight)), airy(-c * push / weight)
    number = 1 if tip == "free" else 0
    return float(foot[0] * top[2 + number] - foot[2] * top[number])


@pytest.mark.parametrize("tip", ["free", "guided"])
@pytest.mark.parametrize("push", [-6.0, -2.0, 1.5])
def test_a_push_or_a_pull_at_the_tip_shifts_the_weight_that_a_column_bears(push: float, tip: str) -> None:
    loads = roots(lambda q: heavy_equation(q, push, tip), 130.0, smallest=0.1)
    assert len(loads) >= 2
    options = {} if tip == "free" else {"tip_held": [False, False, False, True, True, True]}
    for modes, load in enumerate(loads):
        for weight, expected in ((load * (1.0 - NEAR), 2 * modes), (load * (1.0 + NEAR), 2 * modes + 2)):
            assert heavy(EQUAL, weight, push, **options).unstable_modes == expected


# --- Greenhill's rods: an imposed twist --------------------------------------------------------------------------

STIFF_IN_TORSION = sl.Section(axial=3000.0, shear=900.0, bending=1.0, torsion=20.0)
SHEARING = 4.0 * STIFF_IN_TORSION.bending / STIFF_IN_TORSION.shear  # 4 EI/(GA l^2)

# The tip's freedoms held, and the equation in y = T l/(2 EI). Tilts that are free but for the spin feel a torque that
# turns half way with them (semitangential): a hold's reaction belongs to a component of the rotation vector.
TWISTED: dict[str, tuple[list[int], Callable[[float], float]]] = {
    "spin held": ([0, 0, 0, 0, 0, 1], lambda y: np.cos(y)),
    "place and spin held": (
        [1, 1, 0, 0, 0, 1], lambda y: np.sin(y) * (1.0 + y * y) - y * (1.0 - SHEARING * y * y) * np.cos(y),
    ),
    "turns held": ([0, 0, 0, 1, 1, 1], lambda y: np.sin(y)),
    "clamped": ([1, 1, 0, 1, 1, 1], lambda y: np.sin(y) * (1.0 + SHEARING * y * y) - y * np.cos(y)),
    "clamped, length held": ([1, 1, 1, 1, 1, 1], lambda y: np.sin(y) * (1.0 + SHEARING * y * y) - y * np.cos(y)),
}  # fmt: skip


@pytest.mark.parametrize("tip", TWISTED)
def test_an_imposed_twist_makes_a_rod_writhe_at_greenhills_torques(tip: str) -> None:
    held, equation = TWISTED[tip]
    halves = roots(equation, 12.5, smallest=0.5)
    assert len(halves) >= 3
    limb = column(STIFF_IN_TORSION)
    for modes, y in enumerate(halves[:3]):
        for share, expected in ((1.0 - NEAR, 2 * modes), (1.0 + NEAR, 2 * modes + 2)):
            torque = 2.0 * y * share
            pose = moved((0.0, 0.0, 1.0), torque / STIFF_IN_TORSION.torsion)
            found = straight(limb, [pose], tip_pose=pose, tip_held=[bool(h) for h in held])
            assert_allclose(found.tip_reaction, [0.0, 0.0, 0.0, 0.0, 0.0, torque], rtol=0.0, atol=1e-6)
            assert found.unstable_modes == expected, torque


def test_greenhills_clamped_rod_that_does_not_shear_bears_the_torque_of_899() -> None:
    y = roots(lambda y: np.sin(y) - y * np.cos(y), 6.0, smallest=0.5)[0]
    assert 2.0 * y == pytest.approx(8.9868, abs=1e-4)


@pytest.mark.parametrize("force", [-40.0, -5.0, 10.0, 30.0])
def test_tension_holds_a_twisted_rod_and_compression_helps_it_writhe(force: float) -> None:
    # Tilts e^(i q s) with EI q^2 - T q - b F = 0, y = q l/2: sin y1 sin y2/(y1 y2) = r sin(y1 - y2)/(y1 - y2).
    section = STIFF_IN_TORSION
    b, r = factor(force, section), ratio(force, section)

    def equation(torque: float) -> float:
        spread = torque**2 + 4.0 * section.bending * b * force
        half = 0.25 * np.sqrt(complex(spread))
        y1, y2 = 0.25 * torque + half, 0.25 * torque - half
        return float((np.sinc(y1 / np.pi) * np.sinc(y2 / np.pi) - r * np.sinc((y1 - y2) / np.pi)).real)

    torques = roots(equation, 24.0, smallest=0.05)
    assert len(torques) >= 2
    without = 2.0 * roots(TWISTED["clamped"][1], 6.0, smallest=0.5)[0]
    assert (torques[0] > without) == (force < 0.0)
    limb = column(section)
    for modes, torque in enumerate(torques):
        for share, expected in ((1.0 - NEAR, 2 * modes), (1.0 + NEAR, 2 * modes + 2)):
            pose = moved((0.0, 0.0, stretch(force, section)), share * torque / section.torsion)
            options = {"tip_pose": pose, "tip_held": [True, True, False, True, True, True]}
            found = straight(limb, [pose], tip_force=(0.0, 0.0, -force), **options)
            assert found.unstable_modes == expected, torque


# --- rods that buckle between plates -----------------------------------------------------------------------------


def test_rods_between_held_plates_buckle_one_by_one_and_the_plates_do_not_see_it() -> None:
    # Three rods of one axial stiffness and different bending stiffness: all carry the same force.
    shares = (1.0, 2.0, 0.5)
    sections = [sl.Section(axial=3000.0, shear=900.0, bending=b, torsion=b) for b in shares]
    limb = sl.Limb([sl.Segment(rods=[sl.Rod(s, 1.0) for s in sections], ring_radius=0.1)])
    # Their critical loads differ by the stiffness but for what stretch and shear do to them.
    loads = [force for section in sections for force in critical_loads("clamped", section)]
    for load in loads:
        for force in (load * (1.0 - NEAR), load * (1.0 + NEAR)):
            tip = moved((0.0, 0.0, 1.0 - force / 3000.0))
            found = straight(limb, [tip], tip_pose=tip)
            assert found.unstable_modes == 2 * sum(critical < force for critical in loads)
            with pytest.raises(RuntimeError, match="held"):
                found.smallest_stiffness  # noqa: B018


@pytest.mark.parametrize("share, modes", [(0.95, 0), (1.05, 6), (1.95, 6), (2.15, 12)])
def test_thin_rods_between_plates_that_a_thick_one_keeps_apart_buckle_unseen_by_the_plates(
    share: float, modes: int
) -> None:
    # Three thin rods, too long for their places, around a thick one: F/(4 pi^2 EI) = share, the second load is at
    # (8.987/2 pi)^2 = 2.046. The thick rod, 1e6 times as stiff, holds the plate as if it were clamped.
    thin = sl.Section(axial=1e4, shear=1e4, bending=1.0, torsion=1.0)
    thick = sl.Section(axial=1e7, shear=1e7, bending=1e6, torsion=1e6)
    force = share * 4.0 * np.pi**2
    height = 1.0 + 3.0 * force / thick.axial
    rods = [sl.Rod(thick, 1.0)] + [sl.Rod(thin, height / (1.0 - force / thin.axial))] * 3
    frames = np.tile(np.eye(4), (4, 1, 1))
    frames[1:, 0, 3], frames[1:, 1, 3] = [0.1, -0.05, -0.05], [0.0, 0.075**0.5 / 3**0.5, -(0.075**0.5) / 3**0.5]
    limb = sl.Limb([sl.Segment(rods=rods, base_frames=frames, end_frames=frames)])
    found = straight(limb, [moved((0.0, 0.0, height))])
    assert_allclose([rod.force[0, 2] for rod in found.rods[0][1:]], -force, rtol=1e-6)
    assert found.unstable_modes == modes
    assert found.smallest_stiffness > 1e5  # EI/l of the thick rod is 1e6: nothing is wrong with the plate


# --- smallest stiffness and its mode -----------------------------------------------------------------------------


def tip_stiffness(force: float) -> np.ndarray:
    """Of a compressed cantilever: (side force, moment) by (side move, tilt) of the tip in one plane."""
    x, a, b = wave(force), stretch(force), factor(force)
    # theta + H = H cos ks + B sin ks; columns for H = h/F and B.
    moves = np.array([
        [b / x * np.sin(x) - a, b / x * (1.0 - np.cos(x))],
        [np.cos(x) - 1.0, np.sin(x)],
    ])  # fmt: skip
    loads = np.array([[force, 0.0], [-x * np.sin(x), x * np.cos(x)]]) * SOFT.bending
    result: np.ndarray = loads @ np.linalg.inv(moves)
    return result


@pytest.mark.parametrize("force", [1e-3, 1.0, 2.0, 2.4, 3.0, 10.0, 30.0, 60.0])
def test_the_plate_stiffness_of_a_column_is_that_of_the_stability_functions(force: float) -> None:
    tip = moved((0.0, 0.0, stretch(force)))
    found = straight(column(), [tip], tip_force=(0.0, 0.0, -force))
    plane = tip_stiffness(force)
    expected = np.zeros((6, 6))
    expected[np.ix_([0, 4], [0, 4])] = plane
    expected[np.ix_([1, 3], [1, 3])] = plane * [[1.0, -1.0], [-1.0, 1.0]]
    expected[2, 2], expected[5, 5] = SOFT.axial, SOFT.torsion
    # The solve's tolerance is 1e-9 of the length; the stiffness follows with a few hundred times that.
    assert_allclose(found.plate_stiffness, expected, rtol=0.0, atol=1e-6 * np.abs(plane).max() + 1e-9 * SOFT.axial)
    lowest = min(np.linalg.eigvalsh(plane)[0], SOFT.torsion)
    assert found.smallest_stiffness == pytest.approx(lowest, rel=1e-5)
    assert (found.smallest_stiffness < 0.0) == (found.unstable_modes > 0)


def test_the_softest_mode_of_a_column_near_buckling_is_its_buckling_mode() -> None:
    load = critical_loads("free")[0]
    force, parts = load * (1.0 - NEAR), 4
    limb = sl.Limb([sl.Segment(rods=[sl.Rod(SOFT, 1.0 / parts)], ring_radius=0.0) for _ in range(parts)])
    heights = np.arange(1, parts + 1) / parts
    plates = [moved((0.0, 0.0, stretch(force) * height)) for height in heights]
    found = straight(limb, plates, tip_force=(0.0, 0.0, -force))
    # theta = sin(k s) and x = (b/k) (1 - cos(k s)), in any plane.
    x = wave(load)
    mode = found.mode_shape
    tilt = np.stack([mode[:, 4], -mode[:, 3]], axis=1)
    tip = tilt[-1] / np.sin(x)
    assert_allclose(tilt, np.sin(x * heights)[:, None] * tip, rtol=0.0, atol=1e-5 * np.abs(tip).max())
    side = factor(load) / x * (1.0 - np.cos(x * heights))[:, None] * tip
    assert_allclose(mode[:, :2], side, rtol=0.0, atol=1e-5 * np.abs(tip).max())
    # Neither stretch nor spin belong to it.
    assert_allclose(mode[:, [2, 5]], 0.0, rtol=0.0, atol=1e-8 * np.abs(tip).max())
    # Rayleigh: the stiffness against this mode of unit size falls in proportion to what is left of the load.
    further = straight(
        limb,
        [moved((0.0, 0.0, stretch(load * (1.0 - 2.0 * NEAR)) * height)) for height in heights],
        tip_force=(0.0, 0.0, -load * (1.0 - 2.0 * NEAR)),
    )
    assert further.smallest_stiffness == pytest.approx(2.0 * found.smallest_stiffness, rel=1e-3)


# --- loads without a potential -----------------------------------------------------------------------------------


@pytest.mark.parametrize("force", [1.0, 2.4, 2.6, 10.0, 20.0])
def test_becks_column_does_not_diverge_below_its_flutter(force: float) -> None:
    # A force that follows the tip holds a column in no second equilibrium (Beck): Euler's 2.47 EI/l^2 means nothing to
    # it. It flutters from 20.05 on, of which statics knows nothing.
    limb = column(EQUAL)
    tip = moved((0.0, 0.0, stretch(force, EQUAL)))
    found = limb.solve(tip_force=(0.0, 0.0, -force), frame="plate", start=tip[None], tolerance=1e-9)
    assert found.success, found.message
    assert_allclose(found.tip, tip, rtol=0.0, atol=1e-8)
    assert found.stable and found.unstable_modes is None and not found.conservative


@pytest.mark.parametrize("share, stable", [(1.0 - NEAR, True), (1.0 + NEAR, False)])
def test_a_following_force_on_a_pinned_tip_diverges_at_eulers_load(share: float, stable: bool) -> None:
    # The pin takes the force's side component, so that following makes no difference.
    force = share * critical_loads("pinned")[0]
    tip = moved((0.0, 0.0, stretch(force)))
    options: dict[str, Any] = {"tip_pose": tip, "tip_held": [True, True, False, False, False, False]}
    found = column().solve(
        tip_force=(0.0, 0.0, -force), frame="plate", start=tip[None], tolerance=1e-9, prefer_stable=False, **options
    )
    assert found.success, found.message
    assert_allclose(found.tip, tip, rtol=0.0, atol=1e-8)
    assert found.stable == stable
    assert stable or "divergence" in found.message


# --- the energy of a second discretisation -----------------------------------------------------------------------


def counted_again(found: sl.Posture, elements: int, held: Any = None, poses: Any = None) -> tuple[int, float]:
    """Unstable modes of the energy of short elements, and how far its equilibrium is from the posture's plates."""
    second = DiscreteLimb(found, elements, held, poses)
    hessian = second.settle()
    gap = np.abs(second.plates()[:, :3, 3] - found.plates[:, :3, 3]).max() / found.limb.length
    return unstable_modes(hessian), float(gap)


def random_turn(generator: np.random.Generator, largest: float) -> np.ndarray:
    return turn(generator.uniform(-largest, largest, 3))


def random_scene(seed: int) -> tuple[sl.Limb, dict[str, Any], Any, Any]:
    """One or two segments of one to three unequal rods, pushed, heavy, some plates held at random freedoms."""
    generator = np.random.default_rng(seed)
    slender = 10.0 ** generator.uniform(2.0, 4.0)
    segments = []
    for _ in range(generator.integers(1, 3)):
        rods = []
        for _ in range(generator.integers(1, 4)):
            bending = generator.choice([1.0, 0.3, 0.1])
            section = sl.Section(
                axial=slender * bending, shear=0.5 * slender * bending, bending=bending, torsion=0.8 * bending,
                mass_per_length=generator.uniform(0.0, 0.5), rest_twist=generator.uniform(-1.0, 1.0),
                extension_twist=generator.uniform(-0.5, 0.5) / (bending * np.sqrt(0.8 * slender)),
            )  # fmt: skip
            rods.append(sl.Rod(section, generator.uniform(0.97, 1.03)))
        plate = sl.Plate(thickness=0.1, mass=0.2)
        segments.append(sl.Segment(rods=rods, ring_radius=generator.uniform(0.05, 0.3), plate=plate))
    limb = sl.Limb(segments)
    push = generator.uniform(0.0, 25.0) * sum(rod.section.bending for rod in segments[-1].rods)
    options: dict[str, Any] = {
        "gravity": generator.normal(size=3), "tip_force": generator.normal(size=3) * 0.3 + [0.0, 0.0, -push],
    }  # fmt: skip
    held = poses = None
    if generator.random() < 0.6:
        plate_number = generator.integers(len(segments))
        held = np.zeros((len(segments), 6), dtype=bool)
        held[plate_number] = generator.random(6) < 0.5
        poses = limb.solve().plates.copy()
        poses[plate_number, :3, 3] += generator.normal(size=3) * 0.05
        poses[plate_number, :3, :3] = random_turn(generator, 0.4) @ poses[plate_number, :3, :3]
        options |= {"plate_held": held, "plate_poses": poses}
    return limb, options, held, poses


# Seeds whose first equilibrium is unstable, by one to nine modes, and stable ones with partly held plates.
UNSTABLE = (0, 1, 2, 3, 9, 11, 12, 19, 32, 36, 43, 75)
STABLE = (4, 7, 17, 24, 30, 42, 60)


@pytest.mark.parametrize("seed", [*UNSTABLE, *STABLE])
def test_unstable_modes_are_the_falling_directions_of_a_discretised_energy(seed: int) -> None:
    limb, options, held, poses = random_scene(seed)
    found = limb.solve(**options, prefer_stable=False, tolerance=1e-9)
    assert found.success and found.verify().success, found.message
    modes, gap = counted_again(found, 16, held, poses)
    assert found.unstable_modes == modes
    assert (modes > 0) == (seed in UNSTABLE)
    # Turns of up to 3 rad along a rod are 0.2 an element: second order leaves 0.2^2/12 of the length, a third of a per
    # cent, and several times that near buckling.
    assert gap < 0.02


@pytest.mark.parametrize("seed", UNSTABLE)
def test_a_posture_that_is_called_stable_is_a_minimum_of_a_discretised_energy(seed: int) -> None:
    limb, options, held, poses = random_scene(seed)
    found = limb.solve(**options, tolerance=1e-9)
    assert found.success and found.stable and found.verify().success, found.message
    assert counted_again(found, 24, held, poses)[0] == found.unstable_modes == 0


@pytest.mark.parametrize("seed", [2, 11, 32, 44])
def test_the_discretised_equilibrium_approaches_the_posture_with_the_square_of_its_step(seed: int) -> None:
    limb, options, held, poses = random_scene(seed)
    found = limb.solve(**options, prefer_stable=False, tolerance=1e-10)
    coarse, fine = (counted_again(found, elements, held, poses)[1] for elements in (20, 40))
    # The next order is another (1/20)^2 times some turns: a tenth at most.
    assert fine == pytest.approx(0.25 * coarse, rel=0.1)


def test_the_slope_of_the_discretised_energy_is_its_slope() -> None:
    # The second discretisation is itself checked: forces against differences of energy along random moves.
    limb, options, held, poses = random_scene(11)
    second = DiscreteLimb(limb.solve(**options, prefer_stable=False), 6, held, poses)
    slope, _ = second.slope_and_hessian()
    generator = np.random.default_rng(0)
    for _ in range(5):
        direction = generator.normal(size=(second.bodies, 6))
        energies = []
        for step in (1e-4, -1e-4):
            position, vector = second.position.copy(), second.vector.copy()
            second.position[:-1] += step * direction[:, :3]
            second.vector[:-1] += step * direction[:, 3:]
            energies.append(second.energy())
            second.position, second.vector = position, vector
        # Differences err by the square of the step, 1e-8 of the third derivative, with stiffnesses in a ratio of 1e4.
        assert (energies[0] - energies[1]) / 2e-4 == pytest.approx(direction.ravel() @ slope, rel=1e-4)
    hessian = second.settle()
    assert unstable_modes(hessian) == int((np.linalg.eigvalsh(hessian.toarray()) < 0.0).sum()) > 0


@pytest.mark.parametrize("kilopascal, modes", [(0.0, 2), (20.0, 2), (40.0, 4), (60.0, 4)])
def test_the_standing_reference_limb_falls_in_as_many_directions_as_its_discretised_energy(
    kilopascal: float, modes: int
) -> None:
    limb = presets.reference_limb()
    pressures = np.full(9, kilopascal * kPa)
    standing: dict[str, Any] = {"gravity": (0.0, 0.0, -9.81), "tolerance": 1e-9}
    straight_up = limb.solve(pressures, **standing, prefer_stable=False)
    assert straight_up.success and straight_up.tip[2, 3] > 0.6
    assert counted_again(straight_up, 8)[0] == straight_up.unstable_modes == modes
    fallen = limb.solve(pressures, **standing)
    assert fallen.success and fallen.stable
    assert counted_again(fallen, 8)[0] == 0


@pytest.mark.parametrize("share", [0.9, 1.1, 1.9, 2.3])
@pytest.mark.parametrize("stiff", [100.0, 1000.0])
def test_thin_rods_beside_a_thick_one_are_left_for_a_stable_posture(stiff: float, share: float) -> None:
    # Two thin rods too long for their places: straight they bear share of 4 pi^2 EI/l^2.
    thin = sl.Section(axial=1e4, shear=1e4, bending=1.0, torsion=1.0)
    thick = sl.Section(axial=1e6, shear=1e6, bending=stiff, torsion=stiff)
    force = share * 4.0 * np.pi**2
    height = 1.0 + 2.0 * force / thick.axial
    frames = np.tile(np.eye(4), (3, 1, 1))
    frames[1:, 0, 3] = [0.1, -0.1]
    rods = [sl.Rod(thick, 1.0)] + [sl.Rod(thin, height / (1.0 - force / thin.axial))] * 2
    limb = sl.Limb([sl.Segment(rods=rods, base_frames=frames, end_frames=frames)])
    first = straight(limb, [moved((0.0, 0.0, height))])
    assert first.unstable_modes == counted_again(first, 24)[0]
    assert (first.unstable_modes == 0) == (share < 1.0)
    found = limb.solve(tolerance=1e-6)
    assert found.success and found.stable and found.verify().success, found.message
    assert share < 1.0 or "unstable" in found.message


# A rod's own buckling between held plates, whatever way the solver came by


@pytest.mark.parametrize("axial", [1e5, 2e5, 4e5, 1e6, 3e6, 1e8, 1e9])
@pytest.mark.parametrize("load", [37.0, 42.0, 50.0, 60.0, 75.0, 160.0, 400.0])
def test_a_rod_pushed_between_held_plates_bows_however_little_it_stretches(axial: float, load: float) -> None:
    # EI = l = 1, both ends clamped: a straight rod carries 4 pi^2 = 39.48. Its tip is held where the force would be
    # `load`: the last step of Newton then moves nothing but that force, and the modes are those of after it.
    rod = sl.Rod(sl.Section(axial=axial, shear=axial, bending=1.0, torsion=0.77), 1.0)
    tip = np.eye(4)
    tip[2, 3] = 1.0 - load / axial
    posture = sl.Limb([sl.Segment(rods=[rod], ring_radius=0.0)]).solve(tip_pose=tip)
    assert posture.success
    bow = np.linalg.norm(posture.rods[0][0].centreline()[:, :2], axis=1).max()
    assert posture.stable and posture.unstable_modes == 0
    if load < 4.0 * np.pi**2:
        assert bow < 1e-6
    else:
        # Shortened by the square of its bow: (pi a / l)^2 for half a wave of 1 - cos.
        shortened = (load - 4.0 * np.pi**2) / axial
        assert bow == pytest.approx(2.0 / np.pi * np.sqrt(shortened), rel=0.1)


def test_rods_side_by_side_between_held_plates_all_bow() -> None:
    # EI = 1, 2 and 1/2, all pressed six times as hard as the stiffest bears: the softer ones bow first.
    sections = [sl.Section(axial=1e7, shear=1e7, bending=b, torsion=b) for b in (1.0, 2.0, 0.5)]
    limb = sl.Limb([sl.Segment(rods=[sl.Rod(s, 1.0) for s in sections], ring_radius=0.1)])
    shortening = 6.0 * 8.0 * np.pi**2 / 1e7
    tip = np.eye(4)
    tip[2, 3] = 1.0 - shortening
    posture = limb.solve(tip_pose=tip)
    assert posture.success and posture.stable and posture.unstable_modes == 0
    for section, rod in zip(sections, posture.rods[0], strict=True):
        bow = np.linalg.norm(rod.centreline()[:, :2] - rod.centreline()[0, :2], axis=1).max()
        bent = shortening - 4.0 * np.pi**2 * section.bending / section.axial
        assert bow == pytest.approx(2.0 / np.pi * np.sqrt(bent), rel=0.1)


def test_under_a_following_load_only_divergence_is_an_event() -> None:
    # Tension along the rod's own end: det K has no root. Compression (Beck's column): none either, it flutters first.
    rod = sl.Rod(sl.Section(axial=1e5, shear=1e5, bending=1.0, torsion=0.8), 1.0)
    limb = sl.Limb([sl.Segment(rods=[rod], ring_radius=0.0)])
    for last in (30.0, -18.0):
        path = limb.follow(lambda force: {"tip_force": (0.0, 0.0, force)}, 0.0, last, frame="plate")
        assert path.success and path.events == () and path.stable.all()
    found = limb.payload((0.0, 0.0, 1.0), frame="plate", max_force=30.0)
    assert found.limit == "force" and found.posture.stable
