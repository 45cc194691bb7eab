"""Laws that hold for any limb: hypothesis draws the limb and its loads, the same ones every time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import softlimb as sl
from frames import pose, solved, turn
from softlimb import presets
from softlimb.units import kPa

# Two solves within 1e-10 of the length each; turns are a few times that.
TOLERANCE = 1e-10
SAME = 1e-8

seeds = st.integers(min_value=0, max_value=2**32 - 1)
few = settings(max_examples=12, deadline=None, derandomize=True)


@dataclass(frozen=True)
class Drawn:
    """Segments and loads as numbers, so that a test can turn, permute and scale them before a limb is made."""

    bases: list[np.ndarray]
    ends: list[np.ndarray]
    sections: list[list[dict[str, float]]]
    lengths: list[list[float]]
    plates: list[dict[str, float]]
    gravity: np.ndarray
    wrenches: np.ndarray
    forces: list[np.ndarray]

    def limb(self) -> sl.Limb:
        return sl.Limb(
            [
                sl.Segment(
                    rods=[sl.Rod(sl.Section(**s), length) for s, length in zip(sections, lengths, strict=True)],
                    base_frames=bases,
                    end_frames=ends,
                    plate=sl.Plate(**plate),
                )
                for bases, ends, sections, lengths, plate in zip(
                    self.bases, self.ends, self.sections, self.lengths, self.plates, strict=True
                )
            ]
        )

    def loads(self) -> dict[str, Any]:
        return {
            "gravity": self.gravity, "plate_wrenches": self.wrenches, "rod_forces": np.concatenate(self.forces),
            "tolerance": TOLERANCE,
        }  # fmt: skip


def draw(seed: int) -> Drawn:
    """One to three segments of one to four unequal rods at odd places, moderately loaded by forces."""
    generator = np.random.default_rng(seed)
    bases, ends, sections, lengths, plates, forces = [], [], [], [], [], []
    segments = int(generator.integers(1, 4))
    for _ in range(segments):
        count = int(generator.integers(1, 5))
        angles = 2.0 * np.pi * (np.arange(count) + generator.uniform(-0.2, 0.2, count)) / count
        places = 0.15 * np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
        leaning = [turn(generator.normal(size=3) * 0.05) for _ in range(count)]
        bases.append(np.array([pose(p, r) for p, r in zip(places, leaning, strict=True)]))
        ends.append(np.array([pose(p, r) for p, r in zip(places, leaning, strict=True)]))
        drawn = []
        for _ in range(count):
            bending, slender = 10.0 ** generator.uniform(-0.7, 0.0), 10.0 ** generator.uniform(2.0, 4.0)
            drawn.append(
                {
                    "axial": slender * bending, "shear": 0.4 * slender * bending, "bending": bending,
                    "torsion": 0.8 * bending, "mass_per_length": generator.uniform(0.0, 0.05),
                    "rest_twist": generator.uniform(-0.5, 0.5),
                    "extension_twist": generator.uniform(-0.5, 0.5) / (bending * np.sqrt(0.8 * slender)),
                }
            )  # fmt: skip
        sections.append(drawn)
        lengths.append((1.0 + generator.uniform(-0.03, 0.03, count)).tolist())
        plates.append({"thickness": 0.1, "mass": generator.uniform(0.0, 0.02)})
        forces.append(generator.normal(size=(count, 3)) * 0.05)
    wrenches = np.zeros((segments, 6))
    wrenches[:, :3] = generator.normal(size=(segments, 3)) * 0.15
    return Drawn(bases, ends, sections, lengths, plates, generator.normal(size=3) * 3.0, wrenches, forces)


def assert_same(found: sl.Posture, plates: np.ndarray, limb: sl.Limb) -> None:
    assert_allclose(found.plates[:, :3, 3], plates[:, :3, 3], rtol=0.0, atol=SAME * limb.length)
    assert_allclose(found.plates[:, :3, :3], plates[:, :3, :3], rtol=0.0, atol=SAME)


@few
@given(seed=seeds)
def test_rotating_the_base_rotates_the_shape_and_its_wrenches(seed: int) -> None:
    drawn, generator = draw(seed), np.random.default_rng(seed + 1)
    rotation, shift = turn(generator.normal(size=3) * 2.0), generator.normal(size=3)
    first = solved(drawn.limb(), **drawn.loads())
    base = pose(shift, rotation)
    moved = Drawn(
        [base @ drawn.bases[0], *drawn.bases[1:]], drawn.ends, drawn.sections, drawn.lengths, drawn.plates,
        rotation @ drawn.gravity, np.concatenate([drawn.wrenches[:, :3] @ rotation.T, drawn.wrenches[:, 3:]], axis=1),
        [f @ rotation.T for f in drawn.forces],
    )  # fmt: skip
    # Where several postures are stable, another start may lead to another: the turned one is asked for.
    second = solved(moved.limb(), **moved.loads(), start=base @ first.plates)
    assert_same(second, base @ first.plates, moved.limb())
    assert second.unstable_modes == first.unstable_modes
    force, moment = rotation @ first.base_wrench[:3], rotation @ first.base_wrench[3:]
    largest = max(1.0, np.abs(first.base_wrench).max())
    assert_allclose(second.base_wrench[:3], force, rtol=0.0, atol=1e-6 * largest)
    assert_allclose(second.base_wrench[3:], moment + np.cross(shift, force), rtol=0.0, atol=1e-6 * largest)
    both = np.kron(np.eye(2), rotation)
    largest = np.abs(first.compliance).max()
    assert_allclose(second.compliance, both @ first.compliance @ both.T, rtol=0.0, atol=1e-6 * largest)


@few
@given(seed=seeds)
def test_the_order_in_which_rods_are_listed_does_not_matter(seed: int) -> None:
    drawn, generator = draw(seed), np.random.default_rng(seed + 1)
    first = solved(drawn.limb(), **drawn.loads())
    orders = [generator.permutation(len(lengths)) for lengths in drawn.lengths]
    shuffled = Drawn(
        [b[o] for b, o in zip(drawn.bases, orders, strict=True)],
        [e[o] for e, o in zip(drawn.ends, orders, strict=True)],
        [[s[i] for i in o] for s, o in zip(drawn.sections, orders, strict=True)],
        [[x[i] for i in o] for x, o in zip(drawn.lengths, orders, strict=True)],
        drawn.plates, drawn.gravity, drawn.wrenches, [f[o] for f, o in zip(drawn.forces, orders, strict=True)],
    )  # fmt: skip
    second = solved(shuffled.limb(), **shuffled.loads())
    # Sums in another order: rounding, through the same steps from the same start.
    assert_same(second, first.plates, drawn.limb())
    assert second.unstable_modes == first.unstable_modes
    for row, other, order in zip(first.rods, second.rods, orders, strict=True):
        for i, number in enumerate(order):
            largest = max(1.0, np.abs(row[number].base_wrench).max())
            assert_allclose(other[i].base_wrench, row[number].base_wrench, rtol=0.0, atol=1e-6 * largest)


@few
@given(seed=seeds, metre=st.floats(-3.0, 2.0), newton=st.floats(-3.0, 3.0))
def test_other_units_of_length_and_force_give_the_same_posture(seed: int, metre: float, newton: float) -> None:
    drawn = draw(seed)
    a, b = 10.0**metre, 10.0**newton
    power = {"axial": b, "shear": b, "bending": b * a**2, "torsion": b * a**2, "mass_per_length": b / a,
             "rest_twist": 1.0 / a, "extension_twist": 1.0 / (a * b)}  # fmt: skip
    stretched = [frames.copy() for frames in (*drawn.bases, *drawn.ends)]
    for frames in stretched:
        frames[:, :3, 3] *= a
    count = len(drawn.bases)
    scaled = Drawn(
        stretched[:count], stretched[count:],
        [[{name: value * power[name] for name, value in s.items()} for s in row] for row in drawn.sections],
        [[a * x for x in row] for row in drawn.lengths],
        [{"thickness": a * p["thickness"], "mass": b * p["mass"]} for p in drawn.plates],
        drawn.gravity, drawn.wrenches * [b, b, b, a * b, a * b, a * b], [f * b / a for f in drawn.forces],
    )  # fmt: skip
    first, second = solved(drawn.limb(), **drawn.loads()), solved(scaled.limb(), **scaled.loads())
    plates = first.plates.copy()
    plates[:, :3, 3] *= a
    assert_same(second, plates, scaled.limb())
    assert second.unstable_modes == first.unstable_modes
    assert_allclose(second.base_wrench[:3] / b, first.base_wrench[:3], rtol=0.0, atol=1e-6)
    assert_allclose(second.base_wrench[3:] / (a * b), first.base_wrench[3:], rtol=0.0, atol=1e-6)


@few
@given(seed=seeds)
def test_plates_answer_each_others_loads_reciprocally(seed: int) -> None:
    # Maxwell and Betti. Stiffness between all plates, the tip's compliance as one block of its inverse, and where some
    # freedoms are held, too.
    drawn, generator = draw(seed), np.random.default_rng(seed + 1)
    limb = drawn.limb()
    free = solved(limb, **drawn.loads())
    held = np.zeros((len(limb), 6), dtype=bool)
    held[-1, generator.integers(3)] = True  # one place: a hold that turns nothing
    partly = solved(limb, **drawn.loads(), plate_poses=free.plates, plate_held=held, start=free)
    for found in (free, partly):
        stiffness = found.plate_stiffness
        largest = np.abs(stiffness).max()
        # An answer within 1e-10 is so far from balance that moments spoil symmetry by 1e-10 of forces.
        assert_allclose(stiffness, stiffness.T, rtol=0.0, atol=1e-8 * largest)
        compliance = found.compliance
        assert_allclose(compliance, compliance.T, rtol=0.0, atol=1e-8 * np.abs(compliance).max())
    # Stiffnesses in a ratio of up to 1e5 cost so many digits in an inverse.
    inverse = np.linalg.inv(free.plate_stiffness)[-6:, -6:]
    assert_allclose(inverse, free.compliance, rtol=0.0, atol=1e-8 * np.abs(free.compliance).max())
    axis = int(np.flatnonzero(held[-1])[0])
    assert_allclose(partly.compliance[axis], 0.0, rtol=0.0, atol=1e-12 * np.abs(free.compliance).max())
    # A held place stiffens every other: x^T C x falls.
    loss = np.linalg.eigvalsh(free.compliance - 0.5 * (partly.compliance + partly.compliance.T))
    assert free.stable and loss.min() > -1e-8 * np.abs(free.compliance).max()


def stored(found: sl.Posture) -> float:
    """Elastic energy, from strains and forces along the rods, by Simpson's rule."""
    total = 0.0
    for row in found.rods:
        for rod in row:
            poses, force, moment, strain, curvature = rod.along(201)
            rotation = poses[:, :3, :3]
            n, m = (np.einsum("kji,kj->ki", rotation, vector) for vector in (force, moment))
            twist = np.array([0.0, 0.0, rod.section.rest_twist])
            density = 0.5 * ((n * (strain - [0.0, 0.0, 1.0])).sum(axis=1) + (m * (curvature - twist)).sum(axis=1))
            weights = np.full(201, 2.0)
            weights[1::2], weights[[0, -1]] = 4.0, 1.0
            total += float(density @ weights) * rod.length / weights.sum()
    return total


@settings(few, max_examples=8)
@given(seed=seeds)
def test_the_work_of_growing_loads_is_the_energy_that_rods_store(seed: int) -> None:
    # All loads grow together from nothing, s F: the work is the sum over what they move of F times the integral of
    # s dx, by parts F x(1) - F (integral of x ds). Weights and distributed forces act on means along the rods.
    drawn = draw(seed)
    limb = drawn.limb()
    nodes, weights = np.polynomial.legendre.leggauss(24)
    shares, weights = 0.5 * (nodes + 1.0), 0.5 * weights

    def loaded(share: float, start: sl.Posture | None) -> sl.Posture:
        return solved(
            limb,
            gravity=share * drawn.gravity,
            plate_wrenches=share * drawn.wrenches,
            rod_forces=share * np.concatenate(drawn.forces),
            start=start,
            tolerance=TOLERANCE,
        )

    def potential(found: sl.Posture) -> float:
        """Of the full loads at this posture, without sign: F times x."""
        total = 0.0
        for j, (row, segment) in enumerate(zip(found.rods, limb, strict=True)):
            plate = found.plates[j]
            total += float(drawn.wrenches[j, :3] @ plate[:3, 3])
            centre = plate[:3, 3] + 0.5 * segment.plate.thickness * plate[:3, 2]
            total += float(segment.plate.mass * drawn.gravity @ centre)
            for rod, force in zip(row, drawn.forces[j], strict=True):
                points = rod.centreline(201)
                simpson = np.full(201, 2.0)
                simpson[1::2], simpson[[0, -1]] = 4.0, 1.0
                mean = simpson @ points / simpson.sum()
                total += float((force + rod.section.mass_per_length * drawn.gravity) @ mean) * rod.length
        return total

    unloaded = start = loaded(0.0, None)
    integral = 0.0
    for share, weight in zip(shares, weights, strict=True):
        start = loaded(float(share), start)
        integral += weight * potential(start)
    end = loaded(1.0, start)
    work = potential(end) - integral
    gained = stored(end) - stored(unloaded)
    # Gauss points on a path that may turn sharply: of 300 drawn paths the worst left 2e-5 with 14 points, 4e-8 with 24.
    scale = abs(work) + 1e-3
    assert abs(gained - work) < 1e-6 * scale
    assert work > 0.0


@settings(few, max_examples=6)
@given(seed=seeds)
def test_the_force_at_the_tip_is_the_slope_of_the_energy_stored(seed: int) -> None:
    # The reference limb under pressure, without weight: its rods' energy plus nothing else, against a held place.
    generator = np.random.default_rng(seed)
    limb, pressures = presets.reference_limb(), generator.uniform(0.0, 60.0 * kPa, 9)
    free = solved(limb, pressures, tolerance=TOLERANCE)
    shift, direction = generator.uniform(-0.005, 0.005, 3), generator.normal(size=3)
    direction /= np.linalg.norm(direction)
    places = [True, True, True, False, False, False]

    def held(step: float) -> sl.Posture:
        place = free.tip.copy()
        place[:3, 3] += shift + step * direction
        return solved(limb, pressures, tip_pose=place, tip_held=places, start=free, tolerance=TOLERANCE)

    step = 1e-3
    slopes = [(stored(held(h)) - stored(held(-h))) / (2.0 * h) for h in (step, 0.5 * step)]
    slope = (4.0 * slopes[1] - slopes[0]) / 3.0
    reaction = float(held(0.0).tip_reaction[:3] @ direction)
    # Fourth order in steps of a millimetre, over bends of the limb by centimetres.
    assert abs(slope - reaction) < 1e-5 * max(1.0, abs(reaction))
