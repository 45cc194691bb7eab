"""Stiff and extreme scenes, each against a closed form, a law, or another method. Other ones stand in test_rod.py and
test_limb.py, columns and counts in test_stability.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_bvp
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import softlimb as sl
from discrete_rods import DiscreteLimb, rotation_vector, unstable_modes
from frames import pose, solved, turn
from softlimb import presets
from softlimb.bench.limbs import LEG, STEEL, built_height, joints, six_legs
from softlimb.units import deg, kPa, mm

COMPLEX = np.array([[90.0, 60.0, 30.0], [60.0, 40.0, 20.0], [50.0, 50.0, 50.0]]) * kPa


def about_y(angle: float) -> np.ndarray:
    return np.array([[np.cos(angle), 0.0, np.sin(angle)], [0.0, 1.0, 0.0], [-np.sin(angle), 0.0, np.cos(angle)]])


# --- unloaded limbs are beams in parallel and in series ----------------------------------------------------------


def beam_stiffness(rod: sl.Rod) -> np.ndarray:
    """Of a clamped straight beam's end, (force, moment) by (move, turn): Timoshenko, phi = 12 EI/(GA l^2)."""
    s, l = rod.section, rod.length  # noqa: E741
    phi = 12.0 * s.bending / (s.shear * l * l)
    side, mixed = 12.0 * s.bending / (l**3 * (1.0 + phi)), 6.0 * s.bending / (l**2 * (1.0 + phi))
    tilt = (4.0 + phi) * s.bending / (l * (1.0 + phi))
    k = np.diag([side, side, s.axial / l, tilt, tilt, s.torsion / l])
    k[0, 4] = k[4, 0] = -mixed
    k[1, 3] = k[3, 1] = mixed
    return k


def carried(arm: np.ndarray) -> np.ndarray:
    """Move of a point at the arm by the move of the origin of a rigid body."""
    x, y, z = arm
    lever = np.eye(6)
    lever[:3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    return lever


def beam_compliance(limb: sl.Limb) -> np.ndarray:
    """Of the tip of a straight limb without load: stiffnesses of a segment add, compliances of segments add."""
    total, heights, below = np.zeros((6, 6)), [], 0.0
    for segment in limb:
        below += segment.rods[0].length
        heights.append(below)
        below += segment.plate.thickness
    for segment, height in zip(limb, heights, strict=True):
        stiffness = np.zeros((6, 6))
        for rod, frame in zip(segment.rods, segment.end_frames, strict=True):
            lever = carried(frame[:3, 3])
            stiffness += lever.T @ beam_stiffness(rod) @ lever
        lever = carried(np.array([0.0, 0.0, heights[-1] - height]))
        total += lever @ np.linalg.inv(stiffness) @ lever.T
    return total


def section_of(ratio: float, stiffness: float = 1.0, length: float = 1.0) -> sl.Section:
    """EA l^2/EI = ratio, GA = 0.4 EA, EI = stiffness."""
    axial = ratio * stiffness / length**2
    return sl.Section(
        axial=axial, shear=0.4 * axial, bending=stiffness, torsion=0.8 * stiffness, mass_per_length=0.1
    )


def tower(counts: Sequence[int], radii: Sequence[float], ratio: float, size: float = 1.0) -> sl.Limb:
    """Straight segments of equal rods but for their stiffness: the first of each ring is a thousandfold one."""
    segments = []
    for count, radius in zip(counts, radii, strict=True):
        soft = section_of(ratio, size**4, size)
        stiff = section_of(ratio, 1e3 * size**4, size)
        rods = [sl.Rod(stiff if i == 0 else soft, size) for i in range(count)]
        plate = sl.Plate(thickness=0.1 * size)
        segments.append(sl.Segment(rods=rods, ring_radius=radius * size, plate=plate))
    return sl.Limb(segments)


TOWERS: dict[str, tuple[Sequence[int], Sequence[float]]] = {
    **{f"{n} rods": ([n], [0.2]) for n in range(1, 13)},
    **{f"{j} segments": ([3] * j, [0.2] * j) for j in (2, 4, 7, 10)},
    "one to twelve rods": (range(1, 13), [0.2] * 12),
    "tip ring a tenth of the base ring": ([3] * 5, np.geomspace(0.3, 0.03, 5)),
    "tip ring half the base ring": ([3, 4, 5], np.linspace(0.3, 0.15, 3)),
}


@pytest.mark.parametrize("ratio", [10.0, 1e3, 1.6e7, 1e9])
@pytest.mark.parametrize("name", TOWERS)
def test_a_limb_without_load_is_as_compliant_as_beams_in_parallel_and_segments_in_series(
    name: str, ratio: float
) -> None:
    # 1.6e7 is that of a round rod of slenderness 1000, 2000 radii.
    limb = tower(*TOWERS[name], ratio)
    found = solved(limb, tolerance=1e-9)
    assert found.stable and found.unstable_modes == 0
    expected = beam_compliance(limb)
    for rows in (slice(0, 3), slice(3, 6)):
        for columns in (slice(0, 3), slice(3, 6)):
            block = expected[rows, columns]
            # Stiffnesses in a ratio of a thousand times this one: rounding of that many units, in either side.
            largest = np.abs(block).max()
            assert_allclose(found.compliance[rows, columns], block, rtol=0.0, atol=(1e-9 + 2e-15 * ratio) * largest)


@pytest.mark.parametrize("size", [1e-3, 10.0])
def test_small_and_large_limbs_have_the_compliance_of_their_size(size: float) -> None:
    counts, radii = [3, 4, 5], [0.3, 0.2, 0.1]
    small, normal = solved(tower(counts, radii, 1e4, size)), solved(tower(counts, radii, 1e4))
    scale = np.array([size] * 3 + [1.0] * 3)  # EI as size^4: forces as size^2, moments as size^3
    expected = scale[:, None] * normal.compliance * scale / size**3
    # The same arithmetic on scaled numbers: rounding, times the stiffness ratio of 1e4.
    assert_allclose(small.compliance / np.abs(expected).max(axis=1)[:, None], expected / np.abs(expected).max(axis=1)[
        :, None], rtol=0.0, atol=1e-9)  # fmt: skip


# --- circles -----------------------------------------------------------------------------------------------------


def arcs(counts: Sequence[int], radii: Sequence[float], seed: int) -> sl.Limb:
    """Segments of rods of very different stiffness, alike in the sum: Kevlar beside silicone, up to a thousandfold."""
    generator = np.random.default_rng(seed)
    segments: list[sl.Segment] = []
    for count, radius in zip(counts, radii, strict=True):
        bending = 10.0 ** generator.uniform(-3.0, 0.0, count)
        rods = [sl.Rod(sl.Section(axial=1e6 * b, shear=4e5 * b, bending=b, torsion=0.8 * b), 1.0) for b in bending]
        segments.append(sl.Segment(rods=rods, ring_radius=radius, plate=sl.Plate(thickness=0.05)))
    return sl.Limb(segments)


def bent_into_arcs(limb: sl.Limb, angle: float) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """Lengths of parallel arcs in the plane about y, moments on the plates, and the plates' poses.

    A rod at the distance x inside the bend has the length 1 - x angle. Clamped to both plates it needs no force, only
    its moment EI angle/length, the same all along. Each plate bears the difference of the moments of its two rings.
    """
    lengths, moments, plates = [], [], []
    place, rotation = np.zeros(3), np.eye(3)
    for segment in limb:
        arc = 1.0 - segment.end_frames[:, 0, 3] * angle
        lengths.append(arc)
        moments.append(sum(r.section.bending * angle / a for r, a in zip(segment.rods, arc, strict=True)))
        place = place + rotation @ [(1.0 - np.cos(angle)) / angle, 0.0, np.sin(angle) / angle]
        rotation = rotation @ about_y(angle)
        plates.append(pose(place, rotation))
        place = place + rotation @ [0.0, 0.0, segment.plate.thickness]
    wrenches = np.zeros((len(limb), 6))
    wrenches[:, 4] = np.array(moments) - np.array([*moments[1:], 0.0])
    return np.concatenate(lengths), wrenches, plates


def assert_arcs(found: sl.Posture, angle: float, plates: Sequence[np.ndarray]) -> None:
    assert_allclose(found.plates, plates, rtol=0.0, atol=1e-8)
    for row in found.rods:
        for rod in row:
            assert_allclose(rod.curvature[:, 1], angle / rod.length, rtol=1e-6)
            # Errors of 1e-9 of the length stretch a rod of 1e6 EI/l^2 by a force of 1e-3 EI/l^2 each.
            assert np.abs(rod.force).max() < 1e-2 * rod.section.bending


RINGS = {
    "three rods": ([3], [0.05]),
    "two rods": ([2], [0.03]),
    "three segments, a tapering ring": ([3, 4, 5], [0.1, 0.05, 0.01]),
    "six segments": ([3] * 6, [0.05] * 6),
}


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("degrees", [30.0, 120.0, 240.0])
@pytest.mark.parametrize("name", RINGS)
def test_rods_of_the_lengths_of_parallel_arcs_bend_into_them_without_any_force(
    name: str, degrees: float, seed: int
) -> None:
    limb = arcs(*RINGS[name], seed)
    # In all: the tip of three or six segments tilts by the same.
    angle = degrees * deg / len(limb)
    lengths, wrenches, plates = bent_into_arcs(limb, angle)
    found = solved(limb, rest_lengths=lengths, plate_wrenches=wrenches, tolerance=1e-9)
    assert_arcs(found, angle, plates)
    assert not found.conservative and found.unstable_modes is None


@pytest.mark.parametrize(
    "name, turns, step",
    [("three rods", 2.1, 0.05), ("two rods", 3.1, 0.05), ("three segments, a tapering ring", 0.4, 0.02)],
)
def test_growing_arcs_wind_up_turn_after_turn(name: str, turns: float, step: float) -> None:
    limb = arcs(*RINGS[name], 0)
    start, angle = None, 0.0
    # Turns in each segment, by steps that the warm start follows. Just at a whole turn a dead moment meets no
    # resistance in some direction: the steps pass by.
    for turn_of_segment in np.arange(0.03, turns, step):
        angle = float(turn_of_segment) * 2.0 * np.pi
        lengths, wrenches, plates = bent_into_arcs(limb, angle)
        start = limb.solve(rest_lengths=lengths, plate_wrenches=wrenches, start=start, tolerance=1e-9)
        assert start.success, start.message
        assert_arcs(start, angle, plates)
    assert start is not None and start.verify().success and angle * len(limb) > 2.0 * np.pi


def test_a_rod_held_as_a_closed_circle_is_one() -> None:
    # Plate at the base again, after a turn: the reaction is the moment of the circle.
    section = sl.Section(axial=1e6, shear=4e5, bending=1.0, torsion=0.8)
    limb = sl.Limb([sl.Segment(rods=[sl.Rod(section, 0.5)], ring_radius=0.0) for _ in range(2)])
    start = None
    for degrees in (60.0, 120.0, 180.0):
        # Of rods of length one: half of that.
        plates = bent_into_arcs(limb, degrees * deg)[2]
        for plate in plates:
            plate[:3, 3] *= 0.5
        start = limb.solve(tip_pose=plates[-1], start=start if start else np.array(plates), tolerance=1e-9)
        assert start.success, start.message
    assert start is not None and start.verify().success and start.stable
    assert_allclose(start.tip, np.eye(4), rtol=0.0, atol=1e-9)
    assert_allclose(start.tip_reaction, [0.0, 0.0, 0.0, 0.0, 2.0 * np.pi, 0.0], rtol=0.0, atol=1e-4)


# --- strong tension ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("degrees", [20.0, 70.0, 120.0])
@pytest.mark.parametrize("growth", [20.0, 40.0, 80.0])
def test_rods_pulled_between_plates_set_aside_bend_at_both_ends_as_solitons(growth: float, degrees: float) -> None:
    # Clamped upright at both ends and pulled along psi0: psi = 4 atan(tan(psi0/4) e^(-k s)) from either end, k =
    # sqrt(P/EI). Two solitons overlap in e^(-growth/2) <= 5e-5 of the angle, which moves the tip by its square over k.
    stiff, bending, angle = 1e6, 0.01, degrees * deg
    k = growth
    pull = bending * k**2
    direction, across = np.array([np.sin(angle), 0.0, np.cos(angle)]), np.array([-np.cos(angle), 0.0, np.sin(angle)])
    tip = direction * (1.0 - 4.0 / k * (1.0 - np.cos(0.5 * angle)) + pull / stiff) + across * 4.0 / k * np.sin(
        0.5 * angle
    )
    section = sl.Section(axial=stiff, shear=stiff, bending=bending, torsion=bending)
    limb = sl.Limb([sl.Segment(rods=[sl.Rod(section, 1.0)] * 4, ring_radius=0.05)])
    found = solved(limb, tip_pose=pose(tip), tolerance=1e-9)
    assert found.stable and found.unstable_modes == 0
    # A stretch of 1e-9 is a force of 1e-3 N here, 1e-5 of the weakest pull; the overlap is e^-20 of it.
    overlap = 10.0 * np.exp(-growth)
    assert_allclose(found.tip_reaction[:3], 4.0 * pull * direction, rtol=0.0, atol=(1e-5 + overlap) * 4.0 * pull)
    # m = 2 sqrt(EI P) sin(psi0/2) at both ends, of opposite sign.
    moment = 2.0 * np.sqrt(bending * pull) * np.sin(0.5 * angle)
    for rod in found.rods[0]:
        ends = rod.moment[[0, -1], 1]
        assert_allclose(ends, [moment, -moment], rtol=0.0, atol=(1e-4 + overlap) * moment + 1e-9)


# --- far beyond buckling -----------------------------------------------------------------------------------------

# Quarter waves of the elastica in the rod, and the freedoms held at its tip.
BUCKLED = {
    "free": (1, None),
    "guided": (2, [False, False, False, True, True, True]),
    "clamped on the axis": (4, [True, True, False, True, True, True]),
}


@pytest.mark.parametrize("share", [1.001, 1.1, 1.5])
@pytest.mark.parametrize("column", BUCKLED)
def test_a_buckled_column_is_made_of_quarter_waves_of_the_elastica(column: str, share: float) -> None:
    # F l^2/EI = (q K(k))^2, height 2 E/K - 1, largest tilt 2 asin k, sway 2 k/(q K) a quarter wave.
    quarters, held = BUCKLED[column]
    stiff = 1e6
    section = sl.Section(axial=stiff, shear=stiff, bending=1.0, torsion=1.0)
    force = share * (0.5 * np.pi * quarters) ** 2
    m = brentq(lambda m: (quarters * ellipk(m)) ** 2 - force, 0.0, 1.0 - 1e-15, xtol=1e-16)
    height = 2.0 * ellipe(m) / ellipk(m) - 1.0 - force / stiff
    limb = sl.Limb([sl.Segment(rods=[sl.Rod(section, 1.0)], ring_radius=0.0)])
    options: dict[str, Any] = {} if held is None else {"tip_pose": pose((0.0, 0.0, 1.0)), "tip_held": held}
    # A round column may buckle to any side: along that ring of postures a tolerance much below 1e-6 is met by luck.
    found = solved(limb, tip_force=(0.0, 0.0, -force), **options)
    assert found.stable and found.unstable_modes == 0
    assert found.tip[2, 3] == pytest.approx(height, abs=2e-6)
    tangents = found.rods[0][0].along(4001)[0][:, :3, 2]
    tilt = np.arccos(np.clip(tangents[:, 2], -1.0, 1.0)).max()
    assert tilt == pytest.approx(2.0 * np.arcsin(np.sqrt(m)), abs=1e-4)  # read at 4001 points
    sway = np.linalg.norm(found.tip[:2, 3])
    expected = {1: 2.0, 2: 4.0, 4: 0.0}[quarters] * np.sqrt(m) / (quarters * ellipk(m))
    assert sway == pytest.approx(expected, abs=2e-6)


@pytest.mark.parametrize("share", [10.0, 100.0, 1000.0])
def test_a_column_under_a_thousandfold_critical_load_hangs_upside_down(share: float) -> None:
    # From K(k) on, k rounds to one: all but a soliton at the base hangs straight down, 2/w from the base each way.
    stiff = 1e8
    section = sl.Section(axial=stiff, shear=stiff, bending=1.0, torsion=1.0)
    force = share * 0.25 * np.pi**2
    found = solved(sl.Limb([sl.Segment(rods=[sl.Rod(section, 1.0)], ring_radius=0.0)]), tip_force=(0.0, 0.0, -force))
    assert found.stable
    w = np.sqrt(force)
    # K(k) = w: 1 - k^2 = 16 e^(-2 w), which is 7e-4 at the tenfold load and enters height and sway to first order.
    m = brentq(lambda m: ellipk(m) - w, 0.0, 1.0 - 1e-15) if w < 15.0 else 1.0
    height = 2.0 * float(ellipe(m)) / w - 1.0 - force / stiff
    assert found.tip[2, 3] == pytest.approx(height, abs=2e-6)
    assert np.linalg.norm(found.tip[:2, 3]) == pytest.approx(2.0 * np.sqrt(m) / w, abs=2e-6)


@pytest.mark.parametrize("stiff", [1e2, 1e4, 1e6, 1e8])
def test_a_column_at_its_very_critical_load_stands_within_what_a_neutral_mode_allows(stiff: float) -> None:
    section = sl.Section(axial=stiff, shear=stiff, bending=1.0, torsion=1.0)
    limb = sl.Limb([sl.Segment(rods=[sl.Rod(section, 1.0)], ring_radius=0.0)])
    force = 0.25 * np.pi**2
    found = solved(limb, tip_force=(0.0, 0.0, -force))
    # The energy rises with the fourth power of the sway: a slope of 1e-6 is a sway of 1e-2, and a sinking of 1e-4.
    assert np.abs(found.tip[:2, 3]).max() < 1e-2
    assert found.tip[2, 3] == pytest.approx(1.0 - force / stiff, abs=1e-4)
    # A thousandth below and above it, nothing is in doubt.
    assert limb.solve(tip_force=(0.0, 0.0, -0.999 * force)).unstable_modes == 0
    above = limb.solve(tip_force=(0.0, 0.0, -1.001 * force))
    assert above.success and above.stable and np.linalg.norm(above.tip[:2, 3]) > 0.02


# --- the reference limb in extreme scenes ------------------------------------------------------------------------


def hanging_tip(limb: sl.Limb, pressures: Sequence[float], gravity: float) -> float:
    """Height of the tip of a straight limb of equal pressures: each rod stretched by all that hangs below it."""
    carried_mass, height = 0.0, 0.0
    for segment, pressure in reversed(list(zip(limb, pressures, strict=True))):
        rod = segment.actuators[0].rod(pressure)
        count, s, l = len(segment.actuators), rod.section, rod.length  # noqa: E741
        carried_mass += segment.plate.mass
        height += l + gravity * l * (carried_mass / count + 0.5 * s.mass_per_length * l) / s.axial
        carried_mass += count * s.mass_per_length * l
        height += segment.plate.thickness
    return height - limb.segments[-1].plate.thickness


@pytest.mark.parametrize("gravity", [0.0, 9.81, 196.2])
@pytest.mark.parametrize("kilopascal", [(-50.0, -50.0, -50.0), (0.0, 0.0, 0.0), (20.0, 55.0, 90.0)])
def test_rings_of_equal_pressure_hang_straight_and_stretch_by_what_they_carry(
    kilopascal: Any, gravity: float
) -> None:
    limb = presets.reference_limb()
    pressures = [p * kPa for p in kilopascal]
    found = solved(limb, np.repeat(pressures, 3), gravity=(0.0, 0.0, gravity), tolerance=1e-10)
    assert found.stable and found.unstable_modes == 0
    assert found.tip[2, 3] == pytest.approx(hanging_tip(limb, pressures, gravity), abs=1e-10)
    assert_allclose(found.plates[:, :2, 3], 0.0, rtol=0.0, atol=1e-12)
    assert_allclose(found.tip[:3, :3], np.eye(3), rtol=0.0, atol=1e-11)
    # Vacuum shortens, pressure lengthens, whatever hangs on it.
    unpressurised = hanging_tip(limb, [0.0] * 3, gravity)
    assert np.sign(round(found.tip[2, 3] - unpressurised, 9)) == np.sign(kilopascal[0])


@pytest.mark.parametrize("kilopascal", [-5.0, 0.0, 55.0])
def test_the_straight_standing_limb_is_an_equilibrium_and_no_stable_one(kilopascal: float) -> None:
    limb = presets.reference_limb()
    pressures = np.full(9, kilopascal * kPa)
    upright = solved(limb, pressures, gravity=(0.0, 0.0, -9.81), prefer_stable=False, tolerance=1e-10)
    assert upright.tip[2, 3] == pytest.approx(hanging_tip(limb, [kilopascal * kPa] * 3, -9.81), abs=1e-10)
    assert not upright.stable and upright.unstable_modes is not None and upright.unstable_modes > 0
    fallen = solved(limb, pressures, gravity=(0.0, 0.0, -9.81))
    assert fallen.stable and fallen.tip[2, 3] < upright.tip[2, 3]


@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (0.0, -0.6, -0.8), (0.0, 0.0, -1.0)])
def test_gravity_times_twenty_gives_the_minimum_of_a_discretised_energy(direction: Any) -> None:
    limb = presets.reference_limb()
    found = solved(limb, COMPLEX, gravity=196.2 * np.array(direction), tolerance=1e-9)
    assert found.stable
    places = []
    for elements in (10, 20):
        second = DiscreteLimb(found, elements)
        assert unstable_modes(second.settle()) == 0
        places.append(second.plates()[:, :3, 3])
    # Second order: two thirds of a centimetre at worst; extrapolated, the fourth order is left.
    coarse, fine = (np.abs(place - found.plates[:, :3, 3]).max() for place in places)
    extrapolated = np.abs((4.0 * places[1] - places[0]) / 3.0 - found.plates[:, :3, 3]).max()
    assert fine < 0.3 * coarse < 0.02 * limb.length
    assert extrapolated < 1e-4 * limb.length


@pytest.mark.parametrize("size", [1e-3 / 0.65, 10.0 / 0.65])
def test_reference_limbs_of_a_millimetre_and_of_ten_metres_have_one_shape(size: float) -> None:
    # Same materials and pressures: forces as size squared, so that weight, as its cube, needs gravity over size.
    limb = presets.reference_limb()

    def scaled(segment: sl.Segment) -> sl.Segment:
        tubes = [
            sl.Tube(
                size * tube.length,
                [sl.Layer(size * a.inner, size * a.outer, a.law, fibres=a.fibres) for a in tube.layers],
                mass=size**3 * tube.mass,
            )
            for tube in segment.actuators
        ]
        plate = sl.Plate(thickness=size * segment.plate.thickness, mass=size**3 * segment.plate.mass)
        return sl.Segment(tubes, ring_radius=size * segment.ring_radius, plate=plate)

    gravity, force = np.array([2.0, 1.0, 9.0]), np.array([0.3, -0.1, 0.2])
    normal = solved(limb, COMPLEX, gravity=gravity, tip_force=force, tolerance=1e-9)
    other = solved(
        sl.Limb([scaled(segment) for segment in limb]),
        COMPLEX,
        gravity=gravity / size,
        tip_force=size**2 * force,
        tolerance=1e-9,
    )
    assert_allclose(other.plates[:, :3, 3] / size, normal.plates[:, :3, 3], rtol=0.0, atol=2e-9)
    assert_allclose(other.plates[:, :3, :3], normal.plates[:, :3, :3], rtol=0.0, atol=1e-8)
    assert_allclose(other.base_wrench[:3] / size**2, normal.base_wrench[:3], rtol=0.0, atol=1e-7)
    assert_allclose(other.jacobian[:3] / size, normal.jacobian[:3], rtol=0.0, atol=1e-7 * np.abs(normal.jacobian).max())
    assert other.stable == normal.stable


def test_tubes_without_fibres_bend_up_to_where_they_balloon_and_a_limb_of_them_says_where() -> None:
    tube = sl.Tube(0.2, [sl.Layer(18.0 * mm, 21.5 * mm, sl.NeoHookean(c1=340000.0))])
    low, high = 80.0 * kPa, 100.0 * kPa
    while high - low > 1e-9 * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if bool(tube.inflate(middle).success) else (low, middle)
    assert low == pytest.approx(90.6 * kPa, rel=1e-3)
    limb = sl.Limb([sl.Segment([tube] * 3, ring_radius=40.0 * mm, plate=sl.Plate(thickness=20.0 * mm, mass=0.05))] * 2)
    stiffness = []
    for share in (0.0, 0.9, 0.99, 1.0 - 1e-3, 1.0 - 1e-6):
        found = solved(limb, np.full(6, share * low), gravity=(0.0, 0.0, 9.81), tolerance=1e-9)
        assert found.stable
        expected = hanging_tip(limb, [share * low] * 2, 9.81)
        assert found.tip[2, 3] == pytest.approx(expected, abs=1e-9)
        stiffness.append(tube.section(share * low).axial)
    # At the limit point pressure alone moves the wall: the axial stiffness at constant pressure goes to zero with the
    # square root of what is left.
    assert np.all(np.diff(stiffness) < 0.0)
    beyond = limb.solve([low * 0.9] * 5 + [low * 1.01], gravity=(0.0, 0.0, 9.81))
    assert beyond.status == "limit_point" and "actuator 5" in beyond.message


def test_rest_lengths_that_differ_in_the_last_bit_or_not_at_all_are_no_trouble() -> None:
    section = section_of(1e9)
    for count in (1, 2, 3, 6):
        limb = sl.Limb([sl.Segment(rods=[sl.Rod(section, 1.0)] * count, ring_radius=0.2)] * 2)
        equal = solved(limb, rest_lengths=np.full(2 * count, 0.3))
        assert_allclose(equal.tip, pose((0.0, 0.0, 0.6)), rtol=0.0, atol=1e-15)
        assert equal.stable
        lengths = np.full(2 * count, 0.3)
        lengths[::2] = np.nextafter(0.3, 1.0)
        # A last bit, 6e-17 over the ring's radius, tilts by as little.
        assert_allclose(solved(limb, rest_lengths=lengths).tip, equal.tip, rtol=0.0, atol=1e-14)


# --- six legs ----------------------------------------------------------------------------------------------------


def lift_by_collocation(length: float, force: float) -> float:
    """Height of the platform under six equal legs and a force along z.

    It cannot turn, by its mirror planes: one leg in its own upright plane, clamped at both ends in directions known,
    bears a sixth of the force, and the side force that keeps its end where the platform's circle is.
    """
    base, tip = joints()
    across = float(np.linalg.norm((tip - base)[0]))
    slope = np.arctan2(across, built_height())

    def rates(s: np.ndarray, y: np.ndarray, p: np.ndarray) -> np.ndarray:
        angle, moment = y[0], y[1]
        n = np.array([p[0], force / 6.0])
        along = np.sin(angle) * n[0] + np.cos(angle) * n[1]
        aside = np.cos(angle) * n[0] - np.sin(angle) * n[1]
        stretch, shear = 1.0 + along / STEEL.axial, aside / STEEL.shear
        dx = stretch * np.sin(angle) + shear * np.cos(angle)
        dz = stretch * np.cos(angle) - shear * np.sin(angle)
        return np.array([moment / STEEL.bending, dx * n[1] - dz * n[0], dx, dz])

    mesh = np.linspace(0.0, length, 201)
    start = np.array([np.full(201, slope), 0.0 * mesh, mesh * np.sin(slope), mesh * np.cos(slope)])
    found = solve_bvp(
        rates,
        lambda a, b, p: np.array([a[0] - slope, a[2], a[3], b[0] - slope, b[2] - across]),
        mesh,
        start,
        p=[0.0],
        tol=1e-10,
        max_nodes=20000,
    )
    assert found.success, found.message
    return float(found.y[3, -1])


@pytest.mark.parametrize("force", [-100.0, 0.0, 300.0])
@pytest.mark.parametrize("change", [-0.02, -0.002, 0.0, 0.005, 0.03])
def test_six_equal_legs_lift_their_platform_as_collocation_says(change: float, force: float) -> None:
    found = solved(six_legs([LEG + change] * 6), tip_force=(0.0, 0.0, force), tolerance=1e-10)
    assert found.stable
    assert found.tip[2, 3] == pytest.approx(lift_by_collocation(LEG + change, force), abs=1e-8)
    assert_allclose(found.tip[:2, 3], 0.0, rtol=0.0, atol=1e-9)
    assert_allclose(found.tip[:3, :3], np.eye(3), rtol=0.0, atol=1e-8)
    assert_allclose(found.base_wrench, [0.0, 0.0, -force, 0.0, 0.0, 0.0], rtol=0.0, atol=1e-6)


ANGLES = np.repeat([0.0, 120.0, 240.0], 2) * deg
LENGTHS = {
    "tilt": 0.01 * np.cos(ANGLES),
    "lift and tilt": 0.02 + 0.015 * np.sin(ANGLES),
    "twist": np.tile([0.004, -0.004], 3),
    "all at once": np.array([0.01, -0.006, 0.012, 0.003, -0.009, 0.007]),
}


@pytest.mark.parametrize("load", [(0.0, 0.0, 0.0), (3.0, -2.0, -20.0)], ids=["free", "loaded"])
@pytest.mark.parametrize("name", LENGTHS)
def test_new_leg_lengths_move_the_platform_to_the_minimum_of_a_discretised_energy(name: str, load: Any) -> None:
    limb = six_legs(LEG + LENGTHS[name])
    found = solved(limb, tip_force=load, tolerance=1e-10)
    assert found.stable
    assert np.linalg.norm(rotation_vector(found.tip[:3, :3])) > 0.01
    poses = []
    for elements in (12, 24):
        second = DiscreteLimb(found, elements)
        assert unstable_modes(second.settle()) == 0
        poses.append(second.plates()[0])
    # Second order leaves a quarter of a millimetre at 24 elements, of the hand's breadth by which the platform moves;
    # extrapolated, the fourth order is left: a hundredth of that.
    extrapolated = (4.0 * poses[1] - poses[0]) / 3.0
    assert_allclose(poses[1], found.tip, rtol=0.0, atol=5e-4)
    assert_allclose(extrapolated, found.tip, rtol=0.0, atol=5e-6)


def test_a_turned_pattern_of_legs_turns_the_answer() -> None:
    # By 120 degrees: the legs' lengths go round by two places.
    third = turn(np.array([0.0, 0.0, 120.0 * deg]))
    change, load = LENGTHS["all at once"], np.array([3.0, -2.0, -60.0])
    first = solved(six_legs(LEG + change), tip_force=load, tolerance=1e-10)
    second = solved(six_legs(LEG + np.roll(change, 2)), tip_force=third @ load, tolerance=1e-10)
    assert_allclose(second.tip, pose(rotation=third) @ first.tip @ pose(rotation=third.T), rtol=0.0, atol=1e-9)


def test_six_legs_lose_one_mode_after_the_other_under_growing_compression() -> None:
    limb = six_legs([LEG] * 6)
    start, counts = limb.solve(tolerance=1e-9), []
    for force in (50.0, 150.0, 215.0, 250.0, 400.0, 500.0):
        start = limb.solve(tip_force=(0.0, 0.0, -force), start=start, prefer_stable=False, tolerance=1e-9)
        assert start.success and start.verify().success, start.message
        assert_allclose(start.tip[:2, 3], 0.0, rtol=0.0, atol=1e-6)
        counts.append(start.unstable_modes)
        assert unstable_modes(DiscreteLimb(start, 16).settle()) == counts[-1], force
    assert counts == sorted(counts)
    # All legs buckle at once between plates, each to two sides, at 4 pi^2 EI/l^2 = 38.8 N or 230 N in all.
    assert counts[:4] == [0, 0, 0, 12]
    settled = solved(limb, tip_force=(0.0, 0.0, -250.0))
    assert settled.stable
    assert unstable_modes(DiscreteLimb(settled, 24).settle()) == 0


# --- rods that pull against each other ------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", [2, 5])
def test_rods_too_stiff_to_stretch_and_of_different_lengths_share_out_their_misfit(seed: int) -> None:
    # Six rods, ten per cent apart in length, that would rather bend than stretch by a millionth: some stand taut, the
    # others buckle. No rod but by its plate can hold the tip: forces and moments on it balance without load.
    generator = np.random.default_rng(seed)
    bending = 10.0 ** generator.uniform(-1.0, 0.0, 6)
    rods = [
        sl.Rod(sl.Section(axial=1e7 * b, shear=1e7 * b, bending=b, torsion=b), length)
        for b, length in zip(bending, generator.uniform(0.9, 1.0, 6), strict=True)
    ]
    found = solved(sl.Limb([sl.Segment(rods=rods, ring_radius=0.2)] * 2), tip_force=(0.5, 0.2, 1.0))
    assert found.stable
    largest = max(float(np.linalg.norm(rod.force[0])) for row in found.rods for rod in row)
    pulled = sum(rod.force[-1] for rod in found.rods[-1])
    # Relative to the largest of the forces that cancel, ten times the tolerance.
    assert_allclose(pulled, [0.5, 0.2, 1.0], rtol=0.0, atol=1e-5 * largest)
