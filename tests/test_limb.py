"""Limbs: symmetry, balance, reciprocity, holds, loads that follow, stability, extreme scenes, and what is refused."""

from __future__ import annotations

import os
import pickle
import signal
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

import softlimb as sl
from frames import pose, solved, turn
from softlimb import presets
from softlimb.bench.limbs import six_legs
from softlimb.units import kPa, mm

HANGING, STANDING = (0.0, 0.0, 9.81), (0.0, 0.0, -9.81)
COMPLEX = np.array([[90.0, 60.0, 30.0], [60.0, 40.0, 20.0], [50.0, 50.0, 50.0]]) * kPa
SOFT = sl.Section(axial=400.0, shear=130.0, bending=0.08, torsion=0.06, mass_per_length=0.4)
THIN = sl.Section(axial=60.0, shear=20.0, bending=0.003, torsion=0.002, mass_per_length=0.1)
STIFF = sl.Section(axial=4e5, shear=1.5e5, bending=8.0, torsion=6.0, mass_per_length=1.0)


@pytest.fixture(scope="module")
def reference() -> sl.Limb:
    return presets.reference_limb()


def between(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Change of pose from the first to the second: translation and small-to-moderate rotation vector, base axes."""
    spin = second[:3, :3] @ first[:3, :3].T
    sine = 0.5 * np.array([spin[2, 1] - spin[1, 2], spin[0, 2] - spin[2, 0], spin[1, 0] - spin[0, 1]])
    norm = float(np.linalg.norm(sine))
    rotation = sine if norm == 0.0 else sine * (np.arcsin(min(norm, 1.0)) / norm)
    return np.concatenate([second[:3, 3] - first[:3, 3], rotation])


def ring(count: int, radius: float = 0.03, **plate: float) -> sl.Segment:
    return sl.Segment(rods=[sl.Rod(SOFT, 0.2)] * count, ring_radius=radius, plate=sl.Plate(**plate))


def wrench_at_base(found: sl.Posture) -> np.ndarray:
    """Total of weights, wrenches and distributed loads about the base origin, from the posture's own curves."""
    total = np.zeros(6)

    def add(point: np.ndarray, force: np.ndarray, moment: Any = (0.0, 0.0, 0.0)) -> None:
        total[:3] += force
        total[3:] += np.cross(point, force) + np.asarray(moment)

    loads, flat = found.loads, 0
    wrenches = loads["plate_wrenches"].copy()
    wrenches[-1] += np.concatenate([loads["tip_force"], loads["tip_moment"]])
    for segment, plate, row, wrench in zip(found.limb, found.plates, found.rods, wrenches, strict=True):
        axes = plate[:3, :3] if loads["frame"] == "plate" else np.eye(3)
        add(plate[:3, 3], axes @ wrench[:3], axes @ wrench[3:])
        centre = plate[:3, 3] + 0.5 * segment.plate.thickness * plate[:3, 2]
        add(centre, segment.plate.mass * loads["gravity"])
        for rod in row:
            # Gauss-Legendre would be exact for less; Simpson on 401 points errs by 1e-11 of these smooth curves.
            points = rod.centreline(401)
            weights = np.full(401, 2.0)
            weights[1::2] = 4.0
            weights[[0, -1]] = 1.0
            mean = (weights[:, None] * points).sum(axis=0) / weights.sum()
            line = loads["rod_forces"][flat] + rod.section.mass_per_length * loads["gravity"]
            add(mean, line * rod.length, loads["rod_moments"][flat] * rod.length)
            flat += 1
    return total


# --- symmetry ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("section", ["tangent", "nonlinear", "paper"])
def test_permuting_the_actuators_of_each_ring_turns_the_answer(reference: sl.Limb, section: Any) -> None:
    third = turn([0.0, 0.0, 2.0 * np.pi / 3.0])
    force = np.array([0.3, -0.2, 0.1])
    first = solved(reference, COMPLEX, gravity=HANGING, tip_force=force, section=section, tolerance=1e-9)
    second = solved(
        reference,
        np.roll(COMPLEX, 1, axis=1),
        gravity=HANGING,
        tip_force=third @ force,
        section=section,
        tolerance=1e-9,
    )
    expected = pose(rotation=third) @ first.tip @ pose(rotation=third.T)
    # Two solves, each within 1e-9 of the length; rotations a few times that.
    assert_allclose(second.tip, expected, rtol=0.0, atol=1e-8)


def test_reflected_pressures_give_the_reflected_posture(reference: sl.Limb) -> None:
    mirror = np.diag([1.0, -1.0, 1.0])  # actuator 0 stands on the mirror plane, 1 and 2 change places
    first = solved(reference, COMPLEX, gravity=(0.0, 4.0, 8.0), tolerance=1e-9)
    second = solved(reference, COMPLEX[:, [0, 2, 1]], gravity=(0.0, -4.0, 8.0), tolerance=1e-9)
    assert_allclose(second.tip[:3, 3], mirror @ first.tip[:3, 3], rtol=0.0, atol=1e-8)
    assert_allclose(second.tip[:3, :3], mirror @ first.tip[:3, :3] @ mirror, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("pressure", [0.0, 20.0, 55.0, 90.0])
@pytest.mark.parametrize("gravity", [(0.0, 0.0, 0.0), HANGING])
def test_equal_pressures_leave_the_limb_straight(reference: sl.Limb, pressure: float, gravity: Any) -> None:
    found = solved(reference, np.full(9, pressure * kPa), gravity=gravity)
    # Symmetric by bits up to the order of sums: only rounding can bend it.
    assert_allclose(found.plates[:, :2, 3], 0.0, rtol=0.0, atol=1e-12)
    assert_allclose(found.tip[:3, :3], np.eye(3), rtol=0.0, atol=1e-11)
    assert found.stable
    if not any(gravity):
        rest = sum(segment.actuators[0].rest_length(pressure * kPa) for segment in reference) + 2 * 25 * mm
        assert_allclose(found.tip[2, 3], rest, rtol=1e-9)


def test_a_negative_pressure_is_solved_and_contracts(reference: sl.Limb) -> None:
    found = solved(reference, np.full(9, -5.0 * kPa))
    assert found.tip[2, 3] < reference.length
    bent = solved(reference, [[-20.0 * kPa, 0.0, 0.0]] * 3, gravity=HANGING)
    assert bent.tip[0, 3] > 0.01  # towards the actuator that shortens, at +x


# --- laws --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("frame", ["base", "plate"])
@pytest.mark.parametrize("seed", range(4))
def test_the_base_carries_all_weights_and_loads(reference: sl.Limb, seed: int, frame: Any) -> None:
    generator = np.random.default_rng(seed)
    wrenches = generator.normal(size=(3, 6)) * [0.4, 0.4, 0.4, 0.01, 0.01, 0.01]
    found = solved(
        reference,
        generator.uniform(0.0, 60.0 * kPa, 9),
        gravity=generator.normal(size=3) * 4.0,
        tip_force=generator.normal(size=3) * 0.2,
        tip_moment=generator.normal(size=3) * 0.01,
        plate_wrenches=wrenches,
        rod_forces=generator.normal(size=(9, 3)) * 0.3,
        rod_moments=generator.normal(size=(9, 3)) * 0.01,
        frame=frame,
        tolerance=1e-10,
    )
    expected = -wrench_at_base(found)
    assert_allclose(found.base_wrench[:3], expected[:3], rtol=0.0, atol=1e-7)  # of some 10 N
    assert_allclose(found.base_wrench[3:], expected[3:], rtol=0.0, atol=1e-7)  # of some N m
    assert not found.conservative
    assert found.unstable_modes is None


@pytest.mark.parametrize("seed", range(4))
def test_compliance_is_symmetric_under_conservative_loads(reference: sl.Limb, seed: int) -> None:
    generator = np.random.default_rng(50 + seed)
    found = solved(
        reference,
        generator.uniform(0.0, 80.0 * kPa, 9),
        gravity=generator.normal(size=3) * 5.0,
        tip_force=generator.normal(size=3) * 0.3,
        tolerance=1e-10,
    )
    assert found.conservative
    gap = np.abs(found.compliance - found.compliance.T)
    # Betti. The derivative is exact for the steps taken; it sees their error, 1e-10, a hundredfold.
    assert gap.max() <= 1e-8 * np.abs(found.compliance).max()
    # The last Newton step moves the answer after its linearisation: at a stable posture the tensor is positive.
    assert np.linalg.eigvalsh(0.5 * (found.compliance + found.compliance.T)).min() > 0.0


def richardson(solve: Callable[[float], sl.Posture], step: float) -> np.ndarray:
    """Slope of the tip: central differences with two steps, extrapolated; error of the fourth power of the step."""

    def slope(h: float) -> np.ndarray:
        return between(solve(-h).tip, solve(h).tip) / (2.0 * h)

    result: np.ndarray = (4.0 * slope(0.5 * step) - slope(step)) / 3.0
    return result


@pytest.mark.parametrize("frame", ["base", "plate"])
def test_compliance_is_the_slope_of_the_tip_by_its_wrench(reference: sl.Limb, frame: Any) -> None:
    force, moment = np.array([0.2, -0.1, 0.3]), np.array([0.004, 0.01, -0.002])
    common: dict[str, Any] = {"gravity": HANGING, "frame": frame, "tip_moment": moment, "tip_force": force}
    found = solved(reference, COMPLEX, **common, tolerance=1e-12)

    def loaded(k: int) -> Callable[[float], sl.Posture]:
        def solve(change: float) -> sl.Posture:
            wrench = np.zeros(6)
            wrench[k] = change
            # The compliance answers a small wrench in base axes, whatever turns with the plate.
            if frame == "plate":
                axes = found.tip[:3, :3]
                wrench = np.concatenate([axes.T @ wrench[:3], axes.T @ wrench[3:]])
            return reference.solve(
                COMPLEX,
                **(common | {"tip_force": force + wrench[:3], "tip_moment": moment + wrench[3:]}),
                tolerance=1e-12,
                start=found,
            )

        return solve

    scale = np.array([1.0, 1.0, 1.0, 0.1, 0.1, 0.1]) * 2e-3
    differences = np.array([richardson(loaded(k), scale[k]) for k in range(6)]).T
    for rows in (slice(0, 3), slice(3, 6)):
        for columns in (slice(0, 3), slice(3, 6)):
            block = differences[rows, columns]
            assert_allclose(found.compliance[rows, columns], block, rtol=0.0, atol=1e-7 * np.abs(block).max())


@pytest.mark.parametrize("valve", ["open", "locked"])
@pytest.mark.parametrize("section", ["tangent", "nonlinear", "paper"])
def test_the_jacobian_is_the_slope_of_the_tip_by_the_pressures(reference: sl.Limb, section: Any, valve: Any) -> None:
    options: dict[str, Any] = {
        "gravity": (1.0, 2.0, 9.0), "tip_force": (0.2, 0.0, 0.1), "section": section, "valve": valve,
        "tolerance": 1e-12,
    }
    found = solved(reference, COMPLEX, **options)
    assert found.jacobian.shape == (6, 9)
    for k in (0, 2, 4, 8):

        def pressed(change: float, k: int = k) -> sl.Posture:
            pressures = COMPLEX.ravel().copy()
            pressures[k] += change
            return reference.solve(pressures, **options, start=found)

        differences = richardson(pressed, 20.0)
        for rows in (slice(0, 3), slice(3, 6)):
            largest = np.abs(found.jacobian[rows]).max()
            # This posture bends sharply with pressure: at 100 Pa the differences still err by 2e-6, with the fourth
            # power of the step; below 10 Pa rounding takes over.
            assert_allclose(found.jacobian[rows, k], differences[rows], rtol=0.0, atol=2e-7 * largest)


@pytest.mark.parametrize("section", ["tangent", "nonlinear"])
def test_no_work_is_done_around_a_closed_path_of_tip_forces(reference: sl.Limb, section: Any) -> None:
    count = 64
    angles = 2.0 * np.pi * np.arange(count) / count
    forces = 0.4 * np.stack([np.cos(angles), np.sin(2.0 * angles), np.sin(angles)], axis=1)
    slopes = 0.4 * np.stack([-np.sin(angles), 2.0 * np.cos(2.0 * angles), np.cos(angles)], axis=1)
    tips, start = [], None
    for force in forces:
        start = reference.solve(
            COMPLEX, gravity=HANGING, tip_force=force, section=section, tolerance=1e-10, start=start
        )
        assert start.success and start.stable
        tips.append(start.tip[:3, 3])
    powers = ((np.array(tips) - np.mean(tips, axis=0)) * slopes).sum(axis=1)
    # The trapezoidal rule on a smooth periodic function errs by less than its last Fourier coefficient.
    spectrum = np.abs(np.fft.rfft(powers)) / count
    assert abs(powers.mean()) <= 10.0 * spectrum[-1] + 1e-9 * np.abs(powers).mean()
    assert spectrum[-1] < 1e-5 * np.abs(powers).mean()


# --- loads -------------------------------------------------------------------------------------------------------


def test_a_following_tip_force_keeps_its_components_in_the_tip() -> None:
    limb = sl.Limb([sl.Segment(rods=[sl.Rod(SOFT, 0.25)], ring_radius=0.0)])
    wrench = np.array([0.8, 0.1, -0.3, 0.01, -0.02, 0.005])
    found = solved(limb, tip_force=wrench[:3], tip_moment=wrench[3:], frame="plate", tolerance=1e-10)
    rod, axes = found.rods[0][0], found.tip[:3, :3]
    assert_allclose(axes.T @ rod.force[-1], wrench[:3], rtol=0.0, atol=1e-8)
    assert_allclose(axes.T @ rod.moment[-1], wrench[3:], rtol=0.0, atol=1e-8)
    # The same as a dead load turned to where the tip ended.
    dead = solved(limb, tip_force=axes @ wrench[:3], tip_moment=axes @ wrench[3:], start=found, tolerance=1e-10)
    assert_allclose(dead.tip, found.tip, rtol=0.0, atol=1e-8)
    assert not found.conservative


@pytest.mark.parametrize("turns", [0.25, 0.75, 1.0, 2.0, 5.0])
def test_a_moment_rolls_a_rod_into_circles_whether_it_follows_or_not(turns: float) -> None:
    # The tip turns about the moment's own axis, so both kinds have the same equilibrium.
    limb = sl.Limb([sl.Segment(rods=[sl.Rod(SOFT, 0.25)], ring_radius=0.0)])
    angle = 2.0 * np.pi * turns
    moment = (0.0, SOFT.bending * angle / 0.25, 0.0)
    radius = 0.25 / angle
    start = None
    for frame in ("base", "plate"):
        found = start = solved(limb, tip_moment=moment, frame=frame, tolerance=1e-8, start=start)
        place = [radius * (1.0 - np.cos(angle)), 0.0, radius * np.sin(angle)]
        assert_allclose(found.tip[:3, 3], place, rtol=0.0, atol=1e-8 * 0.25)


def test_a_dead_moment_leaves_the_count_of_unstable_modes_open(reference: sl.Limb) -> None:
    found = solved(reference, COMPLEX, gravity=HANGING, tip_moment=(0.0, 0.01, 0.0))
    assert not found.conservative
    assert found.unstable_modes is None
    assert isinstance(found.stable, bool)
    held = solved(reference, COMPLEX, tip_moment=(0.0, 0.01, 0.0), tip_pose=solved(reference, COMPLEX).tip)
    assert held.conservative  # a moment on a plate that cannot turn does no work
    assert held.unstable_modes == 0


def test_weight_given_as_distributed_force_is_the_same_weight(reference: sl.Limb) -> None:
    bare = [
        sl.Segment(
            rods=[sl.Rod(tube.section(p), tube.rest_length(p)) for tube, p in zip(s.actuators, row, strict=True)],
            ring_radius=s.ring_radius,
            plate=sl.Plate(thickness=s.plate.thickness),
        )
        for s, row in zip(reference, COMPLEX, strict=True)
    ]
    gravity = np.array([2.0, -1.0, 9.0])
    expected = solved(sl.Limb(bare), gravity=gravity, tolerance=1e-10)
    forces = np.concatenate([[rod.section.mass_per_length * gravity for rod in s.rods] for s in bare])
    found = solved(sl.Limb(bare), rod_forces=forces, tolerance=1e-10)
    assert_allclose(found.tip, expected.tip, rtol=0.0, atol=1e-9)
    nested = solved(sl.Limb(bare), rod_forces=[forces[:3], forces[3:6], forces[6:]], tolerance=1e-10)
    assert np.array_equal(nested.tip, found.tip)


# --- holds -------------------------------------------------------------------------------------------------------

HOLDS = {
    "all": [1, 1, 1, 1, 1, 1],
    "translations": [1, 1, 1, 0, 0, 0],
    "rotations": [0, 0, 0, 1, 1, 1],
    **{f"freedom {k}": [int(i == k) for i in range(6)] for k in range(6)},
    "a plane": [1, 0, 0, 0, 0, 1],
}


@pytest.mark.parametrize("hold", HOLDS)
def test_a_reaction_applied_as_a_load_gives_the_same_posture(reference: sl.Limb, hold: str) -> None:
    held = np.array(HOLDS[hold], dtype=bool)
    free = solved(reference, COMPLEX, gravity=HANGING, tip_force=(0.1, 0.0, 0.0), tolerance=1e-10)
    shift = np.array([0.02, -0.01, 0.015])
    target = pose(free.tip[:3, 3] + shift, turn([0.1, -0.15, 0.2]) @ free.tip[:3, :3])
    found = solved(
        reference,
        COMPLEX,
        gravity=HANGING,
        tip_force=(0.1, 0.0, 0.0),
        tip_pose=target,
        tip_held=held.tolist(),
        tolerance=1e-10,
    )
    gap = between(target, found.tip)
    assert_allclose(gap[held], 0.0, rtol=0.0, atol=1e-10)
    assert np.abs(found.tip_reaction[held]).min() > 1e-4 or hold in ("all", "translations", "rotations", "a plane")
    # What does no work on the hold's freedoms is no reaction: translations and forces are paired axis by axis.
    assert_allclose(found.tip_reaction[:3][~held[:3]], 0.0, rtol=0.0, atol=1e-8)
    loaded = solved(
        reference,
        COMPLEX,
        gravity=HANGING,
        tip_force=np.array([0.1, 0.0, 0.0]) + found.tip_reaction[:3],
        tip_moment=found.tip_reaction[3:],
        start=found,
        prefer_stable=False,
        tolerance=1e-10,
    )
    assert_allclose(loaded.tip, found.tip, rtol=0.0, atol=1e-8)
    ground = wrench_at_base(loaded)
    assert_allclose(found.base_wrench, -ground, rtol=0.0, atol=1e-6)  # of some 10 N and N m


def test_a_tip_held_where_it_stands_needs_no_reaction(reference: sl.Limb) -> None:
    free = solved(reference, COMPLEX, gravity=HANGING, tolerance=1e-10)
    held = solved(reference, COMPLEX, gravity=HANGING, tip_pose=free.tip, tolerance=1e-10)
    assert_allclose(held.plates, free.plates, rtol=0.0, atol=1e-8)
    assert_allclose(held.tip_reaction, 0.0, rtol=0.0, atol=1e-6)
    assert_allclose(held.compliance, 0.0, rtol=0.0, atol=1e-12)  # a held tip does not move


def test_a_hold_without_a_pose_is_where_the_start_has_the_tip(reference: sl.Limb) -> None:
    held = [True] * 6
    unpressurised = solved(reference, np.zeros(9))
    found = solved(reference, np.full(9, 10.0 * kPa), tip_held=held)
    assert_allclose(found.tip, unpressurised.tip, rtol=0.0, atol=1e-9)
    bent = solved(reference, COMPLEX, tolerance=1e-9)
    found = solved(reference, 0.9 * COMPLEX, tip_held=held, start=bent)
    assert_allclose(found.tip, bent.tip, rtol=0.0, atol=1e-12)


def test_every_plate_can_be_held(reference: sl.Limb) -> None:
    free = solved(reference, COMPLEX, gravity=HANGING, tolerance=1e-10)
    poses = free.plates.copy()
    poses[0, 0, 3] += 0.005
    held = np.zeros((3, 6), dtype=bool)
    held[0] = True
    found = solved(reference, COMPLEX, gravity=HANGING, plate_poses=poses, plate_held=held, tolerance=1e-10)
    assert_allclose(found.plates[0], poses[0], rtol=0.0, atol=1e-10)
    assert np.linalg.norm(found.reactions[0]) > 1e-2
    assert_allclose(found.reactions[1:], 0.0, rtol=0.0, atol=0.0)
    loaded = solved(
        reference, COMPLEX, gravity=HANGING, plate_wrenches=found.reactions, start=found, prefer_stable=False,
        tolerance=1e-10,
    )  # fmt: skip
    assert_allclose(loaded.plates, found.plates, rtol=0.0, atol=1e-8)
    everything = solved(reference, COMPLEX, gravity=HANGING, plate_poses=free.plates, tolerance=1e-10)
    assert_allclose(everything.reactions, 0.0, rtol=0.0, atol=1e-6)


# --- shapes of limbs ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rods", range(1, 9))
@pytest.mark.parametrize("segments", range(1, 7))
def test_any_number_of_rods_and_segments(rods: int, segments: int) -> None:
    generator = np.random.default_rng(100 * rods + segments)
    parts = []
    for _ in range(segments):
        members = [
            sl.Rod(SOFT if generator.random() < 0.5 else THIN, 0.2 * generator.uniform(0.95, 1.05)) for _ in range(rods)
        ]
        plate = sl.Plate(thickness=0.02, mass=0.02)
        parts.append(sl.Segment(rods=members, ring_radius=0.03, plate=plate))
    found = solved(sl.Limb(parts), gravity=HANGING, tip_force=(0.05, 0.02, 0.0))
    assert found.stable
    assert_allclose(found.base_wrench, -wrench_at_base(found), rtol=0.0, atol=1e-4)  # tolerance 1e-6 of some 10 N
    assert len(found.rods) == segments
    assert found.centreline(50).shape == (50, 3)


def test_a_stiff_rod_beside_soft_ones_takes_the_load() -> None:
    members = [sl.Rod(STIFF, 0.2), sl.Rod(THIN, 0.2), sl.Rod(THIN, 0.21)]
    limb = sl.Limb([sl.Segment(rods=members, ring_radius=0.03)])
    found = solved(limb, tip_force=(0.0, 0.0, 5.0), tolerance=1e-9)
    assert found.rods[0][0].force[0, 2] > 4.0
    assert_allclose(found.base_wrench, -wrench_at_base(found), rtol=0.0, atol=1e-6)


def test_six_legs_of_equal_length_stand_as_built() -> None:
    found = solved(six_legs([0.4] * 6), tolerance=1e-9)
    assert_allclose(found.tip[:2, 3], 0.0, rtol=0.0, atol=1e-10)
    assert_allclose(found.tip[:3, :3], np.eye(3), rtol=0.0, atol=1e-8)
    assert found.stable


@pytest.mark.parametrize("seed", range(4))
def test_six_legs_of_unequal_length_move_the_platform_as_a_stewart_gough_robot(seed: int) -> None:
    lengths = 0.4 + np.random.default_rng(seed).uniform(-0.01, 0.01, 6)
    found = solved(six_legs(lengths), tip_force=(1.0, 0.5, -5.0), tolerance=1e-9)
    assert found.stable
    assert_allclose(found.base_wrench[:3], [-1.0, -0.5, 5.0], rtol=0.0, atol=1e-6)
    # As springs: the tip's compliance is small along the legs, so it is stiff in all six freedoms.
    assert np.linalg.eigvalsh(0.5 * (found.compliance + found.compliance.T)).max() < 1.0


@pytest.mark.parametrize("size", [1e-3 / 0.65, 10.0 / 0.65])
def test_limbs_of_a_millimetre_and_of_ten_metres_have_the_same_relative_answers(size: float) -> None:
    def limb(a: float, b: float) -> sl.Limb:
        def section(s: sl.Section) -> sl.Section:
            return sl.Section(
                axial=b * s.axial, shear=b * s.shear, bending=b * a * a * s.bending, torsion=b * a * a * s.torsion,
                mass_per_length=b / a * s.mass_per_length,
            )  # fmt: skip

        members = [sl.Rod(section(SOFT), a * length) for length in (0.2, 0.215, 0.205)]
        thin = [sl.Rod(section(THIN), a * length) for length in (0.2, 0.19, 0.2)]
        return sl.Limb(
            [
                sl.Segment(rods=members, ring_radius=0.03 * a, plate=sl.Plate(thickness=0.025 * a, mass=0.1 * b)),
                sl.Segment(rods=thin, ring_radius=0.02 * a, plate=sl.Plate(thickness=0.025 * a, mass=0.02 * b)),
            ]
        )

    force = np.array([0.2, 0.1, 0.0])
    # Stiffness as size squared, as a geometrically similar limb of the same material has it.
    b = size**2
    normal = solved(limb(1.0, 1.0), gravity=HANGING, tip_force=force, tolerance=1e-9)
    scaled = solved(limb(size, b), gravity=HANGING, tip_force=b * force, tolerance=1e-9)
    assert scaled.iterations == normal.iterations
    assert_allclose(scaled.tip[:3, 3] / size, normal.tip[:3, 3], rtol=0.0, atol=1e-9)
    assert_allclose(scaled.tip[:3, :3], normal.tip[:3, :3], rtol=0.0, atol=1e-9)
    assert scaled.stable == normal.stable


@pytest.mark.parametrize("rods, segments", [(12, 1), (12, 3), (3, 10), (1, 10)])
def test_many_rods_and_long_limbs_hang(rods: int, segments: int) -> None:
    parts = [ring(rods, thickness=0.02, mass=0.02) for _ in range(segments)]
    found = solved(sl.Limb(parts), gravity=(3.0, 0.0, 9.0))
    assert found.stable


@pytest.mark.parametrize("ratio", [0.1, 0.3, 1.0])
def test_the_ring_radius_may_shrink_tenfold_along_the_limb(ratio: float) -> None:
    parts = [ring(3, radius=0.03 * ratio**j, thickness=0.02, mass=0.02) for j in range(3)]
    found = solved(sl.Limb(parts), gravity=(1.0, 0.0, 9.0), tip_force=(0.1, 0.0, 0.0))
    assert found.stable


# --- starts and routes -------------------------------------------------------------------------------------------


def test_every_start_leads_to_the_same_posture(reference: sl.Limb) -> None:
    options: dict[str, Any] = {"gravity": HANGING, "tip_force": (0.1, 0.2, 0.0), "tolerance": 1e-9}
    cold = solved(reference, COMPLEX, **options)
    near = solved(reference, 0.95 * COMPLEX, gravity=HANGING)
    for start in (near, cold, cold.plates, near.plates, cold.rods[0][0].posture):
        warm = solved(reference, COMPLEX, **options, start=start)
        assert_allclose(warm.plates, cold.plates, rtol=0.0, atol=1e-8)
    assert solved(reference, COMPLEX, **options, start=near).descent_iterations == 0


def test_rest_lengths_of_the_pressures_give_the_same_posture(reference: sl.Limb) -> None:
    by_pressure = solved(reference, COMPLEX, gravity=HANGING, tolerance=1e-9)
    by_length = solved(reference, rest_lengths=by_pressure.rest_lengths, gravity=HANGING, tolerance=1e-9)
    assert_allclose(by_length.pressures, COMPLEX.ravel(), rtol=1e-7)  # a stretch determines the pressure to that
    assert_allclose(by_length.tip, by_pressure.tip, rtol=0.0, atol=1e-8)
    nested = solved(reference, rest_lengths=by_pressure.rest_lengths.reshape(3, 3), gravity=HANGING, tolerance=1e-9)
    assert np.array_equal(nested.tip, by_length.tip)


def test_pressures_are_taken_flat_nested_or_as_a_list_of_arrays(reference: sl.Limb) -> None:
    flat = solved(reference, COMPLEX.ravel())
    for given in (COMPLEX, COMPLEX.tolist(), list(COMPLEX), tuple(map(tuple, COMPLEX))):
        assert np.array_equal(solved(reference, given).tip, flat.tip)


def test_the_listed_sections_are_those_of_the_pressures(reference: sl.Limb) -> None:
    found = solved(reference, COMPLEX)
    for row, segment, pressures in zip(found.rods, reference, COMPLEX, strict=True):
        for rod, tube, pressure in zip(row, segment.actuators, pressures, strict=True):
            assert rod.section == tube.section(pressure)
            assert rod.length == tube.rest_length(pressure)


# --- stability ---------------------------------------------------------------------------------------------------


def test_the_straight_standing_limb_is_left_for_a_stable_posture(reference: sl.Limb) -> None:
    pressures = np.full(9, 40.0 * kPa)
    straight = solved(reference, pressures, gravity=STANDING, prefer_stable=False, tolerance=1e-9)
    assert straight.unstable_modes == 4
    assert not straight.stable
    assert_allclose(straight.tip[:2, 3], 0.0, rtol=0.0, atol=1e-9)
    assert "unstable" in straight.message and "unstable" in repr(straight)
    found = solved(reference, pressures, gravity=STANDING, tolerance=1e-9)
    assert found.stable
    assert found.unstable_modes == 0
    assert "unstable" in found.message
    assert np.linalg.norm(found.tip[:2, 3]) > 0.1


@pytest.mark.parametrize("seed", range(30))
def test_random_scenes_of_the_reference_limb_succeed_stably(reference: sl.Limb, seed: int) -> None:
    generator = np.random.default_rng(1000 + seed)
    direction, push = generator.normal(size=3), generator.normal(size=3)
    found = solved(
        reference,
        generator.uniform(0.0, 90.0 * kPa, 9),
        gravity=9.81 * direction / np.linalg.norm(direction),
        tip_force=generator.uniform(0.0, 1.0) * push / np.linalg.norm(push),
    )
    assert found.stable, found.message
    assert found.unstable_modes == 0


@pytest.mark.parametrize("seed", range(10))
def test_random_scenes_with_a_dead_tip_moment_succeed(reference: sl.Limb, seed: int) -> None:
    generator = np.random.default_rng(2000 + seed)
    direction, push, twist = generator.normal(size=3), generator.normal(size=3), generator.normal(size=3)
    solved(
        reference,
        generator.uniform(0.0, 90.0 * kPa, 9),
        gravity=9.81 * direction / np.linalg.norm(direction),
        tip_force=generator.uniform(0.0, 1.0) * push / np.linalg.norm(push),
        tip_moment=generator.uniform(0.0, 0.02) * twist / np.linalg.norm(twist),
    )


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-7, 1e-9, 1e-11])
@pytest.mark.parametrize("seed", range(6))
def test_the_tip_is_within_the_tolerance_of_a_far_finer_answer(
    reference: sl.Limb, seed: int, tolerance: float
) -> None:
    generator = np.random.default_rng(3000 + seed)
    pressures = generator.uniform(0.0, 80.0 * kPa, 9)
    options: dict[str, Any] = {"gravity": HANGING, "tip_force": generator.normal(size=3) * 0.3}
    exact = solved(reference, pressures, **options, tolerance=1e-12)
    found = solved(reference, pressures, **options, tolerance=tolerance)
    error = np.linalg.norm(found.tip[:3, 3] - exact.tip[:3, 3]) / reference.length
    assert error <= tolerance + 1e-12  # the fine answer's own
    assert found.error_estimate <= tolerance


@pytest.mark.parametrize("gravity", [(0.0, 0.0, 196.2), (0.0, 0.0, -196.2), (196.2, 0.0, 0.0)])
def test_gravity_times_twenty_is_solved(reference: sl.Limb, gravity: Any) -> None:
    assert solved(reference, COMPLEX, gravity=gravity).stable


# --- what does not succeed, and what is falsified ----------------------------------------------------------------


def test_a_pressure_past_ballooning_is_a_status_and_no_exception(reference: sl.Limb) -> None:
    found = reference.solve(np.full(9, 5e6))
    assert not found.success
    assert found.status == "limit_point"
    assert "actuator" in found.message and "kPa" in found.message
    assert np.isfinite(found.tip).all()
    with pytest.raises(RuntimeError, match="limit_point"):
        found.compliance  # noqa: B018
    with pytest.raises(RuntimeError, match="limit_point"):
        found.jacobian  # noqa: B018
    assert not found.verify().success
    assert "limit_point" in repr(found)


def test_a_solve_that_fails_answers_every_question_about_its_best_point() -> None:
    # Sixteen thousand turns: far beyond the budget of a solve.
    section = sl.Section(axial=1e6, shear=1e6 / 3.0, bending=1.0, torsion=0.8)
    found = sl.Rod(section, 1.0).cantilever(tip_moment=(0.0, 1e5, 0.0)).posture
    assert not found.success
    assert found.message.startswith("not converged")
    assert found.reactions.shape == (1, 6)
    assert np.array_equal(found.tip_reaction, np.zeros(6))
    assert not found.stable and found.unstable_modes is None
    found.verify()  # read past the end of an empty list once
    assert np.isfinite(found.centreline(11)).all()
    assert pickle.loads(pickle.dumps(found)).status == found.status
    with pytest.raises(RuntimeError, match="equilibrium"):
        found.compliance  # noqa: B018


def test_a_rest_length_out_of_reach_is_a_status_and_no_exception(reference: sl.Limb) -> None:
    found = reference.solve(rest_lengths=np.full(9, 2.0))
    assert found.status == "limit_point"
    assert "rest length" in found.message


def falsified(found: sl.Posture, state: list[Any]) -> sl.Verification:
    """Verification of the posture with another state of what was solved, as a pickle could carry it."""
    kind = type(found._solved)
    solved = kind.__new__(kind)
    solved.__setstate__(tuple(state))
    return sl.Verification(*solved.verify(), found.tolerance)


def test_a_rest_length_beyond_any_stretch_is_a_status_and_no_warning() -> None:
    found = presets.reference_limb(["proximal"]).solve(rest_lengths=[0.2, 1e308, 0.2])
    assert found.status == "limit_point"
    assert "actuator 1 cannot reach" in found.message


def test_verification_refuses_a_posture_of_other_loads(reference: sl.Limb) -> None:
    found = solved(reference, COMPLEX, gravity=HANGING)
    geometry, _, *rest = found._solved.__getstate__()
    scene = solved(reference, COMPLEX, gravity=(0.0, 0.0, 9.80))._solved.__getstate__()[1]
    check = falsified(found, [geometry, scene, *rest])
    assert not check.success
    # A thousandth of the weight of 10 N is missing, of a largest internal force of 26 N.
    assert check.force_error > 3e-5


@pytest.mark.parametrize("what", ["plates", "nodes", "wrenches", "not finite"])
def test_verification_refuses_a_falsified_posture(reference: sl.Limb, what: str) -> None:
    found = solved(reference, COMPLEX, gravity=HANGING)
    state = list(found._solved.__getstate__())
    if what == "plates":
        plates = state[2].copy()
        plates[1, 0, 3] += 1e-4 * reference.length
        state[2] = plates
    else:
        rods = list(state[3])
        nodes, wrenches, *integration = rods[4]
        nodes, wrenches = nodes.copy(), wrenches.copy()
        if what == "nodes":
            nodes[len(nodes) // 2, 0, 3] += 1e-4
        elif what == "wrenches":
            wrenches[0, 0] += 1e-3 * np.abs(wrenches).max()
        else:
            wrenches[0, 0] = np.nan
        rods[4] = (nodes, wrenches, *integration)
        state[3] = rods
    assert not falsified(found, state).success


# --- pickles and texts -------------------------------------------------------------------------------------------


def test_rods_far_apart_are_verified_to_the_rounding_of_their_arms() -> None:
    found = solved(sl.Limb([ring(3, radius=1e27, thickness=0.02, mass=0.1), ring(3)]), gravity=HANGING)
    assert found.verify().moment_error < 1e-6


def test_limbs_segments_plates_and_postures_pickle(reference: sl.Limb) -> None:
    for thing in (reference, reference.segments[0], reference.segments[0].plate):
        again = pickle.loads(pickle.dumps(thing))
        assert again == thing
        assert hash(again) == hash(thing)
    found = solved(reference, COMPLEX, gravity=HANGING)
    again = pickle.loads(pickle.dumps(found))
    for name in ("tip", "plates", "base_wrench", "compliance", "jacobian"):
        assert np.array_equal(getattr(again, name), getattr(found, name)), name
    assert (again.message, again.stable, again.unstable_modes) == (found.message, found.stable, found.unstable_modes)
    assert again.verify() == found.verify()
    warm = reference.solve(COMPLEX, gravity=HANGING, start=again)
    assert warm.success
    failed = reference.solve(np.full(9, 5e6))
    assert pickle.loads(pickle.dumps(failed)).status == failed.status


def test_reprs_say_what_a_reader_wants_to_know(reference: sl.Limb) -> None:
    assert "3 segments" in repr(reference) and "0.65" in repr(reference)
    assert "3 actuators" in repr(reference.segments[0]) and "0.028" in repr(reference.segments[0])
    assert "0.14" in repr(reference.segments[0].plate)
    text = repr(solved(reference, COMPLEX))
    assert "converged" in text and "mm" in text


def test_limbs_that_differ_are_not_equal(reference: sl.Limb) -> None:
    other = sl.Limb([reference.segments[0], reference.segments[1]])
    assert other != reference
    thicker = replace(reference.segments[0].plate, thickness=0.03)
    assert thicker != reference.segments[0].plate
    assert presets.reference_limb() == reference


def test_a_posture_of_another_limb_is_refused_as_start(reference: sl.Limb) -> None:
    short = presets.reference_limb(["proximal"])
    with pytest.raises(ValueError, match="start"):
        reference.solve(COMPLEX, start=solved(short, [0.0, 0.0, 0.0]))


# --- bad input ---------------------------------------------------------------------------------------------------

NAN = float("nan")
NOT_VECTORS: list[Any] = [
    (1.0, 2.0), np.zeros((3, 1)), 1.0, (NAN, 0.0, 0.0), (0.0, float("inf"), 0.0), "x", None, (1j, 0.0, 0.0),
    np.array([1j, 0.0, 0.0]), np.array([True, False, False]), {"x": 1.0}, ("a", "b", "c"), [[1.0, 2.0], [3.0]],
]  # fmt: skip
NOT_POSES: list[Any] = [
    np.eye(3), np.zeros((4, 4)), np.full((4, 4), NAN), np.diag([1.0, 1.0, -1.0, 1.0]), 2.0 * np.eye(4), "x", 1.0,
    np.diag([1.0, 1.0, 1.0, 2.0]), np.ones((4, 4), dtype=bool), np.eye(4) * 1j, np.diag([1e308, 1.0, 1.0, 1.0]),
]  # fmt: skip
BAD_SCENES: list[tuple[dict[str, Any], str]] = [
    *[({name: value}, name) for name in ("gravity", "tip_force", "tip_moment") for value in NOT_VECTORS],
    *[
        ({"plate_wrenches": value}, "plate_wrenches")
        for value in (np.zeros((2, 6)), np.zeros(18), np.full((3, 6), NAN), "x", np.zeros((3, 6), dtype=bool), 1.0)
    ],
    *[
        ({name: value}, name)
        for name in ("rod_forces", "rod_moments")
        for value in (
            np.zeros((8, 3)), np.zeros((9, 2)), np.full((9, 3), NAN), "x", 1.0, np.zeros((9, 3), dtype=bool),
            [np.zeros((3, 3)), np.zeros((3, 3))], [None] * 9, {"a": 1}, [],
        )
    ],
    *[({"frame": value}, "frame") for value in ("tip", None, 3, ["base"], True)],
    *[({"tip_pose": value}, "tip_pose") for value in NOT_POSES],
    *[
        ({"tip_held": value}, "tip_held")
        for value in (
            [True] * 5, [[True], [True, False]], [1, 1, 1, 0, 0, 0], True, "all", [None] * 6, [NAN] * 6,
            np.ones((1, 6), dtype=bool),
        )
    ],
    *[({"plate_poses": value}, "plate_poses") for value in (np.eye(4), np.zeros((3, 4, 4)), "x", np.zeros((2, 4, 4)))],
    *[
        ({"plate_held": value}, "plate_held")
        for value in (np.ones((2, 6), dtype=bool), np.full((3, 6), NAN), "x", np.full((3, 6), 2), [[True] * 6] * 2)
    ],
    ({"tip_pose": np.eye(4), "plate_poses": np.tile(np.eye(4), (3, 1, 1))}, "plate_poses"),
    *[
        ({"tolerance": value}, "tolerance")
        for value in (0.0, -1e-6, NAN, 1.0, 1e-15, "fine", None, 1j, [1e-6], True, np.array([1e-6, 1e-6]))
    ],
    *[
        ({"start": value}, "start")
        for value in ("x", 3.0, np.eye(4), np.zeros((3, 4, 4)), np.full((3, 4, 4), NAN), np.tile(np.eye(4), (2, 1, 1)))
    ],
    *[({"prefer_stable": value}, "prefer_stable") for value in ("no", None, 2, np.array([True, False]))],
    *[({"section": value}, "section") for value in ("linear", None, 3, SOFT, ["tangent"])],
    *[({"valve": value}, "valve") for value in ("shut", None, True, 1.0)],
    *[
        ({"pressures": value}, "pressures")
        for value in (
            np.zeros(8), np.zeros((2, 3)), np.zeros((3, 2)), np.zeros((9, 1)), np.full(9, NAN), 5.0, "x", [], {},
            [[0.0] * 3, [0.0] * 2, [0.0] * 4], np.zeros(9, dtype=bool), np.zeros(9) * 1j, [None] * 9,
            [0.0] * 8 + [float("inf")], [[0.0] * 3] * 2, np.zeros((1, 3, 3)),
        )
    ],
    *[
        ({"pressures": None, "rest_lengths": value}, "rest_lengths")
        for value in (np.zeros(9), -np.ones(9), np.full(9, NAN), np.ones(8), "x", 0.2, np.ones(9, dtype=bool), [])
    ],
    ({"rest_lengths": np.full(9, 0.2)}, "rest_lengths"),
    ({"pressures": None}, "pressures"),
]  # fmt: skip


@pytest.mark.parametrize("arguments, name", BAD_SCENES, ids=lambda value: " ".join(str(value).split())[:60])
def test_a_bad_argument_of_solve_is_refused_by_name(reference: sl.Limb, arguments: dict[str, Any], name: str) -> None:
    given = {"pressures": np.zeros(9)} | arguments
    with pytest.raises((ValueError, TypeError), match=name):
        reference.solve(**given)


ROD = sl.Rod(SOFT, 0.2)
BAD_PARTS: list[tuple[Callable[[], Any], str]] = [
    *[
        (lambda field=field, value=value: sl.Plate(**{field: value}), field)
        for field in ("thickness", "mass")
        for value in (-1.0, NAN, float("inf"), "x", None, 1j, [0.1], True)
    ],
    (lambda: sl.Segment(), "exactly one"),
    (lambda: sl.Segment([], ring_radius=0.1), "at least one"),
    (lambda: sl.Segment(rods=[], ring_radius=0.1), "at least one"),
    (lambda: sl.Segment([], rods=[ROD], ring_radius=0.1), "exactly one"),
    (lambda: sl.Segment([ROD], ring_radius=0.1), "Tube"),
    (lambda: sl.Segment(rods=["x"], ring_radius=0.1), "Rod"),
    (lambda: sl.Segment(rods=ROD, ring_radius=0.1), "rods"),
    (lambda: sl.Segment(rods=5, ring_radius=0.1), "rods"),
    (lambda: sl.Segment(rods=[ROD]), "ring_radius"),
    (lambda: sl.Segment(rods=[ROD], base_frames=np.eye(4)[None]), "end_frames"),
    (lambda: sl.Segment(rods=[ROD], ring_radius=0.1, base_frames=np.eye(4)[None]), "ring_radius"),
    *[
        (lambda value=value: sl.Segment(rods=[ROD], ring_radius=value), "ring_radius")
        for value in (-0.1, NAN, "x", 1j, [0.1], True)
    ],
    *[
        (lambda value=value: sl.Segment(rods=[ROD], base_frames=[value], end_frames=[np.eye(4)]), "base_frames")
        for value in NOT_POSES
    ],
    (lambda: sl.Segment(rods=[ROD], base_frames=[np.eye(4)] * 2, end_frames=[np.eye(4)]), "base_frames"),
    *[(lambda value=value: sl.Segment(rods=[ROD], ring_radius=0.0, plate=value), "plate") for value in (3.0, "x", {})],
    (lambda: sl.Limb([]), "at least one"),
    (lambda: sl.Limb([ROD]), "Segment"),  # type: ignore[list-item]
    (lambda: sl.Limb(np.array(5.0)), "segments"),  # type: ignore[arg-type]
    (lambda: sl.Limb(5), "segments"),  # type: ignore[arg-type]
    (lambda: sl.Limb(None), "segments"),  # type: ignore[arg-type]
    (lambda: sl.Limb(sl.Segment(rods=[ROD], ring_radius=0.0)), "segments"),  # type: ignore[arg-type]
]


@pytest.mark.parametrize("number", range(len(BAD_PARTS)))
def test_a_bad_part_of_a_limb_is_refused_by_name(number: int) -> None:
    make, name = BAD_PARTS[number]
    with pytest.raises((ValueError, TypeError), match=name):
        make()


def test_pressures_for_a_limb_of_rods_are_refused() -> None:
    limb = sl.Limb([ring(3)])
    with pytest.raises(ValueError, match="pressures"):
        limb.solve([0.0, 0.0, 0.0])


@pytest.mark.parametrize("moment", [20.0, 100.0, 1e3, 1e30])
def test_a_mad_moment_ends_with_a_status_and_a_point_to_look_at(moment: float) -> None:
    # Newton millimetres for newton metres: the solve has a budget, whatever it is asked for.
    limb = presets.reference_limb(["proximal"])
    posture = limb.solve([60e3, 60e3, 0.0], tip_moment=(moment, 0.0, 0.0))
    assert posture.tip.shape == (4, 4)
    assert posture.success == posture.verify().success
    assert posture.success or posture.status in ("max_iterations", "no_progress", "singular_jacobian", "not_finite")


@pytest.mark.parametrize("axial", [1e9, 1e11])
def test_a_rod_that_hardly_stretches_is_no_harder_than_one_that_does(axial: float) -> None:
    rod = sl.Rod(sl.Section(axial=axial, shear=axial / 3, bending=1.0, torsion=0.8), 1.0)
    reference = sl.Rod(sl.Section(axial=1e7, shear=1e7 / 3, bending=1.0, torsion=0.8), 1.0)
    for force in ((1.0, 0.0, -5.0), (3.0, 0.0, 0.0)):
        found, expected = rod.cantilever(force), reference.cantilever(force)
        assert found.success and found.stable and found.verify().success
        # Strains n/EA and n/GA of the softer rod: at most 5/3e6 of the length.
        np.testing.assert_allclose(found.tip, expected.tip, rtol=0.0, atol=4e-6)


def test_a_solve_is_interrupted_by_ctrl_c() -> None:
    limb = presets.reference_limb(["proximal"])
    timer = threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    late = time.monotonic() + 60.0  # when it is clear that nobody listens
    with pytest.raises(KeyboardInterrupt):
        while time.monotonic() < late:
            limb.solve([60e3, 60e3, 0.0], tip_moment=(1e3, 0.0, 0.0))


def test_lengths_give_back_their_pressures_where_caps_do_not_stretch() -> None:
    layers = presets.reference_limb().segments[0].actuators[0].layers
    tube = sl.Tube(0.2, layers, cap_length=6 * mm)
    limb = sl.Limb([sl.Segment(actuators=[tube] * 3, ring_radius=0.028)])
    pressures = np.array([50.0, 20.0, 5.0]) * kPa
    there = solved(limb, pressures, section="paper")
    back = solved(limb, rest_lengths=there.rest_lengths, section="paper")
    # As `pressure_for` inverts `inflate`.
    assert back.pressures is not None
    assert_allclose(back.pressures, pressures, rtol=1e-8)


def test_a_length_that_rounding_left_below_the_tubes_own_needs_no_pressure() -> None:
    limb = presets.reference_limb(["proximal"])
    found = solved(limb, rest_lengths=[0.2 - 1e-9, 0.21, 0.2])
    assert found.pressures is not None and found.pressures[0] == 0.0
    assert limb.solve(rest_lengths=[0.199, 0.21, 0.2]).status == "limit_point"
